"""``Errors``: the estimated errors of a trajectory, by comparison with reference runs.

The exact solution is unknown, so the scene is integrated again: with ``RATIO`` times smaller
truncation errors, or in a finer arithmetic, and with body and start rounded oppositely. Both are
compared at the samples. Their states differ so little that the difference is exact, and the
difference of a column follows to first order. A reference run need not detect events: one step of
Newton's method gives the zero of an event's function in it.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import (
    POSE_NAMES,
    Name,
    digits_of_time,
    digits_over_rows,
    worst_digits,
)
from tt_precise.integration.dense_output import ARRIVED, Hits, Segment, Times, long_double, to_limbs
from tt_precise.integration.equations import event_value
from tt_precise.integration.events import Event
from tt_precise.integration.precision import finer
from tt_precise.integration.reading import (
    Numbers,
    drift_columns,
    end_state,
    event_columns,
    is_drift,
    own_table,
    table,
    values_at_end,
)
from tt_precise.integration.setup import Setup, full_tolerance
from tt_precise.integration.solution import Solution
from tt_precise.mechanics.quantities import UNITLESS, Quantity, UserFunction
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.taylor.series import TaylorSeries

ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
TIME, ERROR_OF_TIME = "error", f"{ERROR}t"  # Errors of events' times: alone, and among columns.
RATIO = 30  # Tolerance of a run over that of its reference run in the same arithmetic.
# Time, in units of sqrt(R/g), from an event to the two values that give the slope of a user's
# function, and terms of the state's series there: four digits of the slope suffice.
ASIDE, ASIDE_ORDER = 2.0**-20, 4
SMALL = 2.0**-600  # scale of deviations, so small that their squares vanish


def reference_runs(setup: Setup) -> list[dict[str, Any]]:
    """The reference runs for a run with ``setup``: the changes for ``Solution.again``.

    A coarse run is compared in its own arithmetic, which costs less. Both round the start and the
    body, so the reference run rounds each number oppositely. In Euler form, and below
    ``Kind.rough``, rounding may dominate the error: the reference run is no better, and may agree
    by chance. Then a second reference run repeats the run with opposite rounding.
    """
    precision = setup.precision
    again = {"events": (), "opposite_rounding": True}
    if setup.tolerance >= precision.kind.coarse * precision.eps or (
        precision.doubles and setup.tolerance >= RATIO * full_tolerance(precision)
    ):
        rough = precision.doubles or setup.tolerance >= precision.kind.rough * precision.eps
        if setup.formulation.coordinates == "newton" and rough:
            # a few steps with RATIO times less err by up to a third, which shows in early events
            fine = setup.events and not precision.doubles
            return [again | {"tolerance": 0.0 if fine else setup.tolerance / RATIO}]
        return [again | {"tolerance": tolerance} for tolerance in (0.0, setup.tolerance)]
    return [{"events": (), "tolerance": 0.0, "precision": finer(precision)}]


def errors_of(run: Solution) -> Errors:
    """The errors of a run by reference runs, which are integrated once."""
    return run.once(Errors, lambda: Errors(run))


def is_estimate(name: Name) -> bool:
    """True if a column has estimated errors."""
    return isinstance(name, str) and (name == DIGITS or name.startswith(ERROR))


def table_with_errors(
    run: Solution,
    wanted: Sequence[Name],
    times: Sequence[Fraction] | Array | None,
    numbers: Numbers,
    progress: Progress | None = None,
) -> dict[Any, Array]:
    """Return ``reading.table`` with columns of estimated errors and of drifts, at the samples.

    Raises ``InputError``: there are times and such columns.
    """
    estimates = _estimated(wanted)
    drifts = [str(name) for name in wanted if is_drift(name)]
    if not estimates and not drifts:
        return table(run, wanted, times, numbers, progress)
    if times is not None:
        raise InputError(
            "times: got times with estimated errors or drifts, which exist only at the "
            "samples, expected no times; choose the samples by sample_every of the scene"
        )
    plain = [name for name in wanted if name not in estimates and name not in drifts]
    columns = table(run, plain or ["theta"], None, numbers, progress)
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


def events_with_errors(
    run: Solution, wanted: Sequence[Name], at: Container[str] | None = None
) -> dict[Any, Array]:
    """Return ``reading.event_columns`` with columns of estimated errors, also of "error:t"."""
    estimates = _estimated(wanted)
    plain = [name for name in wanted if name not in estimates]
    columns = event_columns(run, plain, at)
    if estimates:
        names = tuple(set(estimates.values()) - {DIGITS, "t"})
        errors = errors_of(run).events(names)
        columns |= {name: errors[TIME if of == "t" else of] for name, of in estimates.items()}
    return {name: columns[name] for name in ("name", "t", "direction", *wanted)}


def floats(values: Array | Sequence[Scalar]) -> Array:
    """Numbers of any kind as a float64 array, with NaN for undefined values."""
    if isinstance(values, numpy.ndarray) and values.dtype != object:
        return values.astype(float)
    return numpy.array([math.nan if _missing(v) else float(v) for v in values])


def distance(values: Array, others: Array, fn: Functions) -> Array:
    """Absolute distances of two columns, as a float64 array with NaN for undefined values."""
    kinds = [getattr(column, "dtype", None) for column in (values, others)]
    if all(kind in (float, numpy.longdouble) for kind in kinds):
        with numpy.errstate(invalid="ignore"):
            apart: Array = numpy.abs(values - others).astype(float)
        return numpy.where(numpy.isfinite(apart), apart, math.nan)
    pairs = zip(values, others, strict=True)
    return numpy.array(
        [
            math.nan if _missing(a) or _missing(b) else float(abs(fn.mpf(a) - fn.mpf(b)))
            for a, b in pairs
        ],
        dtype=float,
    )


def _missing(value: Scalar) -> bool:
    return value is None or value != value


class Later(Mapping[Any, Scalar]):
    """Errors that are computed when they are first read."""

    def __init__(self, compute: Callable[[], Mapping[Any, Scalar]]):
        self._compute = compute

    @cached_property
    def _errors(self) -> Mapping[Any, Scalar]:
        return self._compute()

    def __getitem__(self, name: Any) -> Scalar:
        return self._errors[name]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._errors)

    def __len__(self) -> int:
        return len(self._errors)


class Errors:
    """The errors of a ``run``, by other solutions of its scene, or by ``reference_runs``."""

    def __init__(self, run: Solution, others: Sequence[Solution] = ()):
        self._run, self._others = run, tuple(others)

    @cached_property
    def references(self) -> tuple[Solution, ...]:
        """The reference runs, integrated when first needed."""
        if self._others:
            return self._others
        return tuple(self._run.again(**changes) for changes in reference_runs(self._run.setup))

    @cached_property
    def at_end(self) -> dict[str, Scalar]:
        """Absolute error of each entry of the state at the end (SI), and of ``t_end`` (s).

        Infinite if a reference run ends in another way: then neither can be trusted.
        """
        fn, own = self._run.precision.context, values_at_end(self._run)
        estimate: dict[str, Scalar] = {}
        for reference in self.references:
            same, better = reference.status == self._run.status, values_at_end(reference)
            for name, value in own.items():
                if value is not None and better[name] is not None:
                    apart = abs(fn.mpf(value) - fn.mpf(better[name])) if same else fn.inf
                    estimate[name] = max(apart, estimate.get(name, apart))
        return estimate

    @property
    def available(self) -> bool:
        """True if the reference trajectories are integrated already."""
        return "references" in self.__dict__

    @property
    def available_at_end(self) -> Mapping[str, Scalar]:
        """Errors of the state, and of "t" if the end was computed; empty without references."""
        if not self.available:
            return {}
        of_its_own = self._run.status not in ARRIVED
        return self.at_end | ({"t": self.at_end["t_end"]} if of_its_own else {})

    @property
    def digits_at_end(self) -> float:
        """Significant digits of the worst component of the state at the end."""
        return worst_digits(end_state(self._run), self.at_end, self._run.start)

    def over_time(self, names: Sequence[Name] = ()) -> dict[Any, Array]:
        """Float64 columns at the samples: t, the errors of ``names`` (SI), and "digits".

        "digits" are those of the state's worst component. An error is the largest distance from a
        reference run, infinite if one of them has ended in another way.
        """
        run, state = self._run, self._run.columns.names
        every = tuple(dict.fromkeys([*state, *names]))
        times = run.sample_times
        alone = run.alone
        own = States(alone, times) if alone else None
        if own:
            columns = run.columns.of_arrays(state, tuple(own.floats), float)
        else:
            columns = own_table(run, state, times, "float")
        values = {name: floats(column) for name, column in columns.items() if name != "t"}
        errors = self.at_times(times, every, own)
        known = {name: errors[name] for name in state}
        digits = digits_over_rows(values, known, run.start, run.precision.bits)
        seconds = numpy.array([float(t) for t in times])
        return {"t": seconds, **{name: errors[name] for name in names}, "digits": digits}

    def at_times(
        self, times: Sequence[Fraction], names: Sequence[Name], own: States | None = None
    ) -> dict[Name, Array]:
        """The errors (SI) of columns at exact ``times`` (s), where ``own`` are the run's states."""
        errors = {name: numpy.zeros(len(times)) for name in names}
        for reference in self.references:
            for name, apart in self._distances(reference, names, times, own).items():
                errors[name] = numpy.fmax(errors[name], apart)
        return errors

    def events(self, names: Sequence[Name] = ()) -> dict[Any, Array]:
        """Columns of the events: name, t, error (s), the errors of ``names`` (SI), "digits"."""
        return event_errors(self._run, self.references, names)

    @cached_property
    def digits_throughout(self) -> float:
        """Significant digits that hold at every sample, in every event, and in ``t_end``."""
        run = self._run
        digits = [*self.over_time()["digits"]]
        if run.event_counts:
            digits += [*self.events()["digits"]]
        if run.status not in ARRIVED:
            error, unit = float(self.at_end["t_end"]), float(run.start.units.time)
            digits.append(digits_of_time(numpy.float64(error), float(run.t_end), unit))
        return float(min(digits))

    def _distances(
        self,
        reference: Solution,
        names: Sequence[Name],
        times: Sequence[Fraction],
        own: States | None,
    ) -> dict[Name, Array]:
        """Distances of the columns from a reference's columns; NaN where a value is undefined."""
        arrived, last = self._run.status in ARRIVED, as_fraction(self._run.end)
        end = float(reference.end) * (1 + 1e-15)  # two runs to one horizon differ by roundings
        # if the model ends before its horizon, the runs have different ends
        inner = numpy.array([t <= end and (arrived or t < last) for t in times], dtype=bool)
        same = own if inner.all() else None
        distances = compare(
            self._run, reference, names, [t for t, i in zip(times, inner, strict=True) if i], same
        )
        for name in names:
            apart = numpy.full(len(times), math.inf)
            apart[inner] = distances[name]
            if reference.status == self._run.status and not arrived:
                apart[~inner] = float(self.at_end.get(str(name), math.nan))
            distances[name] = apart
        return distances


