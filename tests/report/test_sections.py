"""Sections that need no integration, and that a failing claim cannot hide."""

from __future__ import annotations

import pandas

from tt_precise.claims import Judgement
from tt_precise.report.document import Table
from tt_precise.report.sections import claims, thresholds
from tt_precise.report.sections.measured import jellett_alone


def _table(blocks: object) -> Table:
    assert isinstance(blocks, list)
    return next(block for block in blocks if isinstance(block, Table))


def test_errata_hold_what_fails_and_only_that(judgements: list[Judgement]) -> None:
    section = claims.errata(judgements)
    assert [row[0] for row in _table(section.blocks).rows] == ["NUM-02", "EQ-01"]


def test_all_claims_puts_the_failing_ones_first(judgements: list[Judgement]) -> None:
    section = claims.all_claims(judgements, {})
    assert [row[0] for row in _table(section.blocks).rows] == ["NUM-02", "EQ-01", "NUM-01"]
    assert section.results["counts"]["refuted"] == 1
    assert len(section.results["claims"]) == 3


def test_thresholds_state_forty_agreeing_digits() -> None:
    section = thresholds.section()
    agreed = [int(row[3]) for row in _table(section.blocks).rows]
    assert len(agreed) == 9
    assert min(agreed) >= 40


def test_what_lambda_alone_would_show() -> None:
    rows = [
        ("dropped term", drift, caught)
        for drift, caught in [("1e-3", "True"), ("2e-7", "True"), ("", "False")]
    ]
    table = pandas.DataFrame(
        [*rows, ("healthy", "1e-3", "True")], columns=["kind", "jellett", "at_1e-06"]
    )
    told = jellett_alone(table)
    assert "of 3 terms" in told
    assert "alone shows 1 at" in told
    assert "together show 2." in told
