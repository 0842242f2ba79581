"""The formulations for integrating a scene: model and coordinates to state and rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from tt_precise.mechanics import compliant, euler, flight, friction, newton, rolling
from tt_precise.mechanics.compliant import DeepState
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.friction import PolarState
from tt_precise.mechanics.laws import COULOMB, VISCOUS, Law
from tt_precise.mechanics.newton import CentreState, NewtonState
from tt_precise.mechanics.parameters import Dimension, Parameters, of_numbers
from tt_precise.mechanics.quantities import ANGLE, ANGULAR_MOMENTUM, RATE, SPEED, Motion
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.runtime.values import Functions, InputError, Scalar, StateOfAny

COORDINATES = ("newton", "euler")

STATE_DIMENSIONS: dict[str, Dimension] = {
    **dict.fromkeys(("kx", "ky", "kz", "theta", "phi", "psi"), ANGLE),
    **dict.fromkeys(("Lx", "Ly", "Lz"), ANGULAR_MOMENTUM),
    **dict.fromkeys(("theta_dot", "phi_dot", "omega_3"), RATE),
    **dict.fromkeys(("vx", "vy", "s_dot_x", "s_dot_y", "nu_x", "nu_y"), SPEED),
    **dict.fromkeys(("x", "y", "height"), Dimension(0, 1, 0)),
    "rise": SPEED,
}


@dataclass(frozen=True)
class Formulation:
    """State, equations of motion, and conversion to vectors, of a model in a set of coordinates.

    ``equations(body, state, fn)`` is the time derivative of a ``State``; ``friction`` is the law
    and ``spring`` the force of an elastic table, "" for a rigid table. If the equations are those
    of viscous friction, ``velocity(body, state)`` is the gliding velocity at which ``rates``
    substitutes the law's coefficient for mu. In a regularised time, which the equations then refer
    to, the time t is an entry of the state and ``clock(state, fn)`` the rate of t.
    """

    model: str
    coordinates: str
    State: Any
    equations: Callable[..., StateOfAny]
    velocity: Callable[[Parameters, Any], tuple[Scalar, Scalar]] | None = None
    friction: Law = VISCOUS
    spring: str = ""
    clock: Callable[[Any, Functions], Scalar] | None = None

    def rates(self, body: Parameters, state: StateOfAny, fn: Functions) -> StateOfAny:
        """Time derivative of a state under the law of friction."""
        if self.velocity and not self.friction.constant:
            body = friction.viscous_at(body, *self.velocity(body, state), fn)
        return self.equations(body, state, fn)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's entries, in order."""
        return tuple(self.State._fields)

    @property
    def regularised_time(self) -> bool:
        """Whether it uses a regularised time."""
        return self.clock is not None

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
        known = dict.fromkeys(("mu", *self.friction.further), 0)
        known |= dict.fromkeys(("m", "R", "g"), 1)
        given = dict(zip(self.parameters, values, strict=True))
        return of_numbers(known | given, self.friction, self.spring, Parameters)

    def motion(self, body: Parameters, state: StateOfAny, fn: Functions, phi: Scalar = 0) -> Motion:
        """The ``Motion`` of a state; an Euler state needs the azimuth ``phi``."""
        if self.State is CentreState:
            there = CentreState(*state)
            velocity = partial(newton.centre_velocity, body, there)
            return Motion(
                body, newton.centre_to_vectors(body, there), fn, self.model, s_dot=velocity
            )
        if "rise" in self.columns:
            return self._lifted_motion(body, state, fn)
        if self.regularised_time:
            polar_state = self.State(*state)
            length = self.columns.index("log_v")
            state = (*state[:length], *friction.gliding_velocity(polar_state, fn))
        if self.coordinates == "newton":
            vectors = NewtonState(*state, *(0,) * (8 - len(state)))
            return Motion(body, vectors, fn, self.model)
        full = EulerState(*state, *(0,) * (6 - len(state)))
        vectors = vectors_from_euler(body, full, fn, phi)
        return Motion(body, vectors, fn, self.model, euler=full)

    def _lifted_motion(self, body: Parameters, state: StateOfAny, fn: Functions) -> Motion:
        inner = dict(zip(self.columns, state, strict=False))
        height = compliant.height(inner["zeta"]) if self.regularised_time else inner["height"]
        lifted_state = LiftedState(*(*state[:8], height, inner["rise"]))
        return Motion(body, lifted_state, fn, self.model)

    def start(self, body: Parameters, vectors: NewtonState, euler: EulerState) -> StateOfAny:
        """The state that both ``vectors`` and ``euler`` describe."""
        if self.State is CentreState:
            return newton.centre_from_vectors(body, vectors)
        source: tuple[Scalar, ...] = vectors if self.coordinates == "newton" else euler
        return self.State(*source[: len(self.columns)])