def compare(
    run: Solution,
    reference: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction],
    states: States | None = None,
) -> dict[Name, Array]:
    """Absolute distances (SI) of the columns ``names`` of two runs, as float64 arrays.

    To first order from the exact differences of their ``states``, if both integrate the same
    equations throughout; otherwise column by column.
    """
    segment, other = run.alone, reference.alone
    kinds = [(r.setup.formulation, r.setup.record) for r in (run, reference)]
    differentiable = not any(isinstance(n, Quantity) or n in POSE_NAMES for n in names)
    if not (segment and other and kinds[0] == kinds[1] and differentiable):
        own, others = (own_table(r, names, times, "exact") for r in (run, reference))
        context = reference.precision.context
        return {name: distance(own[name], others[name], context) for name in names}
    if not len(times):
        return {name: numpy.zeros(0) for name in names}
    values, apart = (states or States(segment, times)).differences(States(other, times))
    entries = numpy.empty(values.shape, dtype=complex)
    entries.real, entries.imag = values, SMALL * apart
    with numpy.errstate(all="ignore"):
        carried = segment.columns.of_arrays(names, tuple(entries), float, deviations())
        errors = {name: numpy.abs(numpy.imag(column)) / SMALL for name, column in carried.items()}
    return {
        name: numpy.where(numpy.isfinite(numpy.real(carried[name])), error, math.nan)
        for name, error in errors.items()
    }


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


