"""The spot check: some rows are integrated again in a finer arithmetic, and compared.

One row in a thousand, drawn with the sweep's seed. In double-double, by the integrator of
``taylor``, which shares only the equations with heyoka; in quad if it cannot integrate a scene. The
arithmetic, the lanes, the step sizes and the evaluation differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.integration.inversion import NEEDED
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import ended_at_start, refused_in_doubles
from tt_precise.runtime.values import Json
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene
from tt_precise.sweeps.columns import DEFINITIONS, TIMES, extremum, outcomes, parts, turning_events
from tt_precise.taylor.graph import ArcTangentError

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

ONE_IN = 1000
FINE, WHERE_REFUSED = "double-double", "quad"
TOLERANCE = 1e-22  # a million times finer than double, in half the time of the tolerance eps


def drawn(rows: int, seed: int, one_in: int = ONE_IN) -> Iterator[int]:
    """Indices of the rows to recompute: one of each ``one_in``, in order."""
    for block in range(-(-rows // one_in) if one_in else 0):
        size = min(one_in, rows - block * one_in)
        yield block * one_in + int(numpy.random.default_rng([seed, block]).integers(size))


def recomputed(scene: Scene, record: tuple[str, ...]) -> dict[str, Json]:
    """A row's results from a fine integration: "outcome", and floats (None: there is none).

    The numbers are rounded to double at the very end. Only for contact "unilateral".
    """
    extremes = {part.quantity for part in parts(record) if part.extreme} - {"theta"}
    events = (*NEEDED, *(extremum(name) for name in sorted(extremes)))
    double = precision_named("double")
    start = InitialState.of(scene, double.arithmetic)
    ended = ended_at_start(start, "unilateral", double.context)
    if ended:
        return {"outcome": ended, "t_stop": 0.0}
    run = _integrated(scene, events)
    times = run.inversion
    results: dict[str, Json] = {
        **times.times,
        **{f"climb_{d}": getattr(times, d).duration for d in DEFINITIONS},
        "t_stop": run.t_end,
        "t_equator": times.equator,
    }
    for part in parts(record):
        frame = run.frame(part.quantity, times=[0, run.t_end], numbers="exact")
        ends = frame[part.quantity].tolist()
        chosen = dict(zip(("start", "end"), ends, strict=True))
        if part.extreme:
            inner = run.event_table((part.quantity,), at=turning_events(part.quantity))
            known = [value for value in (*ends, *inner[part.quantity]) if value is not None]
            chosen |= {"min": min(known), "max": max(known)}
        results[f"{part.part}_{part.quantity}"] = chosen[part.part]
    results["outcome"] = run.status
    if run.status == "complete":
        theta, energy, lambda_ = (
            run.frame(name, times=[run.t_end])[name].to_numpy(dtype=float)
            for name in ("theta", "E", "lambda")
        )
        crossed = numpy.array([times.equator is not None])
        body = scene.body.numbers(float)
        (results["outcome"],) = outcomes(body, numpy.cos(theta), lambda_, energy, crossed)
    wanted = {"outcome", *TIMES, "min_g_n", "t_stop", *record}
    return {
        name: value if isinstance(value, str) or value is None else float(value)
        for name, value in results.items()
        if name in wanted
    }


def _integrated(scene: Scene, events: tuple[str, ...]) -> Trajectory:
    from tt_precise.integration import integrate  # which a worker without such rows does not load

    run = partial(integrate, scene, events=events, record=(), tolerance=TOLERANCE)
    if refused_in_doubles(scene):
        return run(WHERE_REFUSED)
    try:
        return run(FINE)
    except ArcTangentError:  # of an event's function
        return run(WHERE_REFUSED)


def differences(row: Mapping[Any, Json], again: Mapping[str, Json]) -> dict[str, float]:
    """Absolute difference of each column; infinite where only one of the two has a value."""
    by_name = {}
    for name, fine in again.items():
        if name == "outcome":
            continue
        rough = row[name]
        missing = rough is None or math.isnan(rough)
        if missing or fine is None:
            by_name[name] = 0.0 if missing and fine is None else math.inf
        else:
            by_name[name] = abs(rough - fine)
    return by_name
