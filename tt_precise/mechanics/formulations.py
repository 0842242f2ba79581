"""The formulations a scene can be integrated in: model and coordinates to state and rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from tt_precise.arithmetic import Functions, Scalar, StateOfAny
from tt_precise.body import Dimension, Parameters
from tt_precise.errors import InputError
from tt_precise.mechanics import centre, euler, friction, newton, rolling
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import ANGLE, ANGULAR_MOMENTUM, RATE, SPEED, Motion
from tt_precise.mechanics.rolling import RollingEulerState, RollingState

COORDINATES = ("newton", "euler")

STATE_DIMENSIONS: dict[str, Dimension] = {
    **dict.fromkeys(("kx", "ky", "kz", "theta", "phi", "psi"), ANGLE),
    **dict.fromkeys(("Lx", "Ly", "Lz"), ANGULAR_MOMENTUM),
    **dict.fromkeys(("theta_dot", "phi_dot", "omega_3"), RATE),
    **dict.fromkeys(("vx", "vy", "s_dot_x", "s_dot_y", "nu_x", "nu_y"), SPEED),
    **dict.fromkeys(("x", "y"), Dimension(0, 1, 0)),
}

# Entries are compared with the largest of their kind, so that one that happens to pass through
# zero does not decide: an error of 1e-16 in kx = 1e-5 is 16 good digits of the axis.
KINDS = (
    ("kx", "ky", "kz"),
    ("Lx", "Ly", "Lz"),
    ("vx", "vy"),
    ("nu_x", "nu_y"),
    ("theta",),
    ("theta_dot", "phi_dot", "omega_3"),
    ("phi",),
    ("psi",),
    ("x", "y"),
)


@dataclass(frozen=True)
class Formulation:
    """State, equations of motion, and the way to vectors, of one model in one set of coordinates.

    ``rates(body, state, fn)`` is the time derivative of a ``State``. ``law`` is that of friction.
    """

    model: str
    coordinates: str
    State: Any
    rates: Callable[..., StateOfAny]
    law: str = "viscous"

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's entries, in order."""
        return tuple(self.State._fields)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Which parameters of a dimensionless body its equations contain."""
        if self.model == "rolling":
            return ("alpha", "I1", "I3")
        gliding = ("alpha", "I1", "I3", "mu")
        return (*gliding, "epsilon") if self.law == "regularised" else gliding

    def body(self, values: Sequence[Scalar]) -> Parameters:
        """The dimensionless body whose ``parameters`` have these values."""
        given = dict(zip(self.parameters, values, strict=True))
        return friction.PARAMETERS[self.law](**{"m": 1, "R": 1, "g": 1, "mu": 0, **given})

    def motion(self, body: Parameters, state: StateOfAny, fn: Functions, phi: Scalar = 0) -> Motion:
        """The ``Motion`` of a state; ``phi`` is the azimuth, which an Euler state leaves open."""
        if self.State is CentreState:
            state = CentreState(*state)
            vectors, s_dot = centre.to_vectors(body, state), centre.velocity(body, state)
            return Motion(body, vectors, fn, self.model, s_dot=s_dot)
        if self.coordinates == "newton":
            vectors = NewtonState(*state, *(0,) * (8 - len(state)))
            return Motion(body, vectors, fn, self.model)
        full = EulerState(*state, *(0,) * (6 - len(state)))
        vectors = vectors_from_euler(body, full, fn, phi)
        return Motion(body, vectors, fn, self.model, euler=full)

    def start(self, body: Parameters, vectors: NewtonState, euler: EulerState) -> StateOfAny:
        """The state that both ``vectors`` and ``euler`` describe."""
        if self.State is CentreState:
            return centre.from_vectors(body, vectors)
        source: tuple[Scalar, ...] = vectors if self.coordinates == "newton" else euler
        return self.State(*source[: len(self.columns)])


_ALL = (
    Formulation("gliding", "newton", NewtonState, newton.rates),
    Formulation("gliding", "euler", EulerState, euler.rates),
    Formulation("rolling", "newton", RollingState, rolling.rates),
    Formulation("rolling", "euler", RollingEulerState, rolling.euler_rates),
)
FORMULATIONS = {(f.model, f.coordinates): f for f in _ALL}

# where another state costs less to integrate than the one that is published
INTEGRATED = {("gliding", "newton"): Formulation("gliding", "newton", CentreState, centre.rates)}

_GLIDING_VELOCITY: dict[
    type[StateOfAny], Callable[[Parameters, StateOfAny], tuple[Scalar, Scalar]]
] = {
    NewtonState: lambda body, state: (state.vx, state.vy),
    EulerState: lambda body, state: (state.nu_x, state.nu_y),
    CentreState: lambda body, state: centre.to_vectors(body, state)[-2:],
}


def _with_law(form: Formulation, law: str) -> Formulation:
    """``form`` under the friction ``law``: itself where it is viscous or does not glide."""
    if law == "viscous" or form.model == "rolling":
        return form
    return replace(form, law=law, rates=_rates_of_law(form.State, form.rates))


@cache
def _rates_of_law(state: Any, rates: Callable[..., StateOfAny]) -> Callable[..., StateOfAny]:
    # one function each, so that equal formulations share a compiled integrator
    return friction.of_law(rates, _GLIDING_VELOCITY[state])


def integrated(model: str, coordinates: str, law: str = "viscous") -> Formulation:
    """What heyoka is given for ``formulation(model, coordinates, law)``: the same motion.

    Its ``State`` may be another one; ``start`` makes it from the published state, ``motion`` leads
    back to that.
    """
    cheaper = INTEGRATED.get((model, coordinates))
    return _with_law(cheaper, law) if cheaper else formulation(model, coordinates, law)


def formulation(model: str, coordinates: str, law: str = "viscous") -> Formulation:
    """The formulation of ``model`` in ``coordinates``, with that law of friction.

    Raises
    ------
    InputError
        There is no such formulation.
    """
    try:
        return _with_law(FORMULATIONS[model, coordinates], law)
    except KeyError:
        raise InputError(
            f"formulation: got {coordinates!r}, expected one of: {', '.join(COORDINATES)}"
        ) from None


def contact_terms(
    model: str, body: Parameters, vectors: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n; rolling has no denominator that could vanish."""
    if model == "rolling":
        return rolling.constraint_force(body, vectors)[2], 1
    viscous = friction.viscous_at(body, vectors.vx, vectors.vy, fn)
    return newton.contact_terms(viscous, vectors)
