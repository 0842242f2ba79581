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
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy

from tt_precise.check.columns import unit
from tt_precise.check.law_flow import (
    EPS,
    ContactLaw,
    attitude_rate,
    least_margin,
    switch_intervals,
    through_switches,
)
from tt_precise.check.rows import Rows
from tt_precise.mechanics import quantities
from tt_precise.mechanics.compliant import stored_energy
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import (
    NewtonState,
    contact_arm,
    contact_momentum,
    contact_momentum_rate,
)
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot, multiplied
from tt_precise.runtime.values import Array

# Error of the flow between two rows, relative to the sizes: the sum of a million rows stays below
# the limits of the checks.
TOLERANCE = 1e-13
ROUNDED = 8.0  # A row is rounded at either end in attitude, momentum, velocity and position (eps).
# Nutation (rad) from row to row up to which rates are resolved: they contain twice the nutation,
# which aliases from pi/2 on.
RESOLVED = math.pi / 2
FINE, COARSE = 8, 6  # Rows of the two polynomials.
# Ratio of bound and error estimate. A friction force that changes within a row leaves an error that
# eight rows estimate too small: right rows of regularised friction need 10.
SAFETY = 10.0
# Intervals on either side whose error counts for an interval: the rows of its polynomial.
NEIGHBOURS = 3
# Bounds up to which an interval tells right rows from wrong ones: another convention, clock or body
# is wrong by a part of 1 (rad, R, m g R alpha).
VISIBLE = {"rotation": 0.1, "position": 0.1, "momentum": 0.3}
GAP = 5.0  # An interval of so many usual ones is a gap in the rows.
BLOCK = 20_000  # Intervals at once: their arrays take 60 MB.
# Intervals with a change of phase that are integrated, 20 ms each; of more, every n-th one.
MOST_SWITCHES = 200
# Distance of a neighbouring start, relative to the sizes, that shows how errors grow through a
# change of phase: above rounding by six digits, and small enough for a linear estimate.
NEARBY = 1e-10


@dataclass(frozen=True)
class StepResiduals:
    """The residuals of n - 1 intervals: each row less the row before, propagated to its time.

    ``rotation`` (rad), ``position`` (m) and ``momentum`` Q (kg m^2/s) have shape (3, n - 1).
    ``bounds`` has the error bound of each by name, infinite where it is unresolved. Under the
    scene's law there are also ``state`` and ``energy``, relative to their sizes, the lower bound
    ``least`` of the phases' margins, and the numbers of ``switches`` that were integrated, and of
    all.
    """

    rotation: Array
    position: Array
    momentum: Array
    bounds: dict[str, Array]
    state: Array | None = None
    energy: Array | None = None
    least: Array | None = None
    switches: tuple[int, int] = (0, 0)


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
    return numpy.array(contact_momentum(body, contact_arm(body, tuple(k)), tuple(L), tuple(v)))


def nutation(rows: Rows) -> Array:
    """Return the angle |L|/I1 h (rad) by which the axis turns about L in each interval."""
    return norm(rows.motion.L)[:-1] / rows.body.I1 * numpy.diff(rows.t)


def total_energy(rows: Rows, q: Motion) -> Array:
    """Return E, with the energy that an elastic table stores where its depth is known."""
    energy = quantities.E(q) + 0 * q.state.kx
    if rows.assumed.scene.body.spring and rows.has_height:
        energy = energy + stored_energy(rows.body, q.state.height, numpy)
    total: Array = energy
    return total


# ---- the scene's contact force -----------------------------------------------------------------


def by_law(rows: Rows) -> StepResiduals:
    """Return the residuals of the scene's equations."""
    if "by law" not in rows.cache:
        starts = range(0, max(len(rows.t) - 1, 1), BLOCK)
        blocks = [_flow_residuals(rows, rows.part(slice(a, a + BLOCK + 1))) for a in starts]
        rows.cache["by law"] = _concatenate(blocks)
    steps: StepResiduals = rows.cache["by law"]
    return steps


