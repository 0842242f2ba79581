"""The power of friction in the rows, and the mean normal force: checks for every friction law.

The force in a row is the rate of the velocity there, by polynomials with and without the nutation.
A power above 0 by more than the limit and its error bound fails. Where the bound is above the
limit, the row is not resolved; a check with more such rows than others is open.
"""

from __future__ import annotations

import math

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.force_free_flow import BLIND, nutation
from tt_precise.check.movement import (
    FEWEST_ROWS,
    motion_as_given,
    movement_of,
    rates_with_errors,
    sufficient_spacing,
    too_few,
)
from tt_precise.check.result import Residual
from tt_precise.mechanics import conserved
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Array

# Friction is seen where it is above its error in at least so many rows, and is as a law where what
# the law keeps deviates by less than this part: words of a note. Gliding below this part of the
# fastest is still.
FEWEST, ALIKE, STILL = 8, 0.05, 0.05


def friction_power(samples: Samples, limit: float) -> Residual:
    """Power of friction F_t.v_A in each row, over m g R omega at the start."""
    values, movement = numpy.zeros(len(samples.t)), movement_of(samples)
    rows, at = movement.sparse, movement.visited
    if len(at) < FEWEST_ROWS:
        return Residual(values, math.inf, open=too_few(len(at)))
    body = movement.body
    (x, y, z), off = rates_with_errors(body, rows, rows.v, movement.sparse_rounding.v)
    vx, vy = samples.state.vx[at], samples.state.vy[at]
    speed = numpy.hypot(vx, vy)
    seen = numpy.pad(nutation(body, rows) < BLIND, (0, 1), mode="edge")
    force = conserved.contact_force(motion_as_given(samples), (x, y, z))
    omega = samples.first.omega
    unit = float(body.m * body.g * body.R * numpy.sqrt(dot(omega, omega))) or 1.0
    error, push = body.m * off, numpy.hypot(force[0], force[1])
    bound, power = error * speed / unit, (force[0] * vx + force[1] * vy) / unit
    excess = seen * numpy.maximum(power - bound, 0.0)
    values[at] = numpy.where(numpy.isnan(excess), numpy.inf, excess)
    resolved = seen & (bound <= limit)
    above = error < numpy.minimum(push, force[2])
    kept = resolved & above & (speed > STILL * speed.max())
    # negative where the force pushes
    ratio = numpy.copysign(push / force[2], -power)
    friction = _friction(ratio[kept], speed[kept])
    unseen = len(resolved) - int(resolved.sum())
    said = [friction, f"{unseen} of {len(resolved)} rows not resolved" if unseen else ""]
    if 2 * unseen <= len(resolved):
        return Residual(values, float(bound[resolved].max()), "; ".join(filter(None, said)))
    with numpy.errstate(all="ignore"):  # the limit may be 0
        share = numpy.where(resolved, 0.0, numpy.where(seen, bound / limit, numpy.inf))
    wide = sufficient_spacing(body, rows, numpy.maximum(share[1:], share[:-1]))
    said.append(f"rows {wide:g} s apart would suffice")
    return Residual(values, math.inf, "; ".join(filter(None, said)))


def _friction(ratio: Array, speed: Array) -> str:
    """Say which friction is seen: |F_t|/F_z at the speeds |v_A|."""
    if len(ratio) < FEWEST:
        return ""
    for law, values, unit in (("Coulomb's", ratio, ""), ("viscous", ratio / speed, " s/m v_A")):
        mean, deviation = float(values.mean()), float(values.std())
        if deviation < ALIKE * abs(mean):
            law += ", but along the motion" if mean < 0 else ""
            return f"friction seen: {mean:.3g} +- {deviation:.1g}{unit} of F_z, as {law}"
    return f"friction seen: {ratio.min():.2g} to {ratio.max():.2g} of F_z"


def normal_force(samples: Samples, limit: float) -> Residual:
    """Mean F_z/(m g) since the row before, from the change of the vertical velocity."""
    movement, values = movement_of(samples), numpy.full(len(samples.t), numpy.inf)
    rows = movement.sparse
    rise = numpy.diff(rows.v[2]) / numpy.diff(rows.t)
    values[movement.visited[1:]] = 1 + rise / movement.body.g
    return Residual(values)
