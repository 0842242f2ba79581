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
    columns_in,
    drift_columns,
    event_columns,
    floats,
    is_drift,
    rounding_of,
    seconds_of,
    states_at,
    table,
)
from tt_precise.integration.setup import full_tolerance, refused_in_doubles
from tt_precise.integration.solution import Segment, Solution
from tt_precise.mechanics.quantities import UNITLESS, Quantity
from tt_precise.runtime.values import Array, Functions, InputError
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.series import TaylorSeries

ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
TIME = "error"  # The column of the errors of events' times.
RATIO = 30  # Tolerance of a run over that of its finer run, whose own error is then 3 % of it.
# Tolerance, in eps of double, from which truncation outweighs the roundings of double: a run with
# full tolerance in the same arithmetic shows the errors.
COARSE = 1000
SMALL = 2.0**-600  # scale of deviations, so small that their squares vanish


def finer(run: Solution) -> dict[str, Any]:
    """Return the changes for ``Solution.again`` that give the finer run."""
    own, fn, tolerance = run.precision, run.precision.context, run.tolerance
    if own.is_float and tolerance >= COARSE * own.eps:
        return {"tolerance": 0.0, "events": ()}
    again = {"events": ()}
    names = () if refused_in_doubles(run.scene) else ("double-double", "triple-double")
    for precision in map(precision_named, names):
        if full_tolerance(precision) <= tolerance / RATIO:
            return {**again, "precision": precision, "tolerance": float(tolerance / RATIO)}
    bits = math.ceil(1 - fn.log(tolerance / RATIO, 2))
    return {**again, "precision": precision_named("mp", bits), "tolerance": 0.0}


def errors_of(run: Solution) -> Errors:
    """The errors of a run; its finer run is integrated when an error is first read."""
    return run.once(Errors, lambda: Errors(run))


def table_with_errors(
    run: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction] | Array | None,
    numbers: Numbers,
) -> dict[Any, Array]:
    """Return ``reading.table`` with columns of estimated errors and of drifts, at the samples.

    Raises ``InputError``: there are times and such columns.
    """
    estimates = _estimated(names)
    drifts = [str(name) for name in names if is_drift(name)]
    if not estimates and not drifts:
        return table(run, names, times, numbers)
    if times is not None:
        raise InputError(
            "times: got times with estimated errors or drifts, which exist only at the "
            "samples, expected no times; choose the samples by sample_every of the scene"
        )
    plain = [name for name in names if name not in estimates and name not in drifts]
    columns = table(run, plain or ["theta"], None, numbers)
    if drifts:
        columns |= drift_columns(run, drifts, numbers)
    if estimates:
        errors = errors_of(run).over_time([x for x in estimates.values() if x != DIGITS])
        text = numbers == "text"
        columns |= {
            n: shortest_texts(errors[x]) if text else errors[x] for n, x in estimates.items()
        }
    return {name: columns[name] for name in ("t", *names)}


def _estimated(names: Sequence[Name]) -> dict[str, Name]:
    """Return the columns of errors among ``names``, each with the column whose error it is."""
    own = {name.name.removesuffix(UNITLESS): name for name in names if isinstance(name, Quantity)}
    labels = [x for x in names if isinstance(x, str) and (x == DIGITS or x.startswith(ERROR))]
    of = {label: label.removeprefix(ERROR) for label in labels}
    return {name: own.get(column.removesuffix(UNITLESS), column) for name, column in of.items()}


def events_with_errors(run: Solution, names: Sequence[Name]) -> dict[Any, Array]:
    """Return ``reading.event_columns`` with columns of estimated errors, also of "error:t"."""
    estimates = _estimated(names)
    columns = event_columns(run, [name for name in names if name not in estimates])
    if estimates:
        errors = errors_of(run).events(tuple(set(estimates.values()) - {DIGITS, "t"}))
        columns |= {name: errors[TIME if of == "t" else of] for name, of in estimates.items()}
    return {name: columns[name] for name in ("name", "t", "direction", *names)}


