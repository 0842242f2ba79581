"""The claims of papers, one function each, and their verdicts.

    >>> import tt_precise as tt
    >>> judged = tt.claims.judge("NUM-23")
    >>> judged.verdict, judged.printed, judged.measured
    ('rounded', '1.8571', '1.8571428571428571429')

``claims()`` lists the claims by id, ``judge_all()`` judges all. ``claims.paper`` has the papers,
one package for each paper has its claims, and ``claims.verdicts`` has the rules of the verdicts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.runtime.process import lazy_names

if TYPE_CHECKING:
    from tt_precise.claims.claim import (
        Claim,
        claim_named,
        claims,
        counts,
        judge,
        judge_all,
    )
    from tt_precise.claims.verdicts import JudgedClaim, Part, Verdict

__all__ = [
    "Claim", "JudgedClaim", "Part", "Verdict", "claim_named", "claims", "counts", "judge",
    "judge_all",
]  # fmt: skip

# the claims import what they are judged with, heyoka and SymPy among it
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "claim": ["Claim", "claim_named", "claims", "counts", "judge", "judge_all"],
        "verdicts": ["JudgedClaim", "Part", "Verdict"],
    },
)
