"""The figures of other starts: complete, small, bound to claims that exist."""

from typing import Any

import pytest

from tests.report.conftest import problems
from tt_precise.report import starts


@pytest.mark.parametrize(
    "draw",
    [
        starts.times_by_precession,
        starts.times_by_inclination,
        starts.map_of_inclination_and_lambda,
        starts.map_of_friction_and_spin,
        starts.map_of_precession_and_spin,
    ],
)
def test_a_figure_is_complete(draw: Any) -> None:
    assert problems(draw()) == []
