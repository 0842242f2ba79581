"""The Newton-Euler equations of a top on the scene's table, and their flow from row to row.

A state (13, n) has the orientation q (4), the angular momentum L (3), the velocity v (3) and the
position x (3) of the centre of mass. Each state is in a phase, which has one contact force: the top
glides, rolls, rests on the contact point under Coulomb's law, flies, or presses an elastic table.

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
AT_ONCE = 2048  # States whose arrays fit into the processor's cache.
ON_TABLE = 1e-9  # Height in R up to which the lowest point touches a rigid table.
# Speed of a resting contact point in R omega: v + omega x a has some hundred roundings.
AT_REST = 256 * EPS

GLIDING, ROLLING, RESTING, FLIGHT, ELASTIC = "gliding", "rolling", "resting", "flight", "elastic"
Rates = Callable[[Array], Array]
Watch = Callable[[Array], Array]


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

    ``body`` is in SI. ``height`` says that the height of the lowest point is known; without it a
    top is on the table, or in flight throughout. ``speed`` (m/s) is R omega at the start.
    """

    scene: Scene
    body: Parameters
    height: bool
    speed: float

    def phases(self, y: Array) -> list[tuple[Array, str]]:
        """Return the indices of the states in each phase."""
        count = y.shape[1]
        scene, body, state = self.scene, self.body, self.vectors(y)
        phase = numpy.full(count, ROLLING if scene.model == "rolling" else GLIDING, dtype="U7")
        if scene.may_stick:
            rests = numpy.hypot(state.vx, state.vy) <= AT_REST * self.speed
            phase[rests] = RESTING
        if scene.model == "flight":
            phase[:] = FLIGHT
        elif self.height and body.spring:
            pushes = (state.height < 0) & (compliant.pull(body, state.height, state.rise) < 0)
            phase = numpy.where(pushes, ELASTIC, FLIGHT)
        elif self.height:
            phase[state.height > ON_TABLE * body.R] = FLIGHT
        names = [name for name in (GLIDING, ROLLING, RESTING, FLIGHT, ELASTIC) if name in phase]
        return [(numpy.flatnonzero(phase == name), name) for name in names]

    def vectors(self, y: Array) -> LiftedState:
        """Return the states as vectors, with the height of the lowest point and its rate."""
        k, L = axis_of(*y[:4]), tuple(y[4:7])
        swing = cross(inverse_inertia(self.body, k, L), contact_arm(self.body, k))
        vx, vy, rise = (v + w for v, w in zip(y[7:10], swing, strict=True))
        height = y[12] - self.body.R * (1 - self.body.alpha * k[2])
        return LiftedState._make((*k, *L, vx, vy, height, rise))

    def force(self, phase: str, state: LiftedState) -> Vector:
        """Return the contact force (N) in a phase."""
        body, on_table = self.body, NewtonState(*state[:8])
        if phase == FLIGHT:
            zero = 0 * state.kx
            return (zero, zero, zero)
        if phase == ELASTIC:
            normal = compliant.normal_force(body, state, numpy)
            return compliant.contact_force(body, state, normal, numpy)
        if phase == GLIDING:
            viscous = friction.viscous_at(body, state.vx, state.vy, numpy)
            return newton.contact_force(viscous, on_table)
        return rolling.constraint_force(body, on_table._replace(vx=0.0, vy=0.0))

    def margin(self, phase: str, y: Array) -> Array:
        """Return a function of states that is positive until the phase ends.

        It is the normal force (N), the height (m) in flight, and the margin of the friction cone
        (N^2) at rest.
        """
        state = self.vectors(y)
        if phase == FLIGHT:
            return state.height if self.height else 1 + 0 * state.height
        if phase == RESTING:
            margin: Array = friction.cone_margin(self.body, NewtonState(*state[:6], 0.0, 0.0))
            return margin
        normal: Array = self.force(phase, state)[2] + 0 * state.kx
        return normal

    def rates(self, phase: str) -> Rates:
        """Return the time derivative of states in a phase: L' = a x F, m v' = F - m g z."""
        body = self.body

        def derivative(y: Array) -> Array:
            state = self.vectors(y)
            force, a = self.force(phase, state), contact_arm(body, state.k)
            rates = numpy.empty_like(y)
            rates[:4] = attitude_rate(y[:4], inverse_inertia(body, state.k, state.L))
            rates[4], rates[5], rates[6] = cross(a, force)
            rates[7], rates[8], rates[9] = (component / body.m for component in force)
            rates[9] -= body.g
            rates[10:] = y[7:10]
            return rates

        return derivative

    def flow(self, y: Array, spans: Array, sizes: Array, tolerance: float) -> FlowEnd:
        """Propagate states over their ``spans`` (s), each in its phase."""
        end = FlowEnd(y.copy(), *numpy.full((2, len(spans)), numpy.inf))
        with numpy.errstate(all="ignore"):
            turn = numpy.sqrt((y[4:7] ** 2).sum(axis=0)) / min(self.body.I1, self.body.I3) * spans
            slow = turn <= MOST_TURN
            for indices, phase in self.phases(y):
                rates, watch = self.rates(phase), lambda here, p=phase: self.margin(p, here)
                indices = indices[slow[indices]]
                for first in range(0, len(indices), AT_ONCE):
                    at = indices[first : first + AT_ONCE]
                    most = float(turn[at].max())
                    part = propagate(rates, y[:, at], spans[at], sizes, tolerance, watch, most)
                    end.state[:, at], end.error[at], end.least[at] = part
        return end


