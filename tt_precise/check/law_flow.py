"""The Newton-Euler equations of a top on the scene's table, and their flow from row to row.

A state (13, n) has the orientation q (4), the angular momentum L (3), the velocity v (3) and the
position x (3) of the centre of mass. Each state is in a phase, which has one contact force: the top
glides, rolls, rests on the contact point under Coulomb's law, flies, or presses an elastic table.
Each phase has a margin, which is positive until the phase ends.

The flow is Gragg's method: the explicit midpoint rule in 2, 4, 6, ... steps is extrapolated to step
length zero (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.9). Where
twelve columns do not reach the tolerance, the span is halved. Where the phase changes between two
rows, the scene itself is integrated over this interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy

from tt_precise.mechanics import compliant, friction, newton, rolling
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState, contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, axis_of, cross, multiplied
from tt_precise.runtime.values import Array, InputError
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
# Columns of the extrapolation, of order 24: beyond, rounding grows faster than the error falls.
COLUMNS = 12
# A column that is not better than the one before is the last one, but for the first six columns: a
# fast rotation converges only when its steps resolve it.
FIRST_COLUMNS = 6
# The column at whose eight steps the margin of the phase is sampled.
WATCHED_COLUMN = 4
HALVINGS = 5
# Angle (rad) that twelve columns resolve to 1e-13, and the most between two rows.
TURN = 1.8
MOST_TURN = TURN * 2**HALVINGS
# Speed of a resting contact point in R omega: v + omega x a has some hundred roundings.
AT_REST = 256 * EPS
# Angle (rad) of the spin from the end of a motion up to which a row is at this end: rounding, and a
# thousandth of the limit of the equations.
LATE = 1e-9
# Distance of a neighbouring start, relative to the sizes, that shows how errors grow through a
# change of phase: above rounding by six digits, and small enough for a linear estimate.
NEARBY = 1e-10
FINE_SAMPLES = 32  # Samples of the margin from row to row where it may be the least of all.

GLIDING, ROLLING, RESTING, FLIGHT, ELASTIC = "gliding", "rolling", "resting", "flight", "elastic"
Function = Callable[[Array], Array]


class FlowEnd(NamedTuple):
    """States after their spans.

    ``error`` (n,) is relative to the sizes, infinite where the end was not reached. ``least`` (n,)
    bounds the watched function from below on the way.
    """

    state: Array
    error: Array
    least: Array


@dataclass(frozen=True)
class ContactLaw:
    """The contact law of a scene: the phase of each state, and the force in each phase.

    ``body`` is in SI. Without a known ``height`` the top is on the table, or in flight throughout.
    ``speed`` (m/s) is R omega at the start; up to ``on_table`` (R) a rigid table is touched.
    """

    scene: Scene
    body: Parameters
    height: bool
    speed: float
    on_table: float

    def phases(self, y: Array) -> Array:
        """Return the names of the states' phases."""
        scene, body, state = self.scene, self.body, self.vectors(y)[0]
        phase = numpy.full(y.shape[1], ROLLING if scene.model == "rolling" else GLIDING, "U7")
        if scene.may_stick:
            phase[numpy.hypot(state.vx, state.vy) <= AT_REST * self.speed] = RESTING
        if scene.model == "flight":
            phase[:] = FLIGHT
        elif self.height and body.spring:
            pushes = (state.height < 0) & (compliant.pull(body, state.height, state.rise) < 0)
            phase = numpy.where(pushes, ELASTIC, FLIGHT)
        elif self.height:
            phase[state.height > self.on_table * body.R] = FLIGHT
        return phase

    def vectors(self, y: Array) -> tuple[LiftedState, Vector]:
        """Return the states as vectors, with height and rise of the lowest point, and omega."""
        k, L = axis_of(*y[:4]), tuple(y[4:7])
        omega = inverse_inertia(self.body, k, L)
        swing = cross(omega, contact_arm(self.body, k))
        vx, vy, rise = (v + w for v, w in zip(y[7:10], swing, strict=True))
        height = y[12] - self.body.R * (1 - self.body.alpha * k[2])
        return LiftedState._make((*k, *L, vx, vy, height, rise)), omega

    def force(self, phase: str, state: LiftedState) -> Vector:
        """Return the contact force (N) in a phase."""
        body, on_table = self.body, NewtonState(*state[:8])
        if phase == FLIGHT:
            return (0 * state.kx, 0 * state.ky, 0 * state.kz)
        if phase == ELASTIC:
            normal = compliant.normal_force(body, state, numpy)
            return compliant.contact_force(body, state, normal, numpy)
        if phase == GLIDING:
            viscous = friction.viscous_at(body, state.vx, state.vy, numpy)
            return newton.contact_force(viscous, on_table)
        return rolling.constraint_force(body, on_table._replace(vx=0.0, vy=0.0))

    def margin(self, phase: str, y: Array) -> Array:
        """Return a function of states that is positive until the phase ends.

        It is the height (m) in flight, the margin of the friction cone (N^2) at rest, else the
        normal force over the weight. Where a gliding contact point may come to rest, the margin is
        its speed over R omega if that is less.
        """
        body, state = self.body, self.vectors(y)[0]
        if phase == FLIGHT:
            return state.height if self.height else 1 + 0 * state.height
        if phase == RESTING:
            cone: Array = friction.cone_margin(body, NewtonState(*state[:6], 0.0, 0.0))
            return cone
        normal: Array = self.force(phase, state)[2] / (body.m * body.g) + 0 * state.kx
        if phase == GLIDING and self.scene.may_stick:
            return numpy.minimum(normal, numpy.hypot(state.vx, state.vy) / self.speed)
        return normal

    def margins(self, phases: Array, y: Array) -> Array:
        """Return the margin of each state in its phase."""
        margins = numpy.empty(len(phases))
        for phase in sorted({*phases.tolist()}):
            margins[phases == phase] = self.margin(phase, y[:, phases == phase])
        return margins

    def rates(self, phase: str) -> Function:
        """Return the time derivative of states in a phase: L' = a x F, m v' = F - m g z."""

        def derivative(y: Array) -> Array:
            state, omega = self.vectors(y)
            force, a = self.force(phase, state), contact_arm(self.body, state.k)
            rates = numpy.empty_like(y)
            rates[:4] = attitude_rate(y[:4], omega)
            rates[4], rates[5], rates[6] = cross(a, force)
            rates[7], rates[8], rates[9] = (component / self.body.m for component in force)
            rates[9] -= self.body.g
            rates[10:] = y[7:10]
            return rates

        return derivative

    @numpy.errstate(all="ignore")
    def flow(self, y: Array, spans: Array, sizes: Array, tolerance: float) -> FlowEnd:
        """Propagate states over their ``spans`` (s), each in its phase."""
        end, phases = FlowEnd(y.copy(), *numpy.full((2, len(spans)), numpy.inf)), self.phases(y)
        turn = numpy.sqrt((y[4:7] ** 2).sum(axis=0)) / min(self.body.I1, self.body.I3) * spans
        for phase in sorted({*phases.tolist()}):
            rates, watch = self.rates(phase), lambda here, p=phase: self.margin(p, here)
            at = numpy.flatnonzero((phases == phase) & (turn <= MOST_TURN))
            most = float(turn[at].max(initial=0.0))
            part = propagate(rates, y[:, at], spans[at], sizes, tolerance, watch, most)
            end.state[:, at], end.error[at], end.least[at] = part
        return end

    @numpy.errstate(all="ignore")
    def least_margins(self, y: Array, spans: Array, sizes: Array) -> Array:
        """Return the least margin of each state's phase on its way."""
        shares = numpy.arange(FINE_SAMPLES + 1) / FINE_SAMPLES
        start, phases = numpy.repeat(y, len(shares), axis=1), self.phases(y)
        end = self.flow(start, numpy.outer(spans, shares).ravel(), sizes, 1e-9)
        margins = self.margins(numpy.repeat(phases, len(shares)), end.state)
        return _lower_bound(margins.reshape(len(spans), -1).T, 1 / 8)

    def may_change(self, y: Array, least: Array) -> Array:
        """Return the intervals between states in which the phase may change.

        It stays if it is the same at both ends, and its margin is positive at both ends and, by the
        lower bounds ``least``, between them.
        """
        phases = self.phases(y)
        inside = self.margins(phases, y) >= 0
        changes: Array = ~((phases[:-1] == phases[1:]) & inside[:-1] & inside[1:] & (least > 0))
        return changes


