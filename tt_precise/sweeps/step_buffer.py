"""The last steps of all lanes: what happened in them is read off when there are enough."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy

from tt_precise.integration.system import MOST_EVENTS
from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Adaptive
from tt_precise.sweeps.axis_height import Heights, height_rates, read_heights, turning_points
from tt_precise.sweeps.climb_zeros import EARLY, ClimbZeros, Taken
from tt_precise.sweeps.columns import Detector
from tt_precise.sweeps.min_normal_force import lowest_states, lowest_steps, may_be_lowest, reaches
from tt_precise.sweeps.step_polynomials import WIDTH
from tt_precise.sweeps.steps_again import LaneStart, StepsAgain, noted

ROOM = 500  # steps; not near a multiple of 64, where the rows of columns share lines of a cache
EVENTS_OF_A_ROW = 1000  # a hundred bytes each; a climb has hundreds
MOST_LOWEST = 256  # steps of a row, one of which has the smallest force


class Events(NamedTuple):
    """Events, a row each: an array for each column.

    ``row`` and ``detector`` are positions, ``direction`` is +1 where the function rises and -1
    where it falls, ``time`` is dimensionless as is ``state``, shape (events, entries), NaN where
    the detector is not ``stateful``.
    """

    row: Array
    detector: Array
    direction: Array
    time: Array
    state: Array


class LowestSteps(NamedTuple):
    """Steps in which the normal force of a row may be smallest, a column each.

    ``ceiling`` is what the second derivative of k.z stays below, ``state`` that at the start, shape
    (entries, steps).
    """

    row: Array
    ceiling: Array
    width: Array
    state: Array

    def only(self, chosen: Array) -> LowestSteps:
        """Those at some positions, or where a mask is True."""
        return LowestSteps(*(column[..., chosen] for column in self))


class StepBuffer:
    """Records the steps of a batch integrator, and reads them.

    ``hits`` is where events found by heyoka on the way are noted, see ``compiled``; ``again`` takes
    steps again, with the detectors that are not looked for on the way.
    """

    def __init__(
        self,
        batch: Adaptive,
        form: Formulation,
        detectors: Sequence[Detector],
        hits: array[float],
        again: StepsAgain,
    ):
        self._batch, self._form, self._hits, self._again = batch, form, hits, again
        self._stateful = numpy.array([one.stateful for one in detectors])
        self._turning = [one.turning for one in detectors].index(True)
        self._every = detectors[self._turning].every
        self._height = form.columns.index("kz")
        self._zeros = ClimbZeros(form, list(enumerate(detectors)), again)
        entries, terms, width = batch.tc.shape
        self._columns = numpy.empty((terms + 2, ROOM, width))  # see read_heights
        self._states = numpy.empty((entries, ROOM, width))  # where the steps begin
        self._high, self._low = numpy.zeros((2, ROOM + 1, width))  # times; the first: of the start
        self._rows = numpy.empty((ROOM, width), dtype=int)
        self._rates = numpy.full(width, math.nan)  # of k.z where the steps begin; NaN at starts
        self._closed: list[tuple[int, Array, Array]] = []  # rows that end: step, lanes, states
        self._counts: list[int] = []
        self.steps = 0  # how many there are now
        self.record_step = self._recorder()

    def _recorder(self) -> Callable[[Adaptive], bool]:
        """A function that records the last step of the integrator, which calls it after each.

        Half the time of this loop was Python's way to the places; so all are looked up before.
        """
        # views of heyoka's own memory, which stays where it is
        series, (high, low), last_h = self._batch.tc, self._batch.dtime, self._batch.last_h
        heights, starts = series[self._height, 1:], series[:, 0]
        places = [
            (
                self._columns[:WIDTH, step], self._states[:, step], self._columns[WIDTH, step],
                self._high[step + 1], self._low[step + 1],
            )
            for step in range(ROOM)
        ]  # fmt: skip
        counts, hits = self._counts, self._hits

        def record_step(_: Adaptive) -> bool:
            to_heights, to_starts, to_width, to_high, to_low = places[self.steps]
            to_heights[...] = heights
            to_starts[...] = starts
            to_width[...] = last_h
            to_high[...] = high
            to_low[...] = low
            counts.append(len(hits))
            self.steps += 1
            return True

        return record_step

    def open(self, starts: Sequence[LaneStart]) -> None:
        """Begin with the rows from these starts."""
        rows = len(starts)
        self.steps = 0
        self._rates[:] = math.nan
        self._forget()
        self._high[0] = self._low[0] = 0.0
        self._again.open(starts)
        self._zeros.open(rows)
        # the last one of these is for empty lanes
        self.taken = numpy.zeros(rows + 1, dtype=int)  # steps of each row
        self._highest = numpy.full(rows + 1, -math.inf)  # the largest curvature
        none = numpy.empty(0)
        nothing = none.astype(int)
        entries = len(self._form.columns)
        self._lowest = LowestSteps(nothing, none, none, numpy.empty((entries, 0)))
        self._room = MOST_EVENTS + EVENTS_OF_A_ROW * rows
        self._found = [Events(nothing, nothing, nothing, none, numpy.empty((0, entries)))]

    def _forget(self) -> None:
        del self._hits[:]
        self._closed.clear()
        self._counts.clear()

    def assign(self, since: int, rows: Array) -> None:
        """Say whose the steps from ``since`` on are, -1 for empty lanes."""
        self._rows[since : self.steps] = rows

    def step_start(self, lane: int) -> float:
        """When the last step of ``lane`` began, which is not the first one of its row."""
        return float(self._high[self.steps - 1, lane])

    def close(self, lanes: Sequence[int]) -> None:
        """Note that the rows in these lanes end here."""
        places = numpy.array(lanes)
        self._closed.append((self.steps - 1, places, self._batch.state[:, places]))

    def read(self) -> None:
        """Read off what happened in the steps, and give them up."""
        steps = self.steps
        taken, (last, states) = self._taken(), self._last()
        whose = taken.row[taken.width != 0]
        self.taken += numpy.bincount(whose, minlength=len(self.taken))
        self._zeros.read(taken, last, states)
        rates = height_rates(self._form, self._again.parameters[:, taken.row[last]], states)
        read = read_heights(self._columns[:, :steps], self._rates, last, rates)
        self._find_lowest(read, taken)
        self._found += [self._noted(taken), self._turns(read, taken)]
        self._room -= sum(len(one.row) for one in self._found[-2:])
        if self._room < 0:
            raise InputError(
                f"until: got a time in which {len(self.taken) - 1} rows have more than "
                f"{MOST_EVENTS + EVENTS_OF_A_ROW * (len(self.taken) - 1)} events, expected a "
                "shorter one"
            )
        self._high[0], self._low[0] = self._high[steps], self._low[steps]
        self._rates = rates[: len(self._rates)]
        for step, lanes, _ in self._closed:
            if step == steps - 1:
                self._rates[lanes] = math.nan
        self._forget()
        self.steps = 0

    def events(self) -> Events:
        """All events of the rows, each kind in order of time."""
        hits = self._zeros.hits()
        hits = hits.only(numpy.argsort(hits.time, kind="stable"))
        blank = numpy.full((len(hits.time), len(self._form.columns)), numpy.nan)
        found = [*self._found, Events(hits.place, hits.detector, hits.direction, hits.time, blank)]
        events = Events(*(numpy.concatenate(column) for column in zip(*found, strict=True)))
        order = numpy.argsort(events.row, kind="stable")
        order = order[events.row[order] >= 0]
        return Events(*(column[order] for column in events))

    def lowest(self) -> tuple[Array, Array]:
        """Rows, in order, and states in one of which their normal force is smallest."""
        held = self._still_lowest()
        held = held.only(numpy.argsort(held.row, kind="stable"))
        series = self._again.series(held.row, held.state)
        states, rows = lowest_states(series, held.width, held.row, self._height)
        return rows, states

    def _taken(self) -> Taken:
        steps = self.steps
        high, low = self._high[: steps + 1], self._low[: steps + 1]
        ends = high[1:].copy()
        for step, lanes, _ in self._closed:  # what is next in these lanes begins at time 0
            high[step + 1, lanes] = low[step + 1, lanes] = 0.0
        widths, states = self._columns[WIDTH, :steps], self._states[:, :steps]
        return Taken(self._rows[:steps], widths, ends, high[:-1], low[:-1], states)

    def _last(self) -> tuple[tuple[Array, Array], Array]:
        """Which steps (and lanes) are the last ones, here or of their rows; where they end."""
        lanes = numpy.arange(len(self._rates))
        ends = [(self.steps - 1, lanes, self._batch.state), *self._closed]
        last = (
            numpy.concatenate([numpy.full(len(lanes), step) for step, lanes, _ in ends]),
            numpy.concatenate([lanes for _, lanes, _ in ends]),
        )
        return last, numpy.concatenate([states for _, _, states in ends], axis=1)

    def _still_lowest(self) -> LowestSteps:
        held = self._lowest
        return held.only(reaches(held.ceiling, self._highest[held.row]))

    def _find_lowest(self, read: Heights, taken: Taken) -> None:
        step, lane, ceiling = may_be_lowest(read, taken.width, taken.row, self._highest)
        new = LowestSteps(
            taken.row[step, lane], ceiling, taken.width[step, lane], taken.state[:, step, lane]
        )
        parts = zip(self._lowest, new, strict=True)
        self._lowest = LowestSteps(*(numpy.concatenate(one, axis=-1) for one in parts))
        # a periodic motion has as many as periods
        if (numpy.bincount(self._lowest.row) > MOST_LOWEST).any():
            self._keep_few_lowest()

    def _keep_few_lowest(self) -> None:
        held = self._still_lowest()
        kept = numpy.ones(len(held.row), dtype=bool)
        for row in numpy.flatnonzero(numpy.bincount(held.row) > MOST_LOWEST).tolist():
            mine = numpy.flatnonzero(held.row == row)
            series = self._again.series(held.row[mine], held.state[:, mine])
            chosen = mine[lowest_steps(series, held.width[mine], self._height)]
            kept[mine] = False
            kept[chosen], held.ceiling[chosen] = True, math.inf
        self._lowest = held.only(kept)

    def _turns(self, read: Heights, taken: Taken) -> Events:
        """The turning points of theta: all, or those that the climb depends on.

        As an event of heyoka, which finds hundreds of them in a row of a sweep, that costs as much
        as all other events together.
        """
        climb = self._zeros.climb[taken.row]
        every = self._every | (climb < EARLY)
        at, since, time, rising = turning_points(read, taken.end, climb, every)
        step, lane = numpy.divmod(at, taken.row.shape[1])
        rows = taken.row[step, lane]
        state = self._again.states(rows, taken.state[:, step, lane], since)
        detector = numpy.full(len(lane), self._turning)
        # the event's function falls where theta has a minimum
        return Events(rows, detector, 2 * rising - 1, time, state)

    def _noted(self, taken: Taken) -> Events:
        """What heyoka has found on the way."""
        lane, detector, time, direction = noted(self._hits)
        step = numpy.searchsorted(self._counts, 4 * numpy.arange(len(lane)), side="right")
        rows = taken.row[step, lane]
        state = numpy.full((len(lane), len(taken.state)), numpy.nan)
        wanted = numpy.flatnonzero(self._stateful[detector])
        if len(wanted):
            at, on = step[wanted], lane[wanted]
            begun = taken.end[at, on] - taken.width[at, on]
            state[wanted] = self._again.states(
                rows[wanted], taken.state[:, at, on], time[wanted] - begun
            )
        return Events(rows, detector, direction, time, state)