class Pair(NamedTuple):
    """States of a run and of its finer run at the same instants, each within a segment.

    Components are arrays of one arithmetic, or of sums of doubles (instant, limb). The columns
    ``cleared`` are zero behind the instant, so that their values are errors.
    """

    index: Array
    segment: Segment
    row: Sequence[Array]
    other: Segment
    better: Sequence[Array]
    cleared: tuple[str, ...] = ()

    def errors(self, names: Sequence[Name], numbers: Any) -> dict[Any, Array]:
        """Compute the errors of columns (SI), never below the rounding of a stored value.

        Under the same equations the exact differences of the states are propagated to first order;
        otherwise, and for user-defined functions and poses, columns are compared.
        """
        alike = self.segment.setup.layout == self.other.setup.layout
        plain = [n for n in names if alike and not (isinstance(n, Quantity) or n in POSE_NAMES)]
        others, errors = [name for name in names if name not in plain], dict[Any, Array]()
        bits = self.segment.setup.precision.bits
        with numpy.errstate(all="ignore"):
            if plain:
                row = tuple(map(_deviating, self.row, self.better))
                columns = self.segment.columns.of_arrays(plain, row, float, deviations())
                for name, column in columns.items():
                    value, error = numpy.real(column), abs(numpy.imag(column)) / SMALL
                    error = error + rounding(value, bits)
                    errors[name] = numpy.where(numpy.isfinite(value), error, math.nan)
            if others:
                mine, theirs = (
                    columns_in(segment, others, [_summed(x, numbers) for x in row], numbers)
                    for segment, row in ((self.segment, self.row), (self.other, self.better))
                )
                for name in others:
                    apart = abs((mine[name] - theirs[name]).astype(float))
                    errors[name] = apart + rounding(mine[name].astype(float), bits)
        return errors

    def compare(
        self, run: Solution, names: Sequence[Name], numbers: Any
    ) -> tuple[dict[Any, Array], Array]:
        """Return the errors of columns, and the digits of the state's worst component."""
        state = run.columns.names
        every = tuple(dict.fromkeys([*state, *names]))
        errors = self.errors(every, numbers)
        row = [x[:, 0] if x.ndim == 2 else x.astype(float) for x in self.row]
        values = columns_in(self.segment, every if self.cleared else state, row, DOUBLES)
        remain = {name: abs(values[name]) for name in every if name in self.cleared}
        kept = {name: float(name not in self.cleared) for name in state}
        own, own_errors = ({n: x[n] * kept[n] for n in state} for x in (values, errors))
        errors |= {name: numpy.maximum(errors[name], size) for name, size in remain.items()}
        return errors, digits_over_rows(own, own_errors, run.start, run.precision.bits)


