"""One row from one run: motions that lanes cannot integrate, and rows again in a finer arithmetic.

The columns are those of the lanes, from the events and states of a trajectory in any arithmetic. At
a mode switch, where a quantity may jump, both sides count.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration.events import EXTREMUM
from tt_precise.integration.inversion import InversionTimes
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import ended_at_start, refused_in_doubles
from tt_precise.mechanics.quantities import QUANTITIES, jellett
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.runtime.values import Array, InputError, Json, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState, Scene
from tt_precise.scene.start import LiftedStart
from tt_precise.sweeps import columns as names
from tt_precise.sweeps.columns import Statistic

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

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
        for name in (*names.FIXED, *record)
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
    run = integrate(
        scene, events=names.events_of_run(record), record=(), contact=contact, **arithmetic
    )
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
        **dict(zip(names.CROSSINGS, names.neighbours(crossings, times.equator), strict=True)),
        **{f"climb_{d}": getattr(times, d).duration for d in names.DEFINITIONS},
        **{f"{x.kind}_{x.quantity}": _value(run, x) for x in names.statistics(record)},
    }
    return {
        name: value if isinstance(value, str | int | None) else float(value)
        for name, value in columns.items()
        if name in names.FIXED or name in record
    }


def _outcome(run: Trajectory, scene: Scene, times: InversionTimes, contact: str) -> str:
    if run.status in names.OUTCOMES:
        return str(run.status)
    end = run.frame("theta", "E", "lambda", times=[run.t_end]).astype(float)
    # an elastic table stores energy, and so does height in flight
    falling = (contact == "unilateral" or scene.model == "rolling") and not scene.lifts
    theta, lambda_, energy = (end[name].to_numpy() for name in ("theta", "lambda", "E"))
    crossed, body = numpy.array([times.equator is not None]), scene.body.numbers(float)
    return names.outcomes(body, numpy.cos(theta), lambda_, energy, crossed, falling)[0]


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
