"""Papers: where their equations stand, and another paper beside the first."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tt_precise.claims import (
    claim,
    claims,
    judge,
    judge_all,
    paper,
)
from tt_precise.claims.committed import run_record
from tt_precise.claims.paper import RAUCH_RUTSTAM, Paper, PaperSection
from tt_precise.report.document import ClaimList, Text
from tt_precise.report.overview import Headlines, all_claims, errata, overview

OTHER = Paper(
    name="Somebody", package="somebody_else", title="Another top", authors="A. Body",
    sections=(PaperSection("4", "Section 4: a number"),), prefix="OTHER-",
)  # fmt: skip


CHAPTER = '''
from tt_precise.claims.claim import claims_of
from tt_precise.claims.paper import PAPERS
from tt_precise.claims.verdicts import rounds_to

claim = claims_of(PAPERS[-1], "4")


@claim(
    "NUM-02", statement="Again.", quote="1.86", given={"printed": "1.86"}, finding="NUM-01",
    control=("refuted", {"printed": "1.8"}),
)
@claim("NUM-01", quote="1.8571", control=("refuted", {"printed": "1.8"}))
def ratio(printed="1.8571"):
    """13/7."""
    return rounds_to(printed, 13 / 7), "As computed."
'''


def test_equations_and_figures_lie_in_the_sections_that_the_paper_has_them_in() -> None:
    for one in claims().values():
        section = one.paper.section(one.section)
        first = re.match(r"(?:Sec. [\d.]+, )?(eq|Fig\.) \(?(\d+)", one.where)
        if first and one.where.count("Sec.") < 2:
            known = section.equations if first[1] == "eq" else section.figures
            assert int(first[2]) in known, one.id


@pytest.fixture
def another_paper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One more folder with two claims of one function, and one more entry."""
    folder = tmp_path / OTHER.package
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "section4.py").write_text(CHAPTER, "utf-8")
    known = dict(claims())
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(paper, "PAPERS", (*paper.PAPERS, OTHER))
    monkeypatch.setattr(claim, "_registered", known)
    claims.cache_clear()
    yield
    claims.cache_clear()
    for name in [name for name in sys.modules if name.startswith(OTHER.package)]:
        del sys.modules[name]


def test_another_paper_is_a_folder_and_an_entry_filed_under_its_name(another_paper: None) -> None:
    assert list(claims())[-2:] == ["OTHER-NUM-01", "OTHER-NUM-02"]
    again = judge("OTHER-NUM-02")
    assert (again.statement, again.printed, again.finding) == ("Again.", "1.86", "OTHER-NUM-01")
    other = judge("other-num-01")
    assert (other.verdict, other.paper, other.section) == ("rounded", "Somebody", "4")
    assert judge("OTHER-NUM-01", printed="1.8").verdict == "refuted"
    run = run_record(1, 1, {"date": "today", "commit": "abc", "versions": "heyoka 1"})
    section = all_claims(judge_all(["NUM-23", "OTHER-NUM-01"]), run)
    blocks = [block for block in section.blocks if isinstance(block, ClaimList)]
    groups = {block.title: [one.id for one in block.entries] for block in blocks}
    assert groups == {
        f"{RAUCH_RUTSTAM.name}, Section 2.3: energy, torque, potential": ["NUM-23"],
        "Somebody, Section 4: a number": ["OTHER-NUM-01"],
    }


def test_the_first_screen_counts_the_statements_of_the_paper_that_it_names(
    another_paper: None,
) -> None:
    judged = [judge("NUM-23"), judge("OTHER-NUM-01", printed="1.8")]
    first = overview(judged, Headlines({}, None, {}))
    assert [one.id for one in first.entries] == ["NUM-23"]
    assert first.verdict.startswith("Of 1 statements, 1 hold")
    text = errata(judged).blocks[0]
    assert isinstance(text, Text)
    assert text.text.startswith("1 statements of the papers fail")
