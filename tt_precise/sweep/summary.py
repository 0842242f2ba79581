"""The summary of a sweep: one JSON object, from rows that are read some at a time."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from tt_precise._version import __version__
from tt_precise.sweep.columns import OUTCOMES
from tt_precise.sweep.specification import Specification
from tt_precise.sweep.store import Folder, Memory

SCHEMA = "tt_precise.sweep/1"


def summary_of(spec: Specification, store: Memory | Folder, how: dict[str, Any]) -> dict[str, Any]:
    """Outcomes, the range of every column, what the spot check found, what is missing, how it ran.

    ``columns`` gives least, greatest and mean of the values that exist, and how many are missing.
    """
    outcomes: Counter[str] = Counter()
    ranges: dict[str, _Range] = {}
    rows = 0
    for frame in store.frames():
        rows += len(frame)
        outcomes.update(frame["outcome"].tolist())
        for name in frame.columns:
            if name not in ("index", "outcome"):
                ranges.setdefault(name, _Range()).take(frame[name].to_numpy(dtype=float))
    return {
        "schema": SCHEMA,
        "rows": rows,
        "expected": spec.rows,
        "outcomes": {name: outcomes.get(name, 0) for name in OUTCOMES},
        "columns": {name: found.told() for name, found in ranges.items()},
        "recheck": _recheck(store),
        "quarantined": [
            {
                "chunk": number,
                "first": number * store.size,
                "rows": min(store.size, spec.rows - number * store.size),
                "error": error,
            }
            for number, error in sorted(store.quarantined.items())
        ],
        "how": how,
        "versions": _versions(),
        "fingerprint": spec.fingerprint,
        "specification": spec.description(),
        "out": str(store.path) if isinstance(store, Folder) else None,
    }


class _Range:
    def __init__(self) -> None:
        self.least, self.greatest = math.inf, -math.inf
        self.sum, self.known, self.missing = 0.0, 0, 0

    def take(self, values: Any) -> None:
        import numpy

        known = values[numpy.isfinite(values)]
        self.missing += len(values) - len(known)
        if len(known):
            self.least = min(self.least, float(known.min()))
            self.greatest = max(self.greatest, float(known.max()))
            self.sum += float(known.sum())
            self.known += len(known)

    def told(self) -> dict[str, Any]:
        if not self.known:
            return {"min": None, "max": None, "mean": None, "missing": self.missing}
        mean = self.sum / self.known
        return {"min": self.least, "max": self.greatest, "mean": mean, "missing": self.missing}


def _recheck(store: Memory | Folder) -> dict[str, Any]:
    largest: dict[str, float] = {}
    where: dict[str, int] = {}
    other, errors, unmatched = [], {}, []
    for index, found in sorted(store.checked.items()):
        if "error" in found:
            errors[str(index)] = found["error"]
            continue
        if found["outcomes"][0] != found["outcomes"][1]:
            rough, fine = found["outcomes"]
            other.append({"index": index, "double": rough, "quad": fine})
        for name, difference in found["differences"].items():
            if not math.isfinite(difference):
                unmatched.append({"index": index, "column": name})
            elif difference >= largest.get(name, -1.0):
                largest[name], where[name] = difference, index
    return {
        "rows": len(store.checked),
        "largest_difference": {
            name: {"value": largest[name], "index": where[name]} for name in sorted(largest)
        },
        "other_outcome": other,
        "only_in_one": unmatched,
        "errors": errors,
    }


def _versions() -> dict[str, str]:
    import platform

    import heyoka
    import numpy

    return {
        "tt_precise": __version__,
        "heyoka": heyoka.__version__,
        "numpy": numpy.__version__,
        "python": platform.python_version(),
    }
