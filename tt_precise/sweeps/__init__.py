"""Integration of many starts at once: SIMD lanes, cores, clusters.

>>> import tt_precise as tt
>>> rows = tt.sweep("reference", tt.grid({"phi_dot": [0, 100]}), recheck=0)
>>> list(rows["outcome"])
['inverts', 'inverts']
"""

from tt_precise.sweeps.run import sweep
from tt_precise.sweeps.starts import Sweep, grid
from tt_precise.sweeps.store import read_rows

__all__ = ["Sweep", "grid", "read_rows", "sweep"]