def rounding(values: Array, bits: int) -> Array:
    """Return the roundings of the last of ``bits``, of a state and of a column."""
    return (values != 0) * numpy.spacing(abs(values)) * 2.0 ** max(53 - bits, -1000)


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
        precisions = self._run.precision, self.reference.precision
        if self._run.precision.is_float and not any(x.kind.in_software for x in precisions):
            return LONG_DOUBLES
        return max(self._run, self.reference, key=lambda run: run.precision.bits).precision.mpfr

    @cached_property
    def _of_end(self) -> tuple[dict[Any, Array], float]:
        """The errors of the state at the end, and its digits: none if the runs end differently."""
        run, other, names = self._run, self.reference, self._run.columns.names
        if run.status != other.status:
            return dict.fromkeys(names, numpy.array([math.inf])), 0.0
        with rounding_of(self._numbers):
            pair = _ends(run.segments[-1], other.segments[-1], self._numbers)
            errors, digits = pair.compare(run, names, self._numbers)
        return errors, float(digits[0])

    @cached_property
    def at_end(self) -> dict[str, float]:
        """Absolute error of each component of the state at the end (SI), and of ``t_end`` (s).

        Infinite if the finer run ends in another way: then neither can be trusted.
        """
        run, other, (errors, _) = self._run, self.reference, self._of_end
        t_end = abs(run.end - other.end) + run.end * run.precision.eps
        late = float(t_end) if run.status == other.status else math.inf
        values = {name: float(error[0]) for name, error in errors.items()}
        return {"t_end": late, **{name: x for name, x in values.items() if not math.isnan(x)}}

    @property
    def digits_at_end(self) -> float:
        """Significant digits of the worst component of the state at the end."""
        return self._of_end[1]

    def over_time(self, names: Sequence[Name] = ()) -> dict[Any, Array]:
        """Float64 columns at the samples: t, the errors of ``names`` (SI), and "digits".

        "digits" are those of the state's worst component. An error is infinite where the finer run
        has ended.
        """
        run, times, numbers = self._run, self._run.sample_times, self._numbers
        errors = {name: numpy.full(len(times), math.inf) for name in names}
        digits = numpy.zeros(len(times))
        with rounding_of(numbers):
            for pair in self._pairs:
                own, digits[pair.index] = pair.compare(run, names, numbers)
                for name in names:
                    errors[name][pair.index] = own[name]
        if run.status not in ARRIVED:  # both runs have their own ends
            digits[-1] = self.digits_at_end
            for name in names:
                errors[name][-1] = self._of_end[0].get(name, [math.nan])[0]
        return {"t": seconds_of(run, times), **errors, DIGITS: digits}

    @cached_property
    def _pairs(self) -> list[Pair]:
        """The states of both runs at the samples, up to the end of the finer run."""
        run, other, times = self._run, self.reference, self._run.sample_times
        if self._in_limbs:
            mine, theirs, limbs = run.segments[0], other.segments[0], _limbs_of(other)
            row, better = (x.series.at(limbs, None) for x in (mine, theirs))
            return [Pair(numpy.arange(len(times)), mine, row, theirs, better)]
        if other.status in ARRIVED and run.status in ARRIVED:
            inner: Sequence[Fraction] = other.sample_times
        else:
            end = as_fraction(other.end) * (1 + Fraction(1, 10**15))
            inner = [t for t in times if t <= end]
        pairs = []
        for theirs, number, better in states_at(other, inner, self._numbers):
            for mine, at, row in states_at(run, times, self._numbers):
                index, first, second = numpy.intersect1d(at, number, return_indices=True)
                if len(index):
                    ours, finer_row = [x[first] for x in row], [x[second] for x in better]
                    pairs.append(Pair(index, mine, ours, theirs, finer_row))
        return pairs

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
        run, numbers, unit = self._run, self._numbers, float(self._run.start.units.time)
        shown = event_columns(run, ())
        seconds, count = floats(shown["t"]), len(shown["t"])
        late, digits = numpy.full(count, math.inf), numpy.zeros(count)
        errors = {name: numpy.full(count, math.inf) for name in names}
        first = 0
        with rounding_of(numbers):
            for segment, before in zip(run.segments, _switches(run), strict=True):
                for delay, pair in (*self._inside(segment, before), *self._switch(segment, before)):
                    at = pair.index + first
                    own, digits[at] = pair.compare(run, names, numbers)
                    late[at] = delay * unit
                    for name in names:
                        errors[name][at] = own[name]
                first += len(segment.run.events.hits) + bool(segment.ended)
        late = numpy.where(numpy.isfinite(late), late, math.inf)
        digits = numpy.minimum(digits, digits_of_time(late, seconds, unit))
        late = late + numpy.spacing(seconds) / 2 * run.precision.is_float
        return {"name": shown["name"], "t": seconds, TIME: late, **errors, DIGITS: digits}

    def _inside(self, segment: Segment, before: tuple[str, ...]) -> Iterator[tuple[Array, Pair]]:
        """Give the delays of the events inside a segment, after its mode switches ``before``."""
        other, numbers, hits = self.reference, self._numbers, segment.run.events.hits
        if not len(hits):
            return
        time = hits.time + times_in(numbers, [segment.begin])[0]
        rounded = time.astype(float)
        begins = [float(theirs.begin) for theirs in other.segments[1:]]
        at = numpy.searchsorted(begins, rounded, side="left")
        at[rounded > float(other.end_time)] = -1
        for j, theirs in enumerate(other.segments):
            for name, event in segment.setup.watched.items():
                index = numpy.flatnonzero((at == j) & (hits.name == name))
                if len(index) and _switches(other)[j] == before:
                    delay, better = _zeros_of(event, theirs, time[index], numbers)
                    row = [x[index] for x in hits.state]
                    yield delay, Pair(index, segment, row, theirs, better)

    def _switch(self, segment: Segment, before: tuple[str, ...]) -> Iterator[tuple[float, Pair]]:
        """Give the delay of the mode switch that ends a segment."""
        other, numbers = self.reference, self._numbers
        for theirs, switches in zip(other.segments, _switches(other), strict=True):
            if segment.ended and (switches, theirs.ended) == (before, segment.ended):
                pair = _ends(segment, theirs, numbers)
                end = segment.begin + segment.end_time
                index = numpy.array([len(segment.run.events.hits)])
                yield (
                    abs(float(end - theirs.begin - theirs.end_time)),
                    pair._replace(index=index, cleared=segment.cleared),
                )
                return

    @cached_property
    def digits_throughout(self) -> float:
        """Significant digits that hold at every sample, in every event, and in ``t_end``."""
        run = self._run
        digits = [*self.over_time()[DIGITS], self.digits_at_end]
        if run.event_counts:
            digits += [*self.events()[DIGITS]]
        if run.status not in ARRIVED:
            error, unit = numpy.float64(self.at_end["t_end"]), float(run.start.units.time)
            digits.append(digits_of_time(error, float(run.t_end), unit))
        return float(min(digits))


