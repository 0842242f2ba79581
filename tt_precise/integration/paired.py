"""Two lanes: a run in double and its reference run at once, for little more than the run alone.

heyoka's tolerance is relative to the largest entry of the state, lane by lane. So a batch of two
gets one more entry, which is constant: 0 in one lane, and in the other ``RATIO`` times the largest
entry of the start. There the steps are as long as at a tolerance ``RATIO`` times looser. That
lane is the run, and the finer one its reference, with body and start rounded the other way.

Both integrate the equations in a frame that turns (``mechanics.turning``), and are read as the
states of the centre of mass that single runs have. Events would cost as much as the equations; so
contact is watched from rows that lie close enough, and by events only where it comes near its end.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from typing import NamedTuple

from tt_precise.integration.accuracy import RATIO
from tt_precise.integration.dense_output import DenseOutput
from tt_precise.integration.equations import Equations
from tt_precise.integration.idle import Idle
from tt_precise.integration.pair_reading import PairReading, read_pair
from tt_precise.integration.precision import Precision
from tt_precise.integration.propagate import Pieces, Propagation
from tt_precise.integration.setup import Setup
from tt_precise.integration.step_limit import longest_step
from tt_precise.integration.system import full_tolerance, heyoka_direction, terminal_functions
from tt_precise.integration.times import SampleTimes
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.turning import (
    SHARE,
    TURNING,
    TurningState,
    TurningTop,
    to_centre,
    top_of,
    turned_back,
    with_its_spin,
)
from tt_precise.runtime.arithmetic import Array, Functions, Scalar
from tt_precise.runtime.progress import Progress
from tt_precise.runtime.untyped import Adaptive, ContinuousOutput
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene
from tt_precise.taylor.numbers import moments, multiples

MOST_ROWS, MOST_STEPS = 100_000, 200_000
ROWS_APART = 2.0  # over |l|, the rate of nutation: mostly less than three of the shortest steps
STATE = slice(0, 8)
MOST_SAMPLES = 20_000  # states that are kept of a run at its sample times


@dataclass(frozen=True)
class Beginning:
    """The start of a scene in double, and of its reference run; what follows is computed once."""

    start: InitialState
    precision: Precision
    scene: Scene

    @cached_property
    def samples(self) -> SampleTimes | None:
        """The scene's sample times, where the states there are worth keeping."""
        scene = self.scene
        if not 0 < scene.until <= MOST_SAMPLES * scene.sample_every:
            return None
        return SampleTimes.of(scene, self.start)

    @cached_property
    def sample_moments(self) -> Array | None:
        """The scene's sample times in parts, if they are not too many."""
        import numpy

        unit, until = self.start.units.time, self.start.until
        step = to_mpmath(self.scene.sample_every, self.precision.context) / unit
        if not 0 < until <= MOST_ROWS * step:
            return None
        count = math.ceil(float(until / step) - 1e-9)
        return numpy.concatenate([multiples(step, numpy.arange(count)), moments([until])])

    @cached_property
    def reference(self) -> InitialState:
        """The start with every number on the other side of the exact one."""
        return self.start.map(self.precision.other_side)

    @cached_property
    def lanes(self) -> tuple[Lane, Lane]:
        """The run and its reference run."""
        return Lane.of(self.start), Lane.of(self.reference)

    @cached_property
    def horizon(self) -> float:
        """Where both end, in units of time."""
        return float(self.start.until)

    @cached_property
    def steps_are_free(self) -> bool:
        """Whether no tilt beside a pole bounds the steps."""
        start = self.start
        return longest_step(start.body, start.vectors, 1, self.precision) is None

    @cached_property
    def parameters(self) -> Array:
        """Of both lanes, as ``read_pair`` takes them: a column."""
        import numpy

        return numpy.array([value for lane in self.lanes for value in lane.parameters])[:, None]

    def rows(self, every: Fraction) -> tuple[int, int, float]:
        """Rows before the end, rows to each sample of ``every`` so many s, and their distance."""
        step, until = float(every) / float(self.start.units.time), self.horizon
        fastest = math.hypot(*self.lanes[0].state[3:6])
        between = max(1, math.ceil(min(step, until) * fastest / ROWS_APART - 1e-9))
        return math.ceil(until / step - 1e-9) * between, between, step / between


