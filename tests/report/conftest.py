"""Judged claims and a small report to render, made without any integration."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

import pytest

from tt_precise.claims import Claim, JudgedClaim, claims, part
from tt_precise.claims.committed import run_record
from tt_precise.claims.words import Wording
from tt_precise.report import overview
from tt_precise.report.document import (
    Block,
    Card,
    Figure,
    Overview,
    PageTable,
    Report,
    Section,
    Text,
)

LARGEST_FIGURE = 300_000  # characters of SVG
FACTS = {
    "versions": "tt-precise 1", "machine": "m", "precision": "p", "command": "c", "commit": "abc",
    "date": "today",
}  # fmt: skip
PRINTED = "R*I1*phi_dot*sin(theta)**2 - I3*omega_3*(alpha - cos(theta))"
CORRECT = "R*I1*phi_dot*sin(theta)**2 - R*I3*omega_3*(alpha - cos(theta))"


CLAIM = re.compile(r"\b(?:EQ|TH|NUM|QUAL|FIG|SWP|SUM|NT)-\d\d\b")


def problems(figure: Figure) -> list[str]:
    """Return the problems of a figure."""
    found = []
    if not ElementTree.fromstring(figure.svg).tag.endswith("svg"):
        found.append("no svg")
    if len(figure.svg) > LARGEST_FIGURE:
        found.append(f"{len(figure.svg)} characters")
    paths = re.findall(r' d="([^"]*)"', figure.svg)
    if not paths or any(re.search(r"\.\d{3}", path) for path in paths):
        found.append("paths are long")
    if not figure.alt or "nan" in figure.caption:
        found.append("alt or caption incomplete")
    named = CLAIM.findall(figure.caption)
    if not named or not set(named) <= set(claims()):
        found.append(f"bears on {named}")
    return found


def tables(section: Section) -> list[PageTable]:
    return [block for block in section.blocks if isinstance(block, PageTable)]


def drawn(section: Section) -> list[str]:
    """The names of the section's figures, each of which is whole."""
    figures = [block for block in section.blocks if isinstance(block, Figure)]
    for figure in figures:
        assert ElementTree.fromstring(figure.svg).tag.endswith("svg")
        assert "<path" in figure.svg
        assert figure.alt
        assert len(figure.svg) < LARGEST_FIGURE
    return [figure.name for figure in figures]


def _judged(id: str, grounds: Any, note: str, section: str = "1", rule: Any = "all of") -> Any:
    text = f"claim {id} <b> of theta_dot"
    words = Wording(text, f"Sec. {section}", "a quote", "as in theta", note)
    return Claim(id, section, words, lambda: grounds, rule, id).judge()


@pytest.fixture
def judged() -> list[JudgedClaim]:
    """Claims of each verdict, in five sections of the paper."""
    holds = part.statement(True, "1", "1")
    fails = part.statement(False, "2", "3 | 4")
    right = part.formula(True, CORRECT, "equal", proved=True)
    wrong = part.formula(False, PRINTED, "off by 40 % of its size", proved=True)
    return [
        _judged(
            "EQ-01", {"as printed": wrong, "as corrected": right}, "A factor R.", rule="misprint"
        ),
        _judged("NUM-01", holds, "As printed.", "2.1"),
        _judged("NUM-02", fails, "It is 3.", "2.2"),
        _judged("NUM-03", part.rounds_to("1.5", 1.49), "Rounded.", "2.3"),
        _judged("NUM-04", {"so": holds, "or so": fails}, "Either.", "3", rule="interpretations"),
        _judged("NUM-05", {"first": holds, "second": fails}, "Both.", "2.1"),
        _judged("NT-01", part.untestable("words"), "Wording.", "2.1"),
    ]


@pytest.fixture
def small_report(judged: list[JudgedClaim]) -> Report:
    """Every kind of block once, and the real animation."""
    table = PageTable(
        ("case", "topic", "verdict", "a", "b"),
        [
            ("one", "geometry", "pass", "alpha", "<script>alert(1)</script>"),
            ("two", "contact", "fail", "beta", "a | b"),
            ("three", "geometry", "pass", "1.5e-15", ""),
        ],
        "A table of cases. With more to say.",
        filters=("topic", "verdict"),
        verdict="verdict",
        name="cases-table",
    )
    svg = (
        '<?xml version="1.0"?>\n<!DOCTYPE svg>\n<svg viewBox="0 0 9 9">'
        "<metadata>by somebody</metadata><style>*{fill: red}</style>"
        '<g id="circle-g"><circle style="fill: #000000" r="4"/></g></svg>'
    )
    figures = [
        Figure(name, f"A {name}. Bears on NUM-01.", svg, f"a {name} to be seen")
        for name in ("circle", "ring")
    ]
    blocks: list[Block] = [
        Text("Plain <text> & more of theta_dot, 9.381e-4 kg m^2/s."),
        Text("Look here.", emphasis=True),
        *figures,
        table,
        PageTable(("a", "b"), [("1", "2")], "A short one."),
    ]
    cards = [
        Card("lambda", "1e-15", "order 1e-6", "holds", good=True),
        Card("x", "2", "3", "", good=False),
        Card("y", "2", "3", ""),
    ]
    motion = overview.motion((3.19, 7.82))
    first = Overview("It holds.", "All of 7 claims.", judged, cards, motion, {"a": 1})
    sections = [
        overview.errata(judged),
        Section("one", "One", blocks),
        overview.all_claims(judged, run_record(1, 1, FACTS)),
    ]
    return Report("Title", "Opening.", first, sections, FACTS)
