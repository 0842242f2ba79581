"""Integrate many motions at once in the SIMD lanes of heyoka's batch integrator, in double.

Lanes share only the loop over the steps: each lane has its own time, step size and end. Where a
motion ends, the next start takes its lane, so that no lane waits and no motion depends on another.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.equations import Equations, longest_step, rigid_ends
from tt_precise.integration.heyoka_backend import numeric_options
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.terminal import import_heyoka
from tt_precise.runtime.values import Array
from tt_precise.scene.scene import InitialState
from tt_precise.sweeps.columns import DOUBLE

heyoka = import_heyoka()

# Steps of each lane that are recorded before they are searched: 11 MB for 8 lanes. Half as many
# take 1.2 times as long; twice as many are no faster.
ROOM = 1000
# Steps between two looks at the lanes: an ended lane idles for half of them, 2 % of a motion.
STEPS_PER_CALL = 64
MOST_STEPS = 5_000_000  # A motion with more Taylor steps has failed.


class LaneSteps(NamedTuple):
    """Recorded Taylor steps, dimensionless; those of one motion follow each other.

    ``row`` is the number of the motion, ``begin`` and ``width`` are time and length of a step;
    ``states``, shape (components, steps), are at the beginning. ``last`` are the indices of the
    steps which no recorded step of the same motion follows, and ``ends`` the states there. A step
    is at its ``position`` in ``recorded``, shape (all steps, components, order + 1).
    """

    row: Array
    begin: Array
    width: Array
    states: Array
    last: Array
    ends: Array
    recorded: Array
    position: Array

    def series(self, chosen: Array, component: int | slice = slice(None)) -> Array:
        """Return coefficients of the chosen steps, shape ([components,] order + 1, chosen)."""
        gathered = self.recorded[self.position[chosen], component]
        return numpy.ascontiguousarray(numpy.moveaxis(gathered, 0, -1))

    def at_ends(self, values: Array, at_last: Array) -> Array:
        """Return values at the ends of the steps, from those in ``states`` and in ``ends``."""
        ends = numpy.empty_like(values)
        ends[..., :-1] = values[..., 1:]  # a step ends where the next one begins
        ends[..., self.last] = at_last
        return ends


class LaneEnd(NamedTuple):
    """The end of a motion, dimensionless.

    ``status`` is "complete", "contact_lost", "singular_contact" or "failed"; ``state`` is that at
    ``time``, NaN if the integration failed.
    """

    status: str
    time: float
    state: Array
    steps: int


class BatchIntegrator:
    """A compiled batch integrator of one formulation."""

    def __init__(self, form: Formulation, contact: str, lanes: int):
        # heyoka computes the step size of a single lane by other functions, which round otherwise
        self.lanes = max(2, lanes)
        equations = Equations.of(form)
        terminal = rigid_ends(equations)
        if contact == "bilateral":
            del terminal["contact_lost"]
        options = numeric_options(Setup(formulation=form, precision=DOUBLE))
        options["compact_mode"] |= form.model == "rolling"  # compiles ten times faster
        options["opt_level"] = 3  # at level 0 the bits of a row depend on the number of lanes
        self._form, self._statuses = form, tuple(terminal)
        self._adaptive = heyoka.taylor_adaptive_batch(
            equations.system,
            numpy.zeros((len(form.columns), self.lanes)),
            pars=numpy.ones((len(form.parameters), self.lanes)),
            t_events=[heyoka.t_event_batch(function) for function in terminal.values()],
            **options,
        )
        self._series = numpy.empty((ROOM, self.lanes, *self._adaptive.tc.shape[:2]))
        self._width = numpy.empty((ROOM, self.lanes))
        self._begin = numpy.empty((ROOM + 1, self.lanes))  # the last one: where the last step ends
        self._row = numpy.empty((ROOM, self.lanes), dtype=int)

    def integrate(
        self,
        starts: Sequence[InitialState],
        ends: list[LaneEnd],
        search: Callable[[LaneSteps], None],
    ) -> None:
        """Integrate from the starts whose ``ends`` have no status yet, and fill these in.

        ``search`` receives the Taylor steps in blocks.
        """
        waiting = iter([(n, starts[n]) for n, end in enumerate(ends) if not end.status])
        adaptive, time, state = self._adaptive, self._adaptive.time, self._adaptive.state
        row, taken = numpy.full(self.lanes, -1), numpy.zeros(self.lanes, dtype=int)
        goals, longest = numpy.zeros(self.lanes), numpy.full(self.lanes, math.inf)
        finals = numpy.full((len(state), len(starts)), math.nan)  # where recorded steps end
        counts, count = numpy.zeros(len(starts), dtype=int), 0

        series, width = adaptive.tc, adaptive.last_h  # views of heyoka's memory, which stay
        by_lane = numpy.moveaxis(self._series, 1, -1)  # as heyoka has them
        targets = [*zip(by_lane, self._width, self._begin[1:], strict=True)]

        def record(_: Any = None) -> bool:
            nonlocal count
            to_series, to_width, to_time = targets[count]
            to_series[...], to_width[...], to_time[...] = series, width, time
            count += 1
            return True

        for lane in range(self.lanes):
            row[lane], goals[lane], longest[lane] = self._load(lane, waiting)
        while (row >= 0).any():
            first = count
            self._begin[first] = time
            most = min(STEPS_PER_CALL, ROOM - count)
            adaptive.propagate_until(
                goals, max_delta_t=longest, max_steps=most, callback=record, write_tc=True
            )
            outcomes = [outcome for outcome, _ in adaptive.step_res]
            if heyoka.taylor_outcome.err_nf_state in outcomes:
                record()  # heyoka does not call back after a step to a state that is not finite
            self._row[first:count] = row
            taken += count - first
            busy, arrived = numpy.flatnonzero(row >= 0), (time == goals).tolist()
            finals[:, row[busy]] = state[:, busy]
            for lane in busy.tolist():
                status = self._status(outcomes[lane], arrived[lane], taken[lane])
                if not status:
                    continue
                failed = status == "failed"
                end = self._begin[count - 1, lane] if failed else time[lane]
                factor = math.nan if failed else 1.0
                ends[row[lane]] = LaneEnd(status, float(end), finals[:, row[lane]] * factor, 0)
                row[lane], goals[lane], longest[lane] = self._load(lane, waiting)
                taken[lane] = 0
            if count == ROOM or not (row >= 0).any():
                steps = self._steps(count, finals)
                counts += numpy.bincount(steps.row, minlength=len(starts))
                search(steps)
                count = 0
        ends[:] = [end._replace(steps=int(n)) for end, n in zip(ends, counts, strict=True)]

    def _load(
        self, lane: int, waiting: Iterator[tuple[int, InitialState]]
    ) -> tuple[int, float, float]:
        """Put the next start into a lane; return its number, its horizon and its longest step."""
        adaptive, (number, start) = self._adaptive, next(waiting, (-1, None))
        horizon, longest = 0.0, None
        if start is None:  # a top at rest, which has no time left
            adaptive.state[:, lane] = [column == "kz" for column in self._form.columns]
            adaptive.pars[:, lane] = 0.5
        else:
            adaptive.state[:, lane] = start.state(self._form)
            adaptive.pars[:, lane] = start.parameters(self._form)
            horizon = start.until
            longest = longest_step(start.body, start.vectors, adaptive.order, DOUBLE)
        # heyoka's set_time would cut the low limbs of the other lanes' times
        limbs = [numpy.nan_to_num(limb) for limb in adaptive.dtime]
        limbs[0][lane] = limbs[1][lane] = 0.0
        adaptive.set_dtime(*limbs)
        if adaptive.with_events:
            adaptive.reset_cooldowns(lane)
        return number, horizon, math.inf if longest is None else float(longest)

    def _status(self, outcome: Any, arrived: bool, taken: int) -> str:
        """Return the status of a motion that has ended, "" of one that goes on."""
        if outcome == heyoka.taylor_outcome.err_nf_state or taken > MOST_STEPS:
            return "failed"
        # a step that the longest step cuts short has this outcome too
        if outcome == heyoka.taylor_outcome.time_limit and arrived:
            return "complete"
        event = -1 - int(outcome)
        return self._statuses[event] if 0 <= event < len(self._statuses) else ""

    def _steps(self, count: int, finals: Array) -> LaneSteps:
        """Return the recorded steps, without those of empty lanes and of length 0."""
        row, width = self._row[:count].T, self._width[:count].T
        lane, step = numpy.nonzero((row >= 0) & (width != 0) & numpy.isfinite(width))
        row = row[lane, step]
        last = numpy.flatnonzero(numpy.diff(row, append=-1))
        ends, position = finals.take(row[last], axis=1), step * self.lanes + lane
        recorded = self._series.reshape(-1, *self._series.shape[2:])
        states = numpy.ascontiguousarray(recorded[position, :, 0].T)
        begin, width = self._begin[step, lane], self._width[step, lane]
        return LaneSteps(row, begin, width, states, last, ends, recorded, position)


def states_in(series: Array, since: Array) -> Array:
    """Evaluate Taylor series, shape (components, order + 1, steps), at times after their start.

    Times have the shape (steps,) or (times, steps); a component axis comes in front of it.
    """
    states = numpy.empty((len(series), *since.shape))
    times = since.reshape(math.prod(since.shape[:-1]), -1)
    value = _compiled_values(series.shape[1], len(times))
    for coefficients, values in zip(series, states.reshape(len(series), *times.shape), strict=True):
        value(coefficients, pars=times, outputs=values, batch_parallel=False)
    return states


@cache
def _compiled_values(terms: int, times: int) -> Callable[..., Array]:
    """Compile the values of a polynomial at several times, which are parameters."""
    coefficients = heyoka.make_vars(*(f"c{power}" for power in range(terms)))

    def horner(at: Any) -> Any:
        value = coefficients[-1]
        for coefficient in coefficients[-2::-1]:
            value = value * at + coefficient
        return value

    return heyoka.cfunc([horner(heyoka.par[n]) for n in range(times)], vars=coefficients)
