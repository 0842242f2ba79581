"""The manifest of a scene's golden data: what the columns are, what is claimed, on what evidence.

It names no times of day, hosts or durations: two builds on one machine are equal byte for byte.
"""

from __future__ import annotations

import importlib.metadata
import math
import platform
from collections import Counter
from collections.abc import Sequence
from decimal import Decimal

from tt_precise.golden.consensus import Consensus
from tt_precise.golden.digits import RULE, column_digits, scale_of
from tt_precise.golden.hashes import PROOF_KEY as PROOF_KEY
from tt_precise.golden.hashes import SELF_HASH as SELF_HASH
from tt_precise.golden.hashes import dump as dump
from tt_precise.golden.hashes import scene_sha256 as scene_sha256
from tt_precise.golden.hashes import self_hash as self_hash
from tt_precise.golden.hashes import with_proof as with_proof
from tt_precise.golden.invariants import Constancy
from tt_precise.golden.runs import Run
from tt_precise.golden.store import EVENTS, SCENE, TRAJECTORY
from tt_precise.golden.table import Table
from tt_precise.integration.events import EVENTS as CATALOGUE
from tt_precise.integration.events import JOINING, TERMINAL
from tt_precise.mechanics.columns import described
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene

SCHEMA = "tt_precise.golden/1"

# what an event table has besides the columns of a trajectory
_EVENT_COLUMNS = {
    "name": ("", "event, see event_meanings"),
    "direction": ("1", "+1 where the event's function rises through zero, -1 where it falls"),
}


def compose(
    scene: Scene,
    consensus: Consensus,
    runs: Sequence[Run],
    constant: Sequence[Constancy],
    history: Sequence[dict[str, str]],
) -> dict[str, Json]:
    """The manifest of ``consensus``, made of ``runs``."""
    derived = derive(scene, consensus.trajectory, consensus.events)
    for file, key in ((TRAJECTORY, "trajectory"), (EVENTS, "events")):
        for name, agreements in consensus.agreements[key].items():
            derived["files"][file]["columns"][name]["agreement"] = {
                label: _rounded(digits) for label, digits in agreements.items()
            }
    return {
        "schema": SCHEMA,
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.model,
        "status": consensus.status,
        **derived,
        "rule": RULE,
        "evidence": {
            "agreement": _rounded(consensus.agreement),
            "runs": [_run(run) for run in runs],
            "constant_over_printed_rows": {one.name: _rounded(one.digits) for one in constant},
            "events": "same list in every run; the directions of each event alternate",
        },
        "versions": versions(),
        "history": list(history),
        "row_marks": {
            TRAJECTORY: consensus.trajectory.row_marks,
            EVENTS: consensus.events.row_marks,
        },
    }


def derive(scene: Scene, trajectory: Table, events: Table) -> dict[str, Json]:
    """What of a manifest follows from the scene and the printed tables alone."""
    scales = {name: scale_of(trajectory.column(name)) for name in trajectory.columns}
    files = {
        SCENE: {"sha256": scene_sha256(scene.text)},
        TRAJECTORY: _table(trajectory, scales),
        EVENTS: {**_table(events, scales), "counts": dict(Counter(events.column("name")))},
    }
    claimed = [
        column["digits"]
        for file in (TRAJECTORY, EVENTS)
        for column in files[file]["columns"].values()
        if column["digits"] is not None
    ]
    return {
        "t_end": trajectory.column("t")[-1],
        "digits": min(claimed, default=0),
        "files": files,
        "event_meanings": {
            name: CATALOGUE[name].meaning if name in CATALOGUE else {**TERMINAL, **JOINING}[name]
            for name in dict.fromkeys(events.column("name"))
        },
    }


def versions() -> dict[str, str]:
    """Versions of everything that takes part in making a digit."""
    packages = ("tt-precise", "heyoka", "mpmath")
    found = {name: importlib.metadata.version(name) for name in packages}
    return {**found, "python": platform.python_version()}


def _table(table: Table, scales: dict[str, Decimal]) -> dict[str, Json]:
    columns: dict[str, Json] = {}
    for name in table.columns:
        unit, meaning = _described(name)
        columns[name] = {"unit": unit, "meaning": meaning, "digits": None}
        if name == "t":
            computed = [cell for cell in table.column(name) if "e" in cell]
            columns[name]["digits"] = column_digits(computed, scales[name]).digits
        elif name in scales:
            columns[name] |= column_digits(table.column(name), scales[name]).as_dict()
        columns[name]["sha256"] = table.column_sha256(name)
    return {
        "rows": len(table.rows),
        "sha256": table.sha256,
        "columns": columns,
    }


def _described(name: str) -> tuple[str, str]:
    return _EVENT_COLUMNS.get(name) or described(name)


def _run(run: Run) -> dict[str, Json]:
    content: dict[str, Json] = {
        "name": run.label,
        "formulation": run.formulation,
        "bits": run.bits,
        "status": run.status,
        "rows": len(run.trajectory.rows) - (run.status == "pole"),
    }
    if run.order:
        content |= {"order": run.order, "tolerance": f"2^-{run.bits - 1}"}
    return content


def _rounded(digits: float) -> float | str:
    """Digits to one place, rounded down; "equal" where nothing differs."""
    return "equal" if math.isinf(digits) and digits > 0 else math.floor(digits * 10) / 10
