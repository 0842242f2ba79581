"""The manifest of a scene's golden data: what the columns are, what is claimed, on what evidence.

It names no times of day, hosts or durations: two builds on one machine are equal byte for byte.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import math
import platform
import tomllib
from collections import Counter
from collections.abc import Sequence
from decimal import Decimal
from typing import Any

from tt_precise.golden.consensus import Consensus
from tt_precise.golden.digits import RULE, column_digits, scale_of
from tt_precise.golden.invariants import Constancy
from tt_precise.golden.runs import DIGITS, Run
from tt_precise.golden.store import EVENTS, SCENE, TRAJECTORY
from tt_precise.golden.table import Table
from tt_precise.integrate.events import EVENTS as CATALOGUE
from tt_precise.integrate.events import TERMINAL
from tt_precise.mechanics.columns import described
from tt_precise.scene import Scene

SCHEMA = "tt_precise.golden/1"
SELF_HASH = "sha256_of_manifest"
PROOF_KEY = "sha256_of_proof"

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
) -> dict[str, Any]:
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


def derive(scene: Scene, trajectory: Table, events: Table) -> dict[str, Any]:
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
        "digits": min(claimed, default=DIGITS),
        "files": files,
        "event_meanings": {
            name: CATALOGUE[name].meaning if name in CATALOGUE else TERMINAL[name]
            for name in dict.fromkeys(events.column("name"))
        },
    }


def dump(manifest: dict[str, Any]) -> str:
    """The text of manifest.json, with the manifest's own hash added."""
    sealed = {**manifest, SELF_HASH: self_hash(manifest)}
    return json.dumps(sealed, indent=1, ensure_ascii=False) + "\n"


def with_proof(manifest: dict[str, Any], sha256: str | None) -> dict[str, Any]:
    """The manifest (without its own hash) of data whose proof has that hash, or that have none."""
    content = {k: v for k, v in manifest.items() if k not in (SELF_HASH, PROOF_KEY)}
    return content if sha256 is None else {**content, PROOF_KEY: sha256}


def self_hash(manifest: dict[str, Any], name: str = SELF_HASH) -> str:
    """SHA-256 of a manifest's content, without this hash itself, which it has under ``name``."""
    content = {key: value for key, value in manifest.items() if key != name}
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def scene_sha256(text: str) -> str:
    """SHA-256 of what a scene's TOML says, comments and layout apart."""
    parsed = tomllib.loads(text, parse_float=str)
    canonical = json.dumps(parsed, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


def versions() -> dict[str, str]:
    """Versions of everything that takes part in making a digit."""
    packages = ("tt-precise", "heyoka", "mpmath")
    found = {name: importlib.metadata.version(name) for name in packages}
    return {**found, "python": platform.python_version()}


def _table(table: Table, scales: dict[str, Decimal]) -> dict[str, Any]:
    columns: dict[str, Any] = {}
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


def _run(run: Run) -> dict[str, Any]:
    told: dict[str, Any] = {
        "name": run.label,
        "formulation": run.formulation,
        "bits": run.bits,
        "status": run.status,
        "rows": len(run.trajectory.rows) - (run.status == "pole"),
    }
    if run.order:
        told |= {"order": run.order, "tolerance": f"2^-{run.bits - 1}"}
    return told


def _rounded(digits: float) -> float | str:
    """Digits to one place, rounded down; "equal" where nothing differs."""
    return "equal" if math.isinf(digits) and digits > 0 else math.floor(digits * 10) / 10
