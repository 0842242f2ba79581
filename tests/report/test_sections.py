"""Sections, which a failing claim cannot hide, and how they are collected."""

from __future__ import annotations

import pytest

from tests.report.conftest import problems, tables
from tt_precise.report import sections
from tt_precise.report.document import Figure


def test_thresholds_state_forty_agreeing_digits() -> None:
    table = tables(sections.threshold_values())[0]
    assert len(table.rows) == 9
    assert min(int(row[3]) for row in table.rows) >= 40


EXPECTED = {
    *(f"figure-{n}" for n in range(2, 9)),
    "axis-at-the-pole", "deforming-potential", "jellett-drift", "times-by-inclination",
    "times-by-precession", "map-inclination-lambda", "map-friction-spin",
    "map-precession-spin",
}  # fmt: skip


@pytest.mark.slow
def test_all_figures() -> None:
    made = sections.reference, sections.other_starts, sections.conservation
    blocks = [block for make in (*made, sections.threshold_values) for block in make().blocks]
    figures = [block for block in blocks if isinstance(block, Figure)]
    assert {figure.name for figure in figures} == EXPECTED
    assert [problem for figure in figures for problem in problems(figure)] == []
