"""``Solution``: a scene integrated once, by the first backend that accepts it.

A solution is a list of segments, usually one. Where the equations change, another segment begins.
A time at which two segments meet belongs to the earlier one.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from importlib import import_module
from typing import Any, Literal, NamedTuple

import numpy

from tt_precise.integration.columns import Columns, Row
from tt_precise.integration.events import ARRIVED, LEAVES
from tt_precise.integration.precision import Hardware, Precision, times_in
from tt_precise.integration.setup import IN_PIECES, Setup, full_tolerance, require_contact
from tt_precise.integration.steps import Steps, shifted
from tt_precise.integration.zeros import FoundEvents
from tt_precise.runtime.terminal import Progress, progress_bar
from tt_precise.runtime.values import Array, InputError, Memory, Scalar
from tt_precise.scene.numerals import as_fraction, to_mpmath
from tt_precise.scene.scene import InitialState, Scene
from tt_precise.scene.start import LiftedStart

Status = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed",
]  # fmt: skip
# A time later than t_end by this part of it is t_end: a t_end printed with 16 digits is inside.
TIME_TOLERANCE = Fraction(1, 10**15)
SLOW = ("quad", "mp")  # Precisions that take seconds to minutes, and show their progress.
MOST_STEPS = 10_000_000  # Taylor steps of a run, some minutes in double.


def require_few_steps(steps: int, time: float, horizon: float) -> None:
    """Raise ``InputError`` for a run with more than ``MOST_STEPS``."""
    if steps > MOST_STEPS:
        raise InputError(
            f"until: got more than {MOST_STEPS} Taylor steps, which cover {time / horizon:.1g} of "
            "the time, expected fewer: ask for a shorter time, weaker friction or a softer spring"
        )


class Propagation(NamedTuple):
    """The outcome of an integrator, in dimensionless mpmath numbers.

    ``series()`` gives the Taylor steps; in double it repeats the propagation. ``samples`` are the
    states at the rounded sample times, axes (time, component), if the integrator stored them.
    """

    status: str
    time: Scalar
    row: Row
    steps: int
    order: int
    events: FoundEvents
    series: Callable[[], Steps]
    samples: Array | None = None


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment under one set of equations from ``begin`` on (dimensionless, with guard bits).

    ``ended`` is the event between the segment and the next; "" if only the equations change.
    """

    begin: Scalar
    setup: Setup
    start: InitialState
    run: Propagation
    ended: str = ""

    @property
    def model(self) -> str:
        """The name of the motion, as users read it."""
        return self.setup.formulation.motion_name

    @cached_property
    def columns(self) -> Columns:
        """Columns of the segment's own rows."""
        return Columns(self.setup, self.start)

    @cached_property
    def series(self) -> Steps:
        """The Taylor steps."""
        return self.run.series()

    @cached_property
    def end_time(self) -> Scalar:
        """The duration: to the exact horizon if it was reached."""
        return self.start.until if self.run.status in ARRIVED else self.run.time

    @cached_property
    def start_row(self) -> Row:
        """The row at the beginning, not rounded: v = 0 there is exactly 0."""
        return self.start.first_row(self.setup.formulation, self.setup.record)

    @cached_property
    def end_row(self) -> Row:
        """The row at ``end_time``."""
        if not self.end_time:
            return self.start_row
        delay = self.end_time - self.run.time
        if not delay or self.setup.phase.has_clock:
            return self.run.row
        mpfr = self.setup.precision.mpfr
        with mpfr.precision():
            row = [mpfr.array([x]) for x in self.run.row]
            moved = shifted(self.setup, self.start, row, mpfr.array([delay]), mpfr)
            return tuple(mpfr.back(x[0]) for x in moved)

    def at(self, times: Array, numbers: Any, *, samples: bool = False) -> list[Array]:
        """Evaluate the state at times since ``begin``, or read the stored ``samples``."""
        first = (times <= 0).astype(bool)
        last = (times >= times_in(numbers, [self.end_time])[0]).astype(bool)
        hardware, delay = isinstance(numbers, Hardware), None
        kind = numbers.kind if hardware else object
        row = [numpy.zeros(len(times), dtype=kind) for _ in self.start_row]
        if hardware and self.setup.precision.is_float and not self.setup.phase.has_clock:
            rounded = times.astype(float)
            delay, high = (times - rounded).astype(float), float(self.end_time)
            rounded[last], delay[last] = high, float(self.end_time - high)
            times, last = rounded.astype(times.dtype), last & False
        inner = ~(first | last)
        if samples and self.run.samples is not None:
            row = [x.astype(kind) for x in self.run.samples.T]
        elif inner.any():
            for component, values in zip(row, self.inside(times[inner], numbers), strict=True):
                component[inner] = values
        for here, state in ((last, lambda: self.end_row), (first, lambda: self._start(numbers))):
            if here.any():
                for component, value in zip(row, state(), strict=True):
                    component[here] = numbers.number(value)
        return row if delay is None else shifted(self.setup, self.start, row, delay, numbers)

    def _start(self, numbers: Any) -> Row:
        """The row at the beginning; in hardware that of the rounded start."""
        if not isinstance(numbers, Hardware):
            return self.start_row
        start = self.start.once(numbers, lambda: self.start.map(numbers.number))
        return start.first_row(self.setup.formulation, self.setup.record)

    def inside(self, times: Array, numbers: Any) -> list[Array]:
        """Evaluate the state after the beginning."""
        return self.series.at(times, numbers)


