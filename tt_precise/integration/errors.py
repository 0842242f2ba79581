"""``Errors``: the estimated errors of a trajectory, by comparison with a finer run.

The finer run has the cheapest arithmetic with a tolerance that is ``RATIO`` times smaller. States
differ so little that their difference is exact, and the difference of a column follows to first
order. The finer run detects no events: one step of Newton's method gives the zero in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.integration import reading
from tt_precise.integration.columns import POSE_NAMES, Name, name_of
from tt_precise.integration.equations import event_value
from tt_precise.integration.events import ARRIVED, Event
from tt_precise.integration.precision import LONG_DOUBLES, functions_of, precision_named, times_in
from tt_precise.integration.setup import full_tolerance, refused_in_doubles
from tt_precise.integration.solution import TIME_TOLERANCE, Segment, Solution
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import UNITLESS, Quantity
from tt_precise.runtime.values import Array, InputError, whole_number
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import InitialState, Scene
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.series import TaylorSeries

ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
RATIO = 30  # Tolerance of a run over that of its finer run, whose own error is then 3 % of it.
# Tolerance, in eps of double, from which a run in double with full tolerance shows the errors.
COARSE = 1000
SMALL = 2.0**-600  # scale of deviations, so small that their squares vanish


def finer(run: Solution) -> dict[str, Any]:
    """Return the changes for ``Solution.again`` that give the finer run."""
    own, fn, tolerance = run.precision, run.precision.context, run.tolerance / RATIO
    if own.is_float and run.tolerance >= COARSE * own.eps:
        return {"tolerance": 0.0, "events": ()}
    names = () if refused_in_doubles(run.scene) else ("double-double", "triple-double")
    for precision in map(precision_named, names):
        if full_tolerance(precision) <= tolerance:
            return {"precision": precision, "tolerance": float(tolerance), "events": ()}
    precision = precision_named("mp", math.ceil(1 - fn.log(tolerance, 2)))
    return {"precision": precision, "tolerance": 0.0, "events": ()}


def errors_of(run: Solution) -> Errors:
    """The errors of a run; its finer run is integrated when an error is first read."""
    return run.once(Errors, lambda: Errors(run))


def table_with_errors(
    run: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction] | Array | None,
    numbers: reading.Numbers,
) -> dict[str, Array]:
    """Return ``reading.table`` by the names that users read, with errors and drifts."""
    plain, estimates = _estimated(names)
    drifts = [str(name) for name in plain if reading.is_drift(name)]
    if times is not None and (drifts or estimates):
        raise InputError(
            "times: got times with estimated errors or drifts, which exist only at the "
            "samples, expected no times; choose the samples by sample_every of the scene"
        )
    columns = reading.table(run, [name for name in plain if name not in drifts], times, numbers)
    if drifts:
        columns |= reading.drift_columns(run, drifts, numbers)
    if estimates:
        errors = errors_of(run).over_time(estimates.values())
        columns |= {name: errors[of] for name, of in estimates.items()}
        if numbers == "text":
            columns |= {name: shortest_texts(columns[name]) for name in estimates}
    return {name_of(name): columns[name] for name in ("t", *names)}


def events_with_errors(run: Solution, names: Sequence[Name]) -> dict[str, Array]:
    """Return ``reading.event_columns`` by the names that users read, with errors of times too."""
    plain, estimates = _estimated(names)
    columns = reading.event_columns(run, plain)
    if estimates:
        errors = errors_of(run).events(estimates.values())
        columns |= {name: errors[of] for name, of in estimates.items()}
    return {name_of(name): columns[name] for name in ("name", "t", "direction", *names)}


def _estimated(names: Sequence[Name]) -> tuple[list[Name], dict[Name, Name]]:
    """Separate columns of errors from others; each maps to the column whose error it is."""
    own = {name.name.removesuffix(UNITLESS): name for name in names if isinstance(name, Quantity)}
    estimates = dict[Name, Name]()
    for name in names:
        if isinstance(name, str) and (name == DIGITS or name.startswith(ERROR)):
            column = name.removeprefix(ERROR)
            estimates[name] = own.get(column.removesuffix(UNITLESS), column)
    return [name for name in names if name not in estimates], estimates


class Pair(NamedTuple):
    """States of a run and of its finer run, for the rows ``index`` of a table of errors.

    ``delay`` is the difference of the instants (dimensionless). Components are arrays of one
    arithmetic, or of sums of doubles: axes (instant, limb).
    """

    index: Array
    segment: Segment
    row: Sequence[Array]
    other: Segment
    better: Sequence[Array]
    delay: Array | float = 0.0

    def compare(
        self, names: Sequence[Name], numbers: Any
    ) -> tuple[dict[Any, Array], dict[Any, Array]]:
        """Compute columns (SI) in double, and their errors, no less than the rounding of columns.

        Under other equations, and for user-defined functions and poses, columns are compared;
        otherwise the differences of the states are propagated to first order.
        """
        alike = self.segment.setup.layout == self.other.setup.layout
        plain = [n for n in names if alike and not (isinstance(n, Quantity) or n in POSE_NAMES)]
        others = [name for name in names if name not in plain]
        values, errors = dict[Any, Array](), dict[Any, Array]()
        with numpy.errstate(all="ignore"):
            if plain:
                row = list(map(_deviating, self.row, self.better))
                columns = self.segment.columns.of_arrays(plain, row, Deviations)
                values = {name: numpy.real(column) for name, column in columns.items()}
                errors = {name: abs(numpy.imag(x)) / SMALL for name, x in columns.items()}
            if others:
                both = []
                for segment, state in ((self.segment, self.row), (self.other, self.better)):
                    sums = [numbers.from_limbs(x) if x.ndim == 2 else x for x in state]
                    both.append(segment.columns.of_arrays(others, sums, numbers))
                values |= {name: both[0][name].astype(float) for name in others}
                errors |= {n: abs((both[0][n] - both[1][n]).astype(float)) for n in others}
            ulp = 2.0 ** max(53 - self.segment.setup.precision.bits, -1000)  # in those of double
            for name, x in values.items():
                errors[name] = errors[name] + (x != 0) * numpy.spacing(abs(x)) * ulp
            return values, errors


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


class Deviations:
    """Arithmetic of numbers x with a small deviation d: an analytic f(x + i d) is f + i d f'."""

    number = float
    cos, sin, sqrt, exp, log = numpy.cos, numpy.sin, numpy.sqrt, numpy.exp, numpy.log

    @staticmethod
    def atan2(y: Array, x: Array) -> Array:
        """Angle of (x, y), its deviation without the cancellation that a logarithm would have."""
        turned = (x.real * y.imag - y.real * x.imag) / (x.real * x.real + y.real * y.real)
        return numpy.arctan2(y.real, x.real) + 1j * turned


