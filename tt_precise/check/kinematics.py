"""The checks ``kinematics`` and ``contact_momentum``, independent of the contact force.

``kinematics`` requires that attitude (rad) and position (over R) are the integrals of the
velocities, and that the height follows from the attitude. ``contact_momentum`` requires that weight
and motion account for every change of the angular momentum about the lowest point (m g R alpha).
Both checks hold for every contact force. Sums from the start count as well, because a small
persistent error becomes large; correct integrators have smaller sums.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.conventions import QUATERNION
from tt_precise.check.equations import differences, sizes_of
from tt_precise.check.force_free import Misfit, misfits, norm
from tt_precise.check.force_free_flow import (
    RigidMotion,
    axis_of,
    momentum_at_contact,
    rates_of,
    torque_unit,
)
from tt_precise.check.movement import (
    FEWEST_ROWS,
    Movement,
    motion_as_given,
    movement_of,
    sufficient_spacing,
    too_few,
)
from tt_precise.check.result import Residual
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array

EPS = float(numpy.finfo(float).eps)
# Bounds of an interval's error (rad, R; m g R alpha) up to which it counts as looked at: another
# convention, clock or body is wrong by a part of 1.
RESOLUTION = {"inclination": 0.1, "spin": 0.1, "axis": 0.1, "position": 0.1, "torque": 0.3}
# The part of the time that may lie in intervals that are not resolved: most of it has to be seen.
UNRESOLVED = 0.25
# An interval that is so many times as long as most is a gap, and has to be resolved, however short
# beside the whole motion. Half and double change no verdict (benchmarks/plateaus.py).
GAP = 5.0
# How many times an interval and the sum since the start count. Measured at 1 kHz on the reference
# scene over 1.5 s, one interval and sum: attitude by RK4 with 1 ms steps 6e-8 and 8e-5 rad, by the
# midpoint rule with 0.25 ms 8e-6 and 1e-2, by semi-implicit Euler with 1 ms 3e-4 and 0.5; torque
# 5e-8 and 5e-8, 1e-5 and 1e-5, 3e-3 and 6e-4. Errors of a step add up in the attitude; in
# the mean torque they do not, and those of either sign cancel.
INTERVAL_COUNTS, SUM_COUNTS = 10.0, 1.0
TORQUE_COUNTS, MEAN_COUNTS = 1.0, 2.0
# A mean over fewer intervals says no more than they do, and its bound is smaller than theirs. Half
# and double change no verdict.
MEAN_OVER = 10
# What a cubic between visited rows, ``DENSE`` to twice that apart, misses: of an attitude that
# changes twice as fast as the body turns (4 DENSE)^4/384 = 1.6e-5. Measured are 3e-7 of the
# attitude and 1e-5 of the torque.
BETWEEN = 3e-5
# Ratio of the horizontal to the vertical torque left over, below which a note says that it is about
# the vertical.
ABOUT_VERTICAL = 0.1
SINKS = 0.1  # Part of R by which a soft contact may give way; 0.07 mm of 20 mm are usual.
LEAST_DEPTH = 1e-9  # m of depth that is worth a word: less is rounding.
LENGTH = math.sqrt(3)  # Norm of a vector whose components are 1: bounds hold for each component.
# Sum of the differences from the equations, in the sizes of the state's entries: the usual limit of
# the check ``equations``.
OBEYED = 1e-6


class Sight(NamedTuple):
    """Values of residuals beyond their bounds, in the unit of the limit, one a row.

    ``bound`` is the error bound of most intervals, ``open`` says why too little is resolved ("" if
    enough is), ``worst`` is the quantity with the largest value, and ``drift`` the sum of what is
    left of it there.
    """

    values: Array
    bound: float
    open: str
    worst: str
    drift: Array


def seen(samples: Samples) -> tuple[Movement, dict[str, Misfit]]:
    """Return the motion and its misfits, computed once for both checks."""
    if "misfits" not in samples.shared:
        setup, movement = samples.setup, movement_of(samples)
        rows = movement.sparse
        found = {} if movement.spin or movement.rows.x is not None else by_own_force(samples)
        if found:
            movement = replace(movement, visited=numpy.arange(len(samples.t)))
        elif len(rows.t) >= FEWEST_ROWS:
            found = misfits(movement.body, rows, movement.sparse_rounding, movement.moving)
            if setup.friction == "other":
                found["torque"] = _about_a_higher_point(movement.body, rows, found["torque"])
        samples.shared["misfits"] = movement, found
    both: tuple[Movement, dict[str, Misfit]] = samples.shared["misfits"]
    return both


def depth_of(samples: Samples) -> Array:
    """Return how deep (m) the lowest point lies below a table that gives way; 0 if none does.

    It is known from z under another force than the scene's, up to a tenth of R.
    """
    body, z = samples.setup.body, samples.given.get("z")
    if samples.setup.friction == "scene" or z is None:
        return numpy.zeros(len(samples.t))
    return _depth(body, samples.state.kz, z)


def _depth(body: Parameters, kz: Array, z: Array) -> Array:
    depth = numpy.maximum(body.R * (1 - body.alpha * kz) - z, 0.0)
    soft = numpy.isfinite(depth).all() and float(depth.max()) < SINKS * body.R
    return depth if soft else 0 * z


def jellett_by_depth(samples: Samples) -> Array:
    """Return by how much Jellett's integral changes if the contact force acts at the table's level.

    A force F at the height h above the lowest point changes it at h (F_y a_x - F_x a_y), with F the
    horizontal m dv/dt. An engine's force acts at one part of the depth, so that the true change is
    the same part of this one; without the signs the sum would be a hundred times larger.
    """
    depth, body = depth_of(samples), samples.setup.body
    if not depth.max() > LEAST_DEPTH or not samples.setup.has_velocity:
        return numpy.zeros(len(depth))
    x, y, _ = (numpy.broadcast_to(v, depth.shape) for v in motion_as_given(samples).s_dot)
    a_x, a_y, _ = samples.q.a
    h, a_x, a_y = ((v[1:] + v[:-1]) / 2 for v in (depth, a_x, a_y))
    changes = body.m * h * (numpy.diff(y) * a_x - numpy.diff(x) * a_y)
    return numpy.append(0.0, numpy.cumsum(changes))


def _about_a_higher_point(body: Parameters, rows: RigidMotion, torque: Misfit) -> Misfit:
    """Return the misfit of the torque where a table gives way.

    The force acts at a height between the lowest point and the table, so that the torque about the
    lowest point is uncertain by the depth times the horizontal force, m dv/dt.
    """
    if rows.x is None:
        return torque
    depth, h = _depth(body, axis_of(rows.q)[2], rows.x[2]), numpy.diff(rows.t)
    push = norm(numpy.diff(rows.v[:2])) / (body.g * body.R * body.alpha)
    uncertain = numpy.maximum(depth[1:], depth[:-1]) * push
    return replace(
        torque,
        bound=torque.bound + uncertain / h,
        summed_bound=torque.summed_bound + numpy.cumsum(uncertain) / numpy.cumsum(h),
    )


def by_own_force(samples: Samples) -> dict[str, Misfit]:
    """Return the misfits of rows that obey the scene's own force, none of other rows.

    Along the flow of the equations the axis follows the momentum, and the momentum about the lowest
    point the weight, exactly: its distances from the rows are the misfits.
    """
    setup, body = samples.setup, samples.setup.body
    rounded = any(samples.resolution.get(name) for name in setup.columns.names)
    if rounded or not (setup.own_force and setup.has_velocity):
        return {}
    apart = differences(samples)
    sums, bounds = apart.sums
    if not (abs(sums).max(axis=0) <= bounds + OBEYED).all():
        return {}
    t, unit = samples.t[1:], torque_unit(body)
    if not setup.columns.azimuth:
        tilt = numpy.sqrt(numpy.maximum(1 - samples.state.kz[1:] ** 2, EPS))
        one, whole = apart.state[:1] / tilt, sums[:1] / tilt
        found = Misfit(t, abs(one[0]), apart.bound / tilt, abs(whole[0]), bounds / tilt, whole)
        return {"inclination": found}
    k, all_k = apart.state[:3], sums[:3]
    spin, speed = sizes_of(samples)[[5, 7]]
    # an error of the momentum is that of L, and those of the arm and of the velocity
    whole, slack = numpy.cumsum(apart.momentum, axis=1), LENGTH + 4 * body.m * body.R * speed / spin
    h, span = numpy.diff(samples.t) * unit / spin, t * unit / spin
    return {
        "axis": Misfit(t, norm(k), LENGTH * apart.bound, norm(all_k), LENGTH * bounds, all_k),
        "torque": Misfit(
            t, norm(apart.momentum) / h, slack * apart.bound / h, norm(whole) / span,
            slack * bounds / span, whole,
        ),
    }  # fmt: skip


def look(samples: Samples, names: Sequence[str], limit: float) -> Sight:
    """Return the residuals of the quantities ``names``."""
    movement, found = seen(samples)
    values, visited = numpy.zeros(len(samples.t)), movement.visited
    if not found:
        return Sight(values, math.inf, too_few(len(visited)), "", numpy.zeros(3))
    parts = {name: _excess(found[name], name == "torque") for name in names}
    values[visited[1:]] = numpy.maximum.reduce(list(parts.values()))
    if len(visited) < len(values):
        passed_over, beyond = _between(movement, found, names)
        values[passed_over] = beyond
    shares = [found[name].bound / max(limit, RESOLUTION[name]) for name in names]
    share = numpy.maximum.reduce(shares)
    bounds = [float(numpy.sort(found[name].bound)[len(share) // 2]) for name in names]
    worst = max(parts, key=lambda name: float(parts[name].max()))
    drift = found[worst].drift[:, int(numpy.argmax(parts[worst]))]
    if worst == "position":
        worst = "xyz"[int(numpy.argmax(abs(drift)))]
    return Sight(values, max(bounds), _open(movement, share), worst, drift)


def _excess(one: Misfit, torque: bool) -> Array:
    """Values beyond their bounds, of the intervals and of the sums; 0 where nothing is seen."""
    counts, sums = (TORQUE_COUNTS, MEAN_COUNTS) if torque else (INTERVAL_COUNTS, SUM_COUNTS)
    local, summed = counts * (one.value - one.bound), sums * (one.summed - one.summed_bound)
    if torque:
        summed[:MEAN_OVER] = 0.0
    excess: Array = numpy.fmax(numpy.fmax(local, summed), 0.0)
    return excess


def _open(movement: Movement, share: Array) -> str:
    """The reason why too little is resolved; ``share`` is the bound over the required one."""
    rows, steps = movement.sparse, numpy.diff(movement.sparse.t)
    unseen = ~(share <= 1)
    usual = float(numpy.sort(steps)[len(steps) // 2])
    gaps = numpy.flatnonzero(unseen & (steps > GAP * usual))
    if len(gaps):
        return f"no rows from {rows.t[gaps[0]]:.6g} to {rows.t[gaps[0] + 1]:.6g} s"
    part = float(steps[unseen].sum() / steps.sum())
    if part <= UNRESOLVED:
        return ""
    spacing = sufficient_spacing(movement.body, rows, share)
    return f"{part:.0%} of the motion is not resolved; rows {spacing:g} s apart would suffice"


def _between(
    movement: Movement, found: dict[str, Misfit], names: Sequence[str]
) -> tuple[Array, Array]:
    """The rows that are not visited, and their distances from cubics beyond the bounds.

    The cubic between two visited rows has their values and rates. Where the flow between them is
    not resolved, as at a kink of the force, the cubic is not either.
    """
    body, rows, u = movement.body, movement.rows, movement.rounding
    at = movement.visited
    skipped = numpy.ones(len(rows.t), bool)
    skipped[at] = False
    here = numpy.flatnonzero(skipped)
    left = numpy.searchsorted(at, here) - 1
    begin, end = at[left], at[left + 1]
    h = rows.t[end] - rows.t[begin]
    s = (rows.t[here] - rows.t[begin]) / h
    state = rates_of(body, movement.sparse)

    def off(values: Array, rates: Array) -> Array:
        cubic = (
            (1 + 2 * s) * (1 - s) ** 2 * values[:, begin] + s**2 * (3 - 2 * s) * values[:, end]
            + h * s * (1 - s) ** 2 * rates[:, left] - h * s**2 * (1 - s) * rates[:, left + 1]
        )  # fmt: skip
        return norm(numpy.nan_to_num(values[:, here] - cubic))

    kink = numpy.maximum.reduce([found[name].bound for name in names])[left]
    speed = norm(rows.v)[here]
    omega = norm(rows.L)[here] / min(body.I1, body.I3)
    attitude = BETWEEN + 4 * u.q[here] + 2 * omega * u.t[here]
    if "torque" in names:
        unit = torque_unit(body)
        Q, rate = momentum_at_contact(body, rows), state.Q
        slack = (2 * u.L + 4 * body.R * body.m * u.v)[here] / unit + 8 * EPS * norm(rows.L)[
            here
        ] / unit
        beyond = (off(Q, rate) / unit - slack) / h - BETWEEN
    elif movement.spin:
        beyond = 2 * off(rows.q, state.q) - attitude
    else:
        beyond = off(numpy.array(axis_of(rows.q)), state.k) - attitude
    if "position" in names and rows.x is not None:
        slack = (2 * u.x[here] + 2 * speed * u.t[here] + h * u.v[here]) / body.R
        beyond = numpy.maximum(beyond, off(rows.x, movement.sparse.v) / body.R - slack - BETWEEN)
    return here, numpy.fmax(beyond - kink, 0.0)


def kinematic_quantities(samples: Samples) -> list[str]:
    """Return the quantities that ``kinematics`` checks, by the existing columns."""
    movement, found = seen(samples)
    names = ["axis"]
    if not samples.setup.columns.azimuth:
        return ["inclination"] if found else []
    if movement.spin:
        names.append("spin")
    if movement.moving and movement.rows.x is not None:
        names.append("position")
    return names if found else []


def kinematics(samples: Samples, limit: float) -> Residual:
    """Attitude (rad) and position (over R) against the integrals of the velocities; the height."""
    quantities = kinematic_quantities(samples)
    by_quantity = {"axis": ("phi",), "spin": ("psi", *QUATERNION), "position": ("x", "y", "z")}
    samples.shared["extra columns"] = frozenset(
        name for one in quantities for name in by_quantity.get(one, ())
    )
    sight, looked = look(samples, quantities, limit), [*quantities]
    values, wrong = sight.values, sight.worst
    if "z" in samples.given and not samples.setup.scene.lifts:
        looked.append("height")
        height = _distance_from_table(samples)
        wrong = "height" if height.max() >= values.max() else wrong
        values = numpy.maximum(values, height)
    lacking = [name for name in ("spin",) if name not in looked]
    seen = {*samples.given} if "position" in looked else {"z"} if "height" in looked else set()
    lacking += [name for name in "xyz" if name not in seen]
    text = "checked " + (", ".join(looked) or "nothing")
    if lacking:
        text += f", not at {', '.join(lacking)} (columns missing)"
    fails = f"{wrong} does not follow" if values.max() > limit else ""
    coarse = f"detects {sight.bound:.0e}" if limit < sight.bound < math.inf else ""
    return _residual(sight._replace(values=values), fails, text, coarse)


def _distance_from_table(samples: Samples) -> Array:
    """Distance of z from R (1 - alpha cos theta), over R.

    Under another law the top may leave the table (not at the start), and a soft contact may
    give way.
    """
    body = samples.setup.body
    height = samples.given["z"] / body.R - (1 - body.alpha * samples.state.kz)
    if samples.setup.friction == "other":
        above = numpy.where(samples.t == samples.t[0], height, 0.0)
        height = numpy.maximum(numpy.maximum(above, -height) - SINKS, 0.0)
    distance: Array = abs(height)
    return distance


def contact_momentum(samples: Samples, limit: float) -> Residual:
    """The remaining torque about the lowest point after weight and motion (m g R alpha)."""
    sight = look(samples, ["torque"], limit)
    said = f"detects {max(sight.bound, limit):.0e}" if math.isfinite(sight.bound) else ""
    if sight.values.max() > limit:
        x, y, z = sight.drift
        if math.hypot(x, y) < ABOUT_VERTICAL * abs(z):
            said = "what is left is about the vertical, as torsional friction is"
    return _residual(sight, said, soft(float(depth_of(samples).max())))


def soft(depth: float) -> str:
    """Say that a table gives way by ``depth`` (m); "" where that is not seen."""
    said = f"a soft contact, {1000 * depth:.2g} mm deep at most, is allowed"
    return said if depth > LEAST_DEPTH else ""


def _residual(sight: Sight, *said: str) -> Residual:
    """Rows of which enough is resolved decide; what they show may be above the limit."""
    if sight.open:
        return Residual(sight.values, math.inf, "; ".join(filter(None, (*said, sight.open))))
    return Residual(sight.values, sight.bound, "; ".join(filter(None, said)), decided=True)