def law_of(rows: Rows) -> ContactLaw:
    """Return the contact law of the scene, for the body of the rows."""
    return ContactLaw(rows.assumed.scene, rows.body, rows.has_height, rows.units["v"])


def flow_state(rows: Rows) -> Array:
    """Return the rows as states (13, n) of the flow; unknown positions are 0."""
    motion = rows.motion
    assert motion.v is not None
    x = 0 * motion.k if motion.x is None else numpy.nan_to_num(motion.x)
    return numpy.concatenate((motion.attitude, motion.L, motion.v, x))


def flow_sizes(rows: Rows) -> Array:
    """Return the size of each component of a state of the flow."""
    return numpy.repeat([rows.units[name] for name in "qLvx"], (4, 3, 3, 3))


def _flow_residuals(whole: Rows, rows: Rows) -> StepResiduals:
    """Return the residuals of a block; sizes are those of the ``whole``."""
    body, law, y, units = whole.body, law_of(whole), flow_state(rows), whole.units
    spans = numpy.diff(rows.t)
    end = law.flow(y[:, :-1], spans, flow_sizes(whole), TOLERANCE)
    there = law.vectors(end.state)
    scale = float(abs(INTEGRALS["energy"].scale(whole.first))) or 1.0
    q_there = _motion(whole, there)
    state = _components(whole, rows.state)[:, 1:] - _components(whole, q_there.state)
    energy = total_energy(whole, rows.q)[1:] - total_energy(whole, q_there)
    k, k_there = rows.motion.k, numpy.array(there.k)
    momentum = momentum_about_contact(body, k, y[4:7], y[7:10])[:, 1:]
    momentum -= momentum_about_contact(body, k_there, end.state[4:7], end.state[7:10])
    if not whole.assumed.columns.azimuth:
        rotation = _inclination(k[:, 1:], k[2, 1:] - k_there[2])
    elif rows.motion.q is None:
        rotation = numpy.array(cross(tuple(k_there), tuple(k[:, 1:])))
    else:
        rotation = rotation_between(rows.motion.q[:, 1:], unit(end.state[:4]))
    position = numpy.empty((3, 0)) if rows.motion.x is None else y[10:, 1:] - end.state[10:]
    bound, rotation_bound = end.error + ROUNDED * EPS, 2 * (end.error + ROUNDED * EPS)
    if not whole.assumed.columns.azimuth:
        rotation_bound = _inclination(k[:, 1:], rotation_bound)[0]
    steps = StepResiduals(
        rotation, position, momentum,
        {"rotation": rotation_bound, "position": units["x"] * bound,
         "momentum": 4 * units["L"] * bound, "state": bound},
        state, energy / scale, end.least,
    )  # fmt: skip
    if whole.assumed.scene.may_stick or whole.has_height:
        return _with_switches(whole, rows, law, steps, y)
    return steps


def _inclination(k: Array, change: Array) -> Array:
    """Return a change of k.z as a rotation (3, n) about a horizontal axis."""
    tilt = numpy.sqrt(numpy.maximum(1 - k[2] ** 2, EPS))
    return numpy.array([change / tilt, 0 * change, 0 * change])


def _motion(rows: Rows, state: NewtonState | LiftedState) -> Motion:
    """Return states of the flow as the argument of quantities."""
    if not rows.has_height:
        state = NewtonState(*state[:8])
    if rows.assumed.rolling:
        state = state._replace(vx=0 * state.kx, vy=0 * state.kx)
    return Motion(rows.body, state, numpy, rows.assumed.scene.model)


def _components(rows: Rows, state: NewtonState | LiftedState) -> Array:
    """Return the compared components of states, over their sizes.

    Without the azimuth these are functions that a rotation about the vertical leaves unchanged.
    """
    k, L, (vx, vy), units = state.k, state.L, state[6:8], rows.units
    if rows.assumed.columns.azimuth:
        components = [*k, *(x / units["L"] for x in L), vx / units["v"], vy / units["v"]]
    else:
        momenta = [L[2], dot(L, k), cross(L, k)[2]]
        slip = [vx * k[0] + vy * k[1], vy * k[0] - vx * k[1]]
        components = [k[2], *(x / units["L"] for x in momenta), *(x / units["v"] for x in slip)]
    if rows.assumed.rolling:
        components = components[:-2]
    if isinstance(state, LiftedState):
        components += [state.height / units["x"], state.rise / units["v"]]
    return numpy.array(numpy.broadcast_arrays(*components), dtype=float)


