"""``DenseOutput``: the rows of one propagation at any time, from the Taylor series of its steps.

heyoka evaluates the series of a step in a buffer that its next evaluation overwrites. Therefore one
thread at a time evaluates, and the result is a copy.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, TypeGuard

import numpy

from tt_precise.integration.columns import Columns, Row
from tt_precise.integration.precision import Precision
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.mpfr import Mpfr, mpfr_of
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, ContinuousOutput, Functions, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction, to_mpmath
from tt_precise.scene.scene import Scene
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.system import moments

ARRIVED = ("complete", "contact_ignored")  # at the scene's horizon
LARGEST_EXACT = 2**53  # integers up to this limit are doubles, so a quotient of two is rounded once


def is_doubles(times: Any) -> TypeGuard[numpy.ndarray]:
    """True for times in an array of doubles, which need no conversion."""
    return isinstance(times, numpy.ndarray) and times.dtype == float and times.ndim == 1


class Times(NamedTuple):
    """Times as float64 arrays of one shape.

    ``seconds`` are the doubles nearest to the exact times in s. ``rounded`` + ``delay`` is the
    dimensionless time with the 64 bits of a long double: heyoka takes ``rounded``.
    """

    seconds: Array
    rounded: Array
    delay: Array

    @classmethod
    def of(cls, times: Sequence[Fraction] | Array, unit: Scalar) -> Times:
        """Exact ``times`` in s; ``unit`` is the unit of time in s, an mpmath number."""
        if is_doubles(times):
            return cls._of_doubles(times, times.astype(numpy.longdouble), unit)
        above, below = [t.numerator for t in times], [t.denominator for t in times]
        if max(map(abs, above + below), default=0) < LARGEST_EXACT:
            numerator, denominator = (numpy.array(part, dtype=float) for part in (above, below))
            seconds = numerator / denominator
            exact = numerator.astype(numpy.longdouble) / denominator
        else:
            seconds = numpy.array([float(t) for t in times])
            low = [float(t - Fraction(s)) for t, s in zip(times, seconds.tolist(), strict=True)]
            exact = seconds + numpy.array(low, dtype=numpy.longdouble)
        return cls._of_doubles(seconds, exact, unit)

    @classmethod
    def _of_doubles(cls, seconds: Array, exact: Array, unit: Scalar) -> Times:
        inner = exact / long_double(unit)
        rounded = inner.astype(float)
        return cls(seconds, rounded, (inner - rounded).astype(float))


@dataclass(frozen=True, eq=False)
class SampleTimes:
    """The sample times of a scene: exact, in s, and as doubles."""

    exact: tuple[Fraction, ...]
    doubles: Times
    start: InitialState

    @cached_property
    def limbs(self) -> Array:
        """The dimensionless times, each as three doubles: axes (time, part)."""
        until = self.start.until
        inner = to_limbs(self.exact[:-1], self.start.units.time, mpfr_of(until.context))
        return numpy.concatenate([inner, moments([until])])

    @classmethod
    def of(cls, scene: Scene, start: InitialState) -> SampleTimes:
        """The doubles end with the horizon of ``start``, to the last bit."""
        times = Times.of(scene.sample_times, start.units.time)
        horizon = float(start.until)
        times.rounded[-1], times.delay[-1] = horizon, float(start.until - horizon)
        return cls(scene.sample_times, times, start)


def to_limbs(times: Sequence[Fraction], unit: Scalar, mpfr: Mpfr) -> Array:
    """Exact times in s as dimensionless times, each as three doubles: axes (time, part)."""
    with mpfr.precision():
        return mpfr.to_limbs(mpfr.of_fractions(times) / mpfr.number(unit), MOST_LIMBS)


def long_double(value: Scalar) -> Scalar:
    """An mpmath number as NumPy's long double."""
    high = float(value)
    if math.isinf(high):  # ln v at rest
        return numpy.longdouble(high)
    return numpy.longdouble(high) + numpy.longdouble(float(value - high))


