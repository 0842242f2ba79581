"""Golden reference trajectories: decimal tables with every printed digit right.

    >>> import tt_precise as tt
    >>> golden = tt.golden.load("reference")
    >>> float(golden["theta"].iloc[-1]), len(golden.events), golden.manifest["digits"]
    (3.1340209458534365, 842, 34)

``load`` returns the tables of one scene; ``compare`` counts the correct digits of a trajectory.
``build`` makes the tables; ``verify`` checks them against their manifest and a fresh computation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader

if TYPE_CHECKING:
    from tt_precise.golden.building import Built, build
    from tt_precise.golden.comparing import Comparison, compare
    from tt_precise.golden.loading import GoldenFrame, load
    from tt_precise.golden.store import scenes
    from tt_precise.golden.verifying import Verification, verify

__all__ = [
    "Built", "Comparison", "GoldenFrame", "Verification", "build", "compare", "load", "scenes",
    "verify",
]  # fmt: skip

__getattr__, __dir__, _ = lazy_loader.attach(
    __name__,
    [],
    {
        "building": ["Built", "build"],
        "comparing": ["Comparison", "compare"],
        "loading": ["GoldenFrame", "load"],
        "store": ["scenes"],
        "verifying": ["Verification", "verify"],
    },
)