def _with_switches(
    whole: Rows, rows: Rows, law: ContactLaw, steps: StepResiduals, y: Array
) -> StepResiduals:
    """Return the residuals with the scene integrated over intervals where its phase may change."""
    spans = numpy.diff(rows.t)
    assert steps.state is not None
    assert steps.energy is not None
    assert steps.least is not None
    may_change = switch_intervals(law, y, spans, steps.least) | ~numpy.isfinite(
        steps.bounds["state"]
    )
    intervals = numpy.flatnonzero(may_change)
    for bound in steps.bounds.values():
        bound[intervals] = numpy.inf
    # the body of a hypothesis has no scene
    integrated = intervals[:: math.ceil(len(intervals) / MOST_SWITCHES) or 1]
    integrated = integrated[:0] if rows.assumed.body else integrated
    width = 10 if whole.has_height else 8
    speed, sizes = whole.units["v"], numpy.ones(width)
    sizes[3:6], sizes[6:8], sizes[8:] = (
        whole.units["L"],
        speed,
        [whole.units["x"], speed][: width - 8],
    )
    aside = NEARBY * numpy.resize([1.0, -1.0], width) * sizes
    scale = float(abs(INTEGRALS["energy"].scale(whole.first))) or 1.0
    for i in integrated.tolist():
        row = numpy.array([component[i] for component in rows.state])
        end, reached, count = through_switches(law, row, float(spans[i]))
        neighbour = through_switches(law, row + aside * (row != 0), float(spans[i]))[0]
        growth = max(float((abs(neighbour - end) / sizes).max()) / NEARBY, 1.0)
        there = type(rows.state)(*end[:, None])
        here = type(rows.state)(*(component[i + 1 : i + 2] for component in rows.state))
        q, q_there = _motion(whole, here), _motion(whole, there)
        late = (float(spans[i]) - reached) * whole.spin_rate  # rows behind a solution's end
        steps.state[:, i] = (_components(whole, here) - _components(whole, there))[:, 0] + late
        steps.energy[i] = (total_energy(whole, q) - total_energy(whole, q_there))[0] / scale
        momenta = [
            momentum_about_contact(whole.body, *map(numpy.array, (p.k, p.state.L, p.s_dot)))
            for p in (q, q_there)
        ]
        steps.momentum[:, i] = (momenta[0] - momenta[1])[:, 0]
        steps.rotation[:, i] = numpy.array(cross(there.k, here.k))[:, 0]
        bound = EPS * (ROUNDED + 2 * count) * growth  # each step adds two roundings
        steps.bounds["state"][i], steps.bounds["rotation"][i] = bound, 2 * bound
        steps.bounds["momentum"][i] = 4 * whole.units["L"] * bound
    return StepResiduals(
        steps.rotation, steps.position, steps.momentum, steps.bounds, steps.state, steps.energy,
        steps.least, (len(integrated), len(intervals)),
    )  # fmt: skip


def least_force(rows: Rows, intervals: Array) -> Array:
    """Return the least normal force (N) between each row of ``intervals`` and the next row."""
    y, spans = flow_state(rows)[:, intervals], numpy.diff(rows.t)[intervals]
    with numpy.errstate(all="ignore"):
        return least_margin(law_of(rows), y, spans, flow_sizes(rows))


# ---- any contact force -------------------------------------------------------------------------


def by_any_force(rows: Rows) -> StepResiduals:
    """Return the residuals of the laws that hold under every contact force."""
    if "by any force" not in rows.cache:
        blocks, count = [], len(rows.t) - 1
        for first in range(0, count, BLOCK):
            last, begin = min(first + BLOCK, count), max(first - FINE, 0)
            block = _quadrature(rows.part(slice(begin, min(last + FINE, count + 1))))
            blocks.append(_intervals(block, slice(first - begin, last - begin)))
        rows.cache["by any force"] = _concatenate(blocks)
    steps: StepResiduals = rows.cache["by any force"]
    return steps


