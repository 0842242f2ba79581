"""The summary of a sweep: one JSON object, from the rows of its chunks."""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Mapping

import numpy

from tt_precise._version import __version__
from tt_precise.runtime.values import Json
from tt_precise.sweeps.columns import OUTCOMES
from tt_precise.sweeps.store import Store

SCHEMA = "tt_precise.sweep/1"


def summary_of(
    store: Store, rechecked: Mapping[int, dict[str, Json]], how: dict[str, Json]
) -> dict[str, Json]:
    """Outcomes, ranges of the columns, the spot check, and the run.

    ``columns`` gives least, greatest and mean of the values that exist, and how many are missing.
    """
    import heyoka

    outcomes: Counter[str] = Counter()
    columns: dict[str, list[tuple[float, float, float, int]]] = {}
    for frame in store.frames():
        outcomes.update(frame["outcome"].tolist())
        for name in frame.columns.drop(["index", "outcome"]):
            values = frame[name].to_numpy(dtype=float)
            there = values[numpy.isfinite(values)]
            parts = columns.setdefault(name, [])
            if len(there):
                ends = float(there.min()), float(there.max())
                parts.append((*ends, float(there.sum()), len(there)))
    return {
        "schema": SCHEMA,
        "rows": store.rows,
        "expected": store.spec.rows,
        "outcomes": {name: outcomes[name] for name in OUTCOMES},
        "columns": {name: _column(parts, store.rows) for name, parts in columns.items()},
        "recheck": _recheck(rechecked),
        "how": how,
        "versions": {
            "tt_precise": __version__,
            "heyoka": heyoka.__version__,
            "numpy": numpy.__version__,
            "python": platform.python_version(),
        },
        "fingerprint": store.spec.fingerprint,
        "specification": store.spec.description(),
        "out": store.out,
    }


def _column(chunks: list[tuple[float, float, float, int]], rows: int) -> dict[str, Json]:
    """Least, greatest, mean and number of missing values, from those of the chunks."""
    count = sum(chunk[3] for chunk in chunks)
    return {
        "min": min((chunk[0] for chunk in chunks), default=None),
        "max": max((chunk[1] for chunk in chunks), default=None),
        "mean": math.fsum(chunk[2] for chunk in chunks) / count if count else None,
        "missing": rows - count,
    }


def _recheck(rechecked: Mapping[int, dict[str, Json]]) -> dict[str, Json]:
    largest: dict[str, dict[str, Json]] = {}
    other, errors, unmatched = [], {}, []
    for index, row in sorted(rechecked.items()):
        if "error" in row:
            errors[str(index)] = row["error"]
            continue
        rough, fine = row["outcomes"]
        if rough != fine:
            other.append({"index": index, "double": rough, "finer": fine})
        for name, difference in row["differences"].items():
            if not math.isfinite(difference):
                unmatched.append({"index": index, "column": name})
            elif name not in largest or difference >= largest[name]["value"]:
                largest[name] = {"value": difference, "index": index}
    return {
        "rows": len(rechecked),
        "largest_difference": dict(sorted(largest.items())),
        "other_outcome": other,
        "only_in_one": unmatched,
        "errors": errors,
    }
