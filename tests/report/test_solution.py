"""The figures of the reference solution: complete, small, bound to claims that exist."""

import re
from typing import Any

import pytest

from tests.conftest import more
from tests.report.conftest import problems
from tt_precise.claims.evidence.run import REFERENCE
from tt_precise.report import solution


@pytest.mark.parametrize(
    "draw",
    [
        solution.figure_2,
        more(solution.figure_7),
        more(solution.deforming_potential),
        solution.axis_at_the_pole,
    ],
)
def test_a_figure_is_complete(draw: Any) -> None:
    figure = draw()
    assert problems(figure) == []
    if draw is solution.figure_2:  # its caption has the spike of phi_dot, above any sampled maximum
        (height,) = re.findall(r"spike of ([\d,]+) rad/s", figure.caption)
        assert int(height.replace(",", "")) > 40_000


def test_the_spike_is_in_the_course_and_not_in_samples() -> None:
    course = solution.course("phi_dot")
    sampled = REFERENCE.columns(["phi_dot"], [0.01 * k for k in range(801)])
    assert abs(course["phi_dot"]).max() > 20_000
    assert abs(sampled["phi_dot"]).max() < 10_000
