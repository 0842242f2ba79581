"""The states that engines write, and Euler angles with psi, in any arithmetic."""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.vectors import Vector
from tt_precise.runtime.values import Scalar


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
