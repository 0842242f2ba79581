"""The page and its Markdown twin: whole, escaped, everything linked, blocks in their places."""

from __future__ import annotations

import re
from urllib.parse import unquote

from tt_precise.claims import JudgedClaim, part
from tt_precise.claims.verdicts import conclude
from tt_precise.report import render
from tt_precise.report.document import PageTable, Report
from tt_precise.report.render import names


def test_html_is_escaped_and_its_links_lead_somewhere(small_report: Report) -> None:
    page = render.html(small_report)
    plain = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    ids = re.findall(r'<[^>]* id="([^"]*)"', plain)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r'href="#([^"/]*)', plain)) <= set(ids)
    headings = re.findall(r"<(h\d)", plain)
    assert (headings.index("h1"), headings.count("h1")) == (0, 1)
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert not re.search(r'(?:src|href)="(?!#|data:|https://arxiv\.org)', page)
    assert not re.search(r"url\(http|@import", page)


def test_every_claim_has_a_cell_a_row_and_an_anchor(small_report: Report) -> None:
    page = render.html(small_report)
    for entry in small_report.overview.entries:
        assert page.count(f'href="#{entry.id}" title="{entry.id}, {entry.verdict}') == 1
        assert page.count(f'<details class="claim" id="{entry.id}"') == 1
    assert page.count('<details class="claim erratum"') == 4  # one of each kind
    assert 'class="differs"' in page
    card = page[page.index('<dl class="card">') :]
    assert '<span class="mark v-rounded" title="rounded" aria-label="rounded">≈' in card


def test_figures_are_images_in_the_page(small_report: Report) -> None:
    page = render.html(small_report)
    figure = page[page.index('id="figure-circle"') :]
    figure = figure[: figure.index("</figure>")]
    assert 'alt="A circle."' in figure
    assert "a circle to be seen" in figure
    source = re.search(r'src="data:image/svg\+xml,([^"]*)"', figure)
    assert source
    assert unquote(source[1]) == "<svg viewBox='0 0 9 9'><circle r='4'/></svg>"


def test_markdown_has_what_the_page_has(small_report: Report) -> None:
    text = render.markdown(small_report)
    for content in ("![a circle to be seen](figures/circle.svg)", r"\underline{R}", "a \\| b",
                    r"$\dot{\theta}$"):  # fmt: skip
        assert content in text
    for entry in small_report.overview.entries:
        assert f"| {entry.id} | {entry.verdict}" in text
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    assert all(line.endswith(" |") for line in lines)


def test_a_section_leads_with_its_picture_and_long_tables_fold(small_report: Report) -> None:
    page = render.laid_out(small_report.sections[1])
    assert page["picture"].name == "circle"
    assert [figure.name for figure in page["pictures"]] == ["ring"]
    assert [table.caption for table in page["side_tables"]] == ["A short one."]
    assert [table.name for table in page["tables"]] == ["cases-table"]
    assert render.lead("Figure 2 of sec. 2.1, eq. (3). More.") == "Figure 2 of sec. 2.1, eq. (3)."
    rows = [("1",)] * (render.LONGEST_ROWS + 1)
    assert render.folds(PageTable(("a",), rows))
    assert not render.folds(PageTable(("a",), rows[:-1]))
    assert not render.folds(PageTable(("a",), rows, folded=False))


def test_parts_are_named_by_their_outcome(judged: list[JudgedClaim]) -> None:
    ambiguous = next(claim for claim in judged if claim.id == "NUM-04")
    assert (names(ambiguous, holding=True), names(ambiguous, holding=False)) == ("so", "or so")
    undecided = {"so": part.statement(True, "so", "so"), "or so": part.untestable("so")}
    assert names(conclude("interpretations", undecided, ""), holding=False) == "or so (open)"
