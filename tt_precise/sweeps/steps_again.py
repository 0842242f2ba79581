"""Steps that are taken again, where more of them is wanted than was recorded.

A step follows from the state at its start, to the last bit. So its series need not be kept until
it is known whether they are wanted, and events that only few steps can hold are not looked for in
all: zeros of four functions cost half as much as the integration, copying all series a third.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import heyoka
import numpy

from tt_precise.integration.equations import Equations
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import (
    event_expression,
    heyoka_direction,
    numeric_options,
    terminal_functions,
)
from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.untyped import Adaptive
from tt_precise.sweeps.columns import Detector
from tt_precise.sweeps.step_polynomials import states_in

# heyoka takes the step from the largest of state and event functions: scaled down, these do not
# shorten it, and a trajectory takes the same steps whatever is looked for along it
EVENT_SCALE = 2.0**-10
BATCHES = 15  # whose series are read at once, from memory that is near


class LaneStart(NamedTuple):
    """A start, dimensionless: state, parameters of the formulation, horizon, longest step."""

    state: tuple[float, ...]
    parameters: tuple[float, ...]
    until: float
    longest: float = math.inf


class Begun(NamedTuple):
    """Where steps begin: row, time in two parts, state; arrays, ``state`` of (entries, steps)."""

    row: Array
    high: Array
    low: Array
    state: Array

    def only(self, chosen: Array) -> Begun:
        """Those at some positions, or where a mask is True."""
        return Begun(*(column[..., chosen] for column in self))


class Hits(NamedTuple):
    """Events as heyoka found them, a column each: lane or step, detector, time, direction."""

    place: Array
    detector: Array
    time: Array
    direction: Array

    def only(self, chosen: Array) -> Hits:
        """Those at some positions, or where a mask is True."""
        return Hits(*(column[chosen] for column in self))


def noted(hits: Sequence[float]) -> Hits:
    """The events of a flat list, as ``compiled`` integrators write it."""
    place, detector, time, direction = numpy.array(hits, dtype=float).reshape(-1, 4).T
    return Hits(place.astype(int), detector.astype(int), time, direction.astype(int))


def compiled(
    form: Formulation,
    contact: str,
    width: int,
    detectors: Sequence[tuple[int, Detector]],
    hits: array[float],
) -> tuple[Adaptive, tuple[str, ...]]:
    """A batch integrator that adds what its detectors find to ``hits``, and its terminal events.

    Each event is written as four numbers, because objects are slow: lane, number of the detector,
    time and direction. The same start takes the same steps in all integrators of a form, contact
    and width.
    """
    equations = Equations.of(form)
    terminal = terminal_functions(form, equations.motion, equations.variables[0])
    if contact == "bilateral":
        del terminal["contact_lost"]
    options = numeric_options(Setup(formulation=form, precision=precision_named("double")))
    # rolling compiles in a tenth of the time so, and runs as fast (1.02)
    options["compact_mode"] |= form.model == "rolling"
    made = heyoka.taylor_adaptive_batch(
        equations.system,
        numpy.zeros((len(form.columns), width)),
        pars=numpy.ones((len(form.parameters), width)),
        t_events=[heyoka.t_event_batch(function) for function in terminal.values()],
        nt_events=[
            heyoka.nt_event_batch(
                event_expression(one.event, equations) * EVENT_SCALE,
                _noting(hits, position),
                direction=heyoka_direction(one.direction),
            )
            for position, one in detectors
        ],
        **options,
    )
    return made, tuple(terminal)


def _noting(hits: array[float], position: int) -> Callable[[Adaptive, float, int, int], None]:
    # a function, because heyoka copies callables deeply, but functions with what they refer to
    def note(_: Adaptive, time: float, sign: int, lane: int) -> None:
        if sign:  # 0: the function vanishes identically, so nothing changes sign
            hits.extend((lane, position, time, sign))

    return note


class StepsAgain:
    """Takes steps of some rows again; ``detectors`` are those that are looked for only here."""

    def __init__(
        self,
        form: Formulation,
        contact: str,
        width: int,
        detectors: Sequence[tuple[int, Detector]],
    ):
        self._hits = array("d")
        self._build = (form, contact, width)
        self._detectors = detectors
        self._width = width
        self._plain, _ = compiled(*self._build, (), array("d"))
        self._finding: Adaptive = None  # compiled when it is needed first
        entries, terms, _ = self._plain.tc.shape
        self._columns = numpy.zeros((entries * terms + 1, BATCHES * width))

    def open(self, starts: Sequence[LaneStart]) -> None:
        """Steps are those of rows from these starts."""
        bodies = numpy.array([one.parameters for one in starts])
        self.parameters = bodies.reshape(len(starts), len(self._plain.pars)).T.copy()
        self._goals = numpy.array([one.until for one in starts])
        self._longest = numpy.array([one.longest for one in starts])

    def states(self, rows: Array, begun: Array, since: Array) -> Array:
        """States so long after the start of steps, from their states there.

        ``begun`` has the shape (entries, steps), the result (steps, entries).
        """
        found = numpy.empty((len(rows), len(begun)))
        for here, series in self._series(rows, begun):
            count = here.stop - here.start
            series[-1, :count] = since[here]
            found[here] = states_in(series, len(begun))[:count]
        return found

    def series(self, rows: Array, begun: Array) -> Array:
        """Taylor series of steps from their states at the start, of shape (entries, steps).

        The shape is (entries, order + 1, steps).
        """
        found = numpy.empty((*self._plain.tc.shape[:2], len(rows)))
        flat = found.reshape(len(self._columns) - 1, len(rows))
        for here, series in self._series(rows, begun):
            flat[:, here] = series[:-1, : here.stop - here.start]
        return found

    def _series(self, rows: Array, begun: Array) -> Iterator[tuple[slice, Array]]:
        """Some steps at a time, their series in columns, and a row below them for times."""
        batch, width, columns = self._plain, self._width, self._columns
        state, parameters, flat = batch.state, batch.pars, batch.tc.reshape(-1, width)
        batch.set_time(0.0)
        chosen = self._filled(len(rows))
        begun, bodies = begun[:, chosen], self.parameters[:, rows[chosen]]
        for piece in range(0, len(chosen), columns.shape[1]):
            end = min(piece + columns.shape[1], len(chosen))
            for first in range(piece, end, width):
                state[...] = begun[:, first : first + width]
                parameters[...] = bodies[:, first : first + width]
                batch.step(write_tc=True)
                columns[:-1, first - piece : first - piece + width] = flat
            yield slice(piece, min(end, len(rows))), columns

    def zeros(self, steps: Begun) -> Hits:
        """What the detectors find in the steps."""
        if self._finding is None:
            self._finding, _ = compiled(*self._build, self._detectors, self._hits)
        batch, hits, found = self._finding, self._hits, array("d")
        for number, chosen in enumerate(self._filled(len(steps.row)).reshape(-1, self._width)):
            rows = steps.row[chosen]
            batch.state[:] = steps.state[:, chosen]
            batch.pars[:] = self.parameters[:, rows]
            batch.set_dtime(steps.high[chosen], steps.low[chosen])
            batch.reset_cooldowns()
            del hits[:]
            batch.propagate_until(
                self._goals[rows].tolist(), max_delta_t=self._longest[rows].tolist(), max_steps=1
            )
            for event in range(0, len(hits), 4):
                found.append(number * self._width + hits[event])
                found.extend(hits[event + 1 : event + 4])
        events = noted(found)
        return events.only(events.place < len(steps.row))

    def _filled(self, steps: int) -> Array:
        """Positions of the steps, for all lanes of the batches that they fill."""
        lanes = -(-steps // self._width) * self._width
        # lanes that are left over take the last step, too
        return numpy.minimum(numpy.arange(lanes), steps - 1)
