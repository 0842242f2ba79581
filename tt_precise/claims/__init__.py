"""The claims of papers, one function each, and their verdicts.

    >>> import tt_precise as tt
    >>> judged = tt.claims.judge("NUM-23")
    >>> judged.verdict, judged.printed, judged.measured
    ('rounded', '1.8571', '1.8571428571428571429')

``claims()`` lists the claims by id, ``judge_all()`` judges all. ``claims.paper`` has the papers,
one package for each paper has its claims, and ``claims.verdicts`` has the rules of the verdicts.

Rules of fairness, for every claim:

1. A claim is one statement of the paper. Two statements in a sentence are two claims; one
   statement about several quantities, or at several times, is one claim with a part for each.
2. The quote is verbatim. A definition adds only what the words leave open.
3. "Ambiguous" only where the paper's words admit several meanings of which some hold. A statement
   that is true only under a restriction of ours holds "partly"; the part that fails is named.
4. "About N" has one rule: within one unit of the last significant digit of N (``verdicts.about``).
5. An outcome counts only if it is decided: it happened, or energy and lambda exclude it. Undecided
   starts are integrated further and named; while some starts are undecided, a statement about all
   starts is open.
6. A count counts findings: claims about one mistake name the claim that stands for them.
7. A note never denies its own verdict.
"""

import lazy_loader

from tt_precise.runtime.called import refuse_calls

# the claims import what they are judged with, heyoka and SymPy among it
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
refuse_calls(__name__, 'tt.claims.judge("NUM-23")')
