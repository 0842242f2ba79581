"""The equations of a simulator that forgets the gyroscopic term: I omega_dot = torque.

The right equation is I omega_dot = torque - omega x I omega, so that L = I omega changes by the
torque alone; without the term it changes by torque + omega x L, and omega_dot by what that causes.
The simulator keeps its contact point on the table with the omega_dot that it believes in.
"""

from __future__ import annotations

from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, added, cross, scaled
from tt_precise.runtime.values import Scalar


def rates_without(body: Parameters, state: NewtonState) -> NewtonState:
    """Time derivative of the state in such a simulator."""
    a, f = newton.contact_arm(body, state.k), newton.force_per_normal(body, state)
    forgotten = cross(newton.angular_velocity(body, state), state.L)
    turned = cross(newton.inverse_inertia(body, state.k, forgotten), a)

    def accelerated(normal: Scalar) -> Vector:
        force = scaled(normal, f)
        return added(newton.contact_acceleration(body, state, force), turned)

    # affine in the normal force, which leaves the contact point no vertical acceleration
    free = accelerated(0.0)[2]
    g_n = free / (free - accelerated(1.0)[2])
    v_dot = accelerated(g_n)
    L_dot = added(scaled(g_n, cross(a, f)), forgotten)
    return NewtonState(*newton.axis_rate(body, state), *L_dot, v_dot[0], v_dot[1])