class States:
    """The states of a run under one set of equations at some times: axes (entry, time)."""

    def __init__(self, segment: Segment, times: Sequence[Fraction]):
        self._output, self._times = segment.output, times
        self.precision = segment.output.precision
        self.in_long_double = self.precision.in_long_double

    def differences(self, other: States) -> tuple[Array, Array]:
        """The states, and their exact differences from others at the same times: float64."""
        both = self, other
        if all(states.in_long_double for states in both):
            apart = self.long_doubles - other.long_doubles
        elif all(states.in_limbs for states in both):
            count = min(len(self.limbs), len(other.limbs))
            # the first parts are close to each other, so their differences are exact
            apart = sum(self.limbs[:count] - other.limbs[:count])
            apart = apart + sum(self.limbs[count:]) - sum(other.limbs[count:])
        else:
            mpfr = max(
                (states.precision for states in both), key=lambda precision: precision.bits
            ).mpfr
            with mpfr.precision():
                apart = self.mpfr - other.mpfr
        return self.floats, apart.astype(float)

    @cached_property
    def floats(self) -> Array:
        """The states in float64."""
        if self.in_long_double:
            return self.long_doubles.astype(float)
        return self.limbs[0] if self.in_limbs else self.mpfr.astype(float)

    @property
    def in_limbs(self) -> bool:
        """True if all series are stored, in several doubles."""
        return bool(self.precision.doubles) and self._output.has_series

    @cached_property
    def long_doubles(self) -> Array:
        """The states in long double."""
        return numpy.array(self._output.arrays(self._output.times(self._times), long_double))

    @cached_property
    def limbs(self) -> Array:
        """The states in several doubles, along the first axis."""
        samples = self._output.samples
        if samples and tuple(self._times) == samples.exact:
            moments = samples.limbs
        else:
            moments = to_limbs(self._times, self._output.start.units.time, self.precision.mpfr)
        states: Array = self._output.to_limbs(moments).transpose(1, 2, 0)
        return states

    @cached_property
    def mpfr(self) -> Array:
        """The states in wide numbers."""
        return numpy.array(self._output.mpfr_arrays(self.precision.mpfr.of_fractions(self._times)))


