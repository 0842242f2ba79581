"""The page and its Markdown twin, and the report stored to be laid out again."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

from tt_precise.claims import JudgedClaim
from tt_precise.cli import main
from tt_precise.report import build, render
from tt_precise.report.collect import Computed
from tt_precise.report.document import PageTable, Report, Section, Text
from tt_precise.report.overview import Headlines

from .conftest import FACTS

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


def test_markdown_is_a_twin(small_report: Report) -> None:
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


def test_what_is_written(small_report: Report, tmp_path: Path) -> None:
    written = build.write(small_report, tmp_path)
    assert {path.relative_to(tmp_path).as_posix() for path in written} == {
        "precision-report.html", "precision-report.md", "results.json", "figures/circle.svg",
        "figures/ring.svg",
    }  # fmt: skip
    results = json.loads((tmp_path / "results.json").read_text("utf-8"))
    assert results["summary"] == {"a": 1}
    assert results["claims"]["counts"]["refuted"] == 1


def test_a_report_that_changes_nothing_writes_nothing(
    judged: list[JudgedClaim], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(day: str, commit: str, drift: str, seconds: float) -> dict[str, str]:
        """The files after a run of that day and commit."""
        section = Section("extremes", "E", [Text(drift)], {"cases": drift})
        computed = Computed(judged, [section], Headlines({}, None, {}), "all", seconds)
        facts = {**FACTS, "date": day, "commit": commit}
        monkeypatch.setattr(build, "compute", lambda progress: computed)
        monkeypatch.setattr(build, "provenance", lambda *_: facts)
        return {path.name: path.read_text("utf-8") for path in build.build(tmp_path, "c")}

    first = run("Monday", "abc", "1e-15", 10.2)
    assert run("Tuesday", "def", "1e-15", 13.8) == first
    third = run("Wednesday", "fed", "2e-15", 12.1)
    assert all("Monday" in text and "Tuesday" not in text for text in first.values())
    assert all("Wednesday" in text and "Monday" not in text for text in third.values())
    (tmp_path / "precision-report.md").write_text("spoiled")  # written anew, and by whom
    assert "Friday" in run("Friday", "fed", "2e-15", 12.1)["precision-report.md"]
    (tmp_path / "results.json").write_text("{}")
    assert "Sunday" in run("Sunday", "fed", "2e-15", 12.1)["results.json"]


def test_the_command_opens_what_it_wrote(
    small_report: Report, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr(build, "build", lambda folder, *_: build.write(small_report, folder))
    assert main(["report", "--open", "--out", str(tmp_path / "out")]) == 0
    page = tmp_path / "out" / "precision-report.html"
    assert page.is_file()
    assert opened == [page.resolve().as_uri()]
