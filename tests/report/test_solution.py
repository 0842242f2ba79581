"""Sections, all their figures, and the reference scene in every precision."""

from __future__ import annotations

import re

import pytest

from tests.report.conftest import figures, problems, tables
from tt_precise.claims.evidence.run import REFERENCE
from tt_precise.integration import integrate
from tt_precise.report.build import SECTIONS
from tt_precise.report.document import words
from tt_precise.report.solution import SCENE, figure_2, precision_runs, state_distance
from tt_precise.report.starts import map_of_precession_and_spin, threshold_values
from tt_precise.scene.scene import load_scene


def test_thresholds_state_forty_agreeing_digits() -> None:
    values, how = tables(threshold_values())
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


@pytest.mark.slow
def test_the_finest_run_is_what_200_bits_give() -> None:
    *others, finest = precision_runs()
    assert finest.trajectory.precision.name == "triple-double"
    wide = integrate(SCENE, "mp")
    assert state_distance(finest.trajectory, wide) < 1e-40
    for run in others:
        apart = state_distance(run.trajectory, wide)
        assert apart == pytest.approx(run.state_error, rel=1e-6)
        assert apart > 1e-34  # what the first bound would not let pass


def test_the_distance_is_that_of_the_worst_component() -> None:
    scene = load_scene(SCENE).varied(until="1e-3")
    own, other = integrate(scene), integrate(scene.varied(omega_3="156"))
    # L.z is I3 cos(theta) omega_3, of which 1 rad/s is sqrt(R/g) units
    apart = 0.4 * 0.995 * (0.02 / 9.82) ** 0.5
    assert state_distance(own, other) == pytest.approx(apart, rel=0.01)
