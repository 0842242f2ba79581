"""The catalogue of events: a name, a function whose zeros are the event, and the meaning.

Event functions take a ``Motion``, as quantities do, and are smooth at the poles. A new event is one
new entry here. Any quantity has ``extremum:QUANTITY`` and ``zero:QUANTITY``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from tt_precise.mechanics import newton
from tt_precise.mechanics.formulations import WITHOUT_GLIDING
from tt_precise.mechanics.laws import VISCOUS, Law
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.vectors import Vector, dot
from tt_precise.runtime.values import InputError, Scalar, wrong_name

EXTREMUM, ZERO = "extremum:", "zero:"
ARRIVED = ("complete", "contact_ignored")  # statuses at the horizon of the scene

MOST_EVENTS = 1_000_000  # Largest number of events; bounds memory to 500 MB.


@dataclass(frozen=True)
class Event:
    """A named zero of ``function`` (dimensionless, along a motion).

    ``direction`` keeps only zeros where the function rises (+1) or falls (-1), 0 keeps both;
    ``gliding`` marks events that exist only where the contact point can glide; ``of_rate`` marks
    zeros of the function's rate along the motion; ``azimuth`` those that need the direction of the
    axis, as a user's may; ``smooth`` functions neither bend nor jump.
    """

    name: str
    function: Callable[[Motion], Scalar]
    meaning: str
    direction: int = 0
    gliding: bool = False
    of_rate: bool = False
    azimuth: bool = False
    smooth: bool = False


def axis_fall(q: Motion) -> Scalar:
    """I1 times the rate of cos theta: zero where theta turns."""
    return q.state.Lx * q.state.ky - q.state.Ly * q.state.kx


def precession(q: Motion) -> Scalar:
    """I1 phi_dot sin^2 theta = Lz - cos theta L.k, without the cancellation."""
    s = q.state
    return s.Lz * (s.kx * s.kx + s.ky * s.ky) - s.kz * (s.Lx * s.kx + s.Ly * s.ky)


def alignment(q: Motion, sign: int) -> Scalar:
    """L.k - sign L.z, which keeps its digits near either pole.

    With k.k = 1, 1 - sign cos theta is half of sin^2 + (1 - sign cos)^2, which is small without
    cancellation.
    """
    s = q.state
    below = 1 - sign * s.kz
    horizontal = s.Lx * s.kx + s.Ly * s.ky
    return horizontal - sign * s.Lz * (s.kx * s.kx + s.ky * s.ky + below * below) / 2


def along_tilt(vector: Vector, k: Vector) -> Scalar:
    """The horizontal component towards the tilt, times sin theta."""
    return vector[0] * k[0] + vector[1] * k[1]


def across_tilt(vector: Vector, k: Vector) -> Scalar:
    """The horizontal component across the tilt, times sin theta."""
    return vector[1] * k[0] - vector[0] * k[1]


def balance(q: Motion) -> Scalar:
    """xi sin^2 theta."""
    s = q.state
    return dot(s.L, q.k) * (s.kx * s.kx + s.ky * s.ky) - s.kz * precession(q)


def own_rotation(q: Motion) -> Scalar:
    """psi_dot I1 I3 sin^2 theta."""
    s, body = q.state, q.body
    spin = dot(s.L, q.k) * (s.kx * s.kx + s.ky * s.ky)
    return body.I1 * spin - body.I3 * s.kz * precession(q)


def force_slope(q: Motion) -> Scalar:
    """The rate of g_n times the positive denominator of eq (7), of a viscous top."""
    return newton.normal_force_slope(q.body, q.state)


_ALL = (
    Event("theta_min", axis_fall, "turning point: theta has a local minimum", -1),
    Event("theta_max", axis_fall, "turning point: theta has a local maximum", +1),
    Event("phi_dot_zero", precession, "phi_dot changes sign"),
    Event("nu_x_zero", lambda q: along_tilt(q.state.v, q.k), "nu_x changes sign", gliding=True),
    Event("nu_y_zero", lambda q: across_tilt(q.state.v, q.k), "nu_y changes sign", gliding=True),
    Event("nu_crossing", lambda q: across_tilt(q.state.v, q.k) - along_tilt(q.state.v, q.k),
          "nu_y crosses nu_x (rising: from below)", gliding=True),
    Event("equator", lambda q: q.state.kz, "theta crosses pi/2"),
    Event("omega_3_zero", lambda q: dot(q.state.L, q.k), "omega_3 changes sign"),
    Event("Lk_equals_Lz", lambda q: alignment(q, +1), "L.k = L.z"),
    Event("Lk_equals_minus_Lz", lambda q: alignment(q, -1), "L.k = -L.z"),
)  # fmt: skip
EVENTS = {event.name: replace(event, smooth=True) for event in _ALL}
TURNING = "turning points"  # Minima and maxima of theta, which alternate with each other.
CONTINUED = {TURNING, *(name for name, event in EVENTS.items() if not event.gliding)}

# Functions with the same changes of sign as a quantity, or the same extrema, that are smooth at the
# poles or at rest.
SMOOTH: dict[str, Callable[[Motion], Scalar]] = {
    "zero:theta_dot": lambda q: -axis_fall(q), "zero:phi_dot": precession,
    "zero:psi_dot": own_rotation, "zero:xi": balance,
    "zero:nu_x": EVENTS["nu_x_zero"].function, "zero:nu_y": EVENTS["nu_y_zero"].function,
    "zero:tau_x": lambda q: along_tilt(q.torque, q.k),
    "zero:tau_y": lambda q: across_tilt(q.torque, q.k),
    "zero:theta": lambda q: q.state.kx * q.state.kx + q.state.ky * q.state.ky,
    "extremum:theta": lambda q: -q.state.kz,
    "zero:gliding_speed": lambda q: q.state.vx * q.state.vx + q.state.vy * q.state.vy,
    "extremum:gliding_speed": lambda q: q.state.vx * q.state.vx + q.state.vy * q.state.vy,
}  # fmt: skip

TERMINAL = {
    "contact_lost": "g_n reaches 0: the top leaves the table and the model ends",
    "singular_contact": "the denominator of g_n reaches 0: the solution blows up",
    "landed": "a top that flew after contact was lost comes down; a rigid impact has no law here",
    "pole": "theta reaches 0 or pi, where Euler angles end (Euler form only)",
}

JOINING = {
    "stick": "Coulomb's friction: v_A reaches 0 and the top rolls on",
    "slip": "Coulomb's friction: the force of rolling reaches the cone and the top glides on",
    "lift_off": "g_n reaches 0 in a scene that flies on from there",
    "separation": "elastic table: the normal force reaches 0",
    "landing": "elastic table: the lowest point comes down to the table",
}
# Ends of a phase on the table after which the top is in the air.
LEAVES = ("contact_lost", "lift_off", "separation")


def catalogue(model: str) -> tuple[str, ...]:
    """Names of all events that ``model`` can have, without events of quantities."""
    return tuple(name for name, event in EVENTS.items() if model == "gliding" or not event.gliding)


Asked = str | Event
"""An event of the catalogue by name, or one's own."""


