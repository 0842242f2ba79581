"""Reference-grade verification of the dynamics of the Tippe Top.

    >>> import tt_precise as tt
    >>> trajectory = tt.integrate("reference")
    >>> trajectory.status, round(trajectory.state.theta, 4)
    ('complete', 3.134)

Scenes come in as TOML with exact numbers (``load_scene``), are integrated by heyoka in double,
extended, quad or arbitrary precision (``integrate``), and are judged: ``golden`` holds reference
trajectories, ``check`` finds what anybody's trajectory fails to conserve, ``claims`` judges the
paper. Units are SI; names are the paper's.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tt_precise import check, claims, golden
    from tt_precise.body import TippeTop
    from tt_precise.errors import InputError
    from tt_precise.integrate import Trajectory, integrate
    from tt_precise.scene import Scene, load_scene

__version__ = "0.1.0"
__all__ = [
    "InputError", "Scene", "TippeTop", "Trajectory", "check", "claims", "golden", "integrate",
    "load_scene",
]  # fmt: skip

_HOMES = {
    "InputError": "tt_precise.errors",
    "Scene": "tt_precise.scene",
    "TippeTop": "tt_precise.body",
    "Trajectory": "tt_precise.integrate",
    "integrate": "tt_precise.integrate",
    "load_scene": "tt_precise.scene",
}


def __getattr__(name: str) -> Any:
    # heyoka, pandas and matplotlib take a second to import, so nothing is until it is used
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    if name in __all__:
        return importlib.import_module(f"tt_precise.{name}")
    raise AttributeError(f"module 'tt_precise' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
