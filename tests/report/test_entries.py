"""Claims as the page shows them: the essential in one line, and the sections of the paper."""

from tt_precise.claims.committed import JudgedClaim, committed
from tt_precise.report.document import MARKS, entry, sections


def test_a_line_shows_the_essential(judged: list[JudgedClaim]) -> None:
    by_id = {claim.id: entry(claim) for claim in judged}
    misprint = by_id["EQ-01"]  # what should stand
    assert misprint.correction
    assert "- R*I3" in misprint.result
    assert misprint.note == "A factor R."  # not what stands beside it already
    assert [line.name for line in misprint.lines] == ["as printed", "as corrected"]
    refuted = [by_id[id] for id in ("NUM-02", "NUM-05")]  # the part that fails
    assert [one.printed for one in refuted] == ["2", "2"]
    assert [one.result for one in refuted] == ["3 | 4", "3 | 4 (second)"]
    assert refuted[1].note == "Both."
    reading = by_id["NUM-04"]  # which one holds
    assert (reading.result, reading.note) == ("holds if read as: so", "Either.")
    lines = [(line.name, line.verdict) for line in reading.lines]
    assert lines == [("so", "reproduced"), ("or so", "refuted")]


def test_every_claim_has_a_section_and_a_mark() -> None:
    known = committed()
    assert known is not None
    found = [entry(claim) for claim in known.claims]
    assert {one.section for one in found} == set(sections())
    assert {one.mark for one in found} == set(MARKS.values())
    assert len(set(MARKS.values())) == 6
