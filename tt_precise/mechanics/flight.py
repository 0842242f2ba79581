"""Flight in closed form: a symmetric body without contact, a free rotation and a parabola.

L and omega_3 are constant, the axis turns about L at |L|/I1, and the body turns about its axis
at omega_3 (1 - I3/I1) beside that; the centre of mass falls freely.
"""

from __future__ import annotations

from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.vectors import Vector, dot
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters

Quaternion = tuple[Scalar, Scalar, Scalar, Scalar]


def multiplied(p: Quaternion, q: Quaternion) -> Quaternion:
    """Product of quaternions, scalar first: the rotation q followed by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def turned(q: Quaternion, v: Vector) -> Vector:
    """The vector ``v`` rotated by the unit quaternion ``q``."""
    _, x, y, z = multiplied(multiplied(q, (0, *v)), (q[0], -q[1], -q[2], -q[3]))
    return (x, y, z)


def orientation(
    body: Parameters, q: Quaternion, omega: Vector, t: Scalar, fn: Functions
) -> Quaternion:
    """The orientation at time ``t`` of a free symmetric body; ``omega`` inertial, at t = 0."""
    back = (q[0], -q[1], -q[2], -q[3])
    w1, w2, w3 = turned(back, omega)
    L = turned(q, (body.I1 * w1, body.I1 * w2, body.I3 * w3))
    about_L = rotation((L[0] / body.I1, L[1] / body.I1, L[2] / body.I1), t, fn)
    about_axis = rotation((0, 0, w3 * (1 - body.I3 / body.I1)), t, fn)
    return multiplied(multiplied(about_L, q), about_axis)


def rotation(omega: Vector, t: Scalar, fn: Functions) -> Quaternion:
    """The rotation by the constant angular velocity ``omega`` for the time ``t``."""
    rate = fn.sqrt(dot(omega, omega))
    if rate == 0:
        return (1, 0, 0, 0)
    half = rate * t / 2
    s = fn.sin(half) / rate
    return (fn.cos(half), s * omega[0], s * omega[1], s * omega[2])


def flown(body: Parameters, start: RigidBodyState, t: Scalar, fn: Functions) -> RigidBodyState:
    """The state at time ``t`` of a body that flies from ``start``, a unit quaternion."""
    q0: Quaternion = (start.qw, start.qx, start.qy, start.qz)
    omega = (start.wx, start.wy, start.wz)
    q = orientation(body, q0, omega, t, fn)
    back = (q0[0], -q0[1], -q0[2], -q0[3])
    w1, w2, w3 = turned(back, omega)
    # in the body's frame omega turns about the axis at -(1 - I3/I1) omega_3
    spin = rotation((0, 0, -w3 * (1 - body.I3 / body.I1)), t, fn)
    now = turned(q, turned(spin, (w1, w2, w3)))
    return RigidBodyState(*q, *now, start.vcx, start.vcy, start.vcz - body.g * t)


def height(body: Parameters, z: Scalar, vcz: Scalar, t: Scalar) -> Scalar:
    """Height of the centre of mass at time ``t`` from ``z`` and the rate ``vcz`` at t = 0."""
    return z + vcz * t - body.g * t * t / 2
