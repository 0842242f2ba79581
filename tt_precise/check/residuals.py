"""Residuals of the equations of motion from row to row, in two independent ways.

``by_law`` propagates each row to the time of the next one under the scene's contact force, and
compares. ``by_any_force`` needs no force: attitude, position and the angular momentum Q about the
lowest point change by the integrals of their rates, in which no contact force occurs
(``newton.contact_momentum``). The rates are known in every row and are integrated by polynomials
through eight rows; polynomials through six rows give the error. Residuals are summed from the start
as well, because a small persistent error becomes large.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy

from tt_precise.check.columns import COLUMN_SETS, RigidMotion, unit
from tt_precise.check.law_flow import EPS, ContactLaw, attitude_rate, integrate_scene
from tt_precise.check.rows import Rows
from tt_precise.mechanics import newton, quantities
from tt_precise.mechanics.compliant import stored_energy
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot, multiplied
from tt_precise.runtime.values import Array

# Error of the flow between two rows, relative to the sizes: the sum of a million rows stays below
# the limits of the checks.
TOLERANCE = 1e-13
ON_TABLE = 1e-9  # Height in R up to which the lowest point of exact rows touches a rigid table.
ROUNDED = 8.0  # A row is rounded at either end in attitude, momentum, velocity and position (eps).
# Nutation (rad) from row to row up to which rates are resolved: they contain twice the nutation,
# which aliases from pi/2 on.
RESOLVED = math.pi / 2
FINE, COARSE = 8, 6  # Rows of the two polynomials.
# Nodes and weights of Gauss's rule in [0, 1] that is exact for both.
NODES = 0.5 + numpy.outer([-0.5, 0.5], [0.861136311594052575, 0.339981043584856265]).ravel()
WEIGHTS = numpy.tile([0.173927422568726929, 0.326072577431273071], 2)
# Ratio of bound and error estimate. A friction force that changes within a row leaves an error that
# eight rows estimate too small: right rows of regularised friction need 10.
SAFETY = 10.0
# Intervals on either side whose error counts for an interval: the rows of its polynomial.
NEIGHBOURS = 3
# Bounds of rotation (rad), position (R) and momentum (m g R alpha) up to which an interval tells
# right rows from wrong ones: another convention, clock or body is wrong by a part of 1.
VISIBLE = (0.1, 0.1, 0.3)
GAP = 5.0  # An interval of so many usual ones is a gap in the rows.
BLOCK = 4096  # Intervals at once: their arrays fit into the processor's cache.
MOST_SWITCHES = 200  # Changes of phase that are integrated, 20 ms each; of more, every n-th one.


@dataclass(frozen=True)
class StepResiduals:
    """The residuals of n - 1 intervals: each row less the row before, propagated to its time.

    ``rotation`` (rad), ``position`` (m) and ``momentum`` Q (kg m^2/s) have shape (3, n - 1); the
    position is NaN if unknown. ``bounds`` has the error bound of each by name, infinite where it is
    unresolved. Under the scene's law ``state`` and ``energy`` are relative to their sizes, and
    ``least`` is the lower bound of the phases' margins; under any force all three are empty.
    """

    rotation: Array
    position: Array
    momentum: Array
    bounds: dict[str, Array]
    energy: Array
    least: Array
    state: Array


def _steps(rows: Rows, name: str, blocks: Iterable[Sequence[Array]]) -> StepResiduals:
    """Join blocks of values and bounds into the residuals ``name``, computed once."""
    if name not in rows.cache:
        values, bounds = (numpy.concatenate(parts, axis=1) for parts in zip(*blocks, strict=True))
        rotation, position, momentum, *of_law = numpy.split(values, (3, 6, 9, 10, 11))
        names = ("rotation", "position", "momentum", "state")
        by_name = dict(zip(names, bounds, strict=False))
        rows.cache[name] = StepResiduals(rotation, position, momentum, by_name, *of_law)
    steps: StepResiduals = rows.cache[name]
    return steps


def norm(vectors: Array) -> Array:
    """Return the lengths of vectors, components first."""
    length: Array = numpy.sqrt((vectors**2).sum(axis=0))
    return length


def sums_since_start(values: Array, bound: Array) -> tuple[Array, Array]:
    """Return the lengths of the sums of resolved residuals, and the bounds of their errors."""
    resolved = numpy.isfinite(bound)
    sums = numpy.cumsum(numpy.where(resolved, values, 0.0), axis=-1)
    return norm(sums), numpy.cumsum(numpy.where(resolved, bound, 0.0))


def torque_unit(body: Parameters) -> float:
    """Return m g R alpha (N m)."""
    return float(body.m * body.g * body.R * body.alpha)


def rotation_between(q: Array, other: Array) -> Array:
    """Return the small rotation vectors (3, n) from unit quaternions ``other`` to ``q``."""
    w, *vector = multiplied(tuple(q), (other[0], -other[1], -other[2], -other[3]))
    return 2 * numpy.where(w < 0, -1.0, 1.0) * numpy.array(vector)


def momentum_about_contact(body: Parameters, k: Array, L: Array, v: Array) -> Array:
    """Return Q = L - a x m v, shape (3, n)."""
    return numpy.array(
        newton.contact_momentum(body, contact_arm(body, tuple(k)), tuple(L), tuple(v))
    )


def nutation(rows: Rows) -> Array:
    """Return the angle |L|/I1 h (rad) by which the axis turns about L in each interval."""
    return norm(rows.motion.L)[:-1] / rows.body.I1 * numpy.diff(rows.t)


def total_energy(rows: Rows, state: NewtonState | LiftedState) -> Array:
    """Return E of states, with the energy that an elastic table stores where its depth is known."""
    if not rows.has_height:
        state = NewtonState(*state[:8])
    energy = quantities.E(Motion(rows.body, state, numpy, rows.assumed.scene.model)) + 0 * state.kx
    if rows.assumed.scene.body.spring and isinstance(state, LiftedState):
        energy = energy + stored_energy(rows.body, state.height, numpy)
    total: Array = energy
    return total


# ---- the scene's contact force -----------------------------------------------------------------


def by_law(rows: Rows, tolerance: float = TOLERANCE) -> StepResiduals:
    """Return the residuals of the scene's equations, whose flow has a relative ``tolerance``."""
    starts = range(0, max(len(rows.t) - 1, 1), BLOCK)
    parts = (rows.part(slice(a, a + BLOCK + 1)) for a in starts)
    blocks = (_flow_residuals(rows, part, tolerance) for part in parts)
    return _steps(rows, f"by law to {tolerance}", blocks)


