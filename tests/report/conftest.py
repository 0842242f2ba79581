"""Judged claims and a small report to render, made without any integration."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from tt_precise.claims import Claim, JudgedClaim, claims, part, verdicts
from tt_precise.claims.claim import Wording
from tt_precise.claims.verdicts import run_record
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

LARGEST_FIGURE = 300_000  # Characters of SVG.
FACTS = {
    "versions": "tt-precise 1", "machine": "m", "precision": "p", "command": "c", "commit": "abc",
    "date": "today",
}  # fmt: skip
PRINTED = "R*I1*phi_dot*sin(theta)**2 - I3*omega_3*(alpha - cos(theta))"
CORRECT = "R*I1*phi_dot*sin(theta)**2 - R*I3*omega_3*(alpha - cos(theta))"
CLAIM = re.compile(r"\b(?:EQ|TH|NUM|QUAL|FIG|SWP|SUM|NT)-\d\d\b")


def problems(figure: Figure) -> list[str]:
    """Return the problems of a figure."""
    complaints = []
    if not ElementTree.fromstring(figure.svg).tag.endswith("svg"):
        complaints.append("no svg")
    if len(figure.svg) > LARGEST_FIGURE:
        complaints.append(f"{len(figure.svg)} characters")
    paths = re.findall(r' d="([^"]*)"', figure.svg)
    if not paths or any(re.search(r"\.\d{3}", path) for path in paths):
        complaints.append("paths are long")
    if not figure.alt or "nan" in figure.caption or "{" in figure.caption:
        complaints.append("alt or caption incomplete")
    if not set(CLAIM.findall(figure.caption)) <= set(claims()):
        complaints.append("names a claim that does not exist")
    return complaints


def tables(section: Section) -> list[PageTable]:
    return [block for block in section.blocks if isinstance(block, PageTable)]


def figures(section: Section) -> list[Figure]:
    return [block for block in section.blocks if isinstance(block, Figure)]


def _judged(
    id: str, parts: verdicts.Parts, note: str, section: str = "1", rule: verdicts.Rule = "all of"
) -> JudgedClaim:
    words = Wording(
        f"claim {id} <b> of theta_dot", f"Sec. {section}", "a quote", "as in theta", note
    )
    return Claim(id, section, words, lambda: parts, rule, id).judge()


@pytest.fixture
def judged() -> list[JudgedClaim]:
    """Claims of each verdict, in five sections of the paper."""
    holds, fails = part.statement(True, "1", "1"), part.statement(False, "2", "3 | 4")
    right = part.formula(True, CORRECT, "equal", proved=True)
    wrong = part.formula(False, PRINTED, "off by 40 % of its size", proved=True)
    misprint = {"as printed": wrong, "as corrected": right}
    return [
        _judged("EQ-01", misprint, "A factor R.", rule="misprint"),
        _judged("NUM-01", holds, "As printed.", "2.1"),
        _judged("NUM-02", fails, "It is 3.", "2.2"),
        _judged("NUM-03", part.rounds_to("1.5", 1.49), "Rounded.", "2.3"),
        _judged("NUM-04", {"so": holds, "or so": fails}, "Either.", "3", rule="interpretations"),
        _judged("NUM-05", {"first": holds, "second": fails}, "Both.", "2.1"),
        _judged("NT-01", part.untestable("words"), "Words.", "2.1"),
    ]


@pytest.fixture
def small_report(judged: list[JudgedClaim]) -> Report:
    """Every kind of block once, and the real animation."""
    table = PageTable(
        ("case", "topic", "verdict", "a", "b"),
        [
            ("one", "geometry", "pass", "alpha", "<script>alert(1)</script>"),
            ("two", "contact", "fail", "beta", "a | b"),
        ],
        "A table of cases. With more to say.",
        "cases-table",
        filters=("topic", "verdict"),
        verdict="verdict",
    )
    svg = '<?xml version="1.0"?><svg viewBox="0 0 9 9"><circle r="4"/></svg>'
    blocks: list[Block] = [
        Text("Plain <text> & more of theta_dot, 9.381e-4 kg m^2/s."),
        Text("Look here.", emphasis=True),
        Text("Long.", folded="In detail"),
        *(Figure(n, svg, f"A {n}. Of NUM-01.", f"a {n} to be seen") for n in ("circle", "ring")),
        table,
        PageTable(("a", "b"), [("1", "2")], "A short one."),
    ]
    cards = {
        "NUM-03": Card("lambda", "1e-15", "order 1e-6", "holds"),
        "NUM-02": Card("x", "2", "3", ""),
        "NUM-05": Card("y", "2", "3", ""),
    }
    computed = Overview(cards, overview.motion(3.19, 7.82), {"a": 1})
    sections = [
        overview.errata(judged),
        Section("one", "One", blocks),
        overview.all_claims(judged, run_record(1, 1, FACTS)),
    ]
    first = overview.overview(judged, computed)
    return Report("Title", "Opening.", first, sections, FACTS)
