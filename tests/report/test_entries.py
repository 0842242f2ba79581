"""Claims as the page shows them: the essential in one line, and the sections of the paper."""

import pytest

from tt_precise.claims import Judgement
from tt_precise.claims.committed import committed
from tt_precise.report.entries import MARKS, SECTIONS, Entry, entry, paper_section


@pytest.fixture
def by_id(judgements: list[Judgement]) -> dict[str, Entry]:
    return {one.id: entry(one.as_dict()) for one in judgements}


def test_a_misprint_shows_what_should_stand(by_id: dict[str, Entry]) -> None:
    one = by_id["EQ-01"]
    assert one.corrected
    assert "- R*I3" in one.found
    assert one.note == "A factor R."  # not what stands beside it already
    assert [line.name for line in one.lines] == ["as printed", "as corrected"]


def test_a_refuted_claim_shows_the_part_that_fails(by_id: dict[str, Entry]) -> None:
    assert (by_id["NUM-02"].printed, by_id["NUM-02"].found) == ("2", "3 | 4")
    assert (by_id["NUM-05"].printed, by_id["NUM-05"].found) == ("2", "3 | 4 (second)")
    assert by_id["NUM-05"].note == "Both."


def test_a_reading_says_which_one_holds(by_id: dict[str, Entry]) -> None:
    one = by_id["NUM-04"]
    assert one.found == "holds read as: so"
    assert [(line.name, line.verdict) for line in one.lines] == [
        ("so", "reproduced"), ("or so", "refuted"),
    ]  # fmt: skip
    assert one.note == "Either."


@pytest.mark.parametrize(
    ("where", "section"),
    [
        ("Sec. 2.1; Summary d)", "2.1"), ("eq (13)", "1"), ("eq (21)", "2.1"),
        ("Sec. 2.3, eq (25)", "2.3"), ("Theorem 1.1", "1"), ("Fig. 8, caption", "2.2"),
        ("captions of Figs 2 to 7; Sec. 2.3", "2.3"), ("Summary c)", "3"), ("Sec. 3", "3"),
        ("Proposition 1.1 i)", "1"), ("Fig. 3, caption", "2.1"),
    ],
)  # fmt: skip
def test_places_lie_in_sections(where: str, section: str) -> None:
    assert paper_section(where) == section


def test_every_claim_has_a_section_and_a_mark() -> None:
    known = committed()
    assert known is not None
    found = [entry({"parts": [], "correction": "", **one}) for one in known.claims.values()]
    assert len(found) == 174
    assert {one.section for one in found} == set(SECTIONS)
    assert {one.mark for one in found} == set(MARKS.values())
    assert len(set(MARKS.values())) == 6
