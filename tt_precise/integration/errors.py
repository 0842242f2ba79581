"""``Errors``: the estimated errors of a trajectory, by comparison with a finer run.

The exact solution is unknown, so the scene is integrated again, in the cheapest arithmetic with a
tolerance that is ``RATIO`` times smaller. States differ so little that their difference is exact,
and the difference of a column follows to first order. The finer run detects no events: one step of
Newton's method gives the zero of an event's function in it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cache, cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import POSE_NAMES, Name, digits_of_time, digits_over_rows
from tt_precise.integration.equations import event_value
from tt_precise.integration.events import ARRIVED, Event
from tt_precise.integration.precision import (
    DOUBLES,
    LONG_DOUBLES,
    functions_of,
    precision_named,
    times_in,
)
from tt_precise.integration.reading import (
    Numbers,
    States,
    columns_in,
    drift_columns,
    end_state,
    event_columns,
    is_drift,
    rounding_of,
    seconds_of,
    states_at,
    table,
)
from tt_precise.integration.segment import Segment
from tt_precise.integration.setup import full_tolerance, refused_in_doubles
from tt_precise.integration.solution import Solution
from tt_precise.integration.steps import Limbs
from tt_precise.mechanics.quantities import UNITLESS, Quantity, UserFunction
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.series import TaylorSeries

ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
TIME, ERROR_OF_TIME = "error", f"{ERROR}t"  # Errors of events' times: alone, and among columns.
RATIO = 30  # Tolerance of a run over that of its finer run, whose own error is then 3 % of it.
# Tolerance, in eps of double, from which truncation outweighs the roundings of double: a run with
# full tolerance in the same arithmetic shows the errors.
COARSE = 1000
# Time, in units of sqrt(R/g), from an event to the two values that give the slope of a user's
# function, and terms of the state's series there: four digits of the slope suffice.
ASIDE, ASIDE_ORDER = 2.0**-20, 4
SMALL = 2.0**-600  # scale of deviations, so small that their squares vanish


def finer(run: Solution) -> dict[str, Any]:
    """Return the changes for ``Solution.again`` that give the finer run."""
    own, fn, tolerance = run.precision, run.precision.context, run.tolerance
    if own.is_float and tolerance >= COARSE * own.eps:
        return {"tolerance": 0.0, "events": ()}
    again = {"events": (), "options": ()}
    names = () if refused_in_doubles(run.scene) else ("double-double", "triple-double")
    for precision in map(precision_named, names):
        if full_tolerance(precision) <= tolerance / RATIO:
            return {**again, "precision": precision, "tolerance": float(tolerance / RATIO)}
    bits = math.ceil(1 - fn.log(tolerance / RATIO, 2))
    return {**again, "precision": precision_named("mp", bits), "tolerance": 0.0}


def errors_of(run: Solution) -> Errors:
    """The errors of a run; its finer run is integrated when an error is first read."""
    return run.once(Errors, lambda: Errors(run))


def is_estimate(name: Name) -> bool:
    """True if a column has estimated errors."""
    return isinstance(name, str) and (name == DIGITS or name.startswith(ERROR))


def table_with_errors(
    run: Solution,
    wanted: Sequence[Name],
    times: Sequence[Fraction] | Array | None,
    numbers: Numbers,
) -> dict[Any, Array]:
    """Return ``reading.table`` with columns of estimated errors and of drifts, at the samples.

    Raises ``InputError``: there are times and such columns.
    """
    estimates = _estimated(wanted)
    drifts = [str(name) for name in wanted if is_drift(name)]
    if not estimates and not drifts:
        return table(run, wanted, times, numbers)
    if times is not None:
        raise InputError(
            "times: got times with estimated errors or drifts, which exist only at the "
            "samples, expected no times; choose the samples by sample_every of the scene"
        )
    plain = [name for name in wanted if name not in estimates and name not in drifts]
    columns = table(run, plain or ["theta"], None, numbers)
    if drifts:
        columns |= drift_columns(run, drifts, numbers)
    estimated = [name for name in estimates.values() if name != DIGITS]
    errors = errors_of(run).over_time(estimated) if estimates else {}
    for name, column in estimates.items():
        values = errors[column]
        columns[name] = shortest_texts(values) if numbers == "text" else values
    return {name: columns[name] for name in ("t", *wanted)}


def _estimated(wanted: Sequence[Name]) -> dict[str, Name]:
    """The columns of errors among ``wanted``, each with the column whose error it is."""
    own = {name.name.removesuffix(UNITLESS): name for name in wanted if isinstance(name, Quantity)}
    of = {str(name): str(name).removeprefix(ERROR) for name in wanted if is_estimate(name)}
    return {name: own.get(column.removesuffix(UNITLESS), column) for name, column in of.items()}


def events_with_errors(run: Solution, wanted: Sequence[Name]) -> dict[Any, Array]:
    """Return ``reading.event_columns`` with columns of estimated errors, also of "error:t"."""
    estimates = _estimated(wanted)
    plain = [name for name in wanted if name not in estimates]
    columns = event_columns(run, plain)
    if estimates:
        names = tuple(set(estimates.values()) - {DIGITS, "t"})
        errors = errors_of(run).events(names)
        columns |= {name: errors[TIME if of == "t" else of] for name, of in estimates.items()}
    return {name: columns[name] for name in ("name", "t", "direction", *wanted)}


def floats(values: Any) -> Array:
    """Numbers of any kind as a float64 array, with NaN for undefined values."""
    if isinstance(values, numpy.ndarray) and values.dtype != object:
        return values.astype(float)
    return numpy.array([math.nan if v is None else float(v) for v in values], dtype=float)


class Pair(NamedTuple):
    """States of a run and of its finer run at the same instants, each within a segment.

    Components are arrays of one arithmetic, or of sums of doubles (instant, limb).
    """

    index: Array
    segment: Segment
    row: Sequence[Array]
    other: Segment
    better: Sequence[Array]

    def errors(self, names: Sequence[Name], numbers: Any) -> dict[Any, Array]:
        """Compute the errors of columns (SI), never below the rounding of a stored value.

        Under the same equations the exact differences of the states are propagated to first order;
        otherwise, and for user-defined functions and poses, columns are compared.
        """
        bits, layouts = (
            self.segment.setup.precision.bits,
            [segment.setup.layout for segment in (self.segment, self.other)],
        )
        alike = layouts[0] == layouts[1]
        plain = [n for n in names if alike and not (isinstance(n, Quantity) or n in POSE_NAMES)]
        others, errors = [name for name in names if name not in plain], dict[Any, Array]()
        with numpy.errstate(all="ignore"):
            if plain:
                row = tuple(map(_deviating, self.row, self.better))
                columns = self.segment.columns.of_arrays(plain, row, float, deviations())
                for name, column in columns.items():
                    known, error = numpy.real(column), abs(numpy.imag(column)) / SMALL
                    error = error + rounding(known, bits)
                    errors[name] = numpy.where(numpy.isfinite(known), error, math.nan)
            if others:
                mine, theirs = (
                    columns_in(segment, others, [_summed(x, numbers) for x in row], numbers)
                    for segment, row in ((self.segment, self.row), (self.other, self.better))
                )
                for name in others:
                    apart = abs((mine[name] - theirs[name]).astype(float))
                    errors[name] = apart + rounding(mine[name].astype(float), bits)
        return errors

    def values(self, names: Sequence[Name]) -> dict[Any, Array]:
        """Compute columns (SI) of the run in double."""
        row = [x[:, 0] if x.ndim == 2 else x.astype(float) for x in self.row]
        return columns_in(self.segment, names, row, DOUBLES)


def rounding(values: Array, bits: int) -> Array:
    """Return the roundings of the last of ``bits``, of a state and of a column."""
    return numpy.spacing(abs(values)) * 2.0 ** max(53 - bits, -1000)


def _summed(values: Array, numbers: Any) -> Array:
    return numbers.from_limbs(values) if values.ndim == 2 else values


def _deviating(values: Array, better: Array) -> Array:
    """Return doubles with their differences from better values as small imaginary parts."""
    if values.ndim == 2:  # the first doubles are close to each other, so their difference is exact
        count = min(values.shape[1], better.shape[1])
        apart = (values[:, :count] - better[:, :count]).sum(axis=1)
        apart = apart + values[:, count:].sum(axis=1) - better[:, count:].sum(axis=1)
        values = values[:, 0]
    else:
        apart = (values - better).astype(float)
    deviating = numpy.empty(len(values), dtype=complex)
    deviating.real, deviating.imag = values.astype(float), SMALL * numpy.nan_to_num(apart)
    return deviating


class Errors:
    """The errors of a ``run``: its distances from a finer run, or from the solution ``other``."""

    def __init__(self, run: Solution, other: Solution | None = None):
        self._run, self._other = run, other

    @cached_property
    def reference(self) -> Solution:
        """The finer run, integrated when first needed."""
        return self._other or self._run.again(**finer(self._run))

    @property
    def available(self) -> bool:
        """True if the finer run is integrated already."""
        return "reference" in self.__dict__

    @property
    def _numbers(self) -> Any:
        """The arithmetic of arrays in which both runs are compared."""
        if self._run.precision.is_float:
            return LONG_DOUBLES
        return max(self._run, self.reference, key=lambda run: run.precision.bits).precision.mpfr

    @cached_property
    def at_end(self) -> dict[str, Scalar]:
        """Absolute error of each component of the state at the end (SI), and of ``t_end`` (s).

        Infinite if the finer run ends in another way: then neither can be trusted.
        """
        run, other, fn = self._run, self.reference, self._run.precision.context
        own, better = ({"t_end": r.end, **end_state(r).values} for r in (run, other))
        own["t_end"], same, unit = run.t_end, run.status == other.status, run.precision.eps
        return {
            name: abs(fn.mpf(value) - fn.mpf(better[name])) + abs(fn.mpf(value)) * unit
            if same else fn.inf
            for name, value in own.items()
            if value is not None and better[name] is not None
        }  # fmt: skip

    @property
    def digits_at_end(self) -> float:
        """Significant digits of the worst component of the state at the end."""
        run = self._run
        values = {n: x for n, x in end_state(run).values.items() if x is not None}
        columns = {name: numpy.array([float(x)]) for name, x in values.items()}
        errors = {name: numpy.array([float(self.at_end.get(name, math.inf))]) for name in values}
        return float(digits_over_rows(columns, errors, run.start, run.precision.bits)[0])

    def over_time(self, names: Sequence[Name] = ()) -> dict[Any, Array]:
        """Float64 columns at the samples: t, the errors of ``names`` (SI), and "digits".

        "digits" are those of the state's worst component. An error is infinite where the finer run
        has ended.
        """
        run, state, times = self._run, self._run.columns.names, self._run.sample_times
        errors = self.at_times(times, tuple(dict.fromkeys([*state, *names])))
        values = {name: numpy.zeros(len(times)) for name in state}
        for pair in self._pairs(times):
            for name, column in pair.values(state).items():
                values[name][pair.index] = column
        known = {name: errors[name] for name in state}
        digits = digits_over_rows(values, known, run.start, run.precision.bits)
        seconds = seconds_of(run, times)
        return {"t": seconds, **{name: errors[name] for name in names}, DIGITS: digits}

    def at_times(self, times: Sequence[Fraction], names: Sequence[Name]) -> dict[Name, Array]:
        """The errors (SI) of columns at exact ``times`` (s)."""
        run, numbers = self._run, self._numbers
        errors = {name: numpy.full(len(times), math.inf) for name in names}
        with rounding_of(numbers):
            for pair in self._pairs(times):
                for name, error in pair.errors(names, numbers).items():
                    errors[name][pair.index] = error
        if run.status not in ARRIVED:  # both runs have their own ends
            last = numpy.array([t >= as_fraction(run.end) for t in times], dtype=bool)
            for name in names:
                errors[name][last] = float(self.at_end.get(str(name), math.nan))
        return errors

    def _pairs(self, times: Sequence[Fraction]) -> list[Pair]:
        """Return the states of both runs, up to the end of the finer run."""

        def compute() -> list[Pair]:
            run, other, numbers = self._run, self.reference, self._numbers
            mine, theirs = run.segments[0], other.segments[0]
            if self._in_limbs:
                limbs = _limbs_of(other, times)
                rows = [_at_limbs(segment, limbs) for segment in (mine, theirs)]
                return [Pair(numpy.arange(len(times)), mine, rows[0], theirs, rows[1])]
            end = as_fraction(other.end) * (1 + Fraction(1, 10**15))
            count = sum(t <= end for t in times)
            inner = times if count == len(times) else [t for t in times if t <= end]
            index = numpy.flatnonzero([t <= end for t in times])
            if run.sample_times is times and count == len(times) and other.status in ARRIVED:
                inner = other.sample_times
            return _paired(states_at(run, times, numbers), states_at(other, inner, numbers), index)

        samples = times is self._run.sample_times
        return self._run.once((self, "pairs"), compute) if samples else compute()

    @property
    def _in_limbs(self) -> bool:
        """True if both runs are single segments in sums of doubles, up to the horizon."""
        return all(
            run.precision.doubles and len(run.segments) == 1 and run.status in ARRIVED
            and run.steps and not run.segments[0].setup.phase.has_clock
            for run in (self._run, self.reference)
        )  # fmt: skip

    def events(self, names: Sequence[Name] = ()) -> dict[Any, Array]:
        """Columns of the events in order of time: name, t, error (s), errors (SI), and "digits".

        "digits" are the fewest correct digits of the state there and of the time. Errors are
        infinite if the finer run has ended before, or is in another part of its motion; in double
        the rounding of the time is added.
        """
        run, state, unit = self._run, self._run.columns.names, float(self._run.start.units.time)
        every, bits = tuple(dict.fromkeys([*state, *names])), run.precision.bits
        columns: dict[Any, list[Array]] = {n: [] for n in ("name", "t", TIME, *names, DIGITS)}
        with rounding_of(self._numbers):
            for row in (x for i in range(len(run.segments)) for x in self._events_of(i, every)):
                count, seconds = len(row.name), row.time.astype(float) * unit
                errors = {name: numpy.full(count, math.inf) for name in every}
                digits = numpy.zeros(count)
                for pair in row.pairs:
                    own, values = pair.errors(every, self._numbers), pair.values(every)
                    # zero behind the event: what the end leaves of a column is its error
                    cleared = pair.segment.cleared if row.switch else ()
                    for name, error in own.items():
                        rest = abs(values[name]) if name in cleared else 0.0
                        errors[name][pair.index] = numpy.maximum(error, rest)
                    for name in own.keys() & {*cleared}:
                        own[name], values[name] = 0 * own[name], 0 * values[name]
                    known = {name: own[name] for name in state}
                    values = {name: values[name] for name in state}
                    digits[pair.index] = digits_over_rows(values, known, run.start, bits)
                late = row.late * unit
                digits = numpy.minimum(digits, digits_of_time(late, seconds, unit))
                late = late + numpy.spacing(seconds) / 2 * run.precision.is_float
                shown = {"name": row.name, "t": seconds, TIME: late, **errors, DIGITS: digits}
                for name, column in columns.items():
                    column.append(shown[name])
        empty = {"name": numpy.empty(0, object)}
        return {
            name: numpy.concatenate(column) if column else empty.get(name, numpy.empty(0))
            for name, column in columns.items()
        }

    def _events_of(self, i: int, names: Sequence[Name]) -> Iterator[_Events]:
        """Give the events inside the segment ``i``, and the event that ends it."""
        run, other, numbers = self._run, self.reference, self._numbers
        segment, hits = run.segments[i], run.segments[i].run.found.hits
        before = _switches(run)[i]
        if len(hits):
            time = hits.time + times_in(numbers, [segment.begin])[0]
            late, pairs = numpy.full(len(hits), math.inf), []
            begins = [float(s.begin) for s in other.segments[1:]]
            at = numpy.searchsorted(begins, time.astype(float), side="left")
            for j in numpy.unique(at).tolist():
                here = (at == j) & (time.astype(float) <= float(other.end_time))
                if _switches(other)[j] != before:
                    continue
                for name, event in segment.setup.watched.items():
                    index = numpy.flatnonzero(here & (hits.name == name))
                    if len(index):
                        theirs = other.segments[j]
                        late[index], better = _zeros_of(event, theirs, time[index], numbers)
                        row = [x[index] for x in hits.state]
                        pairs.append(Pair(index, segment, row, theirs, better))
            late = numpy.where(numpy.isfinite(late), late, math.inf)
            yield _Events(hits.name, time, late, pairs)
        if segment.ended:
            end = segment.begin + segment.end_time
            alike = [
                s for s, switches in zip(other.segments, _switches(other), strict=True)
                if (switches, s.ended) == (before, segment.ended)
            ]  # fmt: skip
            late, pairs = numpy.array([math.inf]), []
            for theirs in alike[:1]:
                late = numpy.array([abs(float(end - theirs.begin - theirs.end_time))])
                mine, better = ([numbers.array([x]) for x in s.end_row] for s in (segment, theirs))
                pairs.append(Pair(numpy.arange(1), segment, mine, theirs, better))
            names_of = numpy.array([segment.ended], dtype=object)
            yield _Events(names_of, times_in(numbers, [end]), late, pairs, switch=True)

    @cached_property
    def digits_throughout(self) -> float:
        """Significant digits that hold at every sample, in every event, and in ``t_end``."""
        run = self._run
        digits = [*self.over_time()[DIGITS], self.digits_at_end]
        if run.event_counts:
            digits += [*self.events()[DIGITS]]
        if run.status not in ARRIVED:
            error, unit = float(self.at_end["t_end"]), float(run.start.units.time)
            digits.append(digits_of_time(numpy.float64(error), float(run.t_end), unit))
        return float(min(digits))


class _Events(NamedTuple):
    """Events with dimensionless times and errors of times, and their states in both runs."""

    name: Array
    time: Array
    late: Array
    pairs: Sequence[Pair]
    switch: bool = False


def _switches(run: Solution) -> list[tuple[str, ...]]:
    """Return the mode switches before each segment."""
    ended = [segment.ended for segment in run.segments]
    return [tuple(filter(None, ended[:i])) for i in range(len(ended))]


def _paired(mine: Sequence[States], theirs: Sequence[States], index: Array) -> list[Pair]:
    """Return the common instants of two runs; those of the second are numbers in ``index``."""
    pairs = []
    for segment, at, row in mine:
        for other, number, better in theirs:
            _, first, second = numpy.intersect1d(at, index[number], return_indices=True)
            if len(first):
                rows = [x[first] for x in row], [x[second] for x in better]
                pairs.append(Pair(at[first], segment, rows[0], other, rows[1]))
    return pairs


def _limbs_of(run: Solution, times: Sequence[Fraction]) -> Array:
    """Return exact times (s) as dimensionless sums of three doubles: axes (time, limb)."""
    mpfr = run.precision.mpfr

    def compute() -> Array:
        with mpfr.precision():
            local = mpfr.of_fractions(times) / mpfr.number(run.start.units.time)
            return mpfr.to_limbs(local, MOST_LIMBS)

    own = times is run.scene.sample_times
    return run.start.once("sample times in limbs", compute) if own else compute()


def _at_limbs(segment: Segment, times: Array) -> list[Array]:
    series = segment.series
    step = numpy.searchsorted(series.begin, times[:, 0], side="left") - 1
    return series.evaluate(numpy.maximum(step, 0), times, Limbs())


def _zeros_of(
    event: Event, segment: Segment, times: Array, numbers: Any
) -> tuple[Array, list[Array]]:
    """Return the delays after ``times`` of a function's zeros, and the states there.

    By one step of Newton's method along the power series at ``times``, or at the segment's end.
    """
    setup, fn = segment.setup, functions_of(numbers)
    local = times - times_in(numbers, [segment.begin])[0]
    end = times_in(numbers, [segment.end_time])[0]
    inner = numpy.where((local < end).astype(bool), local, end)
    row = segment.at(inner, numbers)
    body = segment.start.body.numbers(numbers.number)
    entries, q = setup.layout.moving(body, tuple(row), fn)
    if event.of_rate or not isinstance(event.function, UserFunction):
        value = event_value(event, q)
        if not isinstance(value, TaylorSeries):
            return numpy.full(len(times), math.inf), row
        step = -value[0] / value[1]
    else:  # it has values, but may have no series

        def at(delay: float) -> Scalar:
            moved = tuple(sum(x[k] * delay**k for k in range(ASIDE_ORDER)) for x in entries)
            value = event_value(event, setup.layout.motion(body, moved, fn))
            # of a fraction and a long double NumPy makes an object
            return value.astype(numpy.longdouble) if fn is numpy else value

        slope = (at(ASIDE) - at(-ASIDE)) / (2 * ASIDE)
        step = -at(0.0) / numpy.where(slope == 0, math.nan, slope)
    there = [x[0] + step * (x[1] + step * x[2]) for x in entries]
    form = setup.formulation
    before, after = (form.State(*x[: len(form.columns)]) for x in (row, there))
    delay = form.State.elapsed(step, before, after) + (inner - local)
    return abs(delay.astype(float)), there


@cache
def deviations() -> Functions:
    """Functions of numbers with a small deviation, represented as complex numbers.

    An analytic function of x + i d is f(x) + i d f'(x) up to d^2. ``abs`` and comparisons are not
    analytic and must not be used.
    """

    def atan2(y: Array, x: Array) -> Array:
        # the deviation without the cancellation that a logarithm would have
        turned = (x.real * y.imag - y.real * x.imag) / (x.real * x.real + y.real * y.real)
        return numpy.arctan2(y.real, x.real) + 1j * turned

    return SimpleNamespace(
        atan2=atan2, cos=numpy.cos, sin=numpy.sin, sqrt=numpy.sqrt, exp=numpy.exp, log=numpy.log
    )
