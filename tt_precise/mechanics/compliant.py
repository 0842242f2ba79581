"""A top on an elastic table: the normal force follows from the depth.

Hunt and Crossley's force has depth^(3/2), which is not smooth where contact begins and ends. With
depth = zeta^2 and a time sigma, d sigma = dt/zeta, the equations are polynomial in zeta and regular
at zeta = 0. The linear force needs neither zeta nor sigma.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from tt_precise.mechanics import flight, friction
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.friction import InOwnTime
from tt_precise.mechanics.newton import Described
from tt_precise.mechanics.vectors import Vector
from tt_precise.runtime.values import Functions, Scalar


class DeepState(InOwnTime, namedtuple("DeepState", "kx ky kz Lx Ly Lz vx vy zeta rise t")):
    """A ``LiftedState`` with the root zeta of the depth for the height, and the time."""

    @classmethod
    def of(cls, q: Described) -> DeepState:
        """The state of a motion at time 0."""
        *turning, height, rise = LiftedState.of(q)
        zero = q.fn.mpf(0)
        return cls(*(*turning, q.fn.sqrt(-height) if height < 0 else zero, rise, zero))

    def vectors(self, body: Any, fn: Functions, phi: Scalar = 0) -> LiftedState:
        """The state with the height."""
        return LiftedState(*(*self[:8], height(self.zeta), self.rise))

    def clock(self, fn: Functions) -> Scalar:
        """zeta, the rate of t along sigma."""
        return self.zeta


def linear_force(body: Any, height: Scalar, rise: Scalar) -> Scalar:
    """Normal force of a spring and a damper at a depth of -height."""
    return -(body.stiffness * height) - body.damping * rise


def hunt_crossley_force(body: Any, zeta: Scalar, rise: Scalar) -> Scalar:
    """Hunt and Crossley's normal force at the depth zeta^2."""
    return body.stiffness * zeta * zeta * zeta * (1 - body.damping * rise)


def pull(body: Any, height: Scalar, rise: Scalar) -> Scalar:
    """Positive where the table's force would pull; negative where it pushes if height < 0."""
    if body.spring == "linear":
        return -linear_force(body, height, rise)
    return body.damping * rise - 1


def normal_force(body: Any, state: LiftedState, fn: Functions) -> Scalar:
    """Normal force at a state that is in contact."""
    if body.spring == "linear":
        return linear_force(body, state.height, state.rise)
    return hunt_crossley_force(body, fn.sqrt(-state.height), state.rise)


def contact_force(body: Any, state: LiftedState, g_n: Scalar, fn: Functions) -> Vector:
    """Force g_n (z - c v_A) with the coefficient c of the body's law of friction."""
    c = friction.coefficient(body, state.vx, state.vy, fn)
    return (-(c * g_n * state.vx), -(c * g_n * state.vy), g_n)


def rates(body: Any, state: LiftedState, fn: Functions) -> LiftedState:
    """Time derivative in contact; Hunt and Crossley's is not smooth at height 0."""
    g_n = normal_force(body, state, fn)
    return flight.rates(body, state, fn, contact_force(body, state, g_n, fn))


def height(zeta: Scalar) -> Scalar:
    """Height of the lowest point at the depth zeta^2."""
    return -(zeta * zeta)


def hunt_crossley_rates(body: Any, state: DeepState, fn: Functions) -> DeepState:
    """d/d sigma of the state; zeta_dot = -rise/(2 zeta)."""
    zeta = state.zeta
    here = LiftedState(*state[:8], height(zeta), state.rise)
    g_n = hunt_crossley_force(body, zeta, state.rise)
    rate = flight.rates(body, here, fn, contact_force(body, here, g_n, fn))
    moving = (zeta * entry for entry in rate[:8])
    return DeepState(*(*moving, -state.rise / 2, zeta * rate.rise, zeta))


def stored_energy(body: Any, height: Scalar, fn: Functions) -> Scalar:
    """Energy stored in the spring at a negative height: the integral of its force."""
    depth = abs(height) / 2 - height / 2  # 0 above the table, row by row
    if body.spring == "linear":
        return body.stiffness * depth * depth / 2
    return body.stiffness * depth * depth * fn.sqrt(depth) * 2 / 5


def resting_height(body: Any, g_n: Scalar, fn: Functions) -> Scalar:
    """The negative height at which a table at rest exerts ``g_n``."""
    if body.spring == "linear":
        return -(g_n / body.stiffness)
    return height(fn.cbrt(g_n / body.stiffness))