class Stage(NamedTuple):
    """A segment, and the mode switches before it."""

    segment: Segment
    before: tuple[str, ...]


def _stages(run: Solution) -> list[Stage]:
    ends = [segment.ended for segment in run.segments]
    return [
        Stage(segment, tuple(filter(None, ends[:place])))
        for place, segment in enumerate(run.segments)
    ]


def event_errors(
    run: Solution, references: Sequence[Solution], wanted: Sequence[Name] = ()
) -> dict[Any, Array]:
    """Columns of the events in order of time: name, t, error (s), errors (SI), and "digits".

    The error of a column in ``wanted`` is that of its value as ``event_columns`` gives it, at the
    event's own time. "digits" are the fewest correct digits of the state there and of the time. An
    error is the largest of the distances from ``references``, infinite if one of them has ended
    before, or is in another part of its motion; in double the rounding of the time is added.
    """
    unit = float(run.start.units.time)
    others = [(float(reference.end) / unit, _stages(reference)) for reference in references]
    names: list[str] = []
    columns: list[tuple[Array, Array, Array, Array]] = []
    for part in _stages(run):
        hits = part.segment.output.propagation.found.hits
        names += hits.name.tolist()
        columns.append(_errors_within(part, hits, others, wanted))
        if part.segment.ended:
            names.append(part.segment.ended)
            columns.append(_errors_of_switch(part, [parts for _, parts in others], wanted))
    times, errors, digits, apart = (
        numpy.concatenate(column, axis=-1) for column in zip(*columns, strict=True)
    )
    most = run.precision.bits * math.log10(2)
    digits = numpy.minimum(numpy.minimum(digits, digits_of_time(errors, times, unit)), most)
    if run.precision.is_float:
        errors = errors + numpy.spacing(times) / 2
    rows = numpy.array(names, dtype=object)
    known = dict(zip(wanted, apart, strict=True))
    return {"name": rows, "t": times, TIME: errors, **known, "digits": digits}