# A time later than t_end by this part of it is t_end: a t_end printed with 16 digits is inside.
TIME_TOLERANCE = Fraction(1, 10**15)
MOST_BYTES = 400_000_000  # The series of a run are stored up to this size.


@dataclass(frozen=True, eq=False)
class Hits:
    """Recorded events in columns: names, times, directions, and states (event, entry).

    Numbers are dimensionless: doubles in double, else mpmath numbers with guard bits.
    """

    name: Array
    time: Array
    direction: Array
    state: Array

    def __len__(self) -> int:
        return len(self.name)

    def of(self, rows: Array | slice) -> Hits:
        """Return some of the events."""
        return Hits(self.name[rows], self.time[rows], self.direction[rows], self.state[rows])

    @classmethod
    def of_blocks(cls, blocks: Sequence[Hits]) -> Hits:
        """Return the events of all ``blocks`` in order of time."""
        columns = ((hits.name, hits.time, hits.direction, hits.state) for hits in blocks)
        every = cls(*map(numpy.concatenate, zip(*columns, strict=True)))
        return every.of(numpy.argsort(every.time, kind="stable"))


NO_HITS = Hits(*(numpy.empty(shape, dtype=object) for shape in (0, 0, 0, (0, 0))))


class FoundEvents(NamedTuple):
    """The events in order of time, and names of functions whose sign is undecided somewhere.

    Those that ``touches`` names are zero at a tangency, or everywhere, or ``unresolved``: below
    their error over several extrema, so that events may be missing there.
    """

    hits: Hits = NO_HITS
    touches: frozenset[str] = frozenset()
    unresolved: frozenset[str] = frozenset()


NOTHING_FOUND = FoundEvents()


@dataclass(frozen=True)
class Propagation:
    """The outcome of a propagation, in heyoka's numbers, dimensionless.

    The end is at ``time`` + ``time_low``, because a step to an event ends between two numbers.
    ``found`` holds the events, ``series`` the blocks of steps, if they were computed and fit.
    ``samples`` are the states at the requested times, if all were reached.
    """

    status: str
    time: Scalar
    time_low: Scalar
    state: tuple[Scalar, ...]
    steps: int
    order: int
    found: FoundEvents = NOTHING_FOUND
    series: tuple[ContinuousOutput, ...] | None = field(default=None, compare=False, repr=False)
    samples: Array | None = field(default=None, compare=False, repr=False)


Read = Callable[[ContinuousOutput], None]
"""A reader of the blocks of a propagation, in order, while they are made."""

Repeat = Callable[[Read, Progress | None], Propagation]
"""The same propagation once more, for a reader of its blocks."""


class StoredSeries:
    """The series of a propagation, block by block, as long as they fit in ``MOST_BYTES``."""

    def __init__(self, setup: Setup):
        precision = setup.precision
        number = 8 * (precision.doubles or 1 + (precision.bits > 53))
        if precision.bits > 113 and precision.in_software:
            number = precision.bits // 8 + 40
        order = precision.bits * 0.35 + 2  # about, of the finest tolerance
        self._room = MOST_BYTES / (number * len(setup.layout.columns) * order)  # in steps
        self._blocks: list[ContinuousOutput] = []

    def append(self, block: ContinuousOutput) -> None:
        """Store the next block, or forget all if they do not fit."""
        self._room -= block.n_steps
        if self._room < 0:
            self._blocks.clear()
        else:
            self._blocks.append(block)

    @property
    def blocks(self) -> tuple[ContinuousOutput, ...] | None:
        """The blocks in order; None if they do not fit."""
        return tuple(self._blocks) if self._room >= 0 else None


