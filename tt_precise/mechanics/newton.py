"""The gliding Tippe Top as vectors: the paper's eq (1), smooth at the poles.

The state is the symmetry axis k (the paper's 3-hat), the angular momentum L about the centre of
mass and the horizontal velocity v of the contact point A, all in the inertial frame. From
m s_ddot = F - m g z, L_dot = a x F, k_dot = L x k/I1 with F = g_n (z - mu v) the accelerations
are affine in g_n, and the height of the centre of mass, differentiated twice, gives g_n.

``CentreState`` has the horizontal velocity of the centre of mass instead of that of the contact
point. m s_ddot = F - m g z then needs no acceleration of the contact: half of the products of
``rates``, and 3 % fewer steps on the reference scene. heyoka integrates this form; v_A = s_dot +
omega x a follows from the state.

Parameters multiply and divide variables one at a time: heyoka would treat 1/I3 - 1/I1 as an extra
variable, and a product with this variable costs as much as a product of two coordinates.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import partial
from typing import Any

from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, added, cross, dot, scaled, subtracted
from tt_precise.runtime.values import Functions, Scalar

Described = Any  # A ``Motion``, whose type rests on the states.


class Integrated:
    """Defaults of a state of a formulation, beside ``of`` and ``vectors``.

    ``of(q)`` is the state of a motion; ``vectors(body, fn, phi)`` has the velocity of the contact
    point, and the azimuth ``phi`` where the state leaves it open.
    """

    coordinates = "newton"

    @property
    def angles(self) -> Any:
        """The Euler state, if this state has Euler angles."""
        return None

    def centre(self, body: Parameters) -> Callable[[], Vector] | None:
        """The velocity of CM, if the state has a more precise value than its vectors."""
        return None

    def along(self, rates: list[Scalar], fn: Functions) -> list[Scalar]:
        """Derivatives by the variable of integration, by default time, from derivatives by time."""
        return rates

    @staticmethod
    def elapsed(step: Scalar, before: Any, after: Any) -> Scalar:
        """The time between two states that are ``step`` apart in the variable of integration."""
        return step


class OfAxis:
    """The common part of states in vectors."""

    @property
    def k(self: Any) -> Vector:
        """Symmetry axis 3-hat."""
        return self[:3]

    @property
    def L(self: Any) -> Vector:
        """Angular momentum about the centre of mass."""
        return self[3:6]


class NewtonState(OfAxis, Integrated, namedtuple("NewtonState", "kx ky kz Lx Ly Lz vx vy")):
    """Axis k (unit vector), angular momentum L about CM, velocity (vx, vy) of the contact."""

    @classmethod
    def of(cls, q: Described) -> NewtonState:
        """The state of a motion."""
        return cls(*q.state[:8])

    def vectors(self, body: Parameters, fn: Functions, phi: Scalar = 0) -> NewtonState:
        """The state itself."""
        return self

    @property
    def v(self) -> Vector:
        """Velocity v_A of the contact point; the constraint keeps it horizontal."""
        return (self.vx, self.vy, 0)


def contact_arm(body: Parameters, k: Vector) -> Vector:
    """Vector a = R (alpha k - z) from the centre of mass to the contact point; Fig. 1."""
    lever = body.R * body.alpha
    return (lever * k[0], lever * k[1], lever * k[2] - body.R)


def inverse_inertia(body: Parameters, k: Vector, torque: Vector) -> Vector:
    """Inverse inertia tensor applied to a vector: torque to the angular acceleration it causes."""
    along = dot(torque, k)
    return added(scaled(1 / body.I1, torque), scaled(along / body.I3 - along / body.I1, k))


def angular_velocity(body: Parameters, state: NewtonState) -> Vector:
    """Angular velocity omega from L."""
    return inverse_inertia(body, state.k, state.L)


def angular_momentum(body: Parameters, k: Vector, omega: Vector) -> Vector:
    """L = I1 omega + (I3 - I1)(omega.k) k; section 1."""
    return added(scaled(body.I1, omega), scaled((body.I3 - body.I1) * dot(omega, k), k))


def axis_rate(body: Parameters, state: NewtonState) -> Vector:
    """k_dot = L x k/I1; eq (1)."""
    return scaled(1 / body.I1, cross(state.L, state.k))


def contact_velocity_rel_cm(body: Parameters, state: NewtonState) -> Vector:
    """Velocity omega x a of the contact point about CM, as R alpha k_dot - R omega x z."""
    omega = angular_velocity(body, state)
    turned = scaled(body.R * body.alpha, axis_rate(body, state))
    return (turned[0] - body.R * omega[1], turned[1] + body.R * omega[0], turned[2])


def force_per_normal(body: Parameters, state: NewtonState) -> Vector:
    """F/g_n = z - mu v_A; after eq (1)."""
    return (-(body.mu * state.vx), -(body.mu * state.vy), 1)


def torque_per_normal(body: Parameters, state: NewtonState) -> Vector:
    """Torque about the centre of mass over g_n, a x F/g_n."""
    return cross(contact_arm(body, state.k), force_per_normal(body, state))


def contact_terms(body: Parameters, state: NewtonState) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n, scaled as in eq (7): units kg^2 m^3/s^2 and kg m^2.

    The height s.z = R (1 - alpha k.z) gives g_n = m g - m R alpha k.z_ddot with
    I1 k_ddot = L_dot x k + L x k_dot, in which L_dot is g_n times the ``torque_per_normal``.
    """
    lever = body.m * body.R * body.alpha
    swung = cross(state.L, axis_rate(body, state))[2]
    driven = cross(torque_per_normal(body, state), state.k)[2]
    return body.m * body.g * body.I1 - lever * swung, body.I1 + lever * driven


