"""Many trajectories at once in the lanes of heyoka's batch integrator, in double.

Lanes share nothing but the clock of steps: each has its own time, step size and end. One that
ends, leaves the table or blows up is recorded and gets the next start while the others go on
from where they are, so that no lane waits, and what happens in one does not touch another.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import heyoka
import numpy

from tt_precise.integration.idle import Idle
from tt_precise.mechanics.formulations import integrated
from tt_precise.runtime.arithmetic import Array
from tt_precise.sweeps.columns import Detector
from tt_precise.sweeps.step_buffer import ROOM, Events, StepBuffer
from tt_precise.sweeps.steps_again import LaneStart, StepsAgain, compiled

STEPS_BETWEEN = 64  # until Python looks: an ended lane idles half of it, 2 % of a reference run
MOST_AGAIN = 8  # lanes
STEPS_AT_MOST = 5_000_000  # of one trajectory, which then counts as failed


class Build(NamedTuple):
    """What a batch integrator is compiled for."""

    model: str
    contact: str
    detectors: tuple[Detector, ...]
    batch: int


class LaneResult(NamedTuple):
    """How one trajectory ended, dimensionless.

    ``status`` is "complete", "contact_lost", "singular_contact" or "failed"; ``state`` is that at
    ``time``, NaN if it failed.
    """

    status: str
    time: float
    state: Array
    steps: int


class LaneResults(NamedTuple):
    """How all went: a result for each start, and their events.

    Each kind of events of a trajectory is in order of time. Turning points of theta are minima
    before the climb and maxima after it, unless their detector asks for every one; of the kinds
    with a ``side`` there are those on it, and perhaps others. ``lowest`` holds the positions of
    starts, in order, and states in one of which the normal force of a trajectory is smallest, if
    that is inside of it.
    """

    results: list[LaneResult]
    events: Events
    lowest: tuple[Array, Array]


class Lanes:
    """A compiled batch integrator, and what its lanes are carrying."""

    def __init__(self, build: Build):
        heyoka.set_logger_level_critical()  # the status says what it would log
        self.build = build
        # a single lane would take its step sizes with other functions, which differ in the last
        # bit; as one of two it has the same numbers as any other lane
        width = max(2, build.batch)
        form = integrated(build.model, "newton")
        numbered = [(n, one) for n, one in enumerate(build.detectors) if not one.turning]
        seldom = [(n, one) for n, one in numbered if one.side is not None]
        hits = array("d")
        self._batch, self._terminal = compiled(
            form, build.contact, width, [pair for pair in numbered if pair not in seldom], hits
        )
        # of more lanes there would be nothing to gain, and twice as much to compile
        again = StepsAgain(form, build.contact, min(width, MOST_AGAIN), seldom)
        self._row_in = numpy.full(width, -1)  # which row is in each lane, -1: none
        self._goals = [0.0] * width
        self._longest = [math.inf] * width
        self.order = int(self._batch.order)
        self._age = numpy.zeros(width, dtype=int)  # steps since the start of each row
        self._time = self._batch.time  # a view of heyoka's own memory
        self._buffer = StepBuffer(self._batch, form, build.detectors, hits, again)

    def integrate(self, starts: Sequence[LaneStart]) -> LaneResults:
        """Integrate from all starts."""
        ends: dict[int, tuple[str, float, Array]] = {}
        waiting = iter(range(len(starts)))
        self._buffer.open(starts)
        for lane in range(len(self._row_in) if starts else 0):
            number = next(waiting, -1) if lane < self.build.batch else -1
            self._load(lane, number, starts)
        while (self._row_in >= 0).any():
            outcomes = self._advance()
            ended = {
                lane: status
                for lane, number in enumerate(self._row_in.tolist())
                if number >= 0 and (status := self._ended(lane, outcomes[lane]))
            }
            if ended:
                self._buffer.close(list(ended))
            for lane, status in ended.items():
                ends[int(self._row_in[lane])] = self._end(lane, status)
                self._load(lane, next(waiting, -1), starts)
            if self._buffer.steps == ROOM:
                self._buffer.read()
        if self._buffer.steps:
            self._buffer.read()
        return LaneResults(
            [LaneResult(*ends[row], int(self._buffer.taken[row])) for row in range(len(starts))],
            self._buffer.events(),
            self._buffer.lowest(),
        )

    def _load(self, lane: int, number: int, starts: Sequence[LaneStart]) -> None:
        self._row_in[lane] = number
        # an empty lane stands at some valid start with no time left: it takes steps of length 0
        start = starts[max(number, 0)]
        self._batch.state[:, lane] = start.state
        self._batch.pars[:, lane] = start.parameters
        self._goals[lane] = 0.0 if number < 0 else start.until
        self._longest[lane] = start.longest
        # not set_time, which would cut the low parts of the other lanes' times
        high, low = (part.copy() for part in self._batch.dtime)
        high[lane] = low[lane] = 0.0
        if not numpy.isfinite(high).all():
            high, low = numpy.nan_to_num(high), numpy.nan_to_num(low)
        self._batch.set_dtime(high, low)
        self._batch.reset_cooldowns(lane)
        self._age[lane] = 0

    def _advance(self) -> list[Any]:
        before = self._buffer.steps
        self._batch.propagate_until(
            self._goals,
            max_delta_t=self._longest,
            max_steps=min(STEPS_BETWEEN, ROOM - before),
            callback=self._buffer.record_step,
        )
        outcomes = [outcome for outcome, _ in self._batch.step_res]
        if heyoka.taylor_outcome.err_nf_state in outcomes:
            self._buffer.record_step(self._batch)  # heyoka skips the callback of such a step
        self._buffer.assign(before, self._row_in)
        self._age += self._buffer.steps - before
        return outcomes

    def _ended(self, lane: int, outcome: Any) -> str:
        # a step cut short by its longest length has that outcome too
        if outcome == heyoka.taylor_outcome.time_limit and self._time[lane] == self._goals[lane]:
            return "complete"
        if outcome == heyoka.taylor_outcome.err_nf_state or self._age[lane] > STEPS_AT_MOST:
            return "failed"
        stopped = -1 - int(outcome)
        return self._terminal[stopped] if 0 <= stopped < len(self._terminal) else ""

    def _end(self, lane: int, status: str) -> tuple[str, float, Array]:
        """Status, time and state of a row that has ended."""
        state = self._batch.state[:, lane]
        if status == "failed":
            return (
                status,
                self._buffer.step_start(lane) if self._age[lane] > 1 else 0.0,
                state * numpy.nan,
            )
        return status, float(self._time[lane]), state.copy()


_idle = Idle(Lanes)


def lanes(build: Build) -> AbstractContextManager[Lanes]:
    """Compiled lanes: idle ones of an earlier task of this process, or made now."""
    return _idle.lent(build)