def _quadrature(rows: Rows) -> StepResiduals:
    """Return the change of each quantity between rows less the integral of its rate."""
    body, motion, t = rows.body, rows.motion, rows.t
    k, L, unknown = motion.k, motion.L, numpy.full_like(motion.k, numpy.nan)
    k_dot = numpy.array(cross(tuple(L), tuple(k))) / body.I1
    x, v = (unknown if part is None else part for part in (motion.x, motion.v))
    Q = momentum_about_contact(body, k, L, v)
    a = contact_arm(body, tuple(k))
    Q_dot = numpy.array(contact_momentum_rate(body, a, tuple(k_dot), tuple(v)))
    attitude, attitude_dot = k, k_dot
    if motion.q is not None:  # of q and -q the one nearer to the row before
        near = (motion.q * numpy.roll(motion.q, 1, axis=1)).sum(axis=0) >= 0
        attitude = motion.q * numpy.cumprod(numpy.where(near, 1.0, -1.0))
        attitude_dot = attitude_rate(attitude, rows.omega)
    rates = numpy.concatenate((v, Q_dot, attitude_dot))
    integrals = integrate_rates(t, rates, FINE)
    left = numpy.diff(numpy.concatenate((x, Q, attitude))) - integrals
    error = abs(integrals - integrate_rates(t, rates, COARSE))
    if motion.q is not None:
        rotation = rotation_between(attitude[:, 1:], attitude[:, 1:] - left[6:])
        error[6:] *= 2
    elif rows.assumed.columns.azimuth:
        rotation = left[6:]
    else:
        rotation = _inclination(k[:, 1:], left[8])
        error[6:8], error[8] = 0.0, _inclination(k[:, 1:], error[8])[0]
    factor = SAFETY * _error_ratio(nutation(rows))
    limits = {"rotation": 1.0, "position": body.R, "momentum": torque_unit(body) * numpy.diff(t)}
    bounds = {}
    for name, part in (("position", slice(0, 3)), ("momentum", slice(3, 6)),
                       ("rotation", slice(6, None))):  # fmt: skip
        bound = factor * _largest_nearby(norm(numpy.nan_to_num(error[part])))
        bounds[name] = numpy.where(bound < VISIBLE[name] * limits[name], bound, numpy.inf)
    return StepResiduals(rotation, left[:3], left[3:6], bounds)


def _error_ratio(nutation: Array) -> Array:
    """Return the ratio between the error of eight rows and its estimate, by the nutation per row.

    The error of central interpolation of exp(i n x) falls by r = 7/8 sin(n/2)^2 with two more rows,
    so that it is r/(1 - r) times the difference; rates contain n and 2 n.
    """
    r = 7 / 8 * numpy.sin(nutation) ** 2
    return numpy.where(nutation < RESOLVED, numpy.maximum(1.0, r / (1 - r)), numpy.inf)


def integrate_rates(t: Array, rates: Array, count: int) -> Array:
    """Return the integrals of ``rates`` (components, n) over each interval.

    A rate is the polynomial through the ``count`` rows nearest to the interval.
    """
    rows, weights = _stencils(t, count, integral=True)
    return _weighted(rates, rows, weights) * numpy.diff(t)


def differentiate(t: Array, values: Array, count: int) -> Array:
    """Return the rates of ``values`` (components, n) at the beginning of each interval."""
    rates = numpy.empty((len(values), len(t) - 1))
    for first in range(0, len(t) - 1, BLOCK):
        low, last = max(first - count, 0), first + BLOCK
        near = slice(low, last + count)  # stencils at both ends of a block reach beyond it
        rows, weights = _stencils(t[near], count, integral=False)
        inner = _weighted(values[:, near], rows, weights) / numpy.diff(t[near])
        rates[:, first:last] = inner[:, first - low : last - low]
    return rates


