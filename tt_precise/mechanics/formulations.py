"""The formulations of a scene: state and time derivatives by model and coordinates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tt_precise.mechanics import euler, flight, friction, newton, parameters, rolling
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.laws import VISCOUS, Law
from tt_precise.mechanics.newton import CentreState, NewtonState
from tt_precise.mechanics.parameters import Dimension, Parameters, of_numbers
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.runtime.values import Functions, Scalar, require_name

COORDINATES = ("newton", "euler")

STATE_DIMENSIONS: dict[str, Dimension] = {
    **dict.fromkeys(("kx", "ky", "kz", "theta", "phi", "psi"), parameters.ANGLE),
    **dict.fromkeys(("Lx", "Ly", "Lz"), parameters.ANGULAR_MOMENTUM),
    **dict.fromkeys(("theta_dot", "phi_dot", "omega_3"), parameters.RATE),
    **dict.fromkeys(("vx", "vy", "s_dot_x", "s_dot_y", "nu_x", "nu_y"), parameters.SPEED),
    **dict.fromkeys(("x", "y", "height"), parameters.LENGTH),
    "rise": parameters.SPEED,
}


@dataclass(frozen=True)
class Formulation:
    """The equations of motion of a model for one kind of state.

    ``rates(body, state, fn)`` are the derivatives of a ``State``, an ``Integrated`` named tuple, by
    its variable of integration. ``friction`` is the law, ``spring`` the force of an elastic table,
    or "" for a rigid table.
    """

    model: str
    State: Any
    rates: Callable[..., Any]
    friction: Law = VISCOUS
    spring: str = ""

    @property
    def motion_name(self) -> str:
        """The motion: gliding, rolling, flight, or contact with an elastic table."""
        return "contact" if self.model == self.spring else self.model

    @property
    def coordinates(self) -> str:
        """The coordinates of the state: "newton" or "euler"."""
        return str(self.State.coordinates)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's entries, in order."""
        return tuple(self.State._fields)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters of a dimensionless body in its equations."""
        names: tuple[str, ...] = ("alpha", "I1", "I3")
        rolls = self.model == "rolling" and self.friction.smooth_at_rest
        if self.model != "flight" and not rolls:
            names += tuple(parameter.name for parameter in self.friction.parameters)
        return (*names, "stiffness", "damping") if self.spring else names

    def body(self, values: Sequence[Scalar]) -> Parameters:
        """The dimensionless body whose ``parameters`` have these values."""
        constants = dict.fromkeys(("mu", *self.friction.further), 0)
        constants |= dict.fromkeys(("m", "R", "g"), 1)
        numbers = dict(zip(self.parameters, values, strict=True))
        return of_numbers(constants | numbers, self.friction, self.spring, Parameters)

    def motion(self, body: Parameters, state: Any, fn: Functions, phi: Scalar = 0) -> Motion:
        """The ``Motion`` of a state; an Euler state needs the azimuth ``phi``."""
        here = self.State(*state)
        vectors = here.vectors(body, fn, phi)
        return Motion(body, vectors, fn, self.model, euler=here.angles, s_dot=here.centre(body))


# The equations are those of viscous friction with the coefficient of the law in the place of mu.


def newton_rates(body: Parameters, state: NewtonState, fn: Functions) -> NewtonState:
    """Time derivative of gliding in vectors under the body's law of friction."""
    return newton.rates(friction.viscous_at(body, state.vx, state.vy, fn), state)


def centre_rates(body: Parameters, state: CentreState, fn: Functions) -> CentreState:
    """Time derivative of gliding with the velocity of the centre of mass."""
    if not body.friction.constant:
        vectors = state.vectors(body)
        body = friction.viscous_at(body, vectors.vx, vectors.vy, fn)
    return newton.centre_rates(body, state)


def euler_rates(body: Parameters, state: EulerState, fn: Functions) -> EulerState:
    """Time derivative of gliding in Euler angles."""
    return euler.rates(friction.viscous_at(body, state.nu_x, state.nu_y, fn), state, fn)


MODELS = ("gliding", "rolling", "flight")
WITHOUT_GLIDING = ("rolling", "flight")  # The contact point cannot glide in these models.
# by model and coordinates
FORMULATIONS = {
    ("gliding", "newton"): Formulation("gliding", NewtonState, newton_rates),
    ("gliding", "euler"): Formulation("gliding", EulerState, euler_rates),
    ("rolling", "newton"): Formulation("rolling", RollingState, rolling.rates),
    ("rolling", "euler"): Formulation("rolling", RollingEulerState, rolling.euler_rates),
    ("flight", "newton"): Formulation("flight", NewtonState, flight.free_rates),
    ("flight", "euler"): Formulation("flight", EulerState, flight.free_euler_rates),
}
# the same motions in states that are cheaper to integrate than the published ones
CHEAPER = {("gliding", "newton"): Formulation("gliding", CentreState, centre_rates)}


def integration_form(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """The integrated formulation for ``formulation(model, coordinates, law)``: the same motion.

    Its ``State`` may differ.
    """
    published = formulation(model, coordinates, law)
    cheapest = CHEAPER.get((model, coordinates), published)
    return replace(cheapest, friction=published.friction)


def formulation(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """The formulation of ``model`` in ``coordinates``, with that law of friction.

    Raises ``InputError``: there is no such model, or there are no such coordinates.
    """
    require_name("formulation", coordinates, COORDINATES)
    require_name("model", model, MODELS)
    form = FORMULATIONS[model, coordinates]
    return replace(form, friction=law) if model == "gliding" else form


def contact_terms(
    model: str, body: Parameters, vectors: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n; for rolling the denominator cannot vanish."""
    if model == "rolling" or not (body.friction.smooth_at_rest or any(vectors.v)):
        return rolling.constraint_force(body, vectors)[2], 1
    viscous = friction.viscous_at(body, vectors.vx, vectors.vy, fn)
    return newton.contact_terms(viscous, vectors)
