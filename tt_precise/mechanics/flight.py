"""A top with a free height of the lowest point: in the air, or on an elastic table.

The state is that of a gliding top, with this height and its time derivative. The lowest point of
the sphere is always at a = R (alpha k - z) from the centre of mass, and its velocity v_A as a point
of the body has the time derivative of the height as vertical component. The equations are those of
``newton`` with three components of v_A instead of two, for any force at the lowest point.

Flight has a closed form, a free rotation and a parabola: L and omega_3 are constant, the axis
rotates about L at |L|/I1, and the body also rotates about its axis at omega_3 (1 - I3/I1); the
centre of mass falls freely.
"""

from __future__ import annotations

from collections import namedtuple

from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import Described, Integrated, NewtonState, OfAxis
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import (
    Quaternion,
    RigidBodyState,
    Vector,
    cross,
    multiplied,
    rotate,
    rotation,
)
from tt_precise.runtime.values import Functions, Scalar


class LiftedState(
    OfAxis, Integrated, namedtuple("LiftedState", "kx ky kz Lx Ly Lz vx vy height rise")
):
    """A ``NewtonState`` with the height of the lowest point above the table, and its rate."""

    @classmethod
    def of(cls, q: Described) -> LiftedState:
        """The state of a motion, with the lowest point on the table unless a height is given."""
        return q.state if isinstance(q.state, cls) else cls(*(*q.state, q.fn.mpf(0), q.fn.mpf(0)))

    def vectors(self, body: Parameters, fn: Functions, phi: Scalar = 0) -> LiftedState:
        """The state itself."""
        return self

    @property
    def v(self) -> Vector:
        """Velocity v_A of the lowest point."""
        return (self.vx, self.vy, self.rise)


def rates(
    body: Parameters, state: LiftedState, fn: Functions = None, force: Vector = (0, 0, 0)
) -> LiftedState:
    """Time derivative of the state, in flight or under a force at the lowest point; eq (1)."""
    turning = NewtonState(*state[:8])
    torque = cross(newton.contact_arm(body, state.k), force)
    x, y, z = newton.contact_acceleration(body, turning, force)
    return LiftedState(*(*newton.axis_rate(body, turning), *torque, x, y, state.rise, z))


def free_rates(body: Parameters, state: NewtonState, fn: Functions = None) -> NewtonState:
    """Time derivative, in flight, of the state of a gliding top."""
    return NewtonState(*rates(body, LiftedState(*state, 0, 0), fn)[:8])


def free_euler_rates(body: Parameters, state: EulerState, fn: Functions) -> EulerState:
    """Time derivative, in flight, of the state of a gliding top."""
    return euler.rates(body, state, fn, 0)


def orientation(
    body: Parameters, q: Quaternion, omega: Vector, t: Scalar, fn: Functions
) -> Quaternion:
    """The orientation at time ``t`` of a free symmetric body; ``omega`` inertial, at t = 0."""
    back = (q[0], -q[1], -q[2], -q[3])
    w1, w2, w3 = rotate(back, omega)
    L = rotate(q, (body.I1 * w1, body.I1 * w2, body.I3 * w3))
    about_L = rotation((L[0] / body.I1, L[1] / body.I1, L[2] / body.I1), t, fn)
    about_axis = rotation((0, 0, w3 * (1 - body.I3 / body.I1)), t, fn)
    return multiplied(multiplied(about_L, q), about_axis)


def fly(body: Parameters, start: RigidBodyState, t: Scalar, fn: Functions) -> RigidBodyState:
    """The state at time ``t`` of a body in free flight from ``start``, a unit quaternion."""
    q0: Quaternion = (start.qw, start.qx, start.qy, start.qz)
    omega = (start.wx, start.wy, start.wz)
    q = orientation(body, q0, omega, t, fn)
    back = (q0[0], -q0[1], -q0[2], -q0[3])
    w1, w2, w3 = rotate(back, omega)
    # in the body's frame omega turns about the axis at -(1 - I3/I1) omega_3
    spin = rotation((0, 0, -w3 * (1 - body.I3 / body.I1)), t, fn)
    now = rotate(q, rotate(spin, (w1, w2, w3)))
    return RigidBodyState(*q, *now, start.vcx, start.vcy, start.vcz - body.g * t)


def height(body: Parameters, z: Scalar, vcz: Scalar, t: Scalar) -> Scalar:
    """Height of the centre of mass at time ``t`` from ``z`` and the rate ``vcz`` at t = 0."""
    return z + vcz * t - body.g * t * t / 2