def _weighted(values: Array, rows: Array, weights: Array) -> Array:
    total = numpy.zeros((len(values), len(rows)))
    for column in range(rows.shape[1]):
        total += weights[:, column] * values[:, rows[:, column]]
    return total


def _stencils(t: Array, count: int, integral: bool) -> tuple[Array, Array]:
    """Return the rows (n - 1, count) near each interval, and the weights of their values."""
    count = min(count, len(t))
    first = numpy.clip(numpy.arange(len(t) - 1) - (count // 2 - 1), 0, len(t) - count)
    rows = first[:, None] + numpy.arange(count)
    u = (t[rows] - t[:-1, None]) / numpy.diff(t)[:, None]  # the interval is [0, 1]
    # intervals whose rows are at the same distances have the same weights
    keys = numpy.rint(u * 1e9).astype(numpy.int64)
    _, some, back = numpy.unique(keys[:, [0, -1]] @ [1, 1 << 20], return_index=True,
                                 return_inverse=True)  # fmt: skip
    if abs(u - u[some][back]).max() > 1e-9:
        some = back = numpy.arange(len(u))
    powers = numpy.arange(count)
    moments = 1.0 / (powers + 1) if integral else (powers == 1).astype(float)
    matrix = u[some][:, None, :] ** powers[:, None]
    right = numpy.broadcast_to(moments, (len(some), count))[..., None]
    return rows, numpy.linalg.solve(matrix, right)[..., 0][back]


def _largest_nearby(error: Array) -> Array:
    """Return the largest of each error and its neighbours."""
    padded = numpy.pad(error, NEIGHBOURS, mode="edge")
    windows = numpy.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1)
    largest: Array = windows.max(axis=-1)
    return largest


def _intervals(steps: StepResiduals, chosen: slice) -> StepResiduals:
    return StepResiduals(
        steps.rotation[:, chosen], steps.position[:, chosen], steps.momentum[:, chosen],
        {name: bound[chosen] for name, bound in steps.bounds.items()},
    )  # fmt: skip


def _concatenate(blocks: Sequence[StepResiduals]) -> StepResiduals:
    """Return the intervals of all blocks."""

    def every(name: str) -> Any:
        values = [getattr(block, name) for block in blocks]
        return None if values[0] is None else numpy.concatenate(values, axis=-1)

    bounds = {n: numpy.concatenate([b.bounds[n] for b in blocks]) for n in blocks[0].bounds}
    switches = (sum(b.switches[0] for b in blocks), sum(b.switches[1] for b in blocks))
    return StepResiduals(
        every("rotation"), every("position"), every("momentum"), bounds, every("state"),
        every("energy"), every("least"), switches,
    )  # fmt: skip


def unresolved(rows: Rows, bound: Array) -> str:
    """Return why the rows do not resolve the motion; "" if they do.

    A fault may hide in any interval without a bound.
    """
    steps, missing = numpy.diff(rows.t), ~numpy.isfinite(bound)
    if not missing.any():
        return ""
    usual = float(numpy.sort(steps)[len(steps) // 2])
    gaps = numpy.flatnonzero(missing & (steps > GAP * usual))
    if len(gaps):
        return f"no rows from {rows.t[gaps[0]]:.6g} to {rows.t[gaps[0] + 1]:.6g} s"
    share = float(steps[missing].sum() / steps.sum())
    text = f"{100 * share:.3g} % of the motion is not resolved"
    fastest = float(nutation(rows).max() / steps.max()) if len(steps) else 0.0
    enough = RESOLVED / fastest if 0 < fastest < math.inf else math.inf
    if not usual > enough:
        first = int(numpy.argmax(missing))
        return f"{text}, first from {rows.t[first]:.6g} to {rows.t[first + 1]:.6g} s"
    return f"{text}; rows {round_down(enough):g} s apart would suffice"


def round_down(value: float) -> float:
    """Return a positive number with its first digit only."""
    power = 10.0 ** math.floor(math.log10(value))
    return math.floor(value / power) * power
