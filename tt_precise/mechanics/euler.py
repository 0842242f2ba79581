"""The gliding Tippe Top in Euler angles: the paper's eqs (2) to (7), as printed.

The paper integrates these equations, which are undefined at the poles. ``exact.identities`` proves
that these equations and the vectors of ``newton`` are equivalent.

The frame of the paper: x-hat is the horizontal direction towards which the axis is tilted (k = sin
theta x + cos theta z, at azimuth phi), y-hat = z x x-hat, and (1, 2, 3) = (cos theta x - sin theta
z, y, k), in which omega = -phi_dot sin theta 1 + theta_dot 2 + omega_3 3. At the poles x-hat is
undefined, and with it every Euler rate except omega_3.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics.newton import Described, Integrated, NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import added, dot, horizontal_length, scaled
from tt_precise.runtime.values import Functions, Scalar


class InAngles(Integrated):
    """The common part of states in Euler angles."""

    coordinates = "euler"

    def vectors(self, body: Parameters, fn: Functions, phi: Scalar = 0) -> NewtonState:
        """The vector state at azimuth ``phi``."""
        return vectors_from_euler(body, self.angles, fn, phi)


class EulerState(InAngles, namedtuple("EulerState", "theta theta_dot phi_dot omega_3 nu_x nu_y")):
    """Inclination, its time derivative, precession rate, spin about the axis, gliding velocity.

    The units are rad, rad/s, rad/s, rad/s, m/s, m/s; nu_x is along x-hat (the horizontal direction
    towards which the axis is tilted), nu_y along y-hat = z x x-hat.
    """

    @classmethod
    def of(cls, q: Described) -> EulerState:
        """The state of a motion."""
        return cls(*q.euler)

    @property
    def angles(self) -> EulerState:
        """The state itself."""
        return self


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


def contact_terms(body: Parameters, state: EulerState, fn: Functions) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n; eq (7)."""
    m, R, alpha, I1, I3, g, mu = (
        body.m, body.R, body.alpha, body.I1, body.I3, body.g, body.mu,
    )  # fmt: skip
    s, c = fn.sin(state.theta), fn.cos(state.theta)
    phi_dot, theta_dot = state.phi_dot, state.theta_dot
    numerator = m * g * I1 + m * R * alpha * (
        c * (I1 * phi_dot * phi_dot * s * s + I1 * theta_dot * theta_dot)
        - I3 * phi_dot * state.omega_3 * s * s
    )
    denominator = (
        I1
        + m * R * R * alpha * alpha * s * s
        - m * R * R * alpha * s * (1 - alpha * c) * mu * state.nu_x
    )
    return numerator, denominator


def normal_force(body: Parameters, state: EulerState, fn: Functions) -> Scalar:
    """Normal force g_n in N; eq (7)."""
    numerator, denominator = contact_terms(body, state, fn)
    return numerator / denominator


def rates(
    body: Parameters, state: EulerState, fn: Functions, g_n: Scalar | None = None
) -> EulerState:
    """Time derivative of the state; eqs (2) to (6).

    The normal force is that of eq (7), which keeps the contact, unless one is given.
    """
    m, R, alpha, I1, I3, mu = body.m, body.R, body.alpha, body.I1, body.I3, body.mu
    theta_dot, phi_dot, omega_3 = state.theta_dot, state.phi_dot, state.omega_3
    nu_x, nu_y = state.nu_x, state.nu_y
    s, c = fn.sin(state.theta), fn.cos(state.theta)
    if g_n is None:
        g_n = normal_force(body, state, fn)
    friction = mu * g_n
    height = 1 - alpha * c
    theta_ddot = (
        s / I1 * (I1 * phi_dot * phi_dot * c - I3 * omega_3 * phi_dot - R * alpha * g_n)
        + R * friction * nu_x / I1 * height
    )  # (2)
    phi_ddot = (
        I3 * theta_dot * omega_3
        - 2 * I1 * theta_dot * phi_dot * c
        - friction * nu_y * R * (alpha - c)
    ) / (I1 * s)  # (3)
    omega_3_dot = -friction * nu_y * R * s / I3  # (4)
    nu_x_dot = (
        R * s / I1 * (
            phi_dot * omega_3 * (I3 * height - I1)
            + g_n * R * alpha * height
            - I1 * alpha * (theta_dot * theta_dot + phi_dot * phi_dot * s * s)
        )
        - friction * nu_x / (m * I1) * (I1 + m * R * R * height * height)
        + phi_dot * nu_y
    )  # fmt: skip  # (5)
    nu_y_dot = (
        -friction * nu_y / (m * I1 * I3) * (
            I1 * I3 + m * R * R * I3 * (alpha - c) * (alpha - c) + m * R * R * I1 * s * s
        )
        + omega_3 * theta_dot * R / I1 * (I3 * (alpha - c) + I1 * c)
        - phi_dot * nu_x
    )  # fmt: skip  # (6)
    return EulerState(theta_dot, theta_ddot, phi_ddot, omega_3_dot, nu_x_dot, nu_y_dot)


def lift(
    body: Parameters, state: EulerState, rate: EulerState, fn: Functions, g_n: Scalar
) -> Scalar:
    """Vertical acceleration of the lowest point at the given time derivatives, under any g_n.

    The centre of mass is at R (1 - alpha cos theta) above the lowest point.
    """
    s, c = fn.sin(state.theta), fn.cos(state.theta)
    sinking = s * rate.theta_dot + c * state.theta_dot * state.theta_dot
    return g_n / body.m - body.g - body.R * body.alpha * sinking


def jellett(body: Parameters, state: EulerState, fn: Functions) -> Scalar:
    """Jellett's integral lambda in kg m^3/s; eq (14).

    After eq (7) the paper prints lambda without the factor R in the second term, in eq (14) with R.
    """
    s, c = fn.sin(state.theta), fn.cos(state.theta)
    return body.R * (body.I1 * state.phi_dot * s * s - body.I3 * state.omega_3 * (body.alpha - c))