def law_of(rows: Rows) -> ContactLaw:
    """Return the contact law of the scene, for the body of the rows."""
    on_table = max(ON_TABLE, 4 * rows.rounding + rows.position_rounding)
    return ContactLaw(rows.assumed.scene, rows.body, rows.has_height, rows.units["v"], on_table)


def flow_state(motion: RigidMotion) -> Array:
    """Return a motion as states (13, n) of the flow; unknown positions are 0."""
    assert motion.v is not None
    x = 0 * motion.k if motion.x is None else numpy.nan_to_num(motion.x)
    return numpy.concatenate((motion.attitude, motion.L, motion.v, x))


def flow_sizes(rows: Rows) -> Array:
    """Return the size of each component of a state of the flow."""
    return numpy.repeat([rows.units[name] for name in "qLvx"], (4, 3, 3, 3))


@numpy.errstate(all="ignore")
def _flow_residuals(whole: Rows, rows: Rows, tolerance: float) -> tuple[Array, Array]:
    """Return the residuals of a block and their bounds; sizes are those of the ``whole``."""
    body, law, units, motion = whole.body, law_of(whole), whole.units, rows.motion
    y, spans = flow_state(motion), numpy.diff(rows.t)
    there, error, least = law.flow(y[:, :-1], spans, flow_sizes(whole), tolerance)
    integrated = numpy.empty(0, int)
    if whole.assumed.scene.may_stick or whole.has_height:
        switches = numpy.flatnonzero(law.may_change(y, least) | ~numpy.isfinite(error))
        error[switches] = numpy.inf
        if not rows.assumed.body:  # the body of a hypothesis has no scene
            integrated = switches[:: math.ceil(len(switches) / MOST_SWITCHES) or 1]
        states, error[integrated] = integrate_scene(law, y[:, integrated], spans[integrated])
        columns = {"t": states.kx, **states._asdict()}
        vectors = COLUMN_SETS["vectors"].motion(body, columns, whole.assumed.rolling)
        there[:, integrated] = flow_state(vectors)
    state, _ = law.vectors(there)
    if whole.assumed.rolling:
        state = state._replace(vx=0 * state.kx, vy=0 * state.kx)
    scale = float(abs(INTEGRALS["energy"].scale(whole.first))) or 1.0
    energy = (total_energy(whole, rows.state)[1:] - total_energy(whole, state)) / scale
    k, k_there = motion.k, numpy.array(state.k)
    momentum = momentum_about_contact(body, k, y[4:7], y[7:10])[:, 1:]
    momentum -= momentum_about_contact(body, k_there, there[4:7], there[7:10])
    rotation = numpy.array(cross(tuple(k_there), tuple(k[:, 1:])))
    if motion.q is not None:
        whole_rotation = rotation_between(motion.q[:, 1:], unit(there[:4]))
        whole_rotation[:, integrated] = rotation[:, integrated]  # the spin is not integrated there
        rotation = whole_rotation
    position = numpy.full_like(momentum, numpy.nan) if motion.x is None else y[10:, 1:] - there[10:]
    bound = error + ROUNDED * EPS
    bounds = numpy.array([2 * bound, units["x"] * bound, 4 * units["L"] * bound, bound])
    bounds[1, integrated] = numpy.inf
    if not whole.assumed.columns.azimuth:
        rotation = _inclination(k[:, 1:], k[2, 1:] - k_there[2])
        bounds[0] = _inclination(k[:, 1:], bounds[0])[0]
    components = compared_components(whole, rows.state)[:, 1:] - compared_components(whole, state)
    return numpy.vstack((rotation, position, momentum, energy, least, components)), bounds


