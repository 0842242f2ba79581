"""``Segment``: a part of a motion under one set of equations, from one propagation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import Columns, Row
from tt_precise.integration.events import ARRIVED
from tt_precise.integration.precision import Hardware, times_in
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import Steps, shifted
from tt_precise.integration.zeros import FoundEvents
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.scene import InitialState

MOST_STEPS = 10_000_000  # Taylor steps of a run, some minutes in double.


def require_few_steps(steps: int, time: float, horizon: float) -> None:
    """Refuse a run with too many steps.

    Raises ``InputError``: there are more than ``MOST_STEPS``.
    """
    if steps > MOST_STEPS:
        raise InputError(
            f"until: got more than {MOST_STEPS} Taylor steps, which cover {time / horizon:.1g} of "
            "the time, expected fewer: ask for a shorter time, weaker friction or a softer spring"
        )


class Propagation(NamedTuple):
    """The outcome of an integrator, in dimensionless mpmath numbers.

    ``series()`` gives the Taylor steps; in double it repeats the propagation, because a run that
    is only read at its samples does not need them. ``samples`` are the states at the rounded sample
    times, axes (time, component), if the integrator has stored them.
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

    ``ended`` is the event that joins it to the next segment; "" if only the equations change, and
    for the last segment. The columns ``cleared`` are zero behind that event; what the end of the
    segment leaves of them is its error.
    """

    begin: Scalar
    setup: Setup
    start: InitialState
    run: Propagation
    ended: str = ""
    cleared: tuple[str, ...] = ()

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
        """Evaluate the state at times since ``begin``, in an arithmetic of arrays.

        A run in double reads the integrator's own evaluation up to the end, or the stored
        ``samples`` if these are the times.
        """
        end, hardware = times_in(numbers, [self.end_time])[0], isinstance(numbers, Hardware)
        first, last = (times <= 0).astype(bool), (times >= end).astype(bool)
        kind, delay = numbers.kind if hardware else object, None
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
        for here, bound in (
            (last, lambda: self.end_row),
            (first, lambda: self._first_row(numbers)),
        ):
            if here.any():
                for component, value in zip(row, bound(), strict=True):
                    component[here] = numbers.number(value)
        return row if delay is None else shifted(self.setup, self.start, row, delay, numbers)

    def _first_row(self, numbers: Any) -> Row:
        """Return the row at the beginning; in hardware that of the rounded start."""
        if not isinstance(numbers, Hardware):
            return self.start_row
        start = self.start.once(numbers, lambda: self.start.map(numbers.number))
        return start.first_row(self.setup.formulation, self.setup.record)

    def inside(self, times: Array, numbers: Any) -> list[Array]:
        """Evaluate the state after the beginning."""
        return self.series.at(times, numbers)
