"""The figures and maps of the report: complete, small, bound to statements that exist."""

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from tt_precise.claims import claims
from tt_precise.report import maps
from tt_precise.report import solution as paper
from tt_precise.report import starts as many_starts
from tt_precise.report.document import Figure
from tt_precise.report.sections import FIGURES, figures_of
from tt_precise.runtime.cache import fingerprint, unpacked

LARGEST = 300_000  # characters of SVG
EXPECTED = {
    *(f"figure-{n}" for n in range(2, 9)),
    "axis-at-the-pole", "deforming-potential", "jellett-drift", "times-by-inclination",
    "times-by-precession", "map-inclination-lambda", "map-friction-spin",
    "map-precession-spin",
}  # fmt: skip
CLAIM = re.compile(r"\b(?:EQ|TH|NUM|QUAL|FIG|SWP|SUM|NT)-\d\d\b")


def problems(figure: Figure) -> list[str]:
    """What is wrong with a figure."""
    found = []
    if not ElementTree.fromstring(figure.svg).tag.endswith("svg"):
        found.append("no svg")
    if len(figure.svg) > LARGEST:
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
def test_figure_is_complete(draw: Any) -> None:
    figure = draw()
    assert problems(figure) == []
    if draw is paper.figure_2:  # its caption has the spike of phi_dot, above any sampled maximum
        (height,) = re.findall(r"spike of ([\d,]+) rad/s", figure.caption)
        assert int(height.replace(",", "")) > 40_000


@pytest.mark.slow
def test_all_figures() -> None:
    figures = [figure for section in FIGURES for figure in figures_of(section)]
    assert {figure.name for figure in figures} == EXPECTED
    assert [problem for figure in figures for problem in problems(figure)] == []


FILE = Path(__file__).parents[2] / "reports/measured" / maps.FILE


def test_the_committed_file_is_of_the_present_definition() -> None:
    assert unpacked(FILE.read_bytes(), fingerprint(maps.definition())) is not None


def test_maps_are_full_grids_and_nothing_stands_inverted_below_the_threshold() -> None:
    for name, (x, y) in maps.MAPS.items():
        rows = maps.map_rows(name)
        pairs = set(zip(rows[x.name], rows[y.name], strict=True))
        assert len(pairs) == len(rows) == maps.COUNT**2
        inverted = rows["end_theta"] > 3.1
        assert inverted.any()
        assert (rows["outcome"][inverted] == "inverts").all()
        assert (rows["lambda_ratio"][inverted] > 1).all()