class Errors:
    """The errors of a ``run``: its distances from a finer run, or from the solution ``other``.

    Tables have "t", the error of the instant (s), the errors of columns (SI), and "digits", those
    of the state's worst component. Errors are infinite where the finer run has no such instant.
    """

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
        other = self.reference.precision
        hardware = self._run.precision.is_float and (other.is_float or other.doubles)
        return LONG_DOUBLES if hardware else other.mpfr

    def _table(
        self, pairs: Iterable[Pair], count: int, names: Iterable[Name] = ()
    ) -> dict[Any, Array]:
        """Return the table of errors at ``count`` instants, of which ``pairs`` have the states."""
        run, state = self._run, self._run.columns.names
        every = [name for name in dict.fromkeys([*state, *names]) if name not in (DIGITS, "t")]
        errors = {name: numpy.full(count, math.inf) for name in ("t", *every)}
        errors[DIGITS] = numpy.zeros(count)
        with self._numbers.precision():
            for pair in pairs:
                values, own = pair.compare(every, self._numbers)
                values, known = ({name: x[name] for name in state} for x in (values, own))
                own["t"] = pair.delay * float(run.start.units.time)
                own[DIGITS] = digits_over_rows(values, known, run.start, run.precision.bits)
                for name, column in own.items():
                    errors[name][pair.index] = column
        return errors

    def _ends(self, mine: Segment, theirs: Segment, row: int) -> Pair:
        """Return the states of two segments at their ends, for one row of a table."""
        delay = abs(float(mine.begin + mine.end_time - theirs.begin - theirs.end_time))
        own, better = ([self._numbers.array([x]) for x in s.end_row] for s in (mine, theirs))
        return Pair(numpy.array([row]), mine, own, theirs, better, delay)

    def _last(self, row: int) -> list[Pair]:
        """Return the states of both runs at their ends; none if these are of different kinds."""
        run, other = self._run, self.reference
        alike = run.status == other.status
        return [self._ends(run.segments[-1], other.segments[-1], row)] if alike else []

    @cached_property
    def _at_end(self) -> dict[Any, Array]:
        return self._table(self._last(0), 1)

    @cached_property
    def at_end(self) -> dict[str, float]:
        """Absolute error of each component of the state at the end (SI), and of ``t_end`` (s)."""
        run, errors = self._run, {n: float(x[0]) for n, x in self._at_end.items() if n != DIGITS}
        t_end = errors.pop("t") + float(run.end * run.precision.eps)
        return {"t_end": t_end, **{name: x for name, x in errors.items() if not math.isnan(x)}}

    @property
    def digits_at_end(self) -> float:
        """Significant digits of the worst component of the state at the end."""
        return float(self._at_end[DIGITS][0])

    def over_time(self, names: Iterable[Name] = ()) -> dict[Any, Array]:
        """The table of errors at the samples; at an early end each run has its own."""
        return self._table(self._samples, len(self._run.sample_times), names)

    @cached_property
    def _samples(self) -> list[Pair]:
        """The states of both runs at the samples, up to the end of the finer run."""
        run, other, times = self._run, self.reference, self._run.sample_times
        arrived = run.status in ARRIVED
        if _in_limbs(run) and _in_limbs(other):
            mine, theirs, mpfr = run.segments[0], other.segments[0], other.precision.mpfr
            with mpfr.precision():
                local = mpfr.of_fractions(times) / mpfr.number(run.start.units.time)
                limbs = mpfr.to_limbs(local, MOST_LIMBS)
            both = mine.series.at(limbs, None), theirs, theirs.series.at(limbs, None)
            return [Pair(numpy.arange(len(times)), mine, *both)]
        inner: Sequence[Fraction] = other.sample_times
        if not (arrived and other.status in ARRIVED):
            end = as_fraction(other.end) * (1 + TIME_TOLERANCE)
            inner = [t for t in (times if arrived else times[:-1]) if t <= end]
        pairs = []
        for theirs, number, better in reading.states_at(other, inner, self._numbers):
            for mine, at, row in reading.states_at(run, times, self._numbers):
                index, first, second = numpy.intersect1d(at, number, return_indices=True)
                if len(index):
                    both = [x[first] for x in row], theirs, [x[second] for x in better]
                    pairs.append(Pair(index, mine, *both))
        return pairs if arrived else [*pairs, *self._last(len(times) - 1)]

    def events(self, names: Iterable[Name] = ()) -> dict[Any, Array]:
        """The table of errors of the events in order of time; their digits include the time's.

        Errors are infinite if the finer run has ended before, or is in another part of its motion.
        """
        run, unit = self._run, float(self._run.start.units.time)
        seconds = reading.event_columns(run, ())["t"].astype(float)
        errors = self._table(self._events(), len(seconds), names)
        late = numpy.where(numpy.isfinite(errors["t"]), errors["t"], math.inf)
        digits = numpy.minimum(errors[DIGITS], digits_of_time(late, seconds, unit))
        late = late + numpy.spacing(seconds) / 2 * run.precision.is_float
        return {**errors, "t": late, DIGITS: digits}

    def _events(self) -> Iterator[Pair]:
        """Give the states of both runs at each one's events, after the same mode switches."""
        run, other, numbers, first = self._run, self.reference, self._numbers, 0
        mine, theirs = _switches(run), _switches(other)
        end = times_in(numbers, [other.end_time])[0]
        for segment in run.segments:
            hits = segment.run.events.hits
            time = hits.time + times_in(numbers, [segment.begin])[0]
            here = numpy.flatnonzero(time.astype(float) <= float(other.end_time))
            inner = numpy.where((time < end).astype(bool), time, end)[here]
            for finer_segment, at, better in reading.at_times(other, inner, numbers):
                if theirs[finer_segment] != mine[segment]:
                    continue
                for name, event in segment.setup.watched.items():
                    chosen = hits.name[here[at]] == name
                    if chosen.any():
                        index = here[at[chosen]]
                        near = [x[chosen] for x in better]
                        delay, there = _zero(event, finer_segment, near, numbers)
                        late = abs((delay + inner[at[chosen]] - time[index]).astype(float))
                        row = [x[index] for x in hits.state]
                        yield Pair(first + index, segment, row, finer_segment, there, late)
            first += len(hits)
            if segment.ended:
                after = (*mine[segment], segment.ended)
                for finer_segment in other.segments:
                    if (*theirs[finer_segment], finer_segment.ended) == after:
                        yield self._ends(segment, finer_segment, first)
                first += 1

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


