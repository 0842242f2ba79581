"""The figures of the report: functions without arguments, listed here by section."""

from __future__ import annotations

from collections.abc import Callable

from tt_precise.report import solution as paper
from tt_precise.report import starts as many_starts
from tt_precise.report.document import Figure

FIGURES: dict[str, tuple[Callable[[], Figure], ...]] = {
    "figures": (
        paper.figure_2, paper.figure_3, paper.figure_4, paper.figure_5, paper.figure_6,
        paper.figure_7, paper.figure_8, paper.deforming_potential, paper.axis_at_the_pole,
    ),
    "conservation": (paper.jellett_drift,),
    "starts": (
        many_starts.times_by_precession, many_starts.times_by_inclination,
        many_starts.map_of_inclination_and_lambda, many_starts.map_of_friction_and_spin,
        many_starts.map_of_precession_and_spin,
    ),
    "thresholds": (many_starts.outcomes_at_the_threshold,),
}  # fmt: skip


def figures_of(section: str) -> list[Figure]:
    """The figures of a section."""
    return [draw() for draw in FIGURES[section]]


def all_figures() -> list[Figure]:
    """The figures of all sections."""
    return [figure for section in FIGURES for figure in figures_of(section)]
