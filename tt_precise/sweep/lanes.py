"""Many trajectories at once in the lanes of heyoka's batch integrator, in double.

Lanes share nothing but the clock of steps: each has its own time, step size and end. One that
ends, leaves the table or blows up is recorded and gets the next start while the others go on
from where they are, so that no lane waits, and what happens in one does not touch another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import heyoka
import numpy

from tt_precise.integrate.precision import precision_named
from tt_precise.integrate.system import (
    Key,
    event_expression,
    extended_rates,
    heyoka_direction,
    motion,
    numeric_options,
    symbolic_body,
    terminal_functions,
)
from tt_precise.mechanics.formulations import integrated
from tt_precise.sweep.columns import Detector
from tt_precise.sweep.lowest import Step, lowest_steps, may_be_lowest, reaches, states_in

STEPS_BETWEEN = 64  # until Python looks: an ended lane idles half of it, 2 % of a reference run
STEPS_KEPT = 192  # of which the series are held, until the events in them are evaluated
# heyoka takes the step from the largest of state and event functions: scaled down, these do not
# shorten it, and a trajectory takes the same steps whatever is looked for along it
EVENT_SCALE = 2.0**-10
LOWEST_KEPT = 256  # steps of a lane whose series are held, one of which has the smallest force
STEPS_AT_MOST = 5_000_000  # of one trajectory, which then counts as failed


class Build(NamedTuple):
    """What a batch integrator is compiled for."""

    model: str
    contact: str
    detectors: tuple[Detector, ...]
    batch: int


class Departure(NamedTuple):
    """A start, dimensionless: state, parameters of the formulation, horizon, longest step."""

    state: tuple[float, ...]
    parameters: tuple[float, ...]
    until: float
    longest: float = math.inf


class Arrival(NamedTuple):
    """How one trajectory went, dimensionless.

    ``status`` is "complete", "contact_lost", "singular_contact" or "failed"; ``state`` is that at
    ``time``, NaN if it failed. The events: ``detector`` (its position), ``direction`` (+1 where
    the function rises), ``times``, and ``states`` of shape (events, entries), NaN where the
    detector is not ``stateful``. ``lowest`` are the steps in one of which the normal
    force is smallest.
    """

    status: str
    time: float
    state: Any
    steps: int
    detector: Any
    direction: Any
    times: Any
    states: Any
    lowest: Sequence[Step]


_idle: dict[Build, list[Lanes]] = {}


@contextmanager
def lanes(build: Build) -> Iterator[Lanes]:
    """Lend compiled lanes, made now if none are left from an earlier task of this process."""
    shelf = _idle.setdefault(build, [])
    lent = shelf.pop() if shelf else Lanes(build)
    yield lent
    # only after a task without an exception: an interrupted integrator is not used again
    shelf.append(lent)


class Lanes:
    """A compiled batch integrator, and what its lanes are carrying."""

    def __init__(self, build: Build):

        heyoka.set_logger_level_critical()  # what it would log is told by the status
        self.build = build
        # a single lane would take its step sizes with other functions, which differ in the last
        # bit; as one of two it has the same numbers as any other lane
        width = max(2, build.batch)
        form = integrated(build.model, "newton")
        variables = tuple(heyoka.make_vars(*form.columns))
        body = symbolic_body(form)
        rates = extended_rates(form, (), body, variables, heyoka)
        q = motion(form, (), body, variables, heyoka)
        terminal = terminal_functions(form, q, variables[0])
        if build.contact == "bilateral":
            del terminal["contact_lost"]
        self._terminal = tuple(terminal)
        self._stateful = numpy.array([one.stateful for one in build.detectors])
        self._hits: list[float] = []  # flat, because objects are slow
        size, parameters = len(form.columns), len(form.parameters)
        self._batch = heyoka.taylor_adaptive_batch(
            list(zip(variables, rates, strict=True)),
            numpy.zeros((size, width)),
            pars=numpy.ones((parameters, width)),
            t_events=[heyoka.t_event_batch(function) for function in terminal.values()],
            nt_events=[
                heyoka.nt_event_batch(
                    event_expression(one.event, q, variables, rates) * EVENT_SCALE,
                    self._noting(position),
                    direction=heyoka_direction(one.direction),
                )
                for position, one in enumerate(build.detectors)
            ],
            **numeric_options(Key(form, precision_named("double"), (), (), 0.0, ())),
        )
        self._aboard: list[int | None] = [None] * width
        self._goals = [0.0] * width
        self._longest = [math.inf] * width
        self.order = int(self._batch.order)
        self._steps = numpy.zeros(width, dtype=int)
        self._parts: list[list[Any]] = [[] for _ in range(width)]
        self._height = form.columns.index("kz")
        self._highest = numpy.full(width, -math.inf)  # the largest so far in each lane
        self._lowest: list[list[tuple[float, Step]]] = [[] for _ in range(width)]
        # views of heyoka's own memory, which stays where it is
        self._tc, self._time, self._last_h = self._batch.tc, self._batch.time, self._batch.last_h
        self._series = numpy.empty((STEPS_KEPT, *self._tc.shape))
        self._ends = numpy.empty((STEPS_KEPT, width))
        self._widths = numpy.empty((STEPS_KEPT, width))
        self._counts: list[int] = []
        self._kept = 0
        self._since = numpy.zeros(width)  # times when the series were last given up

    def fly(self, departures: Sequence[Departure]) -> Iterator[tuple[int, Arrival]]:
        """Integrate all starts; (position, how it went) of each, in the order of their ends."""
        if not departures:
            return
        waiting = iter(range(len(departures)))
        for lane in range(len(self._aboard)):
            number = next(waiting, None) if lane < self.build.batch else None
            self._board(lane, number, departures)
        while any(number is not None for number in self._aboard):
            outcomes = self._advance()
            ended = [
                (lane, number, status)
                for lane, number in enumerate(self._aboard)
                if number is not None and (status := self._ended(lane, outcomes[lane]))
            ]
            if ended or self._kept > STEPS_KEPT - STEPS_BETWEEN:
                self._share_out()
            for lane, number, status in ended:
                yield number, self._arrival(lane, status)
                self._board(lane, next(waiting, None), departures)

    def _noting(self, position: int) -> Any:
        # a function, because heyoka copies callables deeply, but functions with what they refer to
        hits = self._hits

        def note(_: Any, time: float, sign: int, lane: int) -> None:
            if sign:  # 0: the function vanishes identically, so nothing changes sign
                hits.extend((lane, position, time, sign))

        return note

    def _board(self, lane: int, number: int | None, departures: Sequence[Departure]) -> None:

        self._aboard[lane] = number
        # an empty lane stands at some valid start with no time left: it takes steps of length 0
        start = departures[number or 0]
        self._batch.state[:, lane] = start.state
        self._batch.pars[:, lane] = start.parameters
        self._goals[lane] = 0.0 if number is None else start.until
        self._longest[lane] = start.longest
        # not set_time, which would cut the low parts of the other lanes' times
        high, low = (numpy.nan_to_num(part) for part in self._batch.dtime)
        high[lane] = low[lane] = 0.0
        self._batch.set_dtime(high, low)
        self._batch.reset_cooldowns(lane)
        self._since[lane] = 0.0
        self._steps[lane] = 0
        self._parts[lane] = []
        self._highest[lane] = -math.inf
        self._lowest[lane] = []

    def _advance(self) -> list[Any]:

        before = self._kept
        self._batch.propagate_until(
            self._goals, max_delta_t=self._longest, max_steps=STEPS_BETWEEN, callback=self._keep
        )
        outcomes = [outcome for outcome, _ in self._batch.step_res]
        if heyoka.taylor_outcome.err_nf_state in outcomes:
            self._keep(self._batch)  # heyoka skips the callback of such a step
        self._steps += numpy.count_nonzero(self._widths[before : self._kept], axis=0)
        return outcomes

    def _keep(self, _: Any) -> bool:
        step = self._kept
        self._series[step] = self._tc
        self._ends[step] = self._time
        self._widths[step] = self._last_h
        self._counts.append(len(self._hits) // 4)
        self._kept = step + 1
        return True

    def _share_out(self) -> None:
        """Give the events since the last time to their lanes, and the smallest normal force."""
        taken = slice(self._kept)
        found = may_be_lowest(self._series[taken, self._height], self._widths[taken], self._highest)
        for step, lane, ceiling in zip(*(one.tolist() for one in found), strict=True):
            kept = Step(self._widths[step, lane], self._series[step, :, :, lane].copy())
            self._lowest[lane].append((ceiling, kept))
        for lane, kept_steps in enumerate(self._lowest):
            if len(kept_steps) > LOWEST_KEPT:  # a periodic motion has as many as periods
                steps = lowest_steps(self._may_be_lowest(lane), self._height)
                self._lowest[lane] = [(math.inf, step) for step in steps]
        if self._hits:
            lane, position, time, sign = numpy.array(self._hits).reshape(-1, 4).T
            lane = lane.astype(int)
            order = numpy.argsort(lane, kind="stable")
            step = numpy.searchsorted(self._counts, order, side="right")
            lane, position, time, sign = (one[order] for one in (lane, position, time, sign))
            state = numpy.full((len(lane), self._tc.shape[0]), numpy.nan)
            wanted = self._stateful[position.astype(int)]
            step, on, time_in = step[wanted], lane[wanted], time[wanted]
            begun = self._ends[step, on] - self._widths[step, on]
            state[wanted] = states_in(self._series[step, :, :, on], time_in - begun)
            first = numpy.searchsorted(lane, numpy.arange(len(self._aboard) + 1))
            for one in range(len(first) - 1):
                mine = slice(first[one], first[one + 1])
                self._parts[one].append((position[mine], sign[mine], time[mine], state[mine]))
        self._good = self._ends[self._kept - 2].copy() if self._kept > 1 else self._since.copy()
        self._since = self._ends[self._kept - 1].copy()
        self._hits.clear()
        self._counts.clear()
        self._kept = 0

    def _may_be_lowest(self, lane: int) -> list[Step]:
        highest = self._highest[lane]
        return [step for ceiling, step in self._lowest[lane] if reaches(ceiling, highest)]

    def _ended(self, lane: int, outcome: Any) -> str:

        # a step cut short by its longest length has that outcome too
        if outcome == heyoka.taylor_outcome.time_limit and self._time[lane] == self._goals[lane]:
            return "complete"
        if outcome == heyoka.taylor_outcome.err_nf_state or self._steps[lane] > STEPS_AT_MOST:
            return "failed"
        stopped = -1 - int(outcome)
        return self._terminal[stopped] if 0 <= stopped < len(self._terminal) else ""

    def _arrival(self, lane: int, status: str) -> Arrival:

        failed = status == "failed"
        size = self._batch.state.shape[0]
        empty = (numpy.empty(0), numpy.empty(0), numpy.empty(0), numpy.empty((0, size)))
        detector, direction, times, states = (
            numpy.concatenate(column) for column in zip(empty, *self._parts[lane], strict=True)
        )
        return Arrival(
            status,
            float(self._good[lane] if failed else self._time[lane]),
            self._batch.state[:, lane] * (numpy.nan if failed else 1.0),
            int(self._steps[lane]),
            detector.astype(int),
            direction.astype(int),
            times,
            states,
            self._may_be_lowest(lane),
        )
