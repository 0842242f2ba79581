"""Many starts at once: SIMD lanes, cores, clusters.

    >>> import tt_precise as tt
    >>> rows = tt.sweep("reference", vary={"phi_dot": [0, 100]}, recheck=0)
    >>> list(rows["outcome"])
    ['inverts', 'inverts']

``tt.sweep`` is ``table``; it and the command are made of ``specification`` and ``sweep``.
"""

from tt_precise.runtime.lazy import make_callable
from tt_precise.sweep.rows_file import read_rows
from tt_precise.sweep.run import Swept, sweep
from tt_precise.sweep.specification import Specification, specification
from tt_precise.sweep.sweep_file import read_specification
from tt_precise.sweep.table import table

__all__ = [
    "Specification", "Swept", "read_rows", "read_specification", "specification", "sweep", "table",
]  # fmt: skip

make_callable(__name__, table)
