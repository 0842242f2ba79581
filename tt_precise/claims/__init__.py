"""The claims of the paper, one function each, and their verdicts.

    >>> import tt_precise as tt
    >>> judged = tt.claims.judge("NUM-23")
    >>> judged.verdict, judged.printed, judged.measured
    ('rounded', '1.8571', '1.8571428571428571429')

``claims()`` lists the claims by id, ``judge_all()`` judges all. ``rauch_rutstam`` has the claims of
the paper, ``claims.verdicts`` the rules of the verdicts and the committed ones.

The same rules hold for every claim: ``verdicts.RULES``. Two statements in a sentence are two
claims, and a note never denies its own verdict.
"""

import lazy_loader

# the claims import what they are judged with, heyoka and SymPy among it
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