@dataclass(frozen=True)
class Pair:
    """A run and its reference run, all the way to the horizon.

    ``digits`` are the significant ones of the worst entry of the run, at its samples.
    """

    setup: Setup
    beginning: Beginning
    march: _March
    digits: Array

    @cached_property
    def run(self) -> DenseOutput:
        """The coarser of the two."""
        return self._output(0, self.beginning.start)

    @cached_property
    def reference(self) -> DenseOutput:
        """The finer one."""
        return self._output(1, self.beginning.reference)

    @cached_property
    def _made(self) -> _Again:
        return _Again(self.setup.tolerance, self.beginning, self.march.watched)

    def _output(self, number: int, start: InitialState) -> DenseOutput:
        lane, until = self.beginning.lanes[number], self.beginning.horizon
        propagation = Propagation(
            status="complete",
            time=until,
            time_low=0.0,
            state=lane.inertial(until, self.march.rows[-1, :, number].tolist()[STATE], math),
            steps=self.march.steps[number],
            order=self.march.order,
            hits=(),
        )
        again = partial(self._made, number, propagation)
        return DenseOutput(self.setup, start, propagation, again=again)


def can_be_paired(setup: Setup) -> bool:
    """Whether two lanes can do what ``setup`` asks for."""
    form = setup.formulation
    return (
        setup.precision.name == "double"
        and setup.tolerance >= RATIO * full_tolerance(setup.precision)
        and form.State is CentreState
        and form.law == "viscous"
        and not setup.lifts
        and setup.contact == "unilateral"
        and not (setup.events or setup.record or setup.options)
    )


def propagate_pair(setup: Setup, beginning: Beginning, every: Fraction) -> Pair | None:
    """Both runs to the horizon, with samples ``every`` so many s and there.

    None where a run ends before it, starts close to a pole, or is very long: there a run and its
    reference are made one after the other.
    """
    import numpy

    if not beginning.horizon or not beginning.steps_are_free:
        return None
    count, between, apart = beginning.rows(every)
    if count > MOST_ROWS:
        return None
    times = numpy.append(numpy.arange(count) * apart, beginning.horizon)
    march = _march(setup.tolerance, beginning, times, watched=False)
    if march is None:
        return None
    reading = _read(beginning, times, march)
    if not reading.in_contact(times, march.shortest):
        march = _march(setup.tolerance, beginning, times, watched=True)
        if march is None:
            return None
        reading = _read(beginning, times, march)
    digits = reading.digits(setup.precision.bits)
    return Pair(setup, beginning, march, numpy.append(digits[:-1:between], digits[-1]))


class _March(NamedTuple):
    """What heyoka made of two lanes: rows (times, entries, lanes) or a dense output, their steps.

    ``shortest`` is the shortest step of the coarser lane.
    """

    rows: Array | ContinuousOutput
    steps: tuple[int, ...]
    shortest: float
    order: int
    watched: bool


