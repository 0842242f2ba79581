"""Sections, which a failing claim cannot hide, and all their figures."""

from __future__ import annotations

import re

import pytest

from tests.report.conftest import figures, problems, tables
from tt_precise.claims.evidence.run import REFERENCE
from tt_precise.report import sections
from tt_precise.report.build import SECTIONS
from tt_precise.report.document import words
from tt_precise.report.solution import figure_2
from tt_precise.report.starts import map_of_precession_and_spin


def test_thresholds_state_forty_agreeing_digits() -> None:
    values, how = tables(sections.threshold_values())
    assert len(values.rows) == len(how.rows) == 9
    assert min(int(row[3]) for row in values.rows) >= 40


def test_two_figures_are_complete_and_the_same_data_give_the_same_text() -> None:
    spike, starts = figure_2(), map_of_precession_and_spin()
    assert problems(spike) + problems(starts) == []
    assert map_of_precession_and_spin().svg == starts.svg
    # the spike is above any sampled maximum
    (height,) = re.findall(r"spike of ([\d,]+) rad/s", spike.caption)
    sampled = REFERENCE.columns(["phi_dot"], [0.01 * k for k in range(801)])["phi_dot"]
    assert int(height.replace(",", "")) > 40_000 > 10_000 > abs(sampled).max()


@pytest.mark.slow
def test_every_figure_that_has_words_is_drawn_and_complete() -> None:
    drawn = [figure for make, _ in SECTIONS.values() for figure in figures(make())]
    names = {figure.name for figure in drawn}
    assert names >= {name for level, name in words() if level == "##"}
    assert [problem for figure in drawn for problem in problems(figure)] == []