def _inclination(k: Array, change: Array) -> Array:
    """Return a change of k.z as a rotation (3, n) about a horizontal axis."""
    tilt = numpy.sqrt(numpy.maximum(1 - k[2] ** 2, EPS))
    return numpy.array([change / tilt, 0 * change, 0 * change])


def compared_components(rows: Rows, state: NewtonState | LiftedState) -> Array:
    """Return the compared components of states, over their sizes.

    Without the azimuth these are functions that a rotation about the vertical leaves unchanged.
    """
    k, L, (vx, vy), units = state.k, state.L, state[6:8], rows.units
    axis, momenta, slip = [*k], [*L], [vx, vy]
    if not rows.assumed.columns.azimuth:
        axis, momenta = [k[2]], [L[2], dot(L, k), cross(L, k)[2]]
        slip = [vx * k[0] + vy * k[1], vy * k[0] - vx * k[1]]
    components = axis + [x / units["L"] for x in momenta] + [x / units["v"] for x in slip]
    if rows.assumed.rolling:
        components = components[:-2]
    if isinstance(state, LiftedState) and rows.has_height:
        components += [state.height / units["x"], state.rise / units["v"]]
    return numpy.array(numpy.broadcast_arrays(*components), dtype=float)


# ---- any contact force -------------------------------------------------------------------------


def by_any_force(rows: Rows) -> StepResiduals:
    """Return the residuals of the laws that hold under every contact force."""

    def block(first: int) -> list[Array]:
        begin, end = max(first - FINE, 0), first + BLOCK  # rows near the block help its own
        parts = _quadrature(rows.part(slice(begin, end + FINE + 1)))
        return [part[:, first - begin : end - begin] for part in parts]

    return _steps(rows, "by any force", map(block, range(0, len(rows.t) - 1, BLOCK)))


def _quadrature(rows: Rows) -> tuple[Array, Array]:
    """Return the change of each quantity between rows less the integral of its rate, and bounds."""
    body, motion, t = rows.body, rows.motion, rows.t
    k, L, unknown = motion.k, motion.L, numpy.full_like(motion.k, numpy.nan)
    k_dot = numpy.array(cross(tuple(L), tuple(k))) / body.I1
    x, v = (unknown if part is None else part for part in (motion.x, motion.v))
    Q = momentum_about_contact(body, k, L, v)
    a = contact_arm(body, tuple(k))
    Q_dot = numpy.array(newton.contact_momentum_rate(body, a, tuple(k_dot), tuple(v)))
    attitude, attitude_dot = k, k_dot
    if motion.q is not None:  # of q and -q the one nearer to the row before
        near = (motion.q * numpy.roll(motion.q, 1, axis=1)).sum(axis=0) >= 0
        attitude = motion.q * numpy.cumprod(numpy.where(near, 1.0, -1.0))
        attitude_dot = attitude_rate(attitude, rows.omega)
    rates = numpy.concatenate((attitude_dot, v, Q_dot))
    integrals, error = integrate(t, rates)
    left = numpy.diff(numpy.concatenate((attitude, x, Q))) - integrals
    rotation, rotation_error = left[:-6], error[:-6]
    if motion.q is not None:
        rotation = rotation_between(attitude[:, 1:], attitude[:, 1:] - rotation)
        rotation_error = 2 * rotation_error
    elif not rows.assumed.columns.azimuth:
        rotation, rotation_error = (
            _inclination(k[:, 1:], x[2]) for x in (rotation, rotation_error)
        )
    errors = (rotation_error, error[-6:-3], error[-3:])
    error = numpy.array([norm(numpy.nan_to_num(part)) for part in errors])
    padded = numpy.pad(error, ((0, 0), (NEIGHBOURS, NEIGHBOURS)), mode="edge")
    nearby = numpy.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1, axis=1)
    bounds = SAFETY * _error_ratio(nutation(rows)) * nearby.max(axis=-1)
    sizes = numpy.broadcast_arrays(1.0, body.R, torque_unit(body) * numpy.diff(t))
    visible = bounds < numpy.array(VISIBLE)[:, None] * numpy.array(sizes)
    values = numpy.vstack((rotation, left[-6:]))
    return values, numpy.where(visible, bounds, numpy.inf)


