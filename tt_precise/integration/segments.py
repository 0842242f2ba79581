"""``Run``: what became of a start, as a list of segments of motion, each under its own equations.

Most runs have one. Where friction sticks and slips, the top flies and lands, or gliding begins
from rest, another segment begins; each time belongs to one of them, the earlier one at a bound.
"""

from __future__ import annotations

import bisect
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from tt_precise.integration.columns import Columns, Row, State
from tt_precise.integration.dense_output import DenseOutput, Span, Status
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Scalar


@dataclass(frozen=True)
class Segment:
    """A stretch under one set of equations, from ``begin`` (dimensionless, guarded) on.

    ``ended`` is the event that joins it to the next segment; "" where only the equations change,
    and of the last one.
    """

    begin: Scalar
    output: DenseOutput
    ended: str = ""

    @cached_property
    def columns(self) -> Columns:
        """Columns of the segment's own rows."""
        return Columns(self.output.setup, self.output.start)

    @property
    def begin_s(self) -> Scalar:
        """Where it begins, in s."""
        return self.begin * self.output.start.units.time

    @property
    def end_s(self) -> Scalar:
        """Where it ends, in s."""
        return self.begin_s + self.output.end

    @property
    def model(self) -> str:
        """One of gliding, rolling, flight, and contact with an elastic table."""
        form = self.output.setup.formulation
        return "contact" if form.model == form.spring else form.model


class Stretch(NamedTuple):
    """A stretch of one model as users see it: times in s, and how it ended.

    ``status`` is one of ``events.JOINING`` where another stretch follows, else the trajectory's.
    """

    model: str
    begin: Scalar
    end: Scalar
    status: str


class Run(Span):
    """A start and the segments of what became of it, over the time of them all."""

    def __init__(self, setup: Setup, start: InitialState, segments: Sequence[Segment]):
        self.setup, self.start, self.segments = setup, start, tuple(segments)
        self.precision, self.columns = setup.precision, Columns(setup, start)

    @property
    def alone(self) -> Segment | None:
        """The only segment of a run whose own equations hold throughout, else None."""
        one = self.segments[0]
        return one if len(self.segments) == 1 and one.output.setup == self.setup else None

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.segments[-1].output.status

    @property
    def steps(self) -> int:
        """Taylor steps taken."""
        return sum(one.output.propagation.steps for one in self.segments)

    @property
    def order(self) -> int:
        """The order of the last of them."""
        return self.segments[-1].output.propagation.order

    @property
    def joints(self) -> list[Segment]:
        """The segments that an event joins to the next."""
        return [one for one in self.segments[:-1] if one.ended]

    @property
    def event_counts(self) -> Counter[str]:
        """How often each event was recorded, those that join segments among them."""
        hits = (hit for one in self.segments for hit in one.output.propagation.hits)
        return Counter([hit.name for hit in hits] + [one.ended for one in self.joints])

    @property
    def touches(self) -> tuple[str, ...]:
        """Events asked for whose functions touch zero, or stay there, without crossing it."""
        touched = {name for one in self.segments for name in one.output.propagation.touches}
        return tuple(name for name in self.setup.events if name in touched)

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon where it was reached."""
        last = self.segments[-1]
        if self.alone:
            return last.output.end_time
        return self.start.until if self.status == "complete" else last.begin + last.output.end_time

    def place(self, time: Scalar) -> int:
        """The number of the segment that a dimensionless time belongs to."""
        begins = [one.begin for one in self.segments]
        return max(bisect.bisect_left(begins, time) - 1, 0)

    def rows(self, times: Sequence[Scalar]) -> list[tuple[Segment, Row]]:
        """Rows at guarded dimensionless ``times``, and the segments that they are of."""
        if self.alone:
            return [(self.alone, row) for row in self.alone.output.rows(times)]
        found = []
        for time in times:
            one = self.segments[self.place(time)]
            output = one.output
            if one is self.segments[-1] and time == self.end_time:
                found.append((one, output.end_row))
            else:
                found.append((one, output.rows([min(time - one.begin, output.end_time)])[0]))
        return found

    def states(self, times: Sequence[Scalar]) -> list[State]:
        """The states (SI) at guarded dimensionless ``times``."""
        rows = self.rows(times)
        if self.alone:
            return self.columns.states(times, [row for _, row in rows])
        return [
            one.columns.states([time], [row])[0]
            for time, (one, row) in zip(times, rows, strict=True)
        ]

    def motions(self, times: Sequence[Scalar]) -> list[Motion]:
        """What quantities are computed from at guarded dimensionless ``times``."""
        return [one.columns.motion(row) for one, row in self.rows(times)]

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """From one event that joins segments to the next."""
        to_user, begin, found = self.columns.to_user, self.start.until * 0, []
        for one in self.joints:
            found.append(Stretch(one.model, to_user(begin), to_user(one.end_s), one.ended))
            begin = one.end_s
        last = self.segments[-1].model
        return (*found, Stretch(last, to_user(begin), to_user(self.end), self.status))
