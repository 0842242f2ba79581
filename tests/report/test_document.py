"""Every claim has a place in the document, and every verdict a mark."""

from __future__ import annotations

from tt_precise.claims import Verdict
from tt_precise.claims.committed import committed
from tt_precise.claims.paper import SECTIONS
from tt_precise.report.document import MARKS


def test_every_claim_has_a_section_and_a_mark() -> None:
    known = committed()
    assert known is not None
    assert {claim.section for claim in known.claims} == set(SECTIONS)
    assert {claim.verdict for claim in known.claims} == set(MARKS) == set(Verdict)
    assert len(set(MARKS.values())) == len(MARKS)
