"""The angular momentum about the lowest point of the sphere, which no force there changes.

Let a be the vector from the centre of mass to the lowest point, and v the velocity of the centre of
mass. From L_dot = a x F and m v_dot = F - m g z follows for Q = L - a x m v

    dQ/dt = -da/dt x m v + a x m g z,    da/dt = R alpha k_dot,

for every law of friction, for impulses, and in flight; a torque at the contact, such as torsional
friction, remains. The lowest point rises at v_A.z = v.z + R alpha (L x k).z/I1, the lift.
``exact.identities`` proves all of this for a force of three free symbols.
"""

from __future__ import annotations

from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, cross, scaled, subtracted
from tt_precise.runtime.values import Scalar


def contact_momentum(body: Parameters, a: Vector, L: Vector, v: Vector) -> Vector:
    """Q = L - a x m v."""
    return subtracted(L, scaled(body.m, cross(a, v)))


def contact_momentum_rate(body: Parameters, a: Vector, k_dot: Vector, v: Vector) -> Vector:
    """dQ/dt, which contains no contact force."""
    x, y, z = scaled(body.m * body.R * body.alpha, cross(k_dot, v))
    weight = body.m * body.g
    return (weight * a[1] - x, -weight * a[0] - y, -z)


def contact_lift(body: Parameters, k: Vector, L: Vector, v_z: Scalar) -> Scalar:
    """v_A.z, the rate at which the lowest point rises."""
    return v_z + body.R * body.alpha / body.I1 * cross(L, k)[2]


def momentum_and_velocity(
    body: Parameters, k: Vector, a: Vector, Q: Vector, v_xy: tuple[Scalar, Scalar], rising: Scalar
) -> tuple[Vector, Vector]:
    """L and v from Q, the horizontal velocity of the centre of mass, and the lift ``rising``."""
    lever, m = body.R * body.alpha, body.m
    v_x, v_y = v_xy
    # L but for the part of v.z, in which the lift is linear
    x, y = Q[0] - m * a[2] * v_y, Q[1] + m * a[2] * v_x
    heavier = 1 + m * lever * lever / body.I1 * (1 - k[2] * k[2])
    v_z = (rising - lever / body.I1 * (x * k[1] - y * k[0])) / heavier
    z = Q[2] + m * (a[0] * v_y - a[1] * v_x)
    return (x + m * a[1] * v_z, y - m * a[0] * v_z, z), (v_x, v_y, v_z)


def normal_force_along(
    body: Parameters,
    k: Vector,
    a: Vector,
    L: Vector,
    along: Vector,
    further: tuple[Scalar, Scalar],
    acceleration: Scalar,
) -> Scalar:
    """N/m (m/s^2) of the contact force N ``along`` + m ``further`` that gives a lift's rate.

    ``along``.z is 1, ``further`` is horizontal (m/s^2), ``acceleration`` is the rate of the lift.
    """
    share = body.R * body.alpha / body.I1
    k_dot = scaled(1 / body.I1, cross(L, k))
    by_unit = scaled(body.m, cross(a, along))
    by_further = (-body.m * a[2] * further[1], body.m * a[2] * further[0])
    own = L[0] * k_dot[1] - L[1] * k_dot[0] + by_further[0] * k[1] - by_further[1] * k[0]
    return (body.g + acceleration - share * own) / (
        1 + share * (by_unit[0] * k[1] - by_unit[1] * k[0])
    )