def _errors_within(
    part: Stage,
    hits: Hits,
    others: Sequence[tuple[float, Sequence[Stage]]],
    wanted: Sequence[Name],
) -> tuple[Array, Array, Array, Array]:
    """Times and errors (s) of the events inside a segment, digits of their states, and errors.

    ``others`` are the ends (dimensionless) and the parts of reference runs. The last array has the
    errors (SI) of the columns ``wanted``: axes (column, event).
    """
    of = part.segment.columns
    unit = float(of.start.units.time)
    times = (float(part.segment.begin) + hits.time.astype(float)) * unit
    errors, digits = numpy.zeros(len(hits)), numpy.full(len(hits), math.inf)
    apart = numpy.zeros((len(wanted), len(hits)))
    for last, parts in others:
        alike: dict[tuple[str, int], list[int]] = {}
        begins = [float(other.segment.begin) * unit for other in parts]
        for place, name in enumerate(hits.name):
            at = max(bisect.bisect_left(begins, times[place]) - 1, 0)
            alike.setdefault((name, at), []).append(place)
        for (name, at), places in alike.items():
            event = part.segment.output.setup.watched[name]
            here = hits.of(numpy.array(places))
            late, right, far = _distances_of(part, here, event, parts[at], last, wanted)
            errors[places] = numpy.maximum(errors[places], late)
            digits[places] = numpy.minimum(digits[places], right)
            apart[:, places] = numpy.maximum(apart[:, places], far)
    return times, errors, digits, apart


def _errors_of_switch(
    part: Stage, others: Sequence[Sequence[Stage]], wanted: Sequence[Name]
) -> tuple[Array, Array, Array, Array]:
    """Time, error (s), digits and errors, as ``_errors_within``, of the end of a segment."""
    of, context = part.segment.columns, part.segment.columns.precision.context
    (time, state), values = _end(part), of.of_rows(wanted, [part.segment.output.end_row])
    shown = {name: list(map(of.to_user, column)) for name, column in values.items()}
    rest = [[abs(shown[n][0] or 0) if n in part.segment.cleared else 0.0] for n in wanted]
    error, digits, far = 0.0, math.inf, numpy.array(rest, dtype=float).reshape(len(wanted), 1)
    for parts in others:
        same = [
            p for p in parts if (p.before, p.segment.ended) == (part.before, part.segment.ended)
        ]
        if not same:
            error, digits, far = math.inf, 0.0, numpy.full_like(far, math.inf)
            continue
        other_time, other_state = _end(same[0])
        error = max(error, float(abs(time - other_time)))
        if wanted:
            there = of.of_rows(wanted, [same[0].segment.output.end_row])
            distances = [distance(shown[name], there[name], context) for name in wanted]
            far = numpy.maximum(far, distances)
        apart = {name: distance(state[name], other_state[name], context) for name in state}
        values = {name: floats(column) for name, column in state.items()}
        right = digits_over_rows(values, apart, of.start, of.precision.bits)
        digits = min(digits, float(right[0]))
    return numpy.array([float(time)]), numpy.array([error]), numpy.array([digits]), far


def _end(part: Stage) -> tuple[Scalar, Mapping[str, Sequence[Scalar | None]]]:
    """The time (s) at which a segment ends, and the columns of the state at this time."""
    of, output = part.segment.columns, part.segment.output
    time = (part.segment.begin + output.end_time) * of.start.units.time
    state = of.of_rows(of.names, [part.segment.output.end_row])
    return time, state | {name: [time * 0] for name in part.segment.cleared if name in state}


