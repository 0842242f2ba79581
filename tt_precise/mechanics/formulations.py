"""The formulations a scene can be integrated in: model and coordinates to state and rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, partial
from typing import Any

from tt_precise.mechanics import compliant, euler, flight, friction, newton, rolling
from tt_precise.mechanics.compliant import DeepEulerState, DeepState
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedEulerState, LiftedState
from tt_precise.mechanics.friction import PolarEulerState, PolarState
from tt_precise.mechanics.newton import CentreState, NewtonState
from tt_precise.mechanics.quantities import ANGLE, ANGULAR_MOMENTUM, RATE, SPEED, Motion
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.runtime.arithmetic import Functions, Scalar, StateOfAny
from tt_precise.runtime.errors import InputError
from tt_precise.scene.body import Dimension, Parameters, of_numbers
from tt_precise.scene.laws import COULOMB, VISCOUS, Law, law_named

COORDINATES = ("newton", "euler")

STATE_DIMENSIONS: dict[str, Dimension] = {
    **dict.fromkeys(("kx", "ky", "kz", "theta", "phi", "psi"), ANGLE),
    **dict.fromkeys(("Lx", "Ly", "Lz"), ANGULAR_MOMENTUM),
    **dict.fromkeys(("theta_dot", "phi_dot", "omega_3"), RATE),
    **dict.fromkeys(("vx", "vy", "s_dot_x", "s_dot_y", "nu_x", "nu_y"), SPEED),
    **dict.fromkeys(("x", "y", "height"), Dimension(0, 1, 0)),
    "rise": SPEED,
}

# Entries are compared with the largest of their kind, so that one that happens to pass through
# zero does not decide: an error of 1e-16 in kx = 1e-5 is 16 good digits of the axis. Dimensionless,
# a height and its rate are of one kind: where a flight ends, the height is zero.
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
    ("height", "rise"),
)


@dataclass(frozen=True)
class Formulation:
    """State, equations of motion, and the way to vectors, of one model in one set of coordinates.

    ``rates(body, state, fn)`` is the time derivative of a ``State``; ``friction`` is their law and
    ``spring`` the force of an elastic table, "" where there is none. Where it runs in a time of
    its own, of which the ``rates`` then are, the time t is an entry of its state and
    ``clock(state, fn)`` the rate of t.
    """

    model: str
    coordinates: str
    State: Any
    rates: Callable[..., StateOfAny]
    friction: Law = VISCOUS
    spring: str = ""
    clock: Callable[[Any, Functions], Scalar] | None = None

    def __reduce__(self) -> Any:
        # the rates of a law are made here, and not to be found by name
        if self.friction.constant or self.spring or self.model == "flight":
            return Formulation, tuple(getattr(self, one.name) for one in fields(self))
        return _known, (self.model, self.State, self.friction.name)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's entries, in order."""
        return tuple(self.State._fields)

    @property
    def own_time(self) -> bool:
        """Whether it runs in a time of its own."""
        return self.clock is not None

    @property
    def parameters(self) -> tuple[str, ...]:
        """Which parameters of a dimensionless body its equations contain."""
        found: tuple[str, ...] = ("alpha", "I1", "I3")
        rolls = self.model == "rolling" and self.friction.smooth_at_rest
        if self.model != "flight" and not rolls:
            found += tuple(one.name for one in self.friction.parameters)
        return (*found, "stiffness", "damping") if self.spring else found

    def body(self, values: Sequence[Scalar]) -> Parameters:
        """The dimensionless body whose ``parameters`` have these values."""
        known = dict.fromkeys(("mu", *self.friction.further), 0)
        known |= dict.fromkeys(("m", "R", "g"), 1)
        given = dict(zip(self.parameters, values, strict=True))
        return of_numbers(known | given, self.friction, self.spring, Parameters)

    def motion(self, body: Parameters, state: StateOfAny, fn: Functions, phi: Scalar = 0) -> Motion:
        """The ``Motion`` of a state; ``phi`` is the azimuth, which an Euler state leaves open."""
        if self.State is CentreState:
            there = CentreState(*state)
            velocity = partial(newton.centre_velocity, body, there)
            return Motion(
                body, newton.centre_to_vectors(body, there), fn, self.model, s_dot=velocity
            )
        if "rise" in self.columns:
            return self._lifted_motion(body, state, fn, phi)
        if self.own_time:
            polar_state = self.State(*state)
            length = self.columns.index("log_v")
            state = (*state[:length], *friction.gliding_velocity(polar_state, fn))
        if self.coordinates == "newton":
            vectors = NewtonState(*state, *(0,) * (8 - len(state)))
            return Motion(body, vectors, fn, self.model)
        full = EulerState(*state, *(0,) * (6 - len(state)))
        vectors = vectors_from_euler(body, full, fn, phi)
        return Motion(body, vectors, fn, self.model, euler=full)

    def _lifted_motion(
        self, body: Parameters, state: StateOfAny, fn: Functions, phi: Scalar
    ) -> Motion:
        inner = dict(zip(self.columns, state, strict=False))
        height = compliant.height(inner["zeta"]) if self.own_time else inner["height"]
        euler = None
        turning = state[:8]
        if self.coordinates == "euler":
            euler = EulerState(*state[:6])
            turning = vectors_from_euler(body, euler, fn, phi)
        lifted_state = LiftedState(*(*turning, height, inner["rise"]))
        return Motion(body, lifted_state, fn, self.model, euler=euler)

    def start(self, body: Parameters, vectors: NewtonState, euler: EulerState) -> StateOfAny:
        """The state that both ``vectors`` and ``euler`` describe."""
        if self.State is CentreState:
            return newton.centre_from_vectors(body, vectors)
        source: tuple[Scalar, ...] = vectors if self.coordinates == "newton" else euler
        return self.State(*source[: len(self.columns)])