def _switches(run: Solution) -> dict[Segment, tuple[str, ...]]:
    """Return the mode switches before each segment."""
    ended = [segment.ended for segment in run.segments]
    return {x: tuple(filter(None, ended[:i])) for i, x in enumerate(run.segments)}


def _in_limbs(run: Solution) -> bool:
    """True if a run is one series of sums of doubles, up to the horizon."""
    simple = len(run.segments) == 1 and not run.segments[0].setup.phase.has_clock
    return bool(run.precision.doubles and run.status in ARRIVED and run.steps and simple)


def _zero(
    event: Event, segment: Segment, row: Sequence[Array], numbers: Any
) -> tuple[Array, Sequence[Array]]:
    """Return the delays of an event's zeros after states, and the states there.

    The delay, by one step of Newton's method, is NaN if the function has no power series.
    """
    setup, fn = segment.setup, functions_of(numbers)
    body = segment.start.body.numbers(numbers.number)
    entries, q = setup.layout.moving(body, tuple(row), fn)
    try:
        value = event_value(event, q)
    except InputError:
        value = None
    if not isinstance(value, TaylorSeries):
        return numpy.full(len(row[0]), math.nan), row
    step = -value[0] / value[1]
    there = [x[0] + step * (x[1] + step * x[2]) for x in entries]
    form = setup.formulation
    before, after = (form.State(*x[: len(form.columns)]) for x in (row, there))
    return form.State.elapsed(step, before, after), there


