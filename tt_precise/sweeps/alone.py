"""One row from one run: scenes that SIMD lanes cannot integrate, and the spot check.

The columns are those of ``columns``, from the events and states of a trajectory in any arithmetic.
At a mode switch, where a quantity may jump, both sides count.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration.dense_output import ARRIVED
from tt_precise.integration.inversion import NEEDED, InversionTimes
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import ended_at_start
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.quantities import QUANTITIES, jellett
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.runtime.values import Array, InputError, Json, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LiftedStart
from tt_precise.sweeps.columns import (
    DEFINITIONS,
    FIXED,
    Statistic,
    extremum,
    outcomes,
    statistics,
    turning_events,
)

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

# Part of a time, and of 1 s, by which both sides of a mode switch are read beside it: far more than
# the rounding of its time.
BESIDE = Fraction(1, 10**12)
DOUBLE = precision_named("double")


def in_lanes(scene: Scene) -> bool:
    """True for scenes of SIMD lanes: smooth equations of viscous friction, or rolling."""
    return scene.body.friction.constant and not scene.in_pieces


def columns_alone(
    scenes: Iterable[Scene], record: tuple[str, ...], contact: str
) -> dict[str, Array]:
    """The columns of results of scenes, one row a scene; a refused scene is "failed"."""
    rows = []
    for scene in scenes:
        try:
            rows.append(row_of(scene, record, contact))
        except InputError:
            rows.append({"outcome": "failed", "steps": 0, "t_stop": 0.0})
    columns: dict[str, Array] = {}
    for name in (*FIXED, *record):
        values = [row.get(name) for row in rows]
        if name == "outcome":
            columns[name] = values
        elif name == "steps":
            columns[name] = numpy.array(values, dtype=numpy.int64)
        else:
            columns[name] = numpy.array(values, dtype=float)
    return columns


def row_of(
    scene: Scene,
    record: tuple[str, ...],
    contact: str = "unilateral",
    precision: str = "double",
    tolerance: float = 0.0,
) -> dict[str, Json]:
    """The columns of a row from a run in ``precision``: "outcome", and numbers rounded to double.

    A value that does not exist is None; of a start that the model does not cover only the outcome,
    the smallest force and where it ends exist.

    Raises ``InputError``: the scene cannot be integrated so.
    """
    from tt_precise.integration import integrate  # which a worker with lanes does not load

    start = InitialState.of(scene, DOUBLE.arithmetic)
    lifted = isinstance(scene.start, LiftedStart)
    ended = None if lifted else ended_at_start(start, contact, DOUBLE.context)
    if ended:
        force = QUANTITIES["g_n"]
        least = force.evaluate(start.motion(DOUBLE.context))
        unit = start.units.of_dimension(force.dimension)
        return {"outcome": ended, "min_g_n": float(least * unit), "t_stop": 0.0, "steps": 0}
    run = integrate(
        scene,
        precision,
        events=_events(record),
        record=(),
        contact=contact,
        tolerance=tolerance,
    )
    times = run.inversion
    results: dict[str, Any] = {
        "outcome": _outcome(run, scene, times, contact),
        **times.times,
        "jellett_drift": _drift(run, times),
        "steps": run.steps,
        "t_stop": run.t_end,
        "t_equator": times.equator,
        "lambda_ratio": _lambda_ratio(run),
        **{f"climb_{d}": getattr(times, d).duration for d in DEFINITIONS},
    }
    if {"nu_crossing_init", "nu_crossing_end"} & set(record):
        results |= _crossings(run, times)
    for statistic in statistics(record):
        results[f"{statistic.kind}_{statistic.quantity}"] = _evaluate(run, scene, statistic)
    wanted = {*FIXED, *record}
    return {
        name: value if isinstance(value, str | int) or value is None else float(value)
        for name, value in results.items()
        if name in wanted
    }


def _events(record: tuple[str, ...]) -> tuple[str, ...]:
    extremes = {one.quantity for one in statistics(record) if one.extreme} - {"theta"}
    crossing = {"nu_crossing_init", "nu_crossing_end"} & set(record)
    wanted = (*NEEDED, *(extremum(name) for name in sorted(extremes)))
    return (*wanted, "nu_crossing") if crossing else wanted


def _outcome(run: Trajectory, scene: Scene, times: InversionTimes, contact: str) -> str:
    if run.status not in ARRIVED:
        return str(run.status)
    theta, energy, lambda_ = (
        run.frame(name, times=[run.t_end])[name].to_numpy(dtype=float)
        for name in ("theta", "E", "lambda")
    )
    # an elastic table stores energy; in flight the bound holds too, but nobody has needed it
    falling = (contact == "unilateral" or scene.model == "rolling") and not scene.lifts
    crossed = numpy.array([times.equator is not None])
    body = scene.body.numbers(float)
    (outcome,) = outcomes(body, numpy.cos(theta), lambda_, energy, crossed, falling)
    return outcome


def _drift(run: Trajectory, times: InversionTimes) -> float:
    """The largest relative change of lambda at the events and times that ``columns`` names."""
    table = run.event_table(("lambda",), at=("theta_min", "theta_max"))
    ends = run.frame("lambda", times=[0, run.t_end], numbers="exact")["lambda"].tolist()
    values, climb = [ends[1]], math.inf if times.equator is None else times.equator
    for name, t, value in zip(table["name"], table["t"], table["lambda"], strict=True):
        if (name == "theta_min" and t < climb) or (name == "theta_max" and t > climb):
            values.append(value)
    scale = INTEGRALS["jellett"].scale(run.start.motion(run.precision.context)) or 1
    unit = run.start.units.of_dimension(QUANTITIES["lambda"].dimension)
    return float(max(abs(value - ends[0]) for value in values) / (scale * unit))


def _lambda_ratio(run: Trajectory) -> Scalar:
    q = run.start.motion(run.precision.context)
    if not q.body.gamma < 1 + q.body.alpha:
        return None
    return jellett(q) / lambda_thres(q.body, run.precision.context)


def _crossings(run: Trajectory, times: InversionTimes) -> Mapping[str, Scalar]:
    """The crossings of nu_y and nu_x next to the climb: rising before, falling after the climb."""
    table, climb = run.event_table(()), times.equator
    if climb is None:
        return {}
    rows = list(zip(table["name"], table["t"], table["direction"], strict=True))
    before = [t for name, t, way in rows if name == "nu_crossing" and way > 0 and t < climb]
    after = [t for name, t, way in rows if name == "nu_crossing" and way < 0 and t > climb]
    return {
        "nu_crossing_init": before[-1] if before else None,
        "nu_crossing_end": after[0] if after else None,
    }


def _evaluate(run: Trajectory, scene: Scene, statistic: Statistic) -> Scalar:
    """The value of a quantity at the start or the end, or its smallest or largest value."""
    end = run.sample_times[-1]
    switches = [as_fraction(piece.begin) for piece in run.pieces[1:]] if statistic.extreme else []
    sides = [begin + way * BESIDE * (1 + begin) for begin in switches for way in (-1, 1)]
    sides = [t for t in sides if 0 < t < end]
    frame = run.frame(statistic.quantity, times=[0, *sides, end], numbers="exact")
    values = [value for value in frame[statistic.quantity].tolist() if _exists(value)]
    if not statistic.extreme:
        known = frame[statistic.quantity].tolist()
        return known[0] if statistic.kind == "start" else known[-1]
    lost = run.status == "contact_lost" or any(piece.model == "flight" for piece in run.pieces)
    if statistic.quantity == "g_n" and lost:
        values.append(0.0)  # there is no force in flight, and none where it begins
        values = [max(value, 0.0) for value in values]
    inner = run.event_table((statistic.quantity,), at=turning_events(statistic.quantity))
    values += [value for value in inner[statistic.quantity] if _exists(value)]
    return None if not values else min(values) if statistic.kind == "min" else max(values)


def _exists(value: Scalar) -> bool:
    return value is not None and value == value
