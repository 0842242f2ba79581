"""The columns of a sweep: which exist, what they mean, and which events they need.

Every row has ``FIXED``. Further ones are asked for by name: ``climb_A``, ``climb_B``, ``climb_C``
(climbing time t_end - t_init), ``t_equator`` (theta first rises through pi/2), ``lambda_ratio``
(lambda/lambda_thres), ``nu_crossing_init`` and ``nu_crossing_end`` (nu_y crosses nu_x around the
climb), and ``min_Q``, ``max_Q``, ``start_Q``, ``end_Q`` of any quantity Q. Extrema
are events of the integration together with both ends, never samples; the smallest g_n and the
turning points of theta are read off the Taylor polynomials of the steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from tt_precise.integration.events import EXTREMUM, Event, axis_fall, event_named
from tt_precise.integration.inversion import NEEDED
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError

DEFINITIONS = ("A", "B", "C")
TIMES = tuple(f"{when}_{which}" for when in ("t_init", "t_end") for which in DEFINITIONS)
FIXED = {
    "outcome": "what became of the top; see ``outcome``",
    **dict.fromkeys(TIMES, "initiation or ending time of the climb in one definition, s"),
    "min_g_n": "smallest normal force from the start to t_stop, N",
    "jellett_drift": "largest relative change of lambda: at t_stop, at minima of theta before the "
    "climb, at maxima after it",
    "steps": "Taylor steps",
    "t_stop": "where the trajectory ends, s",
}
DERIVED = {
    **{f"climb_{which}": f"climbing time in definition {which}, s" for which in DEFINITIONS},
    "t_equator": "when theta first rises through pi/2, s",
    "lambda_ratio": "lambda/lambda_thres",
    "nu_crossing_init": "when nu_y last rises through nu_x before t_equator, s",
    "nu_crossing_end": "when nu_y first falls through nu_x after t_equator, s",
}
NU_RISES, NU_FALLS = "nu_y rises through nu_x", "nu_y falls through nu_x"
PARTS = ("min", "max", "start", "end")


class ClimbSide(Enum):
    """Which zeros next to the climb initiation and ending times depend on."""

    FIRST = "the first one, which is the climb"
    BEFORE = "the last one before the climb"
    AFTER = "the first one after it"
    BOTH = "the last one before it and the first one after it"


SIDES = {
    "equator": ClimbSide.FIRST,
    "phi_dot_zero": ClimbSide.BOTH,
    "Lk_equals_Lz": ClimbSide.BEFORE,
    "Lk_equals_minus_Lz": ClimbSide.AFTER,
}


@dataclass(frozen=True)
class Part:
    """One asked-for value of a quantity along a trajectory, such as its minimum."""

    part: str
    quantity: str

    @property
    def extreme(self) -> bool:
        """Whether it needs events."""
        return self.part in ("min", "max")


@dataclass(frozen=True)
class Detector:
    """One event function that is looked for, for all the events that share it.

    ``rising`` and ``falling`` name the event at a zero in that direction, "" where none is asked.
    ``every`` is False where only those are needed that initiation and ending times depend on.
    """

    event: Event
    rising: str
    falling: str
    every: bool = True

    @property
    def stateful(self) -> bool:
        """Whether the states at its events are needed, not only the times."""
        return self.event.name.startswith((EXTREMUM, "theta_"))

    @property
    def turning(self) -> bool:
        """Whether it is where theta turns, which is read off the series of the steps."""
        return self.event.function is axis_fall

    @property
    def side(self) -> ClimbSide | None:
        """Which zeros are needed, None for all; these are looked for in few steps."""
        return SIDES.get(self.event.name)

    @property
    def direction(self) -> int:
        """Direction in which zeros are looked for; 0 is both."""
        return bool(self.rising) - bool(self.falling)


SMALLEST_FORCE = Part("min", "g_n")  # every row has it, read off the series of the steps


def part_named(name: str) -> Part | None:
    """The part of a quantity that a column name asks for, if it is of that kind."""
    part, _, quantity = name.partition("_")
    return Part(part, quantity) if part in PARTS and quantity in QUANTITIES else None


def check_names(record: tuple[str, ...], model: str) -> None:
    """Refuse columns that do not exist.

    Raises
    ------
    InputError
        Unknown, twice, or one that every row has.
    """
    for name in record:
        if name in FIXED or record.count(name) > 1:
            raise InputError(f"record: got {name}, which the rows have already; expected others")
        if name not in DERIVED and part_named(name) is None:
            raise InputError(
                f"record: got {name[:60]!r}, expected one of: {', '.join(DERIVED)}, or min_, max_, "
                "start_, end_ and a quantity, such as max_nu_y"
            )
    detectors(record, model)


def parts(record: tuple[str, ...]) -> tuple[Part, ...]:
    """All parts of quantities that the rows need, the smallest g_n first."""
    asked = (part_named(name) for name in record)
    return (SMALLEST_FORCE, *(part for part in asked if part))


def extremum(quantity: str) -> str:
    """The event at the extrema of a quantity."""
    return f"{EXTREMUM}{quantity}"


def turning_events(quantity: str) -> tuple[str, ...]:
    """The events among which the extrema of a quantity are."""
    return ("theta_min", "theta_max") if quantity == "theta" else (extremum(quantity),)


def detectors(record: tuple[str, ...], model: str) -> tuple[Detector, ...]:
    """The event functions to look for; theta's extrema are its turning points."""
    found: list[Detector] = []
    wanted: dict[Callable[[Motion], Scalar], list[Event]] = {}
    for name in NEEDED:
        event = event_named(name, model)
        wanted.setdefault(event.function, []).append(event)
    for events in wanted.values():
        rising = next((event.name for event in events if event.direction >= 0), "")
        falling = next((event.name for event in events if event.direction <= 0), "")
        if events[0].name == "equator":  # the climb: cos theta falls
            rising = ""
        every = events[0].function is not axis_fall or any(
            part.extreme and part.quantity == "theta" for part in parts(record)
        )
        found.append(Detector(events[0], rising, falling, every))
    if {"nu_crossing_init", "nu_crossing_end"} & set(record):
        found.append(Detector(event_named("nu_crossing", model), NU_RISES, NU_FALLS))
    extreme = [
        part
        for part in parts(record)
        if part.extreme and part.quantity != "theta" and part != SMALLEST_FORCE
    ]
    for quantity in dict.fromkeys(part.quantity for part in extreme):
        asked = {part.part for part in extreme if part.quantity == quantity}
        name = extremum(quantity)
        found.append(
            Detector(
                event_named(name, model),
                name if "min" in asked else "",
                name if "max" in asked else "",
            )
        )
    return tuple(found)