def digits_over_rows(
    columns: Mapping[str, Array], errors: Mapping[str, Array], start: InitialState, bits: int
) -> Array:
    """Correct digits of the worst component of many states, from columns and errors in SI."""
    unit = {n: float(start.units.of_dimension(STATE_DIMENSIONS[n])) for n in columns}
    with numpy.errstate(all="ignore"):
        own = {name: values / unit[name] for name, values in columns.items()}
        scales = sizes(start.body.numbers(float), own, numpy)
        # an entry that is undefined in both, at a pole, has no error
        worst = numpy.fmax.reduce([errors[n] / (unit[n] * scales[n]) for n in errors], initial=0)
        return numpy.clip(-numpy.log10(worst), 0.0, bits * math.log10(2))


def digits_of_time(error: Array, time: Array, unit: float) -> Array:
    """Correct digits of a time, relative to the larger of the time and the unit of time."""
    with numpy.errstate(divide="ignore"):
        return numpy.maximum(-numpy.log10(error / numpy.maximum(time, unit)), 0.0)


RESERVE = 0.1  # Digits by which an estimate must exceed the requested ones; its error is 0.05.
LOSS = 2.0  # Digits of the tolerance that most scenes lose.
MOST_DIGITS = 300  # Errors are doubles, of which the smallest is 1e-308.
FEWEST_BITS_OF_MP = 128


class Level(NamedTuple):
    """An arithmetic and a tolerance; ``bits`` only for mp, which has its full accuracy."""

    precision: str
    tolerance: float
    bits: int | None = None

    @property
    def digits(self) -> float:
        """Digits of the tolerance, or of the bits in mp."""
        return -math.log10(self.tolerance) if self.tolerance else math.log10(2) * (self.bits or 0)


# heyoka's error follows its order, which rises by one at exp(-30) = 9.36e-14
LADDER = (
    Level("double", 1e-10), Level("double", 9.3e-14),
    Level("double-double", 1e-18), Level("double-double", 1e-23), Level("double-double", 1e-28),
    Level("triple-double", 1e-34), Level("triple-double", 1e-40), Level("triple-double", 3e-45),
)  # fmt: skip


def integrate_to_digits(digits: Any, scene: Scene, run: Callable[[Level], Solution]) -> Solution:
    """Return the solution from the first level that delivers ``digits`` throughout.

    The next level adds the digits that the estimate lacks. Where the signs of events stay
    unresolved, finer arithmetics follow while they resolve more.
    """
    whole_number(digits, "digits", 1, MOST_DIGITS)
    refused, needed, best = refused_in_doubles(scene), digits + LOSS, -math.inf
    levels = [level for level in LADDER if level.precision == "double" or not refused]
    coarse: Solution | None = None  # has the digits, but unresolved events
    while True:
        bits = max(FEWEST_BITS_OF_MP, math.ceil(needed / math.log10(2)))
        level = next((x for x in levels if x.digits >= needed), Level("mp", 0.0, bits))
        solution = run(level)
        failed = solution.status == "failed"
        reached = 0.0 if failed else errors_of(solution).digits_throughout
        if reached >= digits + RESERVE:
            unresolved = len(solution.events_with("unresolved"))
            if coarse and unresolved >= len(coarse.events_with("unresolved")):
                return coarse
            others = [x for x in levels
                      if x.digits > level.digits and x.precision != level.precision]  # fmt: skip
            if not unresolved or not others:
                return solution
            # the finest of the next arithmetic, whose first step is short
            needed = max(x.digits for x in others if x.precision == others[0].precision)
            coarse = solution
            continue
        if level.bits and reached < best + RESERVE:
            raise InputError(
                f"digits: got {digits}, but {scene.name} has {reached:.1f} in mp with "
                f"{level.bits} bits ({solution.status} at {float(solution.t_end):.3g} s), and "
                "finer numbers gain no more; expected fewer digits, or a precision in their place"
            )
        best = max(best, reached)
        needed = level.digits + max(digits + RESERVE - reached, LOSS if level.bits else RESERVE)