class PhaseInterval(NamedTuple):
    """A segment of a motion under one model: times in s, and the status at its end.

    ``leaves`` is true if the top leaves the table there.
    """

    model: str
    begin: Scalar
    end: Scalar
    status: str
    leaves: bool


@dataclass(frozen=True, eq=False)
class Solution(Memory):
    """A scene, its start in the arithmetic of a set-up, and the segments from there."""

    scene: Scene
    setup: Setup
    start: InitialState
    segments: tuple[Segment, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        # integrated again where it is unpickled: heyoka's own pickles are machine code
        return solve, (self.scene, self.setup)

    def again(self, **changes: Any) -> Solution:
        """Integrate the scene again, with some fields of the ``Setup`` replaced."""
        return solve(self.scene, self.setup.but(**changes))

    @property
    def precision(self) -> Precision:
        """The working precision."""
        return self.setup.precision

    @property
    def tolerance(self) -> Scalar:
        """The relative tolerance of the integration, an mpmath number."""
        return self.precision.context.mpf(self.setup.tolerance) or full_tolerance(self.precision)

    @cached_property
    def columns(self) -> Columns:
        """The columns of the set-up's rows."""
        return Columns(self.setup, self.start)

    @property
    def status(self) -> str:
        """The ``Status`` at the end."""
        return self.segments[-1].run.status

    @property
    def steps(self) -> int:
        """Taylor steps taken."""
        return sum(segment.run.steps for segment in self.segments)

    @property
    def order(self) -> int:
        """The order of the last step."""
        return self.segments[-1].run.order

    @property
    def event_counts(self) -> Counter[str]:
        """Numbers of recorded events by name, including events that join segments."""
        names = [n for segment in self.segments for n in segment.run.events.hits.name.tolist()]
        return Counter(names + [segment.ended for segment in self.segments if segment.ended])

    def events_with(self, kind: Literal["touches", "unresolved"]) -> tuple[str, ...]:
        """Requested events whose functions ``FoundEvents`` names, of any segment."""
        names = {n for segment in self.segments for n in getattr(segment.run.events, kind)}
        return tuple(name for name in self.setup.watched if name in names)

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon if it was reached."""
        last = self.segments[-1]
        return self.start.until if self.status in ARRIVED else last.begin + last.end_time

    @cached_property
    def end(self) -> Scalar:
        """The end of the solution in s."""
        return self.end_time * self.start.units.time

    @cached_property
    def t_end(self) -> Scalar:
        """The end in s: a float in double, else an mpmath number."""
        return self.precision.to_user(self.end)

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to the end; an early end is added."""
        if self.status in ARRIVED:
            return self.scene.sample_times
        end = as_fraction(self.end)
        return (*(t for t in self.scene.sample_times if t < end), end)

    def dimensionless_time(self, t: Scalar) -> Scalar:
        """A time in s, within the trajectory, as a dimensionless time with guard bits."""
        exact, end = as_fraction(t), as_fraction(self.end)
        if not 0 <= exact <= end * (1 + TIME_TOLERANCE):
            raise InputError(
                f"t: got {float(exact):.17g} s, expected 0 to {float(end):.16g} s, where the "
                f"trajectory ends ({self.status}); it is never extrapolated"
            )
        if exact >= end or (self.precision.is_float and float(exact) == float(end)):
            return self.end_time
        return to_mpmath(exact, self.precision.context) / self.start.units.time

    @property
    def pieces(self) -> tuple[PhaseInterval, ...]:
        """The segments between mode switches, as ``PhaseInterval``."""
        to_user, unit = self.precision.to_user, self.start.units.time
        begin, pieces, last = to_user(self.end * 0), [], self.segments[-1]
        for segment in (*(s for s in self.segments[:-1] if s.ended), last):
            end = to_user((segment.begin + segment.end_time) * unit)
            end, status = self.t_end if segment is last else end, segment.ended or self.status
            pieces.append(PhaseInterval(segment.model, begin, end, status, status in LEAVES))
            begin = end
        return tuple(pieces)


def backends(scene: Scene) -> Iterator[Any]:
    """Give the integrators for a scene, each imported when the earlier ones have refused.

    They have ``refuses(scene, setup)``, a reason or None, and ``run``, which gives the segments.
    """
    here, pieces = "tt_precise.integration", [IN_PIECES] if scene.in_pieces else []
    return map(import_module, [f"{here}.heyoka_backend", *pieces, f"{here}.multidouble_backend"])


def solve(scene: Scene, setup: Setup, progress: Progress | None = None) -> Solution:
    """The solution of ``scene``, integrated once with ``setup`` by the first backend that can."""
    start = beginning(scene, setup.precision, setup.contact, threading.get_ident())
    for backend in backends(scene):
        reason = backend.refuses(scene, setup)
        if not reason:
            silent = progress is not None or setup.precision.name not in SLOW
            title = f"{scene.name} in {setup.precision.name}"
            with nullcontext(progress) if silent else progress_bar(title) as report:
                segments = backend.run(scene, setup, start, report)
            return Solution(scene, setup, start, tuple(segments))
    raise InputError(reason)


@lru_cache(maxsize=64)
def beginning(scene: Scene, precision: Precision, contact: str, thread: int) -> InitialState:
    """The start of a scene, cached per thread, because each thread has its own mpmath context."""
    start = InitialState.of(scene, precision.arithmetic)
    if not isinstance(scene.start, LiftedStart):
        require_contact(scene.name, start, precision.context, contact)
    return start
