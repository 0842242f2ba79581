"""Golden reference trajectories: decimal tables of which every printed digit is right.

    >>> import tt_precise as tt
    >>> golden = tt.golden.load("reference")
    >>> float(golden["theta"].iloc[-1]), len(golden.events), golden.manifest["digits"]
    (3.1340209458534365, 842, 34)

``load`` gives the tables of one scene, ``compare`` tells how many digits of somebody's trajectory
agree with them. ``build`` makes them, ``verify`` judges them against their manifest and a fresh
computation.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

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

_HOMES = {
    **dict.fromkeys(("Built", "build"), "building"),
    **dict.fromkeys(("Comparison", "compare"), "comparing"),
    **dict.fromkeys(("GoldenFrame", "load"), "loading"),
    "scenes": "store",
    **dict.fromkeys(("Verification", "verify"), "verifying"),
}


def __getattr__(name: str) -> Any:
    # pandas and heyoka are imported by what needs them, when it is first used
    if name in _HOMES:
        return getattr(importlib.import_module(f"tt_precise.golden.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'tt_precise.golden' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
