"""The rolling limit v_A = 0: an axisymmetric sphere with integrals lambda, D and E~.

The module has two independent forms. In vectors (state k and L, smooth at the poles) the force F
that keeps v_A = 0 follows from three linear equations. In Euler angles (state theta, theta_dot,
phi_dot, omega_3) the equations of motion are eqs (10), (11) and (12) of the paper with
v_A_dot = 0: lambda, D and E~ are constant.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.euler import EulerState, InAngles
from tt_precise.mechanics.newton import Described, Integrated, NewtonState, axis_rate, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, added, cross, dot, scaled
from tt_precise.runtime.values import Functions, Scalar


class RollingState(Integrated, namedtuple("RollingState", "kx ky kz Lx Ly Lz")):
    """Axis k (unit vector) and angular momentum L about CM, inertial frame; v_A = 0."""

    @classmethod
    def of(cls, q: Described) -> RollingState:
        """The state of a motion that rolls."""
        return cls(*q.state[:6])

    def vectors(self, body: Parameters, fn: Functions, phi: Scalar = 0) -> NewtonState:
        """The state with v_A = 0."""
        return NewtonState(*self, 0, 0)


class RollingEulerState(
    InAngles, namedtuple("RollingEulerState", "theta theta_dot phi_dot omega_3")
):
    """Inclination, its rate, precession rate, spin about the axis: rad, rad/s; v_A = 0."""

    @classmethod
    def of(cls, q: Described) -> RollingEulerState:
        """The state of a motion that rolls."""
        return cls(*q.euler[:4])

    @property
    def angles(self) -> EulerState:
        """The state with v_A = 0."""
        return EulerState(*self, 0, 0)


def constraint_force(body: Parameters, state: NewtonState) -> Vector:
    """Force F at the contact that keeps the top rolling, v_A_dot = 0.

    F/m + inverse_inertia(a x F) x a = b with b = g z - (omega_dot without force) x a
    - omega x (R alpha k_dot). With n = k x a orthogonal to a, the left side is
    (p 1 - a a^T/I1 + c n n^T) F, p = 1/m + a^2/I1, c = 1/I3 - 1/I1, whose inverse is closed. For a
    unit vector k, a^2 is linear in k, b is g z - R alpha L x k_dot/I1 + c R (L.k) k_dot x z, and n
    is -R k x z.
    """
    m, R, alpha, I1, I3 = body.m, body.R, body.alpha, body.I1, body.I3
    a, k_dot = contact_arm(body, state.k), axis_rate(body, state)
    spin = dot(state.L, state.k)
    drift = spin / I3 - spin / I1
    swung = scaled(R * alpha / I1, cross(state.L, k_dot))
    b = (R * drift * k_dot[1] - swung[0], -R * drift * k_dot[0] - swung[1], body.g - swung[2])
    p = 1 / m + R * R * (1 + alpha * alpha - 2 * alpha * state.kz) / I1
    n = (-R * state.ky, R * state.kx, 0)
    sideways = n[0] * n[0] + n[1] * n[1]
    across = (n[0] * b[0] + n[1] * b[1]) / (p + sideways / I3 - sideways / I1)
    along_a, along_n = m * dot(a, b) / I1, across / I1 - across / I3
    return scaled(1 / p, added(b, scaled(along_a, a), scaled(along_n, n)))


def rates(body: Parameters, state: RollingState, fn: Functions = None) -> RollingState:
    """Time derivative of the vector state; eq (1) with v_A = 0."""
    full = NewtonState(*state, 0, 0)
    force = constraint_force(body, full)
    return RollingState(*axis_rate(body, full), *cross(contact_arm(body, full.k), force))


def euler_rates(body: Parameters, state: RollingEulerState, fn: Functions) -> RollingEulerState:
    """Time derivative of the Euler state, from constant D, lambda and E~ (eqs 8 to 12).

    D gives omega_3_dot, then lambda gives phi_dot_dot, both proportional to theta_dot; then
    dE~/dt = 0 divided by theta_dot gives theta_dot_dot. Undefined at the poles.
    """
    m, R, alpha, I1, I3, g = body.m, body.R, body.alpha, body.I1, body.I3, body.g
    theta, theta_dot, phi_dot, omega_3 = state
    s, c = fn.sin(theta), fn.cos(theta)
    u = alpha - c
    d = body.gamma + body.sigma * u * u + body.sigma * body.gamma * s * s
    # omega_3' and phi_dot': derivatives with respect to theta along a solution
    omega_3_slope = -body.sigma * omega_3 * s * (u + body.gamma * c) / d
    phi_dot_slope = (I3 * (omega_3_slope * u + omega_3 * s) / s - 2 * I1 * phi_dot * c) / (I1 * s)
    inertia = I1 + m * R * R * (u * u + s * s)
    # the partial derivatives of E~ (eq 8)
    slope_theta = (
        I1 * phi_dot * phi_dot * s * c
        + m * g * R * alpha * s
        + m * R * R * (u * s + s * c) * theta_dot * theta_dot
        + m * R * R * (u * s * s * s + u * u * s * c) * phi_dot * phi_dot
        + m * R * R * s * c * omega_3 * (omega_3 + 2 * phi_dot * u)
        + m * R * R * s * s * s * omega_3 * phi_dot
    )
    slope_phi_dot = I1 * phi_dot * s * s + m * R * R * s * s * u * (u * phi_dot + omega_3)
    slope_omega_3 = I3 * omega_3 + m * R * R * s * s * (omega_3 + phi_dot * u)
    theta_ddot = (
        -(slope_theta + slope_phi_dot * phi_dot_slope + slope_omega_3 * omega_3_slope) / inertia
    )
    return RollingEulerState(
        theta_dot, theta_ddot, phi_dot_slope * theta_dot, omega_3_slope * theta_dot
    )
