"""The columns of a sweep: ``FIXED`` in every row, and others by name.

The outcome is a statement about the state at the end. Extra columns are ``DERIVED`` ones, and
``min_Q``, ``max_Q``, ``start_Q``, ``end_Q`` of any quantity Q. Extrema come from the Taylor
polynomials of the steps and both ends, never from samples. docs/howto/sweeps.md explains each.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy

from tt_precise.integration.events import EXTREMUM, event_named
from tt_precise.integration.inversion import NEEDED
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.mechanics.thresholds import energy_excludes
from tt_precise.runtime.values import Array, InputError, Scalar

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
FIXED = ("outcome", *TIMES, "min_g_n", "jellett_drift", "steps", "t_stop")
CROSSINGS = ("nu_crossing_init", "nu_crossing_end")
DERIVED = (*(f"climb_{which}" for which in DEFINITIONS), "t_equator", "lambda_ratio", *CROSSINGS)
STATISTICS = ("min", "max", "start", "end")
CLIMB_EVENTS = ("equator", "theta_min", "phi_dot_zero", "Lk_equals_Lz", "Lk_equals_minus_Lz")


class Statistic(NamedTuple):
    """A requested value of a quantity along a trajectory, such as its minimum."""

    kind: str
    quantity: str

    @property
    def extreme(self) -> bool:
        """True for a least or largest value, which needs events."""
        return self.kind in ("min", "max")


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
            raise InputError(
                f"record: got {name!r}, expected {', '.join(DERIVED)}, or min_, max_, start_, end_ "
                "and a quantity, such as max_nu_y"
            )
    for name in events_of_run(record):
        event_named(name, model)


def statistics(record: tuple[str, ...]) -> tuple[Statistic, ...]:
    """All statistics that the rows need, the smallest g_n first."""
    named = (statistic_named(name) for name in record)
    return (SMALLEST_FORCE, *(statistic for statistic in named if statistic))


def event_names(record: tuple[str, ...]) -> tuple[str, ...]:
    """The events on which the columns depend; turning points of theta are in ``theta_min``."""
    return (*CLIMB_EVENTS, *(("nu_crossing",) if {*CROSSINGS} & {*record} else ()))


def events_of_run(record: tuple[str, ...]) -> tuple[str, ...]:
    """The events of a run from which all columns of its row follow."""
    extrema = (f"{EXTREMUM}{each.quantity}" for each in extremes(record))
    return tuple(dict.fromkeys((*NEEDED, *event_names(record), *extrema)))


def extremes(record: tuple[str, ...]) -> tuple[Statistic, ...]:
    """The extreme values that the rows need, but for those of theta, at its turning points."""
    return tuple(each for each in statistics(record) if each.extreme and each.quantity != "theta")


def neighbours(crossings: Iterable[tuple[Scalar, bool]], climb: Scalar) -> tuple[Scalar, Scalar]:
    """Return the last rising crossing (time, rising) before the climb, the first falling after."""
    marks = [] if climb is None else [*crossings]
    before = [t for t, rising in marks if rising and t < climb]
    after = [t for t, rising in marks if not rising and t > climb]
    return before[-1] if before else None, after[0] if after else None


def outcomes(
    body: Parameters, z: Array, lambda_: Array, energy: Array, crossed: Array, falling: bool = True
) -> list[str]:
    """The outcomes of tops that kept contact.

    ``z``, ``lambda_`` and ``energy`` are cos theta, Jellett's integral and energy of each top at
    the end, in its units. ``crossed``: theta has risen through pi/2. ``falling``: the energy can
    only fall from there; with g_n < 0 it may rise.
    """
    with numpy.errstate(all="ignore"):
        excluded = energy_excludes(body, energy + SURE * numpy.abs(energy), lambda_, z) & falling
    names = numpy.where(excluded, "does_not_invert", "undecided")
    return numpy.where(crossed & (z < 0), "inverts", names).tolist()
