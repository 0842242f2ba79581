"""HTML and Markdown of a report."""

from __future__ import annotations

from html.parser import HTMLParser

import pytest

from tt_precise.report import render
from tt_precise.report.document import Report, Table

VOID = {"meta", "link", "input", "br"}


class _Balance(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_html_is_one_balanced_file_that_needs_no_network(small_report: Report) -> None:
    page = render.html(small_report)
    parser = _Balance()
    parser.feed(page)
    assert parser.open == []
    assert "http" not in page
    assert "<?xml" not in page
    assert "<!DOCTYPE svg>" not in page


def test_html_escapes_what_it_shows(small_report: Report) -> None:
    page = render.html(small_report)
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page
    assert "<script>alert" not in page
    assert "Plain &lt;text&gt; &amp; more." in page


def test_html_marks_rows_by_verdict(small_report: Report) -> None:
    page = render.html(small_report)
    for mark in ("good", "bad", "mixed"):
        assert page.count(f'data-mark="{mark}"') == 1


def test_markdown_has_every_block_and_keeps_its_table_whole(small_report: Report) -> None:
    text = render.markdown(small_report)
    assert "![a circle](figures/circle.svg)" in text
    assert "**Look here.**" in text
    assert "- lambda: **1e-15** (holds)" in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert len(rows) == 5
    assert all(line.replace("\\|", "").count("|") == 6 for line in rows)


def test_a_ragged_table_is_refused() -> None:
    with pytest.raises(ValueError, match="got 1 cells, expected 2"):
        Table(("a", "b"), [("only one",)])
