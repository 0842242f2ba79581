"""``Motion``: a body in a state, from which everything else is computed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from tt_precise.mechanics import compliant, friction, newton, rolling
from tt_precise.mechanics.conversion import euler_from_vectors, horizontal_length
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.lifted import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Vector, cross, subtracted
from tt_precise.runtime.arithmetic import Functions
from tt_precise.scene.body import SPRINGS, Parameters


class Motion:
    """A body in a state, in one arithmetic: what quantities are functions of.

    ``state`` holds vectors (a rolling one has vx = vy = 0); ``model`` says which force acts at
    the contact. Everything is computed when first asked for; ``s_dot`` says how, where it is
    known better than from the vectors.
    """

    state: Any  # a NewtonState or a LiftedState

    def __init__(
        self,
        body: Parameters,
        state: NewtonState | LiftedState,
        fn: Functions,
        model: str = "gliding",
        euler: EulerState | None = None,
        s_dot: Callable[[], Vector] | None = None,
    ):
        self.body, self.state, self.fn, self.model = body, state, fn, model
        # what is known already is not derived from the vectors
        if euler is not None:
            self.__dict__["euler"] = euler
        self._s_dot = s_dot

    @cached_property
    def k(self) -> Vector:
        """Symmetry axis."""
        return self.state.k

    @cached_property
    def a(self) -> Vector:
        """From the centre of mass to the contact point."""
        return newton.arm(self.body, self.k)

    @cached_property
    def omega(self) -> Vector:
        """Angular velocity."""
        return newton.angular_velocity(self.body, self.state)

    @cached_property
    def omega_cross_a(self) -> Vector:
        """Velocity of the contact point relative to the centre of mass."""
        return newton.swing(self.body, self.state)

    @cached_property
    def s_dot(self) -> Vector:
        """Velocity of the centre of mass, v_A - omega x a."""
        if self._s_dot:
            return self._s_dot()
        return subtracted(self.state.v, self.omega_cross_a)

    @cached_property
    def viscous(self) -> Parameters:
        """The body whose viscous friction is the body's own law's at this velocity."""
        return friction.viscous_at(self.body, self.state.vx, self.state.vy, self.fn)

    @cached_property
    def rolls(self) -> Any:
        """Whether v_A stays zero: when rolling, and at rest under Coulomb's law; row by row."""
        if self.model == "rolling" or self.body.friction.smooth_at_rest:
            return self.model == "rolling"
        return (self.state.vx == 0) & (self.state.vy == 0)

    @cached_property
    def force(self) -> Vector:
        """Force at the contact point."""
        if self.model == "flight":
            return (0, 0, 0)
        if self.model in SPRINGS:
            g_n = compliant.normal_force(self.body, self.state, self.fn)
            return compliant.contact_force(self.body, self.state, g_n, self.fn)
        return self._by_motion(
            lambda: rolling.constraint_force(self.body, self.state),
            lambda: newton.contact_force(self.viscous, self.state),
        )

    def _by_motion(self, rolling: Callable[[], Vector], gliding: Callable[[], Vector]) -> Vector:
        """What holds while the top rolls or glides, row by row."""
        if not hasattr(self.rolls, "shape"):
            return rolling() if self.rolls else gliding()
        if not self.rolls.any():
            return gliding()
        import numpy

        with numpy.errstate(all="ignore"):
            pairs = zip(rolling(), gliding(), strict=True)
            x, y, z = (numpy.where(self.rolls, still, moving) for still, moving in pairs)
        return (x, y, z)

    @cached_property
    def torque(self) -> Vector:
        """Torque a x F about the centre of mass."""
        return cross(self.a, self.force)

    @cached_property
    def v_dot(self) -> Vector:
        """Acceleration of the contact velocity; zero when rolling."""
        if self.model == "flight" or isinstance(self.state, LiftedState):
            turning = NewtonState(*self.state[:8])
            return newton.contact_acceleration(self.body, turning, self.force)
        return self._by_motion(lambda: (0, 0, 0), self._gliding_acceleration)

    def _gliding_acceleration(self) -> Vector:
        rate = newton.rates(self.viscous, self.state)
        return (rate.vx, rate.vy, 0)

    @cached_property
    def x_hat(self) -> Vector:
        """x-hat: the horizontal direction towards which the axis is tilted."""
        s = horizontal_length(self.fn, self.state.kx, self.state.ky)
        return (self.state.kx / s, self.state.ky / s, 0)

    @cached_property
    def euler(self) -> EulerState:
        """The Euler state."""
        return euler_from_vectors(self.body, self.state, self.fn)
