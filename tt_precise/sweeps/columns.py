"""The columns of a sweep, and the row of one run.

``FIXED`` columns stand in every row, others by name: ``DERIVED`` ones, and ``min_Q``, ``max_Q``,
``start_Q``, ``end_Q`` of any quantity Q. The outcome is a statement about the state at the end.
Extrema come from the Taylor polynomials of the steps and both ends, never from samples.
docs/howto/sweeps.md explains each.

A row comes from one run where lanes cannot integrate the motion, and again in a finer arithmetic.
At a mode switch, where a quantity may jump, both sides count.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy

from tt_precise.integration.events import EXTREMUM, event_named
from tt_precise.integration.inversion import NEEDED, InversionTimes
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import ended_at_start, refused_in_doubles
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, jellett
from tt_precise.mechanics.thresholds import energy_excludes, lambda_thres
from tt_precise.runtime.values import Array, InputError, Json, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState, Scene
from tt_precise.scene.start import LiftedStart

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

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
    outcome = numpy.where(excluded, "does_not_invert", "undecided")
    return numpy.where(crossed & (z < 0), "inverts", outcome).tolist()


# ---- the row of one run -------------------------------------------------------------------------

# Part of a time, and of 1 s, at which both sides of a mode switch are read: far more than the
# rounding of its time.
ASIDE = Fraction(1, 10**12)
FINE_TOLERANCE = 1e-22  # A million times finer than double, in half the time of full accuracy.
DOUBLE = precision_named("double")


def rows_of(scenes: Iterable[Scene], record: tuple[str, ...], contact: str) -> dict[str, Array]:
    """Return the columns of the rows of scenes, one by one; a refused scene has failed."""
    rows = []
    for scene in scenes:
        try:
            rows.append(row_of(scene, record, contact))
        except InputError:
            rows.append({"outcome": "failed", "steps": 0, "t_stop": 0.0})
    kinds = {"outcome": object, "steps": numpy.int64}
    return {
        name: numpy.array([row.get(name) for row in rows], dtype=kinds.get(name, float))
        for name in (*FIXED, *record)
    }


def fine_row_of(
    scene: Scene, record: tuple[str, ...], contact: str = "unilateral"
) -> dict[str, Json]:
    """Return the columns of a row from another integrator, in a finer arithmetic."""
    precision = "quad" if refused_in_doubles(scene) else "double-double"
    return row_of(scene, record, contact, precision=precision, tolerance=FINE_TOLERANCE)


def row_of(
    scene: Scene, record: tuple[str, ...], contact: str = "unilateral", **arithmetic: Any
) -> dict[str, Json]:
    """Return the columns of a row: "outcome", and numbers rounded to double, None if undefined.

    ``arithmetic`` are the arguments ``precision`` and ``tolerance`` of ``integrate``. A start
    without contact has only its outcome, its force and its end.

    Raises ``InputError``: the scene cannot be integrated.
    """
    from tt_precise.integration import integrate  # a worker with lanes does not need it

    start = InitialState.of(scene, DOUBLE.arithmetic)
    lifted = isinstance(scene.start, LiftedStart)
    ended = None if lifted else ended_at_start(start, contact, DOUBLE.context)
    if ended:
        force = QUANTITIES["g_n"]
        unit = start.units.of_dimension(force.dimension)
        least = float(force.evaluate(start.motion(DOUBLE.context)) * unit)
        return {"outcome": ended, "min_g_n": least, "t_stop": 0.0, "steps": 0}
    run = integrate(scene, events=events_of_run(record), record=(), contact=contact, **arithmetic)
    times, q = run.inversion, run.start.motion(run.precision.context)
    threshold = lambda_thres(q.body, q.fn) if q.body.gamma < 1 + q.body.alpha else None
    table = run.event_table(())
    events = zip(table["name"], table["t"], table["direction"], strict=True)
    crossings = [(t, way > 0) for name, t, way in events if name == "nu_crossing"]
    columns: dict[str, Any] = {
        "outcome": _outcome(run, scene, times, contact),
        **times.times,
        "jellett_drift": run.drift["jellett"],
        "steps": run.steps,
        "t_stop": run.t_end,
        "t_equator": times.equator,
        "lambda_ratio": None if threshold is None else jellett(q) / threshold,
        **dict(zip(CROSSINGS, neighbours(crossings, times.equator), strict=True)),
        **{f"climb_{d}": getattr(times, d).duration for d in DEFINITIONS},
        **{f"{x.kind}_{x.quantity}": _value(run, x) for x in statistics(record)},
    }
    return {
        name: value if isinstance(value, str | int | None) else float(value)
        for name, value in columns.items()
        if name in FIXED or name in record
    }


def _outcome(run: Trajectory, scene: Scene, times: InversionTimes, contact: str) -> str:
    if run.status in OUTCOMES:
        return str(run.status)
    end = run.frame("theta", "E", "lambda", times=[run.t_end]).astype(float)
    # an elastic table stores energy, and so does height in flight
    falling = (contact == "unilateral" or scene.model == "rolling") and not scene.lifts
    theta, lambda_, energy = (end[name].to_numpy() for name in ("theta", "lambda", "E"))
    crossed, body = numpy.array([times.equator is not None]), scene.body.numbers(float)
    return outcomes(body, numpy.cos(theta), lambda_, energy, crossed, falling)[0]


def _value(run: Trajectory, statistic: Statistic) -> Scalar:
    """Return a quantity at the start or the end, or its extreme value."""
    name, end = statistic.quantity, run.sample_times[-1]
    switches = [as_fraction(piece.begin) for piece in run.pieces[1:]] if statistic.extreme else []
    sides = [t + way * ASIDE * (1 + t) for t in switches for way in (-1, 1)]
    times = [0, *(t for t in sides if 0 < t < end), end]
    values = run.frame(name, times=times, numbers="exact")[name].tolist()
    if not statistic.extreme:
        return values[0 if statistic.kind == "start" else -1]
    turns = ("theta_min", "theta_max") if name == "theta" else (f"{EXTREMUM}{name}",)
    table = run.event_table((name,))
    values += [v for event, v in zip(table["name"], table[name], strict=True) if event in turns]
    values = [value for value in values if value is not None and value == value]
    flight = any(piece.model == "flight" for piece in run.pieces)
    if name == "g_n" and (flight or run.status == "contact_lost"):
        values = [max(value, 0.0) for value in (*values, 0.0)]  # there is no force in flight
    return None if not values else min(values) if statistic.kind == "min" else max(values)
