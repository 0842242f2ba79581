"""The last steps of all lanes: their series are held until what happened in them is read off."""

from __future__ import annotations

import math
from array import array
from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy

from tt_precise.arithmetic import Array
from tt_precise.errors import InputError
from tt_precise.integrate.system import MOST_EVENTS
from tt_precise.mechanics.formulations import Formulation
from tt_precise.sweep.axis_height import Heights, height_rates, read_heights, turning_points
from tt_precise.sweep.columns import Detector
from tt_precise.sweep.min_normal_force import Step, lowest_steps, may_be_lowest, reaches
from tt_precise.sweep.step_polynomials import states_in
from tt_precise.untyped import Adaptive

ROOM = 384  # steps
EARLY = 2.0**-26.5  # dimensionless; nearer to t = 0 an event may be the start itself
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


class StepBuffer:
    """Records the steps of a batch integrator, and reads them.

    ``hits`` is where events found by heyoka are noted: lane, detector, time and direction of each,
    flat, because objects are slow.
    """

    def __init__(
        self, batch: Adaptive, form: Formulation, detectors: Sequence[Detector], hits: array[float]
    ):
        self._batch, self._form, self._hits = batch, form, hits
        self._stateful = numpy.array([one.stateful for one in detectors])
        self._turning = [one.turning for one in detectors].index(True)
        self._every = detectors[self._turning].every
        self._equator = [one.event.name for one in detectors].index("equator")
        self._height = form.columns.index("kz")
        # views of heyoka's own memory, which stays where it is
        self._tc, self._time, self._last_h = batch.tc, batch.time, batch.last_h
        width = len(self._time)
        self._series = numpy.empty((ROOM, *self._tc.shape))
        self._ends = numpy.empty((ROOM, width))
        self._widths = numpy.empty((ROOM, width))
        self._rows = numpy.empty((ROOM, width), dtype=int)
        self._closing = numpy.full((ROOM, width), math.nan)  # rates of k.z where rows end
        self._since = numpy.zeros(width)  # when the steps begin
        self._rates = numpy.full(width, math.nan)  # of k.z where the steps begin; NaN at starts
        self._counts: list[int] = []
        self.steps = 0  # how many there are now

    def open(self, rows: int) -> None:
        """Begin with so many rows."""
        self.steps = 0
        self._rates[:] = math.nan
        del self._hits[:]
        self._counts.clear()
        # the last one of these is for empty lanes
        self.taken = numpy.zeros(rows + 1, dtype=int)  # steps of each row
        self._climb = numpy.full(rows + 1, math.inf)  # theta first rises through pi/2
        self._highest = numpy.full(rows + 1, -math.inf)  # the largest curvature
        self._lowest: dict[int, list[tuple[float, Step]]] = defaultdict(list)
        none = numpy.empty(0, dtype=int)
        size = self._tc.shape[0]
        self._room = MOST_EVENTS + EVENTS_OF_A_ROW * rows
        self._found = [Events(none, none, none, numpy.empty(0), numpy.empty((0, size)))]

    def record_step(self, _: Adaptive) -> bool:
        """Record the last step of the integrator, which calls this after each."""
        step = self.steps
        self._series[step] = self._tc
        self._ends[step] = self._time
        self._widths[step] = self._last_h
        self._counts.append(len(self._hits))
        self.steps = step + 1
        return True

    def assign(self, since: int, rows: Array) -> None:
        """Say whose the steps from ``since`` on are, -1 for empty lanes."""
        self._rows[since : self.steps] = rows

    def step_start(self, lane: int) -> float:
        """When the last step of ``lane`` began, which is not the first one of its row."""
        step = self.steps - 2
        return float(self._ends[step, lane]) if step >= 0 else float(self._since[lane])

    def close(self, lanes: Sequence[int]) -> None:
        """Note that the rows in these lanes end here."""
        self._closing[self.steps - 1, lanes] = self._height_rates()[lanes]

    def read(self) -> None:
        """Read off what happened in the steps, and give them up."""
        series, widths = self._series[: self.steps], self._widths[: self.steps]
        whose = self._rows[: self.steps][widths != 0]
        self.taken += numpy.bincount(whose, minlength=len(self.taken))
        rates, closing = self._height_rates(), self._closing[: self.steps]
        read = read_heights(series[:, self._height], widths, self._rates, rates, closing)
        self._find_lowest(read)
        noted = self._noted()
        climbs = noted.detector == self._equator
        numpy.minimum.at(self._climb, noted.row[climbs], noted.time[climbs])
        self._found += [noted, self._turns(read)]
        self._room -= len(noted.row) + len(self._found[-1].row)
        if self._room < 0:
            raise InputError(
                f"until: got a time in which {len(self.taken) - 1} rows have more than "
                f"{MOST_EVENTS + EVENTS_OF_A_ROW * (len(self.taken) - 1)} events, expected a "
                "shorter one"
            )
        self._since, self._rates = self._ends[self.steps - 1].copy(), rates
        closing[:] = math.nan
        del self._hits[:]
        self._counts.clear()
        self.steps = 0

    def events(self) -> Events:
        """All events of the rows, in their order."""
        events = Events(*(numpy.concatenate(column) for column in zip(*self._found, strict=True)))
        order = numpy.argsort(events.row, kind="stable")
        order = order[events.row[order] >= 0]
        return Events(*(column[order] for column in events))

    def lowest(self, row: int) -> list[Step]:
        """The steps of a row in one of which the normal force is smallest."""
        highest = self._highest[row]
        return [step for ceiling, step in self._lowest[row] if reaches(ceiling, highest)]

    def _height_rates(self) -> Array:
        """Rates of k.z where the lanes are now."""
        return height_rates(self._form, self._batch.pars, self._batch.state)

    def _find_lowest(self, read: Heights) -> None:
        rows = self._rows[: self.steps]
        found = may_be_lowest(read, self._widths[: self.steps], rows, self._highest)
        step, lane, ceiling = found
        for row, above, width, series in zip(
            rows[step, lane].tolist(),
            ceiling.tolist(),
            self._widths[step, lane].tolist(),
            self._series[step, :, :, lane],
            strict=True,
        ):
            self._lowest[row].append((above, Step(width, series.copy())))
        for row in set(rows[step, lane].tolist()):
            if len(self._lowest[row]) > MOST_LOWEST:  # a periodic motion has as many as periods
                steps = lowest_steps(self.lowest(row), self._height)
                self._lowest[row] = [(math.inf, step) for step in steps]

    def _turns(self, read: Heights) -> Events:
        """The turning points of theta: all, or those that the climb depends on.

        As an event of heyoka, which finds hundreds of them in a row of a sweep, that costs as much
        as all other events together.
        """
        ends, rows = self._ends[: self.steps], self._rows[: self.steps]
        climb = self._climb[rows]
        at, since, time, rising = turning_points(read, ends, climb, self._every | (climb < EARLY))
        step, lane = numpy.divmod(at, len(self._time))
        state = states_in(self._series[step, :, :, lane], since)
        detector = numpy.full(len(lane), self._turning)
        # the event's function falls where theta has a minimum
        return Events(rows.ravel()[at], detector, 2 * rising - 1, time, state)

    def _noted(self) -> Events:
        """What heyoka has found."""
        lane, detector, time, direction = numpy.array(self._hits).reshape(-1, 4).T
        lane, detector, direction = (one.astype(int) for one in (lane, detector, direction))
        step = numpy.searchsorted(self._counts, 4 * numpy.arange(len(lane)), side="right")
        state = numpy.full((len(lane), self._tc.shape[0]), numpy.nan)
        wanted = numpy.flatnonzero(self._stateful[detector])
        if len(wanted):
            at, on = step[wanted], lane[wanted]
            begun = self._ends[at, on] - self._widths[at, on]
            state[wanted] = states_in(self._series[at, :, :, on], time[wanted] - begun)
        return Events(self._rows[step, lane], detector, direction, time, state)
