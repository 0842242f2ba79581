"""Friction at the contact point under the law of the body, generic in the arithmetic.

Every law has F_f = -c g_n v_A with a coefficient c (``scene.laws``). Eqs (1) to (7) are algebraic
in mu, so with c for mu they are the equations of motion of each law: no formula is written twice.
What differentiates mu g_n v_A (``newton.normal_force_slope``) holds for constant c only.

Coulomb's law is singular where v_A = 0: ``polar`` goes through small speeds.
"""

from __future__ import annotations

from collections.abc import Callable

from tt_precise.mechanics import rolling
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.arithmetic import Functions, Scalar, StateOfAny
from tt_precise.scene.body import Parameters


def coefficient(body: Parameters, vx: Scalar, vy: Scalar, fn: Functions) -> Scalar:
    """c in F_f = -c g_n v_A, in s/m, at the gliding velocity (vx, vy); the law is the body's.

    Divides by zero for Coulomb's law at v_A = 0.
    """
    law = body.friction
    if law.constant:
        return body.mu
    law.require(fn)
    return law.coefficient(vx * vx + vy * vy, fn, body.mu, *body.further)


def viscous_at(body: Parameters, vx: Scalar, vy: Scalar, fn: Functions) -> Parameters:
    """The top with viscous friction that feels the same force as ``body`` at this velocity."""
    if body.friction.constant:
        return body
    return Parameters(
        body.m, body.R, body.alpha, body.I1, body.I3, body.g, coefficient(body, vx, vy, fn)
    )


def cone_margin(body: Parameters, state: NewtonState) -> Scalar:
    """mu^2 F_z^2 - F_x^2 - F_y^2 of the force that keeps the top rolling, in N^2.

    A contact with v_A = 0 sticks under Coulomb's law where this is not negative and F_z > 0.
    """
    force = rolling.constraint_force(body, state)
    return body.mu * body.mu * force[2] * force[2] - force[0] * force[0] - force[1] * force[1]


def of_law(
    rates: Callable[..., StateOfAny],
    velocity: Callable[[Parameters, StateOfAny], tuple[Scalar, Scalar]],
) -> Callable[..., StateOfAny]:
    """The equations of motion ``rates`` of a viscous top as those of the body's own law.

    ``velocity(body, state)`` is the gliding velocity in the state's own frame.
    """

    def own_rates(body: Parameters, state: StateOfAny, fn: Functions) -> StateOfAny:
        vx, vy = velocity(body, state)
        return rates(viscous_at(body, vx, vy, fn), state, fn)

    return own_rates


def largest_coefficient(body: Parameters, speed: Scalar) -> Scalar:
    """A bound on c at gliding speeds of at least ``speed``, in s/m."""
    return body.friction.largest(speed, body.mu, *body.further)
