"""The report's figures: complete, small, and bound to statements of the paper that exist."""

import re
from xml.etree import ElementTree

import pytest

from tt_precise.claims import claims
from tt_precise.report import solution as paper
from tt_precise.report import starts as many_starts
from tt_precise.report.document import Figure
from tt_precise.report.sections import FIGURES, figures_of

LARGEST = 300_000  # characters of SVG
EXPECTED = {
    *(f"figure-{n}" for n in range(2, 9)),
    "axis-at-the-pole", "deforming-potential", "jellett-drift", "times-by-inclination",
    "times-by-precession", "map-inclination-lambda", "map-friction-spin",
    "map-precession-spin", "outcomes-at-the-threshold",
}  # fmt: skip
CLAIM = re.compile(r"\b(?:EQ|TH|NUM|QUAL|FIG|SWP|SUM|NT)-\d\d\b")


def problems(figure: Figure) -> list[str]:
    """What is wrong with a figure."""
    found = []
    if not ElementTree.fromstring(figure.svg).tag.endswith("svg"):
        found.append("no svg")
    if len(figure.svg) > LARGEST:
        found.append(f"{len(figure.svg)} characters")
    if not figure.alt or "nan" in figure.caption:
        found.append("alt or caption incomplete")
    named = CLAIM.findall(figure.caption)
    if not named or not set(named) <= set(claims()):
        found.append(f"bears on {named}")
    return found


@pytest.mark.parametrize(
    "draw",
    [
        paper.figure_2,
        paper.figure_7,
        paper.deforming_potential,
        paper.axis_at_the_pole,
        many_starts.times_by_precession,
        many_starts.times_by_inclination,
        many_starts.map_of_inclination_and_lambda,
        many_starts.map_of_friction_and_spin,
        many_starts.map_of_precession_and_spin,
    ],
)
def test_figure_is_complete(draw: object) -> None:
    assert callable(draw)
    assert problems(draw()) == []


def test_the_spike_is_drawn() -> None:
    """The tallest mark of phi_dot in Figure 2 stands in its caption, above any sampled maximum."""
    figure = paper.figure_2()
    assert figure is not None
    height = re.search(r"spike of ([\d,]+) rad/s", figure.caption)
    assert height
    assert int(height[1].replace(",", "")) > 40_000


@pytest.mark.slow
def test_all_figures() -> None:
    figures = [figure for section in FIGURES for figure in figures_of(section)]
    assert {figure.name for figure in figures} == EXPECTED
    assert [problem for figure in figures for problem in problems(figure)] == []
