"""The page and its Markdown twin, and the report stored to be laid out again."""

import re
from html.parser import HTMLParser
from urllib.parse import unquote

from tt_precise.report import render
from tt_precise.report.document import PageTable, Report, Section, Text

VOID = {"img", "meta", "link", "input", "br"}


class _Tags(HTMLParser):
    """The open tags; each is closed before the one around it."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open += [tag] if tag not in VOID else []

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_html_is_whole_escaped_and_its_links_lead_somewhere(small_report: Report) -> None:
    page = render.html(small_report)
    tags = _Tags()
    tags.feed(page)
    assert tags.open == []
    plain = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    ids = re.findall(r'<[^>]* id="([^"]*)"', plain)
    assert len(ids) == len(set(ids))
    assert set(re.findall(r'href="#([^"/]*)', plain)) <= set(ids)
    headings = re.findall(r"<(h\d)", plain)
    assert headings.index("h1") == 0
    assert headings.count("h1") == 1
    assert "alert(1)" in page
    assert "<script>alert" not in page
    assert not re.search(r'(?:src|href)="(?!#|data:|https://arxiv\.org)', page)
    assert "url(http" not in page
    assert "@import" not in page


def test_every_claim_has_a_cell_a_row_and_an_anchor(small_report: Report) -> None:
    page = render.html(small_report)
    for entry in small_report.overview.entries:
        assert page.count(f'href="#{entry.id}" title="{entry.id}, {entry.verdict}') == 1
        assert page.count(f'<details class="claim" id="{entry.id}"') == 1
    assert page.count('<details class="claim erratum"') == 4  # misprint, two refuted, reading
    assert 'class="differs"' in page


def test_figures_are_images_in_the_page(small_report: Report) -> None:
    page = render.html(small_report)
    figure = page[page.index('id="figure-circle"') :]
    figure = figure[: figure.index("</figure>")]
    assert 'alt="A circle."' in figure
    assert 'aria-describedby="about-circle"' in figure
    assert "a circle to be seen" in figure
    held = re.search(r'src="data:image/svg\+xml,([^"]*)"', figure)
    assert held
    assert unquote(held[1]) == (
        "<svg viewBox='0 0 9 9'><metadata>by somebody</metadata><style>*{fill: red}</style>"
        "<g id='circle-g'><circle style='fill: #000000' r='4'/></g></svg>"
    )


def test_markdown_has_what_the_page_has(small_report: Report) -> None:
    text = render.markdown(small_report)
    assert "![a circle to be seen](figures/circle.svg)" in text
    assert r"\underline{R}" in text
    assert "a \\| b" in text
    assert r"$\dot{\theta}$" in text
    for entry in small_report.overview.entries:
        assert f"| {entry.id} | {entry.verdict}" in text
    assert "click" not in text
    lines = [line for line in text.splitlines() if line.startswith("| ")]
    assert all(line.endswith(" |") for line in lines)


def test_a_section_leads_with_its_picture_and_long_tables_and_texts_fold(
    small_report: Report,
) -> None:
    page = render.laid_out(small_report.sections[1])
    assert page["picture"].name == "circle"
    assert [figure.name for figure in page["pictures"]] == ["ring"]
    assert [table.caption for table in page["side_tables"]] == ["A short one."]
    assert [table.name for table in page["tables"]] == ["cases-table"]
    rows = [("1",)] * (render.LONGEST_ROWS + 1)
    assert render.folds(PageTable(("a",), rows))
    assert not render.folds(PageTable(("a",), rows[:-1]))
    assert not render.folds(PageTable(("a",), rows, folded=False))
    text = "This is a sentence of some length. " * 30
    ((shown, folded),) = render.laid_out(Section("a", "A", [Text(text.strip())]))["texts"]
    assert len(shown.text) < render.LONGEST_TEXT
    assert len(shown.text) + len(folded) > 1000
    # sentences are distinguished
    text = "Figure 2 of sec. 2.1 at 0.5 s. Bears on EQ-01, eq. (3). More."
    assert render.lead(text) == "Figure 2 of sec. 2.1 at 0.5 s."
    assert render.rest(text) == "Bears on EQ-01, eq. (3). More."
    assert (render.lead("One only."), render.rest("One only.")) == ("One only.", "")
