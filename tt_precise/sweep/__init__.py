"""Many starts at once: SIMD lanes, cores, clusters.

>>> from tt_precise.sweep import specification, sweep
>>> swept = sweep(specification("reference", vary={"phi_dot": "0,100"}), one_in=0)
>>> list(swept.rows["outcome"])
['inverts', 'inverts']
"""

from tt_precise.sweep.run import Swept, sweep
from tt_precise.sweep.specification import Specification, read_specification, specification
from tt_precise.sweep.store import read_rows

__all__ = ["Specification", "Swept", "read_rows", "read_specification", "specification", "sweep"]