def _ends(mine: Segment, theirs: Segment, numbers: Any) -> Pair:
    """Return the states of two segments at their ends."""
    row, better = ([numbers.array([x]) for x in segment.end_row] for segment in (mine, theirs))
    return Pair(numpy.arange(1), mine, row, theirs, better)


def _switches(run: Solution) -> list[tuple[str, ...]]:
    """Return the mode switches before each segment."""
    ended = [segment.ended for segment in run.segments]
    return [tuple(filter(None, ended[:i])) for i in range(len(ended))]


def _limbs_of(run: Solution) -> Array:
    """Return the dimensionless sample times as sums of three doubles: axes (time, limb)."""
    mpfr = run.precision.mpfr

    def compute() -> Array:
        with mpfr.precision():
            local = mpfr.of_fractions(run.sample_times) / mpfr.number(run.start.units.time)
            return mpfr.to_limbs(local, MOST_LIMBS)

    return run.start.once("sample times in limbs", compute)


def _zeros_of(
    event: Event, segment: Segment, times: Array, numbers: Any
) -> tuple[Array, list[Array]]:
    """Return the delays after ``times`` of a function's zeros, and the states there.

    By one step of Newton's method along the power series at ``times``, or at the segment's end. The
    delay is infinite if the function has no series.
    """
    setup, fn = segment.setup, functions_of(numbers)
    local = times - times_in(numbers, [segment.begin])[0]
    end = times_in(numbers, [segment.end_time])[0]
    inner = numpy.where((local < end).astype(bool), local, end)
    row = segment.at(inner, numbers)
    body = segment.start.body.numbers(numbers.number)
    entries, q = setup.layout.moving(body, tuple(row), fn)
    try:
        value = event_value(event, q)
    except InputError:
        value = None
    if not isinstance(value, TaylorSeries):
        return numpy.full(len(times), math.inf), row
    step = -value[0] / value[1]
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
