"""The scoreboard: what the ladder measured of every engine, as one JSON object."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from fractions import Fraction

from tt_precise._version import __version__
from tt_precise.engines.catalogue import Engine
from tt_precise.engines.ladder import VERDICTS, RungResult, climb
from tt_precise.engines.rungs import Rung, rungs
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json

SCHEMA = "tt_precise.engines/1"


def measure(
    engines: Sequence[Engine],
    steps: Sequence[Fraction],
    *,
    chosen: Callable[[Rung], bool] = lambda rung: True,
    time_limit: float,
    workers: int,
    note: Callable[[str], None] = lambda line: None,
    progress: Progress = silent,
) -> dict[str, Json]:
    """Every engine that is installed on every chosen rung; the others are skipped with a line."""
    rows: list[RungResult] = []
    skipped: list[str] = []
    present = []
    for engine in engines:
        if engine.version is None:
            skipped.append(engine.missing)
            note(f"skipped: {engine.missing}")
        else:
            present.append(engine)
    for done, engine in enumerate(present):
        ladder = [rung for rung in rungs(engine.law) if chosen(rung)]
        results = climb(
            engine.name, engine.command, ladder, steps, time_limit=time_limit, workers=workers
        )
        for climbed, result in enumerate(results, start=1):
            rows.append(result)
            progress((done + climbed / len(ladder)) / len(present))
    return as_dict(present, rungs(), steps, rows, skipped)


def as_dict(
    engines: Sequence[Engine],
    ladder: Sequence[Rung],
    steps: Sequence[Fraction],
    rows: Sequence[RungResult],
    skipped: Sequence[str] = (),
) -> dict[str, Json]:
    """The scoreboard as plain values: the same for the same engines, whenever it is measured."""
    return {
        "schema": SCHEMA,
        "tt_precise": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "steps": [float(step) for step in steps],
        "verdicts": VERDICTS,
        "engines": [
            {
                "name": engine.name,
                "version": engine.version,
                "precision": engine.precision,
                "friction": engine.friction,
                "settings": engine.settings,
            }
            for engine in engines
        ],
        "rungs": [{"name": rung.name, "meaning": rung.meaning} for rung in ladder],
        "rows": [row.as_dict() for row in rows],
        "skipped": list(skipped),
    }


def line(row: dict[str, Json]) -> str:
    """One row of the scoreboard in one line of a terminal."""
    parts = [f"{row['engine']:10} {row['rung']:18} {row['verdict']:10}"]
    if row["message"]:
        parts.append(row["message"])
    if row["digits"]:
        parts.append("digits " + " ".join(f"{digits:.1f}" for digits in row["digits"]))
    known = (name for name in ("order", "floor", "limit") if row[name] is not None)
    parts.extend(f"{name} {row[name]:.3g}" for name in known)
    if row["drift"]:
        drifts = (f"{name} {values[-1]:.1e}" for name, values in row["drift"].items())
        parts.append("drift " + ", ".join(drifts))
    if row["rung"] == "inversion" and row["equator"]:
        moments = ("never" if t is None else f"{t:.2f}" for t in row["equator"])
        parts.append(f"axis horizontal at {' '.join(moments)} s")
    return "  ".join(parts)