class TimeSpan:
    """The time span of a solution: from 0 to ``end_time``."""

    setup: Setup
    start: InitialState
    end_time: Scalar

    @property
    def precision(self) -> Precision:
        """The working precision."""
        return self.setup.precision

    @property
    def status(self) -> str:
        """Status at the end of the solution."""
        raise NotImplementedError

    @cached_property
    def end(self) -> Scalar:
        """The end of the solution in s."""
        return self.end_time * self.start.units.time

    def dimensionless_time(self, t: Scalar) -> Scalar:
        """A time in s as a dimensionless time with guard bits.

        Raises ``InputError``: it lies outside the trajectory.
        """
        wanted = as_fraction(t)
        time = to_mpmath(wanted, self.precision.context)
        if wanted < 0 or time > self._latest:
            raise InputError(
                f"t: got {float(wanted):.17g} s, expected 0 to {float(self.end):.17g} s, where the "
                f"trajectory ends ({self.status}); it is never extrapolated"
            )
        if time >= self.end or self._as_given(time) == self._as_given(self.end):
            return self.end_time
        return time / self.start.units.time

    @cached_property
    def _latest(self) -> Scalar:
        return self.end * (1 + to_mpmath(TIME_TOLERANCE, self.precision.context))

    def _as_given(self, time: Scalar) -> Scalar:
        return float(time) if self.precision.is_float else time