_ALL = (
    Formulation("gliding", "newton", NewtonState, newton.rates),
    Formulation("gliding", "euler", EulerState, euler.rates),
    Formulation("rolling", "newton", RollingState, rolling.rates),
    Formulation("rolling", "euler", RollingEulerState, rolling.euler_rates),
    Formulation("flight", "newton", NewtonState, flight.free_rates),
    Formulation("flight", "euler", EulerState, flight.free_euler_rates),
)
FORMULATIONS = {(f.model, f.coordinates): f for f in _ALL}

# where another state costs less to integrate than the one that is published
INTEGRATED = {
    ("gliding", "newton"): Formulation("gliding", "newton", CentreState, newton.centre_rates)
}

# Coulomb's law near v_A = 0, and while the top rolls because the force stays within the cone
SLOW = {
    "newton": Formulation(
        "gliding", "newton", PolarState, friction.polar_rates, COULOMB, clock=friction.polar_speed
    ),
    "euler": Formulation(
        "gliding",
        "euler",
        PolarEulerState,
        friction.polar_euler_rates,
        COULOMB,
        clock=friction.polar_speed,
    ),
}
STICKING = {
    coordinates: replace(FORMULATIONS["rolling", coordinates], friction=COULOMB)
    for coordinates in COORDINATES
}

# in the air, and on an elastic table
FLIGHT = {
    "newton": Formulation("flight", "newton", LiftedState, flight.flight_rates),
    "euler": Formulation("flight", "euler", LiftedEulerState, flight.flight_euler_rates),
}
_deep = compliant.root_of_depth
ELASTIC = {
    form_.model + " " + form_.coordinates: form_
    for form_ in (
        Formulation("linear", "newton", LiftedState, compliant.rates, spring="linear"),
        Formulation(
            "linear", "euler", LiftedEulerState, compliant.linear_euler_rates, spring="linear"
        ),
        Formulation(
            "hunt-crossley", "newton", DeepState, compliant.hunt_crossley_rates,
            spring="hunt-crossley", clock=_deep,
        ),
        Formulation(
            "hunt-crossley", "euler", DeepEulerState, compliant.hunt_crossley_euler_rates,
            spring="hunt-crossley", clock=_deep,
        ),
    )
}  # fmt: skip


