"""The pose of the body, for physics engines and viewers, in any arithmetic.

Body frame: origin in the centre of mass, third axis k; the orientation is Rz(phi) Ry(theta)
Rz(psi); at t = 0 the Euler angles phi and psi are 0.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Vector, dot
from tt_precise.runtime.values import Functions, Scalar


class Pose(namedtuple("Pose", "qw qx qy qz x y z vcx vcy vcz wx wy wz wbx wby wbz")):
    """Orientation (scalar first), position and velocity of the centre of mass, angular velocity.

    (qw, qx, qy, qz) rotates the body frame to the inertial frame, unit length; x, y, z and vcx,
    vcy, vcz in the inertial frame (m, m/s), z above the table; wx, wy, wz is the angular velocity
    in the inertial frame, wbx, wby, wbz the same vector in the body frame (rad/s).
    """


def half_angles(fn: Functions, k: Vector, s: Scalar) -> tuple[Scalar, Scalar]:
    """cos(theta/2) and sin(theta/2), with all their digits near either pole.

    ``s`` is sin theta, the length of the horizontal part of ``k``.
    """
    angle = fn.atan2(s, abs(k[2])) / 2  # from the nearer pole
    large, small = fn.cos(angle), fn.sin(angle)
    upright = (k[2] >= 0) * 1  # a number, so that arrays choose entry by entry
    return (large * upright + small * (1 - upright), small * upright + large * (1 - upright))


def pose(q: Motion, s: Scalar, phi: Scalar, psi: Scalar, x: Scalar, y: Scalar) -> Pose:
    """The pose of a motion at azimuth ``phi`` and rotation ``psi`` about the axis.

    ``s`` is sin theta; ``x``, ``y`` is the horizontal position of the centre of mass.
    """
    fn, body = q.fn, q.body
    cosine, sine = half_angles(fn, q.k, s)
    total, difference = (phi + psi) / 2, (phi - psi) / 2
    height = body.R * (1 - body.alpha * q.k[2])  # eq (1): (s + a).z = 0
    if isinstance(q.state, LiftedState):
        height = height + q.state.height
    qw, qz = cosine * fn.cos(total), cosine * fn.sin(total)
    qx, qy = -sine * fn.sin(difference), sine * fn.cos(difference)
    # the body's first two axes: the columns of the quaternion's matrix
    first = (1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy))
    second = (2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx))
    turning = (dot(q.omega, axis) for axis in (first, second, q.k))
    return Pose(*(qw, qx, qy, qz, x, y, height), *q.s_dot, *q.omega, *turning)
