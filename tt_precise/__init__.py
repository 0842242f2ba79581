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

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