def flight_over(spring: str, coordinates: str) -> Formulation:
    """The formulation of flight above an elastic table, or out of reach of its force."""
    return replace(FLIGHT[coordinates], spring=spring)


def elastic(spring: str, coordinates: str, law: Law) -> Formulation:
    """The formulation of contact with an elastic table, under that law of friction."""
    return replace(ELASTIC[f"{spring} {coordinates}"], friction=law)


def elastic_in_time(spring: str, law: Law) -> Formulation:
    """As ``elastic`` in vectors and in t, in which it need not be smooth at height 0."""
    return replace(ELASTIC["linear newton"], model=spring, spring=spring, friction=law)


_GLIDING_VELOCITY: dict[
    type[StateOfAny], Callable[[Parameters, StateOfAny], tuple[Scalar, Scalar]]
] = {
    NewtonState: lambda body, state: (state.vx, state.vy),
    EulerState: lambda body, state: (state.nu_x, state.nu_y),
    CentreState: lambda body, state: newton.centre_to_vectors(body, state)[-2:],
}


def _known(model: str, state: Any, law: str) -> Formulation:
    """The formulation of ``model`` with this class of state, under the law of that name."""
    every = (*SLOW.values(), *STICKING.values(), *INTEGRATED.values(), *_ALL)
    found = (form for form in every if (form.model, form.State) == (model, state))
    friction = law_named(law)
    return _with_law(next(form for form in found if form.friction in (friction, VISCOUS)), friction)


def _with_law(form: Formulation, law: Law) -> Formulation:
    """``form`` under the friction ``law``: itself where it has that, or does not glide."""
    if law is form.friction or form.model == "rolling":
        return form
    return replace(form, friction=law, rates=_rates_of_law(form.State, form.rates))


@cache
def _rates_of_law(state: Any, rates: Callable[..., StateOfAny]) -> Callable[..., StateOfAny]:
    # one function each, so that equal formulations share a compiled integrator
    return friction.of_law(rates, _GLIDING_VELOCITY[state])


def integrated(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """What heyoka is given for ``formulation(model, coordinates, law)``: the same motion.

    Its ``State`` may be another one; ``start`` makes it from the published state, ``motion`` leads
    back to that.
    """
    if model == "flight":
        return FLIGHT[coordinates]
    cheaper = INTEGRATED.get((model, coordinates))
    return _with_law(cheaper, law) if cheaper else formulation(model, coordinates, law)


def formulation(model: str, coordinates: str, law: Law = VISCOUS) -> Formulation:
    """The formulation of ``model`` in ``coordinates``, with that law of friction.

    Raises
    ------
    InputError
        There is no such model, or there are no such coordinates.
    """
    if coordinates not in COORDINATES:
        raise InputError(
            f"formulation: got {coordinates!r}, expected one of: {', '.join(COORDINATES)}"
        )
    if (model, coordinates) not in FORMULATIONS:
        known = ", ".join(dict.fromkeys(name for name, _ in FORMULATIONS))
        raise InputError(f"model: got {model!r}, expected one of: {known}")
    return _with_law(FORMULATIONS[model, coordinates], law)


def contact_terms(
    model: str, body: Parameters, vectors: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of g_n; rolling has no denominator that could vanish."""
    if model == "rolling" or not (body.friction.smooth_at_rest or any(vectors.v)):
        return rolling.constraint_force(body, vectors)[2], 1
    viscous = friction.viscous_at(body, vectors.vx, vectors.vy, fn)
    return newton.contact_terms(viscous, vectors)
