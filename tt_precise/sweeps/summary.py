"""The summary of a sweep: one JSON object, from what the workers say of each chunk."""

from __future__ import annotations

import math
from collections import Counter

from tt_precise._version import __version__
from tt_precise.runtime.values import Json
from tt_precise.sweeps.columns import OUTCOMES
from tt_precise.sweeps.specification import Specification
from tt_precise.sweeps.store import Store

SCHEMA = "tt_precise.sweep/1"


def summary_of(spec: Specification, store: Store, how: dict[str, Json]) -> dict[str, Json]:
    """Outcomes, the range of every column, what the spot check found, what is missing, how it ran.

    ``columns`` gives least, greatest and mean of the values that exist, and how many are missing.
    """
    import platform

    import heyoka
    import numpy

    found = merged([store.parts[number] for number in sorted(store.parts)])
    outcomes = found["outcomes"]
    return {
        "schema": SCHEMA,
        "rows": found["rows"],
        "expected": spec.rows,
        "outcomes": {name: outcomes.get(name, 0) for name in OUTCOMES},
        "columns": found["columns"],
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
        "versions": {
            "tt_precise": __version__,
            "heyoka": heyoka.__version__,
            "numpy": numpy.__version__,
            "python": platform.python_version(),
        },
        "fingerprint": spec.fingerprint,
        "specification": spec.description(),
        "out": store.out,
    }


def _recheck(store: Store) -> dict[str, Json]:
    largest: dict[str, float] = {}
    where: dict[str, int] = {}
    other, errors, unmatched = [], {}, []
    for index, found in sorted(store.checked.items()):
        if "error" in found:
            errors[str(index)] = found["error"]
            continue
        if found["outcomes"][0] != found["outcomes"][1]:
            rough, fine = found["outcomes"]
            other.append({"index": index, "double": rough, "finer": fine})
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


def merged(parts: list[dict[str, Json]]) -> dict[str, Json]:
    """The ``summarized`` rows of all parts; the order of the parts does not matter."""
    outcomes: Counter[str] = Counter()
    for part in parts:
        outcomes.update(part["outcomes"])
    rows = sum(part["rows"] for part in parts)
    columns: dict[str, Json] = {}
    for name in dict.fromkeys(name for part in parts for name in part["columns"]):
        mine = [part["columns"][name] for part in parts]
        known = [one for one in mine if one[3]]
        count = sum(one[3] for one in known)
        columns[name] = {
            "min": min((one[0] for one in known), default=None),
            "max": max((one[1] for one in known), default=None),
            "mean": math.fsum(one[2] for one in known) / count if count else None,
            "missing": rows - count,
        }
    return {"rows": rows, "outcomes": outcomes, "columns": columns}