def _of_contact(body: Parameters, state: NewtonState) -> tuple[Scalar, Scalar]:
    return state.vx, state.vy


def _of_euler(body: Parameters, state: EulerState) -> tuple[Scalar, Scalar]:
    return state.nu_x, state.nu_y


def _of_centre(body: Parameters, state: CentreState) -> tuple[Scalar, Scalar]:
    vectors = newton.centre_to_vectors(body, state)
    return vectors.vx, vectors.vy


MODELS = ("gliding", "rolling", "flight")
CENTRE, SLOW, STICKING, RAISED = "centre of mass", "slow", "sticking", "raised"
# by motion and coordinates: the formulation of a scene's model, and the integrated one
FORMULATIONS = {
    ("gliding", "newton"): Formulation("gliding", "newton", NewtonState, newton.rates, _of_contact),
    ("gliding", "euler"): Formulation("gliding", "euler", EulerState, euler.rates, _of_euler),
    ("rolling", "newton"): Formulation("rolling", "newton", RollingState, rolling.rates),
    ("rolling", "euler"): Formulation("rolling", "euler", RollingEulerState, rolling.euler_rates),
    ("flight", "newton"): Formulation("flight", "newton", NewtonState, flight.free_rates),
    ("flight", "euler"): Formulation("flight", "euler", EulerState, flight.free_euler_rates),
    # gliding, in a state that is cheaper to integrate than the published state
    (CENTRE, "newton"): Formulation(
        "gliding", "newton", CentreState, newton.centre_rates, _of_centre
    ),
    # Coulomb's law near v_A = 0, and while the top rolls because the force stays within the cone
    (SLOW, "newton"): Formulation(
        "gliding", "newton", PolarState, friction.polar_rates,
        friction=COULOMB, clock=friction.polar_speed,
    ),
    (STICKING, "newton"): Formulation(
        "rolling", "newton", RollingState, rolling.rates, friction=COULOMB
    ),
    # in the air, with the height, and on an elastic table
    (RAISED, "newton"): Formulation("flight", "newton", LiftedState, flight.rates),
    ("linear", "newton"): Formulation(
        "linear", "newton", LiftedState, compliant.rates, spring="linear"
    ),
    ("hunt-crossley", "newton"): Formulation(
        "hunt-crossley", "newton", DeepState, compliant.hunt_crossley_rates,
        spring="hunt-crossley", clock=compliant.root_of_depth,
    ),
}  # fmt: skip


def raised(spring: str = "") -> Formulation:
    """Flight with the height: above a table, or beyond the force of an elastic table."""
    return replace(FORMULATIONS[RAISED, "newton"], spring=spring)


def elastic(spring: str, law: Law) -> Formulation:
    """The formulation of contact with an elastic table, under that law of friction."""
    return replace(FORMULATIONS[spring, "newton"], friction=law)


def elastic_in_time(spring: str, law: Law) -> Formulation:
    """As ``elastic`` in vectors and in t, where it may be non-smooth at height 0."""
    return replace(FORMULATIONS["linear", "newton"], model=spring, spring=spring, friction=law)


def integrated(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """The integrated formulation for ``formulation(model, coordinates, law)``: the same motion.

    Its ``State`` may differ; ``start`` computes it from the published state, ``motion`` converts it
    back.
    """
    if model == "flight" and coordinates == "newton":
        return raised()
    if model == "gliding" and (CENTRE, coordinates) in FORMULATIONS:
        return replace(FORMULATIONS[CENTRE, coordinates], friction=law)
    return formulation(model, coordinates, law)


def formulation(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """The formulation of ``model`` in ``coordinates``, with that law of friction.

    Raises ``InputError``: there is no such model, or there are no such coordinates.
    """
    if coordinates not in COORDINATES:
        raise InputError(
            f"formulation: got {coordinates!r}, expected one of: {', '.join(COORDINATES)}"
        )
    if model not in MODELS:
        raise InputError(f"model: got {model!r}, expected one of: {', '.join(MODELS)}")
    known = FORMULATIONS[model, coordinates]
    return replace(known, friction=law) if model == "gliding" else known


def contact_terms(
    model: str, body: Parameters, vectors: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n; for rolling the denominator cannot vanish."""
    if model == "rolling" or not (body.friction.smooth_at_rest or any(vectors.v)):
        return rolling.constraint_force(body, vectors)[2], 1
    viscous = friction.viscous_at(body, vectors.vx, vectors.vy, fn)
    return newton.contact_terms(viscous, vectors)
