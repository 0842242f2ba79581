"""Friction at the contact point under the law of the body, generic in the arithmetic.

Every law has F_f = -c g_n v_A with a coefficient c (``mechanics.laws``). Eqs (1) to (7) are
algebraic in mu, so with c for mu they are the equations of motion of each law, and no formula is
repeated. A formula with the derivative of mu g_n v_A (``newton.normal_force_slope``) holds only for
constant c.

Where v_A = 0 the direction of Coulomb's force is undefined and the equations are singular. In polar
form, v_A = v e with |e| = 1, and in a time tau, d tau = dt/v, they are regular: g_n and the
accelerations contain v_A only in the force, and there only e. v = 0 is reached as tau -> oo,
exponentially, so ln v is in the state: its derivative e.v_A_dot is bounded, and v keeps its
relative accuracy down to any size.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics import newton, rolling
from tt_precise.mechanics.newton import Described, Integrated, NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import horizontal_length
from tt_precise.runtime.values import Functions, Scalar


def coefficient(body: Parameters, vx: Scalar, vy: Scalar, fn: Functions) -> Scalar:
    """c in F_f = -c g_n v_A, in s/m, at the gliding velocity (vx, vy); the law is the body's.

    Divides by zero for Coulomb's law at v_A = 0.
    """
    law = body.friction
    if law.constant:
        return body.mu
    return law.coefficient(vx * vx + vy * vy, fn, body.mu, *body.further)


def viscous_at(body: Parameters, vx: Scalar, vy: Scalar, fn: Functions) -> Parameters:
    """The top with viscous friction and the same force as ``body`` at this velocity."""
    if body.friction.constant:
        return body
    return Parameters(
        body.m, body.R, body.alpha, body.I1, body.I3, body.g, coefficient(body, vx, vy, fn)
    )


def cone_margin(body: Parameters, state: NewtonState) -> Scalar:
    """mu^2 F_z^2 - F_x^2 - F_y^2 of the force that keeps the top rolling, in N^2.

    A contact with v_A = 0 sticks under Coulomb's law if this is not negative and F_z > 0.
    """
    force = rolling.constraint_force(body, state)
    return body.mu * body.mu * force[2] * force[2] - force[0] * force[0] - force[1] * force[1]


def largest_coefficient(body: Parameters, speed: Scalar) -> Scalar:
    """A bound on c at gliding speeds of at least ``speed``, in s/m."""
    return body.friction.largest(speed, body.mu, *body.further)


class InOwnTime(Integrated):
    """The common part of states that contain the time t, integrated along another variable."""

    t: Scalar

    def clock(self, fn: Functions) -> Scalar:
        """The derivative of t by the variable of integration."""
        raise NotImplementedError

    def along(self, rates: list[Scalar], fn: Functions) -> list[Scalar]:
        """Derivatives by the variable of integration from derivatives by time."""
        clock = self.clock(fn)
        return [clock * rate for rate in rates]

    @staticmethod
    def elapsed(step: Scalar, before: InOwnTime, after: InOwnTime) -> Scalar:
        """The time between two states."""
        return after.t - before.t


class PolarState(InOwnTime, namedtuple("PolarState", "kx ky kz Lx Ly Lz log_v ex ey t")):
    """Axis k, angular momentum L about CM, ln v, the unit direction e of gliding, and the time."""

    @classmethod
    def of(cls, q: Described) -> PolarState:
        """The state at time 0 of a motion whose contact point glides."""
        vectors = q.state
        v = horizontal_length(q.fn, vectors.vx, vectors.vy)
        direction = q.fn.log(v), vectors.vx / v, vectors.vy / v
        return cls._make([*vectors[:6], *direction, vectors.kx * 0])

    def vectors(self, body: Parameters, fn: Functions, phi: Scalar = 0) -> NewtonState:
        """The state with v_A = v e."""
        v = self.clock(fn)
        return NewtonState(*self[:6], v * self.ex, v * self.ey)

    def clock(self, fn: Functions) -> Scalar:
        """v, the rate of t along tau."""
        return fn.exp(self.log_v)


def along_direction(body: Parameters, state: NewtonState) -> NewtonState:
    """Rates (d/dt) under the force g_n (z - mu e); ``state`` has e in the place of v_A.

    Finite where v vanishes.
    """
    return newton.rates(body, state)


def polar_rates(body: Parameters, state: PolarState, fn: Functions) -> PolarState:
    """d/d tau of the state, d tau = dt/v.

    v_A_dot = v_dot e + v e_dot gives (ln v)' = e.v_A_dot and e' = (n.v_A_dot) n, n = z x e.
    """
    v = state.clock(fn)
    ex, ey = state.ex, state.ey
    rate = along_direction(body, NewtonState(*state[:6], ex, ey))
    along = ex * rate.vx + ey * rate.vy
    across = ex * rate.vy - ey * rate.vx
    direction_rate = (along, -(across * ey), across * ex)
    return PolarState(*(*(v * entry for entry in rate[:6]), *direction_rate, v))
