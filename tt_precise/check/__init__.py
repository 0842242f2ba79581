"""Conservation checks on a trajectory from anywhere.

    >>> import tt_precise as tt
    >>> frame = tt.integrate("reference").frame()
    >>> result = tt.check.conservation(frame, "reference")
    >>> result.verdict, result["jellett"].value < 1e-13
    ('pass', True)

``result.frame`` is the table, ``result.plot("drift.svg")`` draws it.
"""

import lazy_loader

# the pytest plugin lives in this package and must cost nothing until it is used
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
