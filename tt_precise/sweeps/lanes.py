"""Many trajectories at once in the lanes of heyoka's batch integrator, in double.

Lanes share only the loop over steps: each lane has its own time, step size and end. A lane that
ends, loses contact or blows up is recorded and gets the next start while the other lanes continue,
so that no lane waits and no lane affects another.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.equations import Equations, terminal_functions
from tt_precise.integration.heyoka_backend import numeric_options, pooled
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.formulations import Formulation, integration_form
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.values import Adaptive, Array
from tt_precise.sweeps.columns import Detector, Statistic
from tt_precise.sweeps.events import BatchSteps, BatchZeros, Events
from tt_precise.sweeps.extremes import Extreme

heyoka = import_heyoka()

ROOM = 500  # steps; not near a multiple of 64, where the rows of columns share lines of a cache
# Steps until Python looks at the lanes: an ended lane idles half of it, 2 % of a reference run.
STEPS_BETWEEN = 64
STEPS_AT_MOST = 5_000_000  # A trajectory with more Taylor steps counts as failed.


class LaneStart(NamedTuple):
    """A start, dimensionless: state, parameters of the formulation, horizon, longest step."""

    state: tuple[float, ...]
    parameters: tuple[float, ...]
    until: float
    longest: float = math.inf


class Build(NamedTuple):
    """The equations of a batch integrator, and the searches along its trajectories."""

    model: str
    contact: str
    batch: int
    detectors: tuple[Detector, ...]
    extremes: tuple[Statistic, ...]


class LaneResult(NamedTuple):
    """The end of one trajectory, dimensionless.

    ``status`` is "complete", "contact_lost", "singular_contact" or "failed"; ``state`` is that at
    ``time``, NaN if it failed.
    """

    status: str
    time: float
    state: Array
    steps: int


class LaneResults(NamedTuple):
    """The results of all starts, their events, and their extreme values.

    The latter are positions of starts, in order, and the states with the extreme value, for each of
    ``Build.extremes``.
    """

    results: list[LaneResult]
    events: Events
    extremes: dict[Statistic, tuple[Array, Array]]


class Lanes:
    """A compiled batch integrator, the contents of its lanes, and their last steps."""

    def __init__(self, build: Build):
        heyoka.set_logger_level_critical()  # the status says what it would log
        self.build = build
        # a single lane would compute step sizes with other functions, which differ in the last bit;
        # with two lanes the numbers are those of any other lane
        width = max(2, build.batch)
        form = integration_form(build.model, "newton")
        self._batch, self._terminal = _compiled(form, build.contact, width)
        # in an empty lane a top at rest has no time left: it takes steps of length 0
        upright = tuple(float(column == "kz") for column in form.columns)
        self._rest = LaneStart(upright, (0.5,) * len(form.parameters), 0.0)
        self._zeros = BatchZeros(form, build.detectors)
        self._extremes = [Extreme(form, part) for part in build.extremes]
        self._readers: list[BatchZeros | Extreme] = [self._zeros, *self._extremes]
        self.order = int(self._batch.order)
        self._row_in = numpy.full(width, -1)  # which row is in each lane, -1: none
        self._goals, self._longest = [0.0] * width, [math.inf] * width
        self._age = numpy.zeros(width, dtype=int)  # steps since the start of each row
        self._time = self._batch.time  # a view of heyoka's own memory
        self._series = numpy.empty((ROOM, *self._batch.tc.shape))
        self._widths = numpy.empty((ROOM, width))
        self._times = numpy.zeros((ROOM + 1, width))  # the first: of the start
        self._rows = numpy.empty((ROOM, width), dtype=int)
        self._steps = 0  # how many are recorded now
        self._closed: list[tuple[int, Array, Array]] = []  # rows that end: step, lanes, states
        self._record_step = self._recorder()

    def integrate(self, starts: Sequence[LaneStart], signs: Array) -> LaneResults:
        """Integrate from all starts, where the detectors' functions have these ``signs``."""
        ends: dict[int, tuple[str, float, Array]] = {}
        waiting = iter(range(len(starts)))
        bodies = numpy.array([start.parameters for start in starts])
        bodies = bodies.reshape(len(starts), len(self._batch.pars)).T.copy()
        self._zeros.open(bodies, signs)
        for extreme in self._extremes:
            extreme.open(bodies)
        self._taken = numpy.zeros(len(starts) + 1, dtype=int)  # the last one: by empty lanes
        self._steps = 0
        self._times[0] = 0.0
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
                places = numpy.array(list(ended))
                self._closed.append((self._steps - 1, places, self._batch.state[:, places]))
            for lane, status in ended.items():
                ends[int(self._row_in[lane])] = self._end(lane, status)
                self._load(lane, next(waiting, -1), starts)
            if self._steps == ROOM:
                self._search()
        if self._steps:
            self._search()
        return LaneResults(
            [LaneResult(*ends[row], int(self._taken[row])) for row in range(len(starts))],
            self._zeros.events(),
            {extreme.statistic: extreme.states() for extreme in self._extremes},
        )

    def _load(self, lane: int, number: int, starts: Sequence[LaneStart]) -> None:
        self._row_in[lane] = number
        start = starts[number] if number >= 0 else self._rest
        self._batch.state[:, lane] = start.state
        self._batch.pars[:, lane] = start.parameters
        self._goals[lane] = start.until
        self._longest[lane] = start.longest
        # not set_time, which would cut the low parts of the other lanes' times
        high, low = (part.copy() for part in self._batch.dtime)
        high[lane] = low[lane] = 0.0
        if not numpy.isfinite(high).all():
            high, low = numpy.nan_to_num(high), numpy.nan_to_num(low)
        self._batch.set_dtime(high, low)
        if self._batch.with_events:
            self._batch.reset_cooldowns(lane)
        self._age[lane] = 0

    def _recorder(self) -> Callable[[Adaptive], bool]:
        """A callback that records the last step of the integrator.

        All attributes are looked up beforehand: that halves the time of this loop.
        """
        # views of heyoka's own memory, which stays where it is
        series, high, last_h = self._batch.tc, self._time, self._batch.last_h
        places = list(zip(self._series, self._widths, self._times[1:], strict=True))

        def record_step(_: Adaptive) -> bool:
            to_series, to_width, to_time = places[self._steps]
            to_series[...] = series
            to_width[...] = last_h
            to_time[...] = high
            self._steps += 1
            return True

        return record_step

    def _advance(self) -> list[Any]:
        before = self._steps
        self._batch.propagate_until(
            self._goals,
            max_delta_t=self._longest,
            max_steps=min(STEPS_BETWEEN, ROOM - before),
            callback=self._record_step,
            write_tc=True,
        )
        outcomes = [outcome for outcome, _ in self._batch.step_res]
        if heyoka.taylor_outcome.err_nf_state in outcomes:
            self._record_step(self._batch)  # heyoka skips the callback of such a step
        self._rows[before : self._steps] = self._row_in
        self._age += self._steps - before
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
        state = self._batch.state[:, lane]
        if status == "failed":
            begun = float(self._times[self._steps - 1, lane]) if self._age[lane] > 1 else 0.0
            return status, begun, state * numpy.nan
        return status, float(self._time[lane]), state.copy()

    def _search(self) -> None:
        """Read the events in the recorded steps, and forget the steps."""
        count, lanes = self._steps, numpy.arange(len(self._row_in))
        ends, times = self._times[1 : count + 1].copy(), self._times
        for step, closed, _ in self._closed:  # what is next in these lanes begins at time 0
            times[step + 1, closed] = 0.0
        last = [(count - 1, lanes, self._batch.state), *self._closed]
        steps = BatchSteps(
            self._rows[:count],
            times[:count],
            ends,
            self._widths[:count],
            self._series[:count],
            (
                numpy.concatenate([numpy.full(len(mine), step) for step, mine, _ in last]),
                numpy.concatenate([mine for _, mine, _ in last]),
            ),
            numpy.concatenate([states for _, _, states in last], axis=1),
        )
        self._taken += numpy.bincount(steps.row[steps.belongs], minlength=len(self._taken))
        for reader in self._readers:
            reader.search(steps)
        times[0] = times[count]
        self._closed.clear()
        self._steps = 0


# compiled lanes for a ``Build``: idle ones of an earlier task of this process, or made now
lanes = partial(pooled, Lanes)


def _compiled(form: Formulation, contact: str, width: int) -> tuple[Adaptive, tuple[str, ...]]:
    equations = Equations.of(form)
    terminal = terminal_functions(form, equations.motion)
    if contact == "bilateral":
        del terminal["contact_lost"]
    options = numeric_options(Setup(formulation=form, precision=precision_named("double")))
    # rolling compiles in a tenth of the time so, and runs as fast (1.02)
    options["compact_mode"] |= form.model == "rolling"
    options["opt_level"] = 3  # at 0 the bits of a row would depend on the number of lanes
    made = heyoka.taylor_adaptive_batch(
        equations.system,
        numpy.zeros((len(form.columns), width)),
        pars=numpy.ones((len(form.parameters), width)),
        t_events=[heyoka.t_event_batch(function) for function in terminal.values()],
        **options,
    )
    return made, tuple(terminal)
