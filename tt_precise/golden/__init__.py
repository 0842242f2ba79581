"""Golden reference trajectories: decimal tables with every printed digit right.

    >>> import tt_precise as tt
    >>> golden = tt.golden.load("reference")
    >>> float(golden["theta"].iloc[-1]), len(golden.events), golden.manifest["digits"]
    (3.1340209458534365, 842, 34)

``load`` returns the tables of one scene; ``compare`` counts the correct digits of a trajectory.
``build`` makes the tables; ``verify`` checks them against their manifest and a fresh computation.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
