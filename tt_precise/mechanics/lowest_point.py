"""What holds at the lowest point of the sphere whatever force acts there.

Let a be the vector from the centre of mass to the lowest point, v_CM the velocity of the former.
The angular momentum about the lowest point, Q = L - a x m v_CM, changes by

    dQ/dt = -da/dt x m v_CM + a x m g z,    da/dt = R alpha omega x k,

since the torque a x F of a force F at that point drops out: dL/dt = a x F and
m dv_CM/dt = F - m g z. So it does for impulses, and in flight. Whether friction is Coulomb's or
another's does not matter; a torque beside the force does: that of torsional friction is left over.
"""

from __future__ import annotations

from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Vector, cross, scaled, subtracted
from tt_precise.runtime.values import Scalar
from tt_precise.scene.body import Parameters


def momentum(q: Motion) -> Vector:
    """Q = L - a x m v_CM."""
    return subtracted(q.state.L, scaled(q.body.m, cross(q.a, q.s_dot)))


def momentum_rate(q: Motion) -> Vector:
    """dQ/dt, which contains no contact force."""
    lever = scaled(q.body.R * q.body.alpha, cross(q.omega, q.k))
    carried = scaled(q.body.m, cross(lever, q.s_dot))
    weight = q.body.m * q.body.g
    # a x z = (a_y, -a_x, 0)
    return (weight * q.a[1] - carried[0], -weight * q.a[0] - carried[1], -carried[2])


def torque_unit(body: Parameters) -> Scalar:
    """m g R alpha, the unit of residuals of ``momentum_rate``."""
    return body.m * body.g * body.R * body.alpha


def contact_force(q: Motion, acceleration: Vector) -> Vector:
    """F = m (dv_CM/dt + g z): the force that rows with this acceleration have had."""
    x, y, z = scaled(q.body.m, acceleration)
    return (x, y, z + q.body.m * q.body.g)
