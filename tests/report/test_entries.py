"""Claims as the page shows them: the essential in one line, and the sections of the paper."""

import pytest

from tt_precise.claims.committed import JudgedClaim, committed
from tt_precise.report.document import MARKS, Entry, entry, sections


@pytest.fixture
def by_id(judged: list[JudgedClaim]) -> dict[str, Entry]:
    return {claim.id: entry(claim) for claim in judged}


def test_a_misprint_shows_what_should_stand(by_id: dict[str, Entry]) -> None:
    one = by_id["EQ-01"]
    assert one.correction
    assert "- R*I3" in one.result
    assert one.note == "A factor R."  # not what stands beside it already
    assert [line.name for line in one.lines] == ["as printed", "as corrected"]


def test_a_refuted_claim_shows_the_part_that_fails(by_id: dict[str, Entry]) -> None:
    assert (by_id["NUM-02"].printed, by_id["NUM-02"].result) == ("2", "3 | 4")
    assert (by_id["NUM-05"].printed, by_id["NUM-05"].result) == ("2", "3 | 4 (second)")
    assert by_id["NUM-05"].note == "Both."


def test_a_reading_says_which_one_holds(by_id: dict[str, Entry]) -> None:
    one = by_id["NUM-04"]
    assert one.result == "holds if read as: so"
    assert [(line.name, line.verdict) for line in one.lines] == [
        ("so", "reproduced"), ("or so", "refuted"),
    ]  # fmt: skip
    assert one.note == "Either."


def test_every_claim_has_a_section_and_a_mark() -> None:
    known = committed()
    assert known is not None
    found = [entry(claim) for claim in known.claims]
    assert {one.section for one in found} == set(sections())
    assert {one.mark for one in found} == set(MARKS.values())
    assert len(set(MARKS.values())) == 6
