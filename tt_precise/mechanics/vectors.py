"""Three-vectors, quaternions (scalar first) and the states that engines write, in any arithmetic.

Vectors and quaternions are plain tuples of scalars.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.runtime.values import Functions, Scalar

Vector = tuple[Scalar, Scalar, Scalar]
Quaternion = tuple[Scalar, Scalar, Scalar, Scalar]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def horizontal_length(fn: Functions, x: Scalar, y: Scalar) -> Scalar:
    """sqrt(x^2 + y^2), without underflow where the arithmetic offers it."""
    hypot = getattr(fn, "hypot", None)
    return hypot(x, y) if hypot else fn.sqrt(x * x + y * y)


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product, right-handed."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def scaled(factor: Scalar, a: Vector) -> Vector:
    """``factor`` times ``a``."""
    return (factor * a[0], factor * a[1], factor * a[2])


def added(a: Vector, *others: Vector) -> Vector:
    """Sum of vectors."""
    for b in others:
        a = (a[0] + b[0], a[1] + b[1], a[2] + b[2])
    return a


def subtracted(a: Vector, b: Vector) -> Vector:
    """``a - b``."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def multiplied(p: Quaternion, q: Quaternion) -> Quaternion:
    """Product of quaternions, scalar first: the rotation q followed by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def rotate(q: Quaternion, v: Vector) -> Vector:
    """The vector ``v`` rotated by the unit quaternion ``q``."""
    _, x, y, z = multiplied(multiplied(q, (0, *v)), (q[0], -q[1], -q[2], -q[3]))
    return (x, y, z)


def rotation(omega: Vector, t: Scalar, fn: Functions) -> Quaternion:
    """The rotation by the constant angular velocity ``omega`` for the time ``t``."""
    rate = fn.sqrt(dot(omega, omega))
    if rate == 0:
        return (1, 0, 0, 0)
    half = rate * t / 2
    s = fn.sin(half) / rate
    return (fn.cos(half), s * omega[0], s * omega[1], s * omega[2])


# ---- the states that engines write ---------------------------------------------------------------


class RigidBodyState(namedtuple("RigidBodyState", "qw qx qy qz wx wy wz vcx vcy vcz")):
    """The state that physics engines write: orientation, angular velocity, velocity of CM.

    The quaternion q (scalar first, any nonzero length) rotates the body frame to the inertial
    frame; the symmetry axis is the body's third axis. omega and s_dot in the inertial frame.
    """


def spin(psi_dot: Scalar, phi_dot: Scalar, cosine: Scalar) -> Scalar:
    """omega_3 = psi_dot + phi_dot cos theta; section 1."""
    return psi_dot + phi_dot * cosine


def axis_of(qw: Scalar, qx: Scalar, qy: Scalar, qz: Scalar) -> Vector:
    """The symmetry axis in the inertial frame, for an orientation as in ``RigidBodyState``."""
    norm = qw * qw + qx * qx + qy * qy + qz * qz
    return (
        2 * (qx * qz + qw * qy) / norm,
        2 * (qy * qz - qw * qx) / norm,
        (qw * qw + qz * qz - qx * qx - qy * qy) / norm,
    )