def _error_ratio(nutation: Array) -> Array:
    """Return the ratio between the error of eight rows and its estimate, by the nutation per row.

    The error of central interpolation of exp(i n x) falls by r = 7/8 sin(n/2)^2 with two more rows,
    so that it is r/(1 - r) times the difference; rates contain n and 2 n.
    """
    r = 7 / 8 * numpy.sin(nutation) ** 2
    return numpy.where(nutation < RESOLVED, numpy.maximum(1.0, r / (1 - r)), numpy.inf)


def integrate(t: Array, values: Array) -> tuple[Array, Array]:
    """Return the integrals of ``values`` (components, n) over each interval, and their errors.

    A value is the polynomial through the eight rows nearest to the interval; the error is the
    difference from the polynomial through six.
    """
    sums = numpy.zeros((2, len(values), len(t) - 1))
    for total, count in zip(sums, (FINE, COARSE), strict=True):
        first, weights = stencils(t, count)
        for column, weight in enumerate(weights):
            total += weight * values.take(first + column, axis=1)
    sums *= numpy.diff(t)
    return sums[0], abs(sums[0] - sums[1])


def stencils(t: Array, count: int) -> tuple[Array, Array]:
    """Return the first of the rows near each interval, and the weights (count, n - 1) of all."""
    count, steps, interval = min(count, len(t)), numpy.diff(t), numpy.arange(len(t) - 1)
    first = numpy.clip(interval - (count // 2 - 1), 0, len(t) - count)
    # intervals at the same position among evenly spaced rows have the same weights
    even = abs(steps / steps[0] - 1).max() < 1e-9
    _, distinct, back = numpy.unique(interval - first if even else interval, return_index=True,
                                 return_inverse=True)  # fmt: skip
    times, span = t[first[distinct, None] + numpy.arange(count)], steps[distinct, None, None]
    away = NODES[:, None] - (times - t[distinct, None])[:, None] / span
    apart = (times[:, :, None] - times[:, None]) / span + numpy.eye(count)
    lagrange = away.prod(axis=-1, keepdims=True) / away / apart.prod(axis=-1)[:, None]
    weights = numpy.tensordot(lagrange, WEIGHTS, (1, 0))
    return first, weights.T[:, back]


def unresolved(rows: Rows, bound: Array, allowed: float = 0.0) -> str:
    """Return why the rows do not resolve the motion; "" if they do.

    A fault may hide in any interval without a bound. A part of the motion that is ``allowed`` may
    lie in such intervals, but in no gap of the rows.
    """
    steps, missing = numpy.diff(rows.t), ~numpy.isfinite(bound)
    usual = float(numpy.sort(steps)[len(steps) // 2])
    gaps = numpy.flatnonzero(missing & (steps > GAP * usual))
    if len(gaps):
        return f"no rows from {rows.t[gaps[0]]:.6g} to {rows.t[gaps[0] + 1]:.6g} s"
    share = float(steps[missing].sum() / steps.sum())
    if share <= allowed:
        return ""
    text = f"{100 * share:.3g} % of the motion is not resolved"
    fastest = float((nutation(rows) / steps).max())
    if not RESOLVED < usual * fastest < math.inf:
        first = int(numpy.argmax(missing))
        return f"{text}, first from {rows.t[first]:.6g} to {rows.t[first + 1]:.6g} s"
    enough = 0.95 * RESOLVED / fastest  # two digits round up by a twentieth at most
    return f"{text}; rows {enough:.2g} s apart would suffice"
