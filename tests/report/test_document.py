"""The words of the report: every section and figure has them, and blocks stand where they say."""

from __future__ import annotations

import pytest

from tt_precise.claims import Verdict
from tt_precise.claims.claim import SECTIONS as PAPER_SECTIONS
from tt_precise.claims.verdicts import committed
from tt_precise.report import document
from tt_precise.report.build import SECTIONS
from tt_precise.report.document import MARKS, ClaimList, Figure, PageTable, Section, Text, words


def test_every_claim_has_a_section_and_a_mark() -> None:
    judged = committed()
    assert judged is not None
    assert {claim.section for claim in judged.claims} == set(PAPER_SECTIONS)
    assert {claim.verdict for claim in judged.claims} == set(MARKS) == set(Verdict)


def test_every_section_and_every_figure_has_words() -> None:
    keys = {name for level, name in words() if level == "#"}
    assert keys == {*SECTIONS, "errata", "claims", "answers", "untested", "motion"}
    drawn = {name: text for (level, name), text in words().items() if level == "##"}
    assert [name for name, text in drawn.items() if len(text) != 2] == []
    placed = {text[1:-1] for texts in words().values() for text in texts if text[-1:] == "]"}
    assert set(drawn) <= placed


@pytest.fixture
def own_words(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = {
        ("#", "one"): [
            "One", "[plot]", "{count} starts.", "! Beware.", "> Why: Because of {count}.",
            "[numbers] The numbers.", "[list] Title ({count}): About it.", "[absent]", "{nothing}",
        ],
        ("##", "plot"): ["A plot of {count:.1f}. More.", "a plot"],
    }  # fmt: skip
    monkeypatch.setattr(document, "words", lambda: entries)


@pytest.mark.usefixtures("own_words")
def test_blocks_stand_in_the_order_of_the_words_and_numbers_are_filled_in() -> None:
    figure = Figure.of("plot", "<svg/>", {"count": 3})
    assert (figure.caption, figure.alt) == ("A plot of 3.0. More.", "a plot")
    table = PageTable.of([{"a": "1"}, {"b": "2"}], folded=True)
    assert (table.header, table.rows) == (("a", "b"), [("1", "-"), ("-", "2")])
    blocks: dict[str, document.Block] = {
        "plot": figure,
        "numbers": table,
        "list": ClaimList(()),
        "not placed": table,
    }
    section = Section.of("one", blocks, {"x": 1}, count=3, nothing="")
    assert section.title == "One"
    picture, text, emphasis, folded, numbers, claims = section.blocks
    assert picture is figure
    assert [text, emphasis] == [Text("3 starts."), Text("Beware.", emphasis=True)]
    assert isinstance(folded, Text)
    assert folded.folded == "Why"
    assert isinstance(numbers, PageTable)
    assert (numbers.name, numbers.caption, numbers.folded) == ("numbers", "The numbers.", True)
    assert isinstance(claims, ClaimList)
    assert (claims.title, claims.about) == ("Title (3)", "About it.")


@pytest.mark.usefixtures("own_words")
def test_a_number_without_a_value_is_refused() -> None:
    with pytest.raises(ValueError, match="nothing"):
        Section.of("one", {}, {}, count=3)
