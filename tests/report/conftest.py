"""Judgements and a small report to render, made without any integration."""

from __future__ import annotations

import pytest

from tt_precise.claims import Claim, Judgement
from tt_precise.claims.verdicts import Finding, judged, misprint, statement
from tt_precise.report.document import Block, Card, Cards, Figure, Report, Section, Table, Text


def _judgement(id: str, finding: Finding) -> Judgement:
    return Judgement(
        Claim(id, f"claim {id} <b>", "a quote", "Sec. 0", "", lambda: finding, None), finding
    )


@pytest.fixture
def judgements() -> list[Judgement]:
    """One reproduced, one refuted, one misprinted claim."""
    holds = statement(True, printed="1", measured="1")
    fails = statement(False, printed="2", measured="3 | 4")
    return [
        _judgement("NUM-01", judged(holds, "As printed.")),
        _judgement("NUM-02", judged(fails, "It is 3.")),
        _judgement("EQ-01", misprint(fails, holds, "x = 3", "A sign.")),
    ]


@pytest.fixture
def small_report() -> Report:
    """Every kind of block once."""
    table = Table(
        ("claim", "kind", "verdict", "a", "b"),
        [
            ("NUM-01", "number", "reproduced", "alpha", "<script>alert(1)</script>"),
            ("NUM-02", "number", "refuted", "beta", "a | b"),
            ("EQ-01", "equation", "misprint", "gamma", ""),
        ],
        filters=("kind", "verdict"),
        verdict="verdict",
        name="claims-table",
    )
    svg = '<?xml version="1.0"?>\n<!DOCTYPE svg>\n<svg viewBox="0 0 9 9"><circle r="4"/></svg>'
    blocks: list[Block] = [
        Text("Plain <text> & more."),
        Text("Look here.", emphasis=True),
        Cards([Card("lambda", "1e-15", "holds", good=True), Card("x", "2", "", good=False)]),
        Figure("circle", "A circle.", svg, "a circle"),
        table,
    ]
    return Report("Title", "Opening.", [Section("one", "One", blocks)], [("date", "today")])