def _march(
    tolerance: float, beginning: Beginning, times: Array | None, watched: bool
) -> _March | None:
    """Rows at ``times``, or without them the dense output; None where a run ends before.

    ``watched`` by events of heyoka, a loss of contact ends a run.
    """
    import heyoka
    import numpy

    lanes, until = beginning.lanes, beginning.horizon
    with _batches.lent((tolerance / RATIO, watched)) as batch:
        batch.set_time(0.0)
        batch.pars[:] = beginning.parameters.reshape(2, -1).T
        batch.state[STATE] = numpy.array([lane.state for lane in lanes]).T
        batch.state[8] = RATIO * max(map(abs, lanes[0].state)), 0.0
        if watched:
            batch.reset_cooldowns()
        if times is None:
            rows, _ = batch.propagate_until([until, until], c_output=True, max_steps=MOST_STEPS)
        else:
            grid = numpy.stack([times, times], axis=1)
            _, rows = batch.propagate_grid(grid, max_steps=MOST_STEPS)
        results = batch.propagate_res
        if any(result[0] != heyoka.taylor_outcome.time_limit for result in results):
            return None
        steps = tuple(int(result[3]) for result in results)
        return _March(rows, steps, results[0][1], int(batch.order), watched)


def _read(beginning: Beginning, times: Array, march: _March) -> PairReading:
    import numpy

    states = march.rows[:, STATE].transpose(2, 1, 0).reshape(16, -1)
    parameters = numpy.repeat(beginning.parameters, len(times), axis=1)
    return read_pair(states, parameters, times)


class _Again:
    """Makes the dense outputs of both lanes, when a state in between is first asked for."""

    def __init__(self, tolerance: float, beginning: Beginning, watched: bool):
        self._given = tolerance, beginning, None, watched
        self._lock = threading.Lock()
        self._output: ContinuousOutput = None

    def __call__(
        self, number: int, first: Propagation, pieces: Pieces, progress: Progress | None
    ) -> Propagation:
        beginning = self._given[1]
        with self._lock:
            if self._output is None:
                done = _march(*self._given)
                if done is None or done.steps[number] != first.steps:
                    raise RuntimeError("the same integration gave another result when repeated")
                self._output = done.rows
        lane, until = beginning.lanes[number], beginning.horizon
        pieces.append(_Piece(self._output, number, lane, until, self._lock, first.steps))
        return first


@dataclass(frozen=True)
class Lane:
    """The start of one lane in double, and the frame it turns with."""

    top: TurningTop
    state: tuple[float, ...]
    parameters: tuple[float, ...]

    @classmethod
    def of(cls, start: InitialState) -> Lane:
        """The lane that begins with ``start``."""
        begun = start.map(float)
        state = tuple(map(float, begun.state(TURNING)))
        top = top_of(begun.body, TurningState(*state), SHARE * state[5])
        return cls(top, state, tuple(float(getattr(top, n)) for n in TURNING.parameters))

    def inertial(self, times: Scalar, entries: Sequence[Scalar], fn: Functions) -> CentreState:
        """What a single run integrates, at ``times``, of the entries of this lane there."""
        angle = self.parameters[-1] * times
        there = to_centre(self.top, with_its_spin(self.top, TurningState(*entries)))
        return turned_back(there, fn.cos(angle), fn.sin(angle))


class _Piece:
    """The dense output of one lane: called as heyoka's of a single run is."""

    def __init__(
        self,
        output: ContinuousOutput,
        number: int,
        lane: Lane,
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
        rows = numpy.array(self._lane.inertial(times, states.T[STATE], numpy)).T
        return rows if numpy.ndim(time) else rows[0]


def _build(which: tuple[float, bool]) -> Adaptive:
    """A compiled batch of two lanes with a tolerance, watched by events or not."""
    import heyoka
    import numpy

    tolerance, watched = which
    heyoka.set_logger_level_critical()
    equations = Equations.of(TURNING)
    terminal = terminal_functions(TURNING, equations.motion, equations.variables[0])
    events = [
        heyoka.t_event_batch(function, direction=heyoka_direction(-1))
        for function in terminal.values()
    ]
    scale = heyoka.make_vars("scale")
    return heyoka.taylor_adaptive_batch(
        [*equations.system, (scale, heyoka.expression(0.0))],
        numpy.zeros((9, 2)),
        pars=numpy.ones((len(TURNING.parameters), 2)),
        tol=tolerance,
        **({"t_events": events} if watched else {}),
    )


_batches = Idle(_build)
