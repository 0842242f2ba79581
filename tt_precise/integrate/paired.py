"""Two lanes: a run in double and its reference run at once, for little more than the run alone.

heyoka's tolerance is relative to the largest entry of the state, lane by lane. So a batch of two
gets one more entry, which is constant: 0 in one lane, and in the other ``RATIO`` times the largest
entry of the start. There the steps are as long as at a tolerance ``RATIO`` times looser. That
lane is the run, and the finer one its reference, with body and start rounded the other way.

Both integrate the equations in a frame that turns (``mechanics.turning``), and are read as the
states of the centre of mass that single runs have.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from tt_precise.arithmetic import Array
from tt_precise.body import Parameters
from tt_precise.initial_state import InitialState
from tt_precise.integrate.accuracy import digits_over_rows
from tt_precise.integrate.columns import Columns
from tt_precise.integrate.dense_output import DenseOutput
from tt_precise.integrate.equations import Equations
from tt_precise.integrate.idle import Idle
from tt_precise.integrate.propagate import Pieces, Propagation
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.step_limit import longest_step
from tt_precise.integrate.system import full_tolerance, heyoka_direction, terminal_functions
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.turning import (
    SHARE,
    TURNING,
    TurningState,
    to_centre,
    top_of,
    turned_back,
)
from tt_precise.progress import Progress
from tt_precise.untyped import Adaptive, ContinuousOutput

RATIO = 30
MOST_ROWS, MOST_STEPS = 100_000, 200_000
STATE = slice(0, 8)


class Pair(NamedTuple):
    """A run and its reference run: dense outputs, and rows at ``times`` (dimensionless).

    ``start`` is that of the reference run. Rows are arrays over the times, one an entry.
    """

    run: DenseOutput
    reference: DenseOutput
    start: InitialState
    times: Array
    rows: tuple[Array, ...]
    reference_rows: tuple[Array, ...]

    def digits(self, columns: Columns) -> Array:
        """Significant digits of the worst entry at each of the times."""
        import numpy

        values, others = (
            columns.of_arrays(columns.names, rows, float)
            for rows in (self.rows, self.reference_rows)
        )
        errors = {name: numpy.abs(values[name] - others[name]) for name in columns.names}
        return digits_over_rows(values, errors, columns.start.units, columns.precision.bits)


def can_be_paired(setup: Setup) -> bool:
    """Whether two lanes can do what ``setup`` asks for."""
    form = setup.formulation
    return (
        setup.precision.name == "double"
        and setup.tolerance >= RATIO * float(full_tolerance(setup.precision))
        and form.State is CentreState
        and form.law == "viscous"
        and setup.contact == "unilateral"
        and not (setup.events or setup.record or setup.options)
    )


def propagate_pair(setup: Setup, start: InitialState, every: Fraction) -> Pair | None:
    """Both runs to the horizon, with rows ``every`` so many s and there.

    None where a run ends before it, starts close to a pole, or is very long: there a run and its
    reference are made one after the other.
    """
    import numpy

    until, step = float(start.until), float(every) / float(start.units.time)
    if not until or until / step > MOST_ROWS:
        return None
    if longest_step(start.body, start.vectors, 1, setup.precision) is not None:
        return None
    times = numpy.append(numpy.arange(math.ceil(until / step - 1e-9)) * step, until)
    starts = start, start.map(setup.precision.other_side)
    lanes = [_Lane.of(one) for one in starts]
    done = _propagate(setup.tolerance, lanes, until, times)
    if done is None:
        return None
    rows, steps, order = done
    made = _Again(setup.tolerance, lanes, until)
    outputs, found = [], []
    for number, (begun, lane) in enumerate(zip(starts, lanes, strict=True)):
        found.append(lane.rows(times, rows[:, :, number]))
        propagation = Propagation(
            status="complete",
            time=until,
            time_low=0.0,
            state=tuple(float(entry[-1]) for entry in found[-1]),
            steps=steps[number],
            order=order,
            hits=(),
        )
        output = DenseOutput(setup, begun, propagation, again=partial(made, number, propagation))
        outputs.append(output)
    return Pair(outputs[0], outputs[1], starts[1], times, found[0], found[1])


def _propagate(
    tolerance: float, lanes: Sequence[_Lane], until: float, times: Array | None
) -> tuple[ContinuousOutput | Array, list[int], int] | None:
    """Rows at ``times``, or without them the dense output; with steps and order."""
    import heyoka
    import numpy

    with _batches.lent(tolerance / RATIO) as batch:
        batch.set_time(0.0)
        batch.pars[:] = numpy.array([lane.parameters for lane in lanes]).T
        batch.state[STATE] = numpy.array([lane.state for lane in lanes]).T
        batch.state[8] = RATIO * max(map(abs, lanes[0].state)), 0.0
        batch.reset_cooldowns()
        if times is None:
            found, _ = batch.propagate_until([until, until], c_output=True, max_steps=MOST_STEPS)
        else:
            grid = numpy.stack([times, times], axis=1)
            _, found = batch.propagate_grid(grid, max_steps=MOST_STEPS)
        results = batch.propagate_res
        if any(result[0] != heyoka.taylor_outcome.time_limit for result in results):
            return None
        return found, [int(result[3]) for result in results], int(batch.order)


class _Again:
    """Makes the dense outputs of both lanes, when a state in between is first asked for."""

    def __init__(self, tolerance: float, lanes: Sequence[_Lane], until: float):
        self._given = tolerance, lanes, until
        self._lock = threading.Lock()
        self._output: ContinuousOutput = None

    def __call__(
        self, number: int, first: Propagation, pieces: Pieces, progress: Progress | None
    ) -> Propagation:
        _, lanes, until = self._given
        with self._lock:
            if self._output is None:
                done = _propagate(*self._given, None)
                if done is None or done[1][number] != first.steps:
                    raise RuntimeError("the same integration gave another result when repeated")
                self._output = done[0]
        pieces.append(_Piece(self._output, number, lanes[number], until, self._lock, first.steps))
        return first


@dataclass(frozen=True)
class _Lane:
    """The start of one lane in double, and the frame it turns with."""

    body: Parameters
    state: tuple[float, ...]
    parameters: tuple[float, ...]

    @classmethod
    def of(cls, start: InitialState) -> _Lane:
        begun = start.map(float)
        state = tuple(map(float, begun.state(TURNING)))
        top = top_of(begun.body, TurningState(*state), SHARE * state[5])
        return cls(begun.body, state, tuple(float(getattr(top, n)) for n in TURNING.parameters))

    def rows(self, times: Array, states: Array) -> tuple[Array, ...]:
        """Arrays over ``times`` of what a single run integrates; ``states`` has a row a time."""
        import numpy

        angle = self.parameters[-1] * times
        there = to_centre(self.body, TurningState(*states.T[STATE]))
        return turned_back(there, numpy.cos(angle), numpy.sin(angle))


class _Piece:
    """The dense output of one lane: called as heyoka's of a single run is."""

    def __init__(
        self,
        output: ContinuousOutput,
        number: int,
        lane: _Lane,
        until: float,
        lock: threading.Lock,
        steps: int,
    ):
        self._output, self._number, self._lane, self._lock = output, number, lane, lock
        self.bounds, self.n_steps = (0.0, until), steps

    def __call__(self, time: Array) -> Array:
        import numpy

        times = numpy.atleast_1d(numpy.asarray(time, dtype=float))
        with self._lock:  # both lanes are read through one buffer
            states = self._output(numpy.stack([times, times], axis=1))[:, :, self._number].copy()
        rows = numpy.array(self._lane.rows(times, states)).T
        return rows if numpy.ndim(time) else rows[0]


def _build(tolerance: float) -> Adaptive:
    """A compiled batch of two lanes with this tolerance."""
    import heyoka
    import numpy

    heyoka.set_logger_level_critical()
    equations = Equations.of(TURNING)
    terminal = terminal_functions(TURNING, equations.motion, equations.variables[0])
    scale = heyoka.make_vars("scale")
    return heyoka.taylor_adaptive_batch(
        [*equations.system, (scale, heyoka.expression(0.0))],
        numpy.zeros((9, 2)),
        pars=numpy.ones((len(TURNING.parameters), 2)),
        t_events=[
            heyoka.t_event_batch(function, direction=heyoka_direction(-1))
            for function in terminal.values()
        ],
        tol=tolerance,
    )


_batches = Idle(_build)