class DenseOutput(TimeSpan):
    """Rows over the time of a propagation, dimensionless: with guard bits or in double.

    The series of the steps are stored where they fit (``MOST_BYTES``); otherwise each call repeats
    the propagation and reads block by block. In double the first propagation computes no series,
    which would take half of its time again, but stores the states at ``samples``, with the same
    bits; the first call that reads other times repeats it. Several threads may use it.
    """

    def __init__(
        self,
        setup: Setup,
        start: InitialState,
        propagation: Propagation,
        again: Repeat | None = None,
        samples: SampleTimes | None = None,
    ):
        self.setup, self.start, self.propagation = setup, start, propagation
        self.samples, self._again, self._lock = samples, again, threading.RLock()

    @property
    def status(self) -> str:
        """Status at the end of the propagation."""
        return self.propagation.status

    @property
    def has_series(self) -> bool:
        """True if the series of all steps are stored; a run to t = 0 has none."""
        return bool(self.propagation.series)

    def to_limbs(self, times: Array) -> Array:
        """States of a stored run in several doubles at rising times, both in parts.

        Axes (time, part, entry).
        """
        blocks = self.propagation.series
        assert blocks
        ends = [float(block.bounds[1]) for block in blocks[:-1]]
        first = numpy.searchsorted(times[:, 0], ends, side="right")
        parts = zip(blocks, numpy.split(times, first), strict=True)
        return numpy.concatenate([block.at(part) for block, part in parts])

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon if the run is complete."""
        if self.propagation.status in ARRIVED:
            return self.start.until
        return self._last_time

    @cached_property
    def start_row(self) -> Row:
        """The row at t = 0, not rounded to heyoka's precision: v = 0 there is exactly 0."""
        return self.start.first_row(self.setup.formulation, self.setup.record)

    @cached_property
    def end_row(self) -> Row:
        """The row at ``end_time``."""
        if not self.end_time:
            return self.start_row
        row = tuple(map(self.precision.with_guard_bits, self.propagation.state))
        back = self.precision.mpfr.back
        return tuple(back(x[0]) for x in self._shift([row], [self.end_time - self._last_time]))

    @cached_property
    def _last_time(self) -> Scalar:
        return sum(
            map(self.precision.with_guard_bits, (self.propagation.time, self.propagation.time_low))
        )

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Row]:
        """Rows at dimensionless ``times``, both with guard bits."""
        if not len(times):
            return []
        back = self.precision.mpfr.back
        return [
            tuple(map(back, row)) for row in zip(*self._components(times, progress), strict=True)
        ]

    def _components(self, times: Sequence[Scalar], progress: Progress | None) -> tuple[Array, ...]:
        """The rows at dimensionless ``times`` with guard bits: an array of wide numbers each."""
        number, with_guard_bits = self.precision.number, self.precision.with_guard_bits
        rows: dict[int, Row] = {}
        inner: dict[int, ContinuousOutput] = {}
        for place, time in enumerate(times):
            if not time or time == self.end_time:
                rows[place] = self.end_row if time else self.start_row
            else:
                inner[place] = number(time)

        def evaluate(output: ContinuousOutput, low: Scalar, high: Scalar) -> None:
            for place, rounded in inner.items():
                if (low is None or low < rounded) and (high is None or rounded <= high):
                    rows[place] = tuple(map(with_guard_bits, output(rounded)))

        if inner:
            self._visit(evaluate, progress)
        delays = [
            time - with_guard_bits(inner[place]) if place in inner else time * 0
            for place, time in enumerate(times)
        ]
        return self._shift([rows[place] for place in range(len(times))], delays)

    def mpfr_arrays(self, seconds: Array, progress: Progress | None = None) -> tuple[Array, ...]:
        """The rows of any run at ``seconds``, an array for each entry; both in wide numbers.

        The bits equal those of ``rows``, which reads several doubles row by row.
        """
        mpfr, parts = self.precision.mpfr, self.precision.doubles
        size = len(self.setup.layout.columns)
        if not len(seconds):
            return tuple(seconds for _ in range(size))
        if not (parts and self.has_series):
            return self._components(
                [self.dimensionless_time(mpfr.back(t)) for t in seconds], progress
            )
        for time in {min(seconds), max(seconds)}:
            self.dimensionless_time(mpfr.back(time))
        times = mpfr.to_limbs(seconds / mpfr.number(self.start.units.time), MOST_LIMBS)
        at_start, at_end = seconds == 0, seconds >= mpfr.number(self.end)
        order = numpy.argsort(times[:, 0], kind="stable")
        states = numpy.empty((len(times), parts, size))
        states[order] = self.to_limbs(times[order])
        entries = tuple(mpfr.from_limbs(states[:, :, entry]) for entry in range(size))
        for entry, first, last in zip(entries, self.start_row, self.end_row, strict=True):
            entry[at_start], entry[at_end] = mpfr.number(first), mpfr.number(last)
        return entries

    def times(self, times: Sequence[Fraction] | Array) -> Times:
        """Exact times in s for ``arrays``; a time within ``TIME_TOLERANCE`` of the end is the end.

        Raises ``InputError``: a time lies outside the trajectory.
        """
        samples = self.samples
        whole = samples and self.propagation.status in ARRIVED and not is_doubles(times)
        if samples and whole and tuple(times) == samples.exact:
            return samples.doubles
        seconds, rounded, delay = Times.of(times, self.start.units.time)
        for place in {int(seconds.argmin()), int(seconds.argmax())} if len(times) else ():
            self.dimensionless_time(times[place])
        end = float(self.end_time)
        at_end = seconds >= float(self.end)
        return Times(
            seconds,
            numpy.where(at_end, end, rounded),
            numpy.where(at_end, float(self.end_time - end), delay),
        )

    def arrays(
        self,
        times: Times,
        number: Callable[[Scalar], Scalar] = float,
        progress: Progress | None = None,
    ) -> tuple[Array, ...]:
        """The rows of a run in double or extended at all ``times``: an array for each entry.

        ``number`` converts numbers with guard bits: ``float``, or ``long_double``, in which an
        entry keeps its change within a delay of less than an ulp of time.
        """
        state, rounded = self.propagation.state, times.rounded
        given = self.precision.fp_type  # double, or extended's long double
        kind = type(number(self.precision.context.mpf(0)))
        entries = [numpy.full(len(rounded), x, dtype=kind) for x in state]
        taken = self.propagation.samples

        def evaluate(output: ContinuousOutput, low: Scalar, high: Scalar) -> None:
            chosen = numpy.ones(len(rounded), dtype=bool) if low is None else rounded > low
            if high is not None:
                chosen &= rounded <= high
            for entry, values in zip(entries, output(rounded[chosen].astype(given)).T, strict=True):
                entry[chosen] = values

        if taken is not None and self.samples and times is self.samples.doubles:
            for entry, values in zip(entries, taken.T, strict=True):
                entry[1:] = values
        else:
            self._visit(evaluate, progress)
        start = self.start.once(number, lambda: self.start.map(number))
        row = start.first_row(self.setup.formulation, self.setup.record)
        for entry, value in zip(entries, row, strict=True):
            entry[rounded == 0] = value
        return shift_arrays(self.setup, self.start.body.numbers(float), tuple(entries), times.delay)

    def _visit(
        self, visit: Callable[[ContinuousOutput, Scalar, Scalar], None], progress: Progress | None
    ) -> None:
        """Call ``visit`` with each block and the interval of times for which it is needed.

        None stands for all earlier and for all later times.
        """
        if not self.propagation.steps:  # a horizon of zero
            return
        low, end = None, self.propagation.time

        def take(block: ContinuousOutput) -> None:
            nonlocal low
            high = block.bounds[1]
            visit(block, low, high if high < end else None)
            low = high

        with self._lock:
            if self.propagation.series is not None:
                for block in self.propagation.series:
                    take(block)
                return
            assert self._again, "a propagation without its series can be repeated"
            again = self._again(take, progress)
            if again.state != self.propagation.state:
                raise RuntimeError("the same integration gave another result when it was repeated")
            self.propagation = replace(self.propagation, series=again.series)

    def _shift(self, rows: Sequence[Row], delays: Sequence[Scalar]) -> tuple[Array, ...]:
        """``rows`` at rounded times, moved by ``delays``, as arrays of wide numbers.

        heyoka's times are rounded to its precision, which costs up to t eps of state at late times;
        one Euler step over the rounding (about 1e-14) corrects that.
        """
        mpfr = self.precision.mpfr
        entries = tuple(map(mpfr.array, zip(*rows, strict=True)))
        delay = mpfr.array(map(self._own_delay, rows, delays))
        with mpfr.precision():
            body = self.start.body.numbers(mpfr.number)
            return shift_arrays(self.setup, body, entries, delay, mpfr)

    def _own_delay(self, row: Row, delay: Scalar) -> Scalar:
        """A delay of the variable of integration, from one of time."""
        return delay