def attitude_rate(q: Array, omega: Array | Vector) -> Array:
    """Return dq/dt = omega q/2 of quaternions (4, n), with omega in the inertial frame."""
    x, y, z = omega
    return numpy.array(multiplied((0 * q[0], x / 2, y / 2, z / 2), tuple(q)))


def propagate(
    rates: Rates, start: Array, spans: Array, sizes: Array, tolerance: float,
    watch: Watch | None = None, turn: float = 0.0, halvings: int = HALVINGS,
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
    rates: Rates, start: Array, spans: Array, sizes: Array, tolerance: float, watch: Watch | None
) -> FlowEnd:
    """Return the extrapolated states; the last two columns differ by the error."""
    slope = rates(start)
    row: list[Array] = []
    error, least = numpy.full((2, len(spans)), numpy.inf)
    for column in range(1, COLUMNS + 1):
        watched: list[Array] | None = [] if watch and column == WATCHED_COLUMN else None
        previous, row = row, [_midpoint(rates, start, slope, spans / (2 * column), column, watched)]
        if watch and watched:
            least = _lower_bound(numpy.array([watch(y) for y in watched]))
        for j, coarse in enumerate(previous):
            ratio = (column / (column - 1 - j)) ** 2
            row.append(row[j] + (row[j] - coarse) / (ratio - 1))
        if not previous:
            continue
        before, error = error, (abs(row[-1] - previous[-1]) / sizes).max(axis=0)
        enough = (error <= tolerance).all() or not (error < before).any()
        if column >= WATCHED_COLUMN and enough and (column > FIRST_COLUMNS or error.max() < 1):
            break
    return FlowEnd(start + row[-1], error, least)


def _midpoint(
    rates: Rates, start: Array, slope: Array, h: Array, column: int, watched: list[Array] | None
) -> Array:
    """Return the change of states by 2 ``column`` steps of ``h``; ``watched`` gets their states."""
    before, change = numpy.zeros_like(start), h * slope
    for _ in range(2 * column - 1):
        here = start + change
        if watched is not None:
            watched.append(here)
        before, change = change, before + 2 * h * rates(here)
    return change


def _lower_bound(values: Array) -> Array:
    """Return a lower bound of a function that has ``values`` (points, n) at even distances.

    Between two points it dips below them by an eighth of its second difference at most; the
    midpoint rule's own error deserves all of it.
    """
    bend = abs(numpy.diff(values, n=2, axis=0)).max(axis=0)
    bound: Array = values.min(axis=0) - bend
    return bound


def least_margin(law: ContactLaw, y: Array, spans: Array, sizes: Array, points: int = 8) -> Array:
    """Return the least margin of each state's phase on its way, from ``points`` parts of the span.

    The flow to the minimum of the parabola through the three lowest points finds a short dip.
    """
    count = len(spans)
    shares = numpy.repeat(numpy.arange(points + 1) / points, count)
    margins = _margins(
        law, numpy.tile(y, points + 1), shares * numpy.tile(spans, points + 1), sizes
    )
    values = margins.reshape(points + 1, count)
    low = numpy.clip(values.argmin(axis=0), 1, points - 1)
    before, here, after = (values[low + shift, numpy.arange(count)] for shift in (-1, 0, 1))
    vertex = numpy.clip(numpy.nan_to_num((before - after) / (before - 2 * here + after) / 2), -1, 1)
    least: Array = numpy.fmin(
        values.min(axis=0), _margins(law, y, (low + vertex) / points * spans, sizes)
    )
    return least


