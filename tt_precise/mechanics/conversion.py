"""Conversion between the Euler-angle state and the vector state, in any arithmetic.

The frame of the paper: x-hat is the horizontal direction towards which the axis is tilted (k = sin
theta x + cos theta z, at azimuth phi), y-hat = z x x-hat, and (1, 2, 3) = (cos theta x - sin theta
z, y, k), in which omega = -phi_dot sin theta 1 + theta_dot 2 + omega_3 3. At the poles x-hat is
undefined, and with it every Euler rate except omega_3.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState, angular_momentum, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, added, cross, dot, scaled
from tt_precise.runtime.values import Functions, Scalar


class RigidBodyState(namedtuple("RigidBodyState", "qw qx qy qz wx wy wz vcx vcy vcz")):
    """The state that physics engines write: orientation, angular velocity, velocity of CM.

    The quaternion q (scalar first, any nonzero length) rotates the body frame to the inertial
    frame; the symmetry axis is the body's third axis. omega and s_dot in the inertial frame.
    """


def horizontal_length(fn: Functions, x: Scalar, y: Scalar) -> Scalar:
    """sqrt(x^2 + y^2), without underflow where the arithmetic offers it."""
    hypot = getattr(fn, "hypot", None)
    return hypot(x, y) if hypot else fn.sqrt(x * x + y * y)


def spin(psi_dot: Scalar, phi_dot: Scalar, cosine: Scalar) -> Scalar:
    """omega_3 = psi_dot + phi_dot cos theta; section 1."""
    return psi_dot + phi_dot * cosine


def vectors_from_euler(
    body: Parameters, state: EulerState, fn: Functions, phi: Scalar = 0, sine_cosine: Scalar = None
) -> NewtonState:
    """The vector state of an Euler state at azimuth ``phi``.

    ``sine_cosine`` replaces (sin theta, cos theta) if they are known more precisely than theta.
    """
    s, c = sine_cosine or (fn.sin(state.theta), fn.cos(state.theta))
    along_X = isinstance(phi, int) and phi == 0
    x = (1, 0, 0) if along_X else (fn.cos(phi), fn.sin(phi), 0)
    y = (-x[1], x[0], 0)
    k = (s * x[0], s * x[1], c)
    across = (c * x[0], c * x[1], -s)
    L = added(
        scaled(-body.I1 * state.phi_dot * s, across),
        scaled(body.I1 * state.theta_dot, y),
        scaled(body.I3 * state.omega_3, k),
    )
    vx = state.nu_x * x[0] + state.nu_y * y[0]
    vy = state.nu_x * x[1] + state.nu_y * y[1]
    return NewtonState(*k, *L, vx, vy)


def euler_from_vectors(body: Parameters, state: NewtonState, fn: Functions) -> EulerState:
    """The Euler state of a vector state.

    phi_dot is computed as (Lz - cos theta (L.x)/sin theta)/I1, which keeps its digits near the
    poles where (Lz - cos theta L.k)/(I1 sin^2 theta) cancels. Divides by zero at the poles.
    """
    s = horizontal_length(fn, state.kx, state.ky)
    x = (state.kx / s, state.ky / s)
    along_x = state.Lx * x[0] + state.Ly * x[1]
    along_y = state.Ly * x[0] - state.Lx * x[1]
    return EulerState(
        theta=fn.atan2(s, state.kz),
        theta_dot=along_y / body.I1,
        phi_dot=(state.Lz - state.kz * along_x / s) / body.I1,
        omega_3=dot(state.L, state.k) / body.I3,
        nu_x=state.vx * x[0] + state.vy * x[1],
        nu_y=state.vy * x[0] - state.vx * x[1],
    )


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