def shift_arrays(
    setup: Setup,
    body: Parameters,
    components: tuple[Array, ...],
    delay: Array,
    fn: Functions = numpy,
) -> tuple[Array, ...]:
    """Components at rounded times, moved by a ``delay`` of less than an ulp of time.

    ``body`` is the dimensionless body in the arithmetic ``fn``. Doubles are precise enough for the
    rates of long doubles.
    """
    known = components
    if fn is numpy:
        known = tuple(one.astype(float, copy=False) for one in components)
    with numpy.errstate(all="ignore"):
        rates = setup.layout.rates(body, known, fn)
        moved = [x + rate * delay for x, rate in zip(components, rates, strict=True)]
        # at a pole the rates of phi and psi are undefined; there it stands as it is
        finite = [(x - x == 0).astype(bool) for x in moved]
    return tuple(map(numpy.where, finite, moved, components))


@dataclass(frozen=True)
class Segment:
    """A segment under one set of equations from ``begin`` on (dimensionless, with guard bits).

    ``ended`` is the event that joins it to the next segment; "" if only the equations change, and
    for the last segment. The columns ``cleared`` are zero behind that event; what the end of the
    segment leaves of them is its error.
    """

    begin: Scalar
    output: DenseOutput
    ended: str = ""
    cleared: tuple[str, ...] = ()

    @cached_property
    def columns(self) -> Columns:
        """Columns of the segment's own rows."""
        return Columns(self.output.setup, self.output.start)

    @property
    def begin_s(self) -> Scalar:
        """Begin in s."""
        return self.begin * self.output.start.units.time

    @property
    def end_s(self) -> Scalar:
        """End in s."""
        return self.begin_s + self.output.end

    @property
    def model(self) -> str:
        """The name of the motion, as users read it."""
        return self.output.setup.formulation.motion_name