def _margins(law: ContactLaw, y: Array, spans: Array, sizes: Array) -> Array:
    """Return the margins of the phases of the states ``y``, ``spans`` (s) later."""
    end, margins = law.flow(y, spans, sizes, 1e-9), numpy.empty(len(spans))
    for indices, phase in law.phases(y):
        margins[indices] = law.margin(phase, end.state[:, indices])
    return numpy.where(numpy.isfinite(end.error), margins, numpy.inf)


def switch_intervals(law: ContactLaw, y: Array, spans: Array, least: Array) -> Array:
    """Return the intervals between rows in which the phase may change.

    The phase stays if it is the same at both ends, its margin is positive from row to row, and the
    contact point neither comes to rest nor leaves rest: twice the rate of v_A at either end would
    not bring it to 0.
    """
    count = y.shape[1]
    phase, margin, change = numpy.empty(count, dtype="U7"), numpy.empty(count), numpy.zeros(count)
    state = law.vectors(y)
    for indices, name in law.phases(y):
        phase[indices], margin[indices] = name, law.margin(name, y[:, indices])
        if name == GLIDING and law.scene.may_stick:
            here = NewtonState(*(component[indices] for component in state[:8]))
            force = law.force(name, LiftedState(*here, 0 * here.kx, 0 * here.kx))
            x, y_, _ = newton.contact_acceleration(law.body, here, force)
            change[indices] = 2 * numpy.hypot(x, y_)
    stays = (phase[:-1] == phase[1:]) & (margin[:-1] >= 0) & (margin[1:] >= 0) & (least > 0)
    speed, slides = numpy.hypot(state.vx, state.vy), phase[:-1] == GLIDING
    glides = (speed[:-1] > change[:-1] * spans) & (speed[1:] > change[1:] * spans)
    return ~(stays & (glides | ~slides)) if law.scene.may_stick else ~stays


def through_switches(law: ContactLaw, row: Array, span: float) -> tuple[Array, float, int]:
    """Integrate the scene from the vectors ``row`` (SI) through all changes of its phase.

    Returns the state after ``span`` (s), or where the motion ends, the time (s) until then, and the
    number of steps.
    """
    from tt_precise.integration.setup import Setup, ended_at_start
    from tt_precise.mechanics.formulations import STATE_DIMENSIONS
    from tt_precise.nonsmooth import backend
    from tt_precise.nonsmooth.lifting import flying
    from tt_precise.nonsmooth.phases import SegmentStart
    from tt_precise.scene.scene import InitialState

    setup = Setup.of(law.scene, events=(), record=())
    start = InitialState.of(law.scene, setup.precision.arithmetic)
    fn, names = setup.precision.context, LiftedState._fields[: len(row)]
    units = [start.units.of_dimension(STATE_DIMENSIONS[name]) for name in names]
    components = [fn.mpf(float(x)) / unit for x, unit in zip(row, units, strict=True)]
    state: Any = LiftedState(*components, *[fn.mpf(0)] * (10 - len(row)))
    if numpy.hypot(*row[6:8]) <= AT_REST * law.speed:
        state = state._replace(vx=fn.mpf(0), vy=fn.mpf(0))
    spring = law.scene.body.spring
    vectors = state if spring else NewtonState(*state[:8])
    start = replace(start, vectors=vectors, until=span / start.units.time)
    try:
        pulled = not spring and ended_at_start(start, setup.contact, fn)
        if pulled or (not spring and state.height > ON_TABLE):
            above = SegmentStart.of_run(setup, replace(start, vectors=state))
            segments = [flying(setup, above, start.until * 0)]
        else:
            segments = backend.run(law.scene, setup, start, None)
    except InputError:  # the law does not say how the motion goes on
        return row, 0.0, 0
    last = segments[-1]
    there = (*last.columns.motion(last.end_row).state, 0, 0)
    end = [float(x * unit) for x, unit in zip(there, units, strict=False)]
    steps = sum(segment.run.steps for segment in segments)
    return numpy.array(end), float((last.begin + last.end_time) * start.units.time), steps
