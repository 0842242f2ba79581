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

from typing import Any

import lazy_loader

from tt_precise.integration import registry

registry.register("in_pieces", "tt_precise.nonsmooth.backend")

_attached, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


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
