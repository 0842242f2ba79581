"""Reference-grade verification of the dynamics of the Tippe Top.

    >>> import tt_precise as tt
    >>> trajectory = tt.integrate("reference")
    >>> trajectory.status, round(trajectory.state.theta, 4)
    ('complete', 3.134)

``load_scene`` reads a scene, a TOML file with exact numbers. ``integrate`` computes the trajectory
of a scene in any precision from double to arbitrary. ``golden`` has reference trajectories,
``check`` tests the conservation laws on any trajectory, ``claims`` judges the statements of the
paper, ``sweep`` integrates many starts at once, ``threshold`` finds the smallest value of an entry
that passes the equator, ``certify`` proves digits. Units are SI; names are the paper's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import lazy_loader

from tt_precise._version import __version__
from tt_precise.integration import registry

if TYPE_CHECKING:
    from tt_precise import certify, check, claims, golden, threshold
    from tt_precise.exact.thresholds import thresholds
    from tt_precise.integration import Trajectory, integrate
    from tt_precise.integration.columns import quantity
    from tt_precise.runtime.values import InputError
    from tt_precise.scene.scene import Scene, load_scene
    from tt_precise.sweeps.run import sweep

__all__ = [
    "InputError",
    "Scene",
    "Trajectory",
    "__version__",
    "certify",
    "check",
    "claims",
    "golden",
    "integrate",
    "load_scene",
    "quantity",
    "sweep",
    "threshold",
    "thresholds",
]  # fmt: skip

registry.register("in_pieces", "tt_precise.nonsmooth.backend")

_attached, _, _ = lazy_loader.attach(
    __name__,
    ["certify", "check", "claims", "golden", "threshold"],
    {
        "runtime.values": ["InputError"],
        "integration": ["Trajectory", "integrate"],
        "integration.columns": ["quantity"],
        "exact.thresholds": ["thresholds"],
        "scene.scene": ["Scene", "load_scene"],
        "sweeps.run": ["sweep"],
    },
)


def __getattr__(name: str) -> Any:
    try:
        return _attached(name)
    except AttributeError:
        from tt_precise.integration import Trajectory
        from tt_precise.runtime.values import WRITTEN, nearest

        if name.startswith("_"):
            raise
        own = f"tt.integrate(scene).{name}" if hasattr(Trajectory, name) else ""
        where = WRITTEN.get(name) or own or nearest(name, __all__) or "`tt-precise --help`"
        raise AttributeError(f"tt_precise has no {name} (expected {where})", name=name) from None


def __dir__() -> list[str]:
    return sorted(__all__)
