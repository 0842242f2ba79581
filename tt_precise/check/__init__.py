"""Conservation checks on a trajectory from anywhere.

    >>> import tt_precise as tt
    >>> frame = tt.integrate("reference").frame()
    >>> result = tt.check.conservation(frame, "reference")
    >>> result.verdict, result["jellett"].value < 1e-13
    ('pass', True)

``result.frame`` is the table, ``result.plot("drift.svg")`` draws it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader

if TYPE_CHECKING:
    from tt_precise.check.result import Result
    from tt_precise.check.run import assert_conserves, assert_matches_golden, conservation

__all__ = ["Result", "assert_conserves", "assert_matches_golden", "conservation"]

# the pytest plugin lives in this package and must cost nothing until it is used
__getattr__, __dir__, _ = lazy_loader.attach(
    __name__,
    [],
    {
        "result": ["Result"],
        "run": ["assert_conserves", "assert_matches_golden", "conservation"],
    },
)