def attitude_rate(q: Array, omega: Array | Vector) -> Array:
    """Return dq/dt = omega q/2 of quaternions (4, n), with omega in the inertial frame."""
    x, y, z = omega
    return numpy.array(multiplied((0 * q[0], x / 2, y / 2, z / 2), tuple(q)))


def propagate(
    rates: Function, start: Array, spans: Array, sizes: Array, tolerance: float,
    watch: Function | None = None, turn: float = 0.0, halvings: int = HALVINGS,
) -> FlowEnd:  # fmt: skip
    """Propagate the states ``start`` (components, n) over ``spans`` (s).

    Errors are relative to ``sizes`` (components,). Where a state turns by more than ``TURN``, the
    span is halved at once.
    """
    if turn > TURN and halvings:
        end = FlowEnd(start.copy(), *numpy.full((2, len(spans)), numpy.inf))
    else:
        end = _extrapolate(rates, start, spans, sizes[:, None], tolerance, watch)
    missed = numpy.flatnonzero(~(end.error <= tolerance))
    end.error[missed] = numpy.inf
    if len(missed) and halvings:
        options = (sizes, tolerance, watch, turn / 2, halvings - 1)
        first = propagate(rates, start[:, missed], spans[missed] / 2, *options)
        on = numpy.isfinite(first.error)  # the second half is out of reach of the others
        first, missed = FlowEnd(first.state[:, on], first.error[on], first.least[on]), missed[on]
        if len(missed):
            second = propagate(rates, first.state, spans[missed] / 2, *options)
            end.state[:, missed] = second.state
            end.error[missed] = first.error + second.error
            end.least[missed] = numpy.fmin(first.least, second.least)
    return end