def change(name: str, direction: int) -> str:
    """An event in a word: minimum or maximum, up or down; "" for events that join pieces."""
    if name in JOINING:
        return ""
    if name.startswith(EXTREMUM):
        return "minimum" if direction > 0 else "maximum"
    if name == "equator":  # cos theta falls where theta rises
        direction = -direction
    kinds = {"theta_min": "minimum", "theta_max": "maximum"}
    return kinds.get(name, "up" if direction > 0 else "down")


def existing(names: Iterable[Asked], model: str) -> tuple[Asked, ...]:
    """Return the events of ``names`` that ``model`` can have."""
    others = [name for name in EVENTS if name not in catalogue(model)]
    return tuple(name for name in names if name not in others)


def event_named(name: Asked, model: str, law: Law = VISCOUS) -> Event:
    """The event called ``name``, or the extremum or zero of a quantity; an ``Event`` unchanged.

    Raises ``InputError``: there is no such event, or not in this model.
    """
    if isinstance(name, Event):
        return name
    if name in JOINING:
        raise InputError(
            f"event: got {name}, expected no such name: it is recorded wherever it happens"
        )
    if name in EVENTS:
        event = EVENTS[name]
        if event.gliding and model in WITHOUT_GLIDING:
            raise InputError(f"event: got {name} in a {model} scene, expected no gliding event")
        return event
    quantity = QUANTITIES.get(name.partition(":")[2])
    if quantity and name.startswith((ZERO, EXTREMUM)):
        function = SMOOTH.get(name, quantity.evaluate)
        if name.startswith(ZERO):
            return Event(name, function, f"{quantity.name} changes sign", azimuth=quantity.azimuth)
        meaning = f"extremum of {quantity.name} (rising: minimum)"
        if quantity.name == "g_n" and model == "gliding" and law.constant:
            # five times smaller than the derivative of g_n by every state entry
            return Event(name, force_slope, meaning)
        return Event(name, function, meaning, of_rate=True, azimuth=quantity.azimuth)
    also = (
        f", or {EXTREMUM}QUANTITY or {ZERO}QUANTITY of the catalogue such as {EXTREMUM}g_n, "
        "or one's own function itself for its zeros, tt.quantity(function) for its extrema"
    )
    raise wrong_name("event", name, EVENTS, also)


def not_alternating(happened: Iterable[tuple[str, int]]) -> tuple[str, ...]:
    """Events that rise or fall twice in a row among ``happened`` (name, direction, in order)."""
    last, missed = dict[str, int](), dict[str, None]()
    for name, direction in happened:
        kind = TURNING if name in ("theta_min", "theta_max") else name
        if name in JOINING:  # forces, and gliding after a rest, do not continue those before
            last = {n: way for n, way in last.items() if n in CONTINUED}
            continue
        if direction in (0, last.get(kind)):
            missed[kind] = None
        last[kind] = direction
    return tuple(missed)
