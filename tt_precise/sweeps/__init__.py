"""Integration of many starts at once: SIMD lanes, cores, clusters.

    >>> import tt_precise as tt
    >>> rows = tt.sweep("reference", vary={"phi_dot": [0, 100]}, recheck=0)
    >>> list(rows["outcome"])
    ['inverts', 'inverts']

``sweep`` is ``tt.sweep``; ``sweep`` and the command use ``SweepSpec`` and ``run_sweep``.
"""

from tt_precise.sweeps.run import Swept, run_sweep, sweep
from tt_precise.sweeps.specification import SweepSpec
from tt_precise.sweeps.store import read_rows

__all__ = [
    "SweepSpec", "Swept", "read_rows", "run_sweep", "sweep",
]  # fmt: skip