def _extrapolate(
    rates: Function, start: Array, spans: Array, sizes: Array, tolerance: float,
    watch: Function | None,
) -> FlowEnd:  # fmt: skip
    """Return the extrapolated states; the last two columns differ by the error."""
    slope, row, watched = rates(start), list[Array](), list[Array]()
    error, least = numpy.full((2, len(spans)), numpy.inf)
    for column in range(1, COLUMNS + 1):
        h, before = spans / (2 * column), numpy.zeros_like(start)
        change = h * slope
        for _ in range(2 * column - 1):
            here = start + change
            if watch and column == WATCHED_COLUMN:
                watched.append(watch(here))
            before, change = change, before + 2 * h * rates(here)
        previous, row = row, [change]
        for j, coarse in enumerate(previous):
            ratio = (column / (column - 1 - j)) ** 2
            row.append(row[j] + (row[j] - coarse) / (ratio - 1))
        if previous:
            last, error = error, (abs(row[-1] - previous[-1]) / sizes).max(axis=0)
            enough = (error <= tolerance).all() or not (error < last).any()
            resolved = column > FIRST_COLUMNS or error.max(initial=0.0) < 1
            if column >= WATCHED_COLUMN and enough and resolved:
                break
    if watched:  # the midpoint rule's own error deserves all of the second difference
        least = _lower_bound(numpy.array(watched), 1.0)
    return FlowEnd(start + row[-1], error, least)


