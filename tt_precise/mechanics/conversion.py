"""Conversion of the states that engines write to vectors, in any arithmetic."""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.newton import NewtonState, angular_momentum, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, added, cross
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


def vectors_from_rigid_body(body: Parameters, state: RigidBodyState) -> tuple[NewtonState, Scalar]:
    """The vector state of a rigid body's state, and v_A.z, which is 0 in contact with the table.

    L = I1 omega + (I3 - I1)(omega.k) k and v_A = s_dot + omega x a; section 1.
    """
    k = axis_of(*state[:4])
    omega = (state.wx, state.wy, state.wz)
    v = added((state.vcx, state.vcy, state.vcz), cross(omega, contact_arm(body, k)))
    return NewtonState(*k, *angular_momentum(body, k, omega), v[0], v[1]), v[2]