def normal_force(body: Parameters, state: NewtonState) -> Scalar:
    """Normal force g_n in the direction of z; eq (7) in vector form."""
    numerator, denominator = contact_terms(body, state)
    return numerator / denominator


def normal_force_slope(body: Parameters, state: NewtonState) -> Scalar:
    """Rate of g_n times the denominator of eq (7): positive where g_n rises, units kg^2 m^3/s^3.

    The height s.z = R (1 - alpha k.z) gives g_n = m g - m R alpha k.z_ddot, so the rate of g_n is
    -m R alpha k.z_dddot with I1 k_dddot = (L x k)_ddot. In it L_ddot = (g_n a x f)_dot, f = F/g_n,
    contains the rate once more; what that part leaves on the left is the denominator.
    """
    rate = rates(body, state)
    k_dot, L_dot = axis_rate(body, state), rate.L
    k_ddot = scaled(1 / body.I1, added(cross(L_dot, state.k), cross(state.L, k_dot)))
    a, f = contact_arm(body, state.k), force_per_normal(body, state)
    a_dot = scaled(body.R * body.alpha, k_dot)
    f_dot = (-body.mu * rate.vx, -body.mu * rate.vy, 0)
    L_ddot = scaled(normal_force(body, state), added(cross(a_dot, f), cross(a, f_dot)))
    turning = cross(L_ddot, state.k)[2] + 2 * cross(L_dot, k_dot)[2] + cross(state.L, k_ddot)[2]
    return -body.m * body.R * body.alpha * turning


def contact_force(body: Parameters, state: NewtonState) -> Vector:
    """Force F = g_n (z - mu v_A) on the top at the contact point; after eq (1)."""
    return scaled(normal_force(body, state), force_per_normal(body, state))


def contact_acceleration(body: Parameters, state: NewtonState, force: Vector) -> Vector:
    """v_A_dot under any force at the contact point.

    v_A = s_dot + omega x a, so v_A_dot = F/m - g z + omega_dot x a + omega x (R alpha k_dot), and
    omega_dot = inverse_inertia(a x F) + (1/I3 - 1/I1)(L.k) k_dot, because (L.k)_dot = (a x F).k.
    """
    a, k_dot = contact_arm(body, state.k), axis_rate(body, state)
    spin = dot(state.L, state.k)
    omega_dot = added(
        inverse_inertia(body, state.k, cross(a, force)),
        scaled(spin / body.I3 - spin / body.I1, k_dot),
    )
    centripetal = scaled(body.R * body.alpha, cross(angular_velocity(body, state), k_dot))
    return added(scaled(1 / body.m, force), (0, 0, -body.g), cross(omega_dot, a), centripetal)


def contact_momentum(body: Parameters, a: Vector, L: Vector, v: Vector) -> Vector:
    """Angular momentum Q = L - a x m v about the lowest point, at velocity ``v`` of the centre."""
    return subtracted(L, scaled(body.m, cross(a, v)))


def contact_momentum_rate(body: Parameters, a: Vector, k_dot: Vector, v: Vector) -> Vector:
    """dQ/dt = -a_dot x m v + a x m g z, a_dot = R alpha k_dot.

    L_dot = a x F and m v_dot = F - m g z leave no contact force: the rate holds for every law of
    friction, for impulses, and in flight, but not with a torque at the contact.
    """
    x, y, z = scaled(body.m * body.R * body.alpha, cross(k_dot, v))
    weight = body.m * body.g
    return (weight * a[1] - x, -weight * a[0] - y, -z)


def rates(body: Parameters, state: NewtonState, fn: Functions = None) -> NewtonState:
    """Time derivative of the state; eq (1). Polynomial except for the division in g_n."""
    force = contact_force(body, state)
    v_dot = contact_acceleration(body, state, force)
    torque = cross(contact_arm(body, state.k), force)
    return NewtonState(*axis_rate(body, state), *torque, v_dot[0], v_dot[1])


class CentreState(Integrated, namedtuple("CentreState", "kx ky kz Lx Ly Lz s_dot_x s_dot_y")):
    """Axis k (unit vector), angular momentum L about CM, horizontal velocity s_dot of CM."""

    @classmethod
    def of(cls, q: Described) -> CentreState:
        """The state of a motion: s_dot = v_A - omega x a."""
        x, y, _ = contact_velocity_rel_cm(q.body, q.state)
        return cls._make([*q.state[:6], q.state.vx - x, q.state.vy - y])

    def vectors(self, body: Parameters, fn: Functions = None, phi: Scalar = 0) -> NewtonState:
        """The state with v_A = s_dot + omega x a."""
        still = NewtonState(*self[:6], 0, 0)
        x, y, _ = contact_velocity_rel_cm(body, still)
        return still._replace(vx=self.s_dot_x + x, vy=self.s_dot_y + y)

    def centre(self, body: Parameters) -> Callable[[], Vector]:
        """The velocity of CM, whose height is R (1 - alpha k.z)."""
        return partial(_centre_velocity, body, self)


def _centre_velocity(body: Parameters, state: CentreState) -> Vector:
    sinking = axis_rate(body, NewtonState(*state[:6], 0, 0))[2]
    return (state.s_dot_x, state.s_dot_y, -body.R * body.alpha * sinking)


def centre_rates(body: Parameters, state: CentreState, fn: Functions = None) -> CentreState:
    """Time derivative of the state; eq (1). Polynomial except for the division in g_n."""
    vectors = state.vectors(body)
    g_n = normal_force(body, vectors)
    push = force_per_normal(body, vectors)
    torque = scaled(g_n, torque_per_normal(body, vectors))
    return CentreState(
        *axis_rate(body, vectors), *torque, g_n * push[0] / body.m, g_n * push[1] / body.m
    )