def _distances_of(
    part: Stage,
    hits: Hits,
    event: Event,
    other_part: Stage,
    last: float,
    wanted: Sequence[Name],
) -> tuple[Array, Array, Array]:
    """Distances in time (s), digits of states, distances of ``wanted``, at an event's times.

    They are those from a reference that ends at the time ``last`` (dimensionless).
    """
    late, digits = numpy.full(len(hits), math.inf), numpy.zeros(len(hits))
    far = numpy.full((len(wanted), len(hits)), math.inf)
    hits = hits.of(float(part.segment.begin) + hits.time.astype(float) <= last)
    if not len(hits) or part.before != other_part.before:
        return late, digits, far
    of, other = part.segment.columns, other_part.segment.columns
    mpf, mpfr = other.precision.context.mpf, other.precision.mpfr
    shift = mpf(part.segment.begin) - mpf(other_part.segment.begin)
    number: Callable[[Scalar], Scalar] = mpfr.number
    fn: Functions = mpfr
    if other.precision.in_long_double:
        number, fn = long_double, numpy
    with mpfr.precision(), numpy.errstate(all="ignore"):
        times = [mpf(time) + shift for time in hits.time.tolist()]
        delay, there = _zeros(other_part.segment, times, event, number, fn)
        rows = numpy.frompyfunc(lambda x: number(mpf(x)), 1, 1)(hits.state.T)
        every = tuple(dict.fromkeys([*of.names, *wanted]))
        values = of.of_arrays(every, tuple(numpy.array(row.tolist()) for row in rows), number, fn)
        others = other.of_arrays(every, there, number, fn)
        apart = {name: abs(values[name] - others[name]).astype(float) for name in of.names}
        # what a user has of a run in double is rounded
        shown = {n: values[n].astype(float) if of.precision.is_float else values[n] for n in wanted}
        rounded = [abs(shown[name] - others[name]).astype(float) for name in wanted]
    inner, floating = slice(0, len(hits)), {name: floats(values[name]) for name in of.names}
    late[inner] = numpy.abs(delay) * float(of.start.units.time)
    digits[inner] = digits_over_rows(floating, apart, of.start, of.precision.bits)
    if wanted:
        far[:, inner] = rounded
    return numpy.where(numpy.isfinite(late), late, math.inf), digits, far


def _zeros(
    segment: Segment,
    times: Sequence[Scalar],
    event: Event,
    number: Callable[[Scalar], Scalar],
    fn: Functions,
) -> tuple[Array, tuple[Array, ...]]:
    """The delays after ``times`` at which an event's function vanishes, and the states then.

    By one step of Newton's method along the power series at ``times``, or at the segment's end.
    """
    setup, end = segment.output.setup, segment.output.end_time
    inner = [min(time, end) for time in times]
    if fn is numpy:
        rounded = numpy.array([float(time) for time in inner])
        rest = numpy.array([float(time - float(time)) for time in inner])
        rows = segment.output.arrays(Times(rounded, rounded, rest), number)
    else:
        rows = tuple(map(fn.array, zip(*segment.output.rows(inner), strict=True)))
    body = segment.output.start.body.numbers(number)
    entries, q = setup.layout.moving(body, rows, fn)
    if event.of_rate or not isinstance(event.function, UserFunction):
        value = event_value(event, q)
        if not isinstance(value, TaylorSeries):
            return numpy.full(len(times), math.inf), rows
        step = -value[0] / value[1]
    else:  # it has values, but may have no series

        def at(delay: float) -> Scalar:
            row = tuple(sum(x[k] * delay**k for k in range(ASIDE_ORDER)) for x in entries)
            value = event_value(event, setup.layout.motion(body, row, fn))
            # of a fraction and a long double NumPy makes an object
            return value.astype(numpy.longdouble) if fn is numpy else value

        slope = (at(ASIDE) - at(-ASIDE)) / (2 * ASIDE)
        step = -at(0.0) / numpy.where(slope, slope, math.nan)
    there = tuple(x[0] + step * (x[1] + step * x[2]) for x in entries)
    form = setup.formulation
    before, after = (form.State(*entries[: len(form.columns)]) for entries in (rows, there))
    delay = form.State.elapsed(step, before, after)
    return delay.astype(float) - [float(t - i) for t, i in zip(times, inner, strict=True)], there
