"""Conservation checks on a trajectory from anywhere.

    >>> import tt_precise as tt
    >>> frame = tt.integrate("reference").frame()
    >>> result = tt.check.conservation(frame, "reference")
    >>> result.verdict, result["jellett"].value < 1e-13
    ('pass', True)

``result.frame`` is the table, ``result.plot("drift.svg")`` draws it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tt_precise.check.assertions import assert_conserves, assert_matches_golden
    from tt_precise.check.result import Finding, Result
    from tt_precise.check.run import conservation

__all__ = ["Finding", "Result", "assert_conserves", "assert_matches_golden", "conservation"]

_HOMES = {
    "Finding": "tt_precise.check.result",
    "assert_conserves": "tt_precise.check.assertions",
    "assert_matches_golden": "tt_precise.check.assertions",
    "Result": "tt_precise.check.result",
    "conservation": "tt_precise.check.run",
}


def __getattr__(name: str) -> Any:
    # the pytest plugin lives in this package and must cost nothing until it is used
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'tt_precise.check' has no attribute {name!r}")
