"""The columns of a sweep, with their meanings and the events on which they depend.

Every row has ``FIXED``. Extra columns are requested by name: ``climb_A``, ``climb_B``,
``climb_C`` (climbing time t_end - t_init), ``t_equator`` (theta first rises through pi/2),
``lambda_ratio`` (lambda/lambda_thres), ``nu_crossing_init`` and ``nu_crossing_end`` (nu_y crosses
nu_x around the climb), and ``min_Q``, ``max_Q``, ``start_Q``, ``end_Q`` of any quantity Q. Extrema
come from the Taylor polynomials of the steps and both ends, never from samples.

The outcome is a statement about the state at the end (``OUTCOMES``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy

from tt_precise.integration.events import EXTREMUM, Event, axis_fall, event_named
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.mechanics.thresholds import energy_excludes
from tt_precise.runtime.values import Array, InputError, wrong_name

OUTCOMES = {
    "inverts": "equator passed, and below it at the end",
    "does_not_invert": "equator never passed: energy and lambda at the end exclude it",
    "undecided": "equator not passed by the horizon, or the axis is above it again",
    "contact_lost": "the normal force g_n reached 0",
    "singular_contact": "the denominator of g_n reached 0",
    "landed": "the top came down after a flight; a rigid impact has no law here",
    "failed": "the integration failed",
}
SURE = 2.0**-40  # Part of the energy that exceeds its rounding errors by far.
DEFINITIONS = ("A", "B", "C")
TIMES = tuple(f"{when}_{which}" for when in ("t_init", "t_end") for which in DEFINITIONS)
FIXED = {
    "outcome": ", ".join(OUTCOMES),
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
STATISTICS = ("min", "max", "start", "end")


@dataclass(frozen=True)
class Statistic:
    """A requested value of a quantity along a trajectory, such as its minimum."""

    kind: str
    quantity: str

    @property
    def extreme(self) -> bool:
        """True for a least or largest value, which needs events."""
        return self.kind in ("min", "max")


@dataclass(frozen=True)
class Detector:
    """An event function whose zeros are searched.

    ``before`` is the direction of the wanted zeros before the climb (+1 rising, -1 falling, 0 both,
    None: no zeros), ``after`` the same after the climb: the zeros next to the climb, or all zeros
    if ``turning``. The first detector is that of the climb. ``every`` requests all zeros
    everywhere.
    """

    event: Event
    before: int | None = None
    after: int | None = None
    every: bool = False

    @property
    def turning(self) -> bool:
        """True for turning points of theta, whose states are needed too."""
        return self.event.function is axis_fall


SMALLEST_FORCE = Statistic("min", "g_n")  # every row has it, computed from the series of the steps


def statistic_named(name: str) -> Statistic | None:
    """Return the statistic that a column name requests, if any."""
    kind, _, quantity = name.partition("_")
    return Statistic(kind, quantity) if kind in STATISTICS and quantity in QUANTITIES else None


def check_names(record: tuple[str, ...], model: str) -> None:
    """Refuse columns that do not exist.

    Raises ``InputError``: a column is unknown, named twice, or a default column.
    """
    for name in record:
        if name in FIXED or record.count(name) > 1:
            raise InputError(f"record: got {name} twice or as a default column, expected it once")
        if name not in DERIVED and statistic_named(name) is None:
            also = ", or min_, max_, start_, end_ and a quantity, such as max_nu_y"
            statistics = (f"{kind}_{name}" for kind in STATISTICS for name in QUANTITIES)
            raise wrong_name("record", name, DERIVED, also, further=statistics)
    detectors(record, model)
    for statistic in extremes(record):
        event_named(extremum(statistic.quantity), model)


def statistics(record: tuple[str, ...]) -> tuple[Statistic, ...]:
    """All statistics that the rows need, the smallest g_n first."""
    named = (statistic_named(name) for name in record)
    return (SMALLEST_FORCE, *(statistic for statistic in named if statistic))


def extremum(quantity: str) -> str:
    """The event at the extrema of a quantity."""
    return f"{EXTREMUM}{quantity}"


def turning_events(quantity: str) -> tuple[str, ...]:
    """The events that include the extrema of a quantity."""
    return ("theta_min", "theta_max") if quantity == "theta" else (extremum(quantity),)


def detectors(record: tuple[str, ...], model: str) -> tuple[Detector, ...]:
    """The event functions to search; theta's extrema are its turning points."""
    every = any(one.extreme and one.quantity == "theta" for one in statistics(record))
    # minima of theta before the climb, maxima after it
    wanted = [("equator", None, None), ("theta_min", -1, 1), ("phi_dot_zero", 0, 0)]
    wanted += [("Lk_equals_Lz", 0, None), ("Lk_equals_minus_Lz", None, 0)]
    if {"nu_crossing_init", "nu_crossing_end"} & set(record):
        wanted.append(("nu_crossing", 1, -1))
    return tuple(
        Detector(event_named(name, model), before, after, every and name == "theta_min")
        for name, before, after in wanted
    )


def extremes(record: tuple[str, ...]) -> tuple[Statistic, ...]:
    """The extreme values to search in the steps, the smallest g_n first."""
    wanted = (one for one in statistics(record) if one.extreme and one.quantity != "theta")
    return tuple(dict.fromkeys(wanted))


def outcomes(
    body: Parameters,
    z: Array,
    lambda_: Array,
    energy: Array,
    crossed: Array,
    falling: bool = True,
) -> list[str]:
    """The outcomes of tops that kept contact.

    ``body`` holds numbers, or an array with a body for each top; ``z``, ``lambda_`` and ``energy``
    are cos theta, Jellett's integral and energy of each top at the end, in its units. ``crossed``:
    theta has risen through pi/2. ``falling``: the energy can only fall from there; with g_n < 0 it
    may rise.
    """
    with numpy.errstate(all="ignore"):
        held = energy_excludes(body, energy + SURE * numpy.abs(energy), lambda_, z) & falling
    names = numpy.where(held, "does_not_invert", "undecided")
    return numpy.where(crossed & (z < 0), "inverts", names).tolist()