def _lower_bound(values: Array, share: float) -> Array:
    """Return a lower bound of a function that has ``values`` (points, n) at even distances.

    Between two points it dips below them by a ``share`` of its second difference at most: an eighth
    if the values are accurate.
    """
    bend = abs(numpy.diff(values, n=2, axis=0)).max(axis=0)
    bound: Array = values.min(axis=0) - share * bend
    return bound


def integrate_scene(law: ContactLaw, y: Array, spans: Array) -> tuple[LiftedState, Array]:
    """Integrate the scene from states through all changes of its phase.

    Returns the states after their ``spans`` (s), NaN where the motion ends before, and the error
    bounds: two roundings a step, times the growth of the distance from a neighbouring start.
    """
    state = numpy.array(law.vectors(y)[0])
    sizes = numpy.repeat([1.0, 0.0, law.speed, law.body.R, law.speed], (3, 3, 2, 1, 1))[:, None]
    sizes[3:6] = numpy.sqrt((state[3:6] ** 2).sum(axis=0)).max(initial=0.0)
    nearby = state + NEARBY * numpy.resize([1.0, -1.0], 10)[:, None] * sizes * (state != 0)
    ends, steps = numpy.full((2, *state.shape), numpy.nan), numpy.zeros(len(spans))
    for i, span in enumerate(spans.tolist()):
        ends[0, :, i], steps[i] = _through_switches(law, state[:, i], span)
        ends[1, :, i], _ = _through_switches(law, nearby[:, i], span)
    growth = numpy.fmax((abs(ends[1] - ends[0]) / sizes).max(axis=0) / NEARBY, 1.0)
    return LiftedState(*ends[0]), EPS * 2 * steps * growth


def _through_switches(law: ContactLaw, row: Array, span: float) -> tuple[Array, int]:
    """Return the state (10,) after ``span`` (s), and the number of steps."""
    from tt_precise.integration.setup import Setup, ended_at_start
    from tt_precise.mechanics.formulations import STATE_DIMENSIONS
    from tt_precise.nonsmooth import backend
    from tt_precise.nonsmooth.lifting import flying
    from tt_precise.nonsmooth.phases import SegmentStart
    from tt_precise.scene.scene import InitialState

    setup = Setup.of(law.scene, events=(), record=())
    start = InitialState.of(law.scene, setup.precision.arithmetic)
    fn, names = setup.precision.context, LiftedState._fields
    units = [start.units.of_dimension(STATE_DIMENSIONS[name]) for name in names]
    state: Any = LiftedState(*(fn.mpf(float(x)) / u for x, u in zip(row, units, strict=True)))
    if not law.height:
        state = state._replace(height=fn.mpf(0), rise=fn.mpf(0))
    if numpy.hypot(*row[6:8]) <= AT_REST * law.speed:
        state = state._replace(vx=fn.mpf(0), vy=fn.mpf(0))
    spring = law.scene.body.spring
    vectors = state if spring else NewtonState(*state[:8])
    start = replace(start, vectors=vectors, until=span / start.units.time)
    try:
        pulled = not spring and ended_at_start(start, setup.contact, fn)
        if pulled or (not spring and state.height > law.on_table):
            above = SegmentStart.of_run(setup, replace(start, vectors=state))
            segments = [flying(setup, above, start.until * 0)]
        else:
            segments = backend.run(law.scene, setup, start, None)
    except InputError:  # the law does not say how the motion goes on
        return numpy.full(10, numpy.nan), 0
    last = segments[-1]
    late = span - float((last.begin + last.end_time) * start.units.time)
    there = (*last.columns.motion(last.end_row).state, 0, 0)[:10]
    end = numpy.array([float(x * unit) for x, unit in zip(there, units, strict=True)])
    ended = late * law.speed / law.body.R > LATE
    return numpy.where(ended, numpy.nan, end), sum(segment.run.steps for segment in segments)
