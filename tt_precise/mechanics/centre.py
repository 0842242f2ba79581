"""The gliding Tippe Top by the motion of its centre of mass: the paper's eq (1) as it stands.

The same motion as in ``newton``, with the horizontal velocity of the centre of mass for that of
the contact point in the state. m s_ddot = F - m g z then needs no acceleration of the contact:
half the products of ``newton.rates``, and 3 % fewer steps on the reference scene. It is what
heyoka integrates; v_A = s_dot + omega x a follows from the state.
"""

from __future__ import annotations

from typing import NamedTuple

from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Vector, scaled
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters


class CentreState(NamedTuple):
    """Axis k (unit vector), angular momentum L about CM, horizontal velocity s_dot of CM."""

    kx: Scalar
    ky: Scalar
    kz: Scalar
    Lx: Scalar
    Ly: Scalar
    Lz: Scalar
    s_dot_x: Scalar
    s_dot_y: Scalar


def from_vectors(body: Parameters, vectors: NewtonState) -> CentreState:
    """The state whose contact point has the velocity of ``vectors``."""
    swing = newton.swing(body, vectors)
    return CentreState(*vectors[:6], vectors.vx - swing[0], vectors.vy - swing[1])


def to_vectors(body: Parameters, state: CentreState) -> NewtonState:
    """The state with the velocity of the contact point, v_A = s_dot + omega x a."""
    still = NewtonState(*state[:6], 0, 0)
    swing = newton.swing(body, still)
    return still._replace(vx=state.s_dot_x + swing[0], vy=state.s_dot_y + swing[1])


def velocity(body: Parameters, state: CentreState) -> Vector:
    """Velocity s_dot of the centre of mass, whose height is R (1 - alpha k.z)."""
    sinking = newton.axis_rate(body, NewtonState(*state[:6], 0, 0))[2]
    return (state.s_dot_x, state.s_dot_y, -body.R * body.alpha * sinking)


def rates(body: Parameters, state: CentreState, fn: Functions = None) -> CentreState:
    """Time derivative of the state; eq (1). Polynomial but for the one division in g_n."""
    vectors = to_vectors(body, state)
    g_n = newton.normal_force(body, vectors)
    push = newton.force_per_normal(body, vectors)
    torque = scaled(g_n, newton.torque_per_normal(body, vectors))
    return CentreState(
        *newton.axis_rate(body, vectors), *torque, g_n * push[0] / body.m, g_n * push[1] / body.m
    )
