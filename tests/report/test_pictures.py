"""Pictures of the measured tables: those that the numbers allow, complete and small."""

from __future__ import annotations

import pytest

from tests.conftest import more
from tests.report.conftest import problems
from tt_precise.report import measured
from tt_precise.report.build import MEASURED
from tt_precise.report.document import Figure
from tt_precise.report.pictures import all_pictures

WORK = [{"mu": 10.0**n, "steps": 100.0 * 2**n, "seconds": 0.01} for n in range(-2, 3)]
LIMIT = [{"mu": 10.0**n, "distance": 10.0**-n} for n in range(3)]
NEAR = [{"off": 10.0**-n, "rate": 0.1 * n, "eigenvalue": 0.1 * n} for n in range(1, 4)]


@pytest.mark.parametrize(
    ("points", "names"),
    [
        (WORK, ["extremes-poles"]),  # without the limit there is nothing to compare with
        more([*WORK, *LIMIT, *NEAR], ["extremes-poles", "extremes-friction", "extremes-threshold"]),
    ],
)
def test_a_picture_is_drawn_where_its_numbers_are_there(
    points: list[dict[str, float]], names: list[str]
) -> None:
    assert [figure.name for figure in all_pictures(points)] == names


@pytest.mark.slow
@pytest.mark.parametrize("make", [measured.tradeoff, measured.extremes])
def test_the_pictures_of_the_committed_tables_are_complete(make: object) -> None:
    assert callable(make)
    figures = [block for block in make(MEASURED).blocks if isinstance(block, Figure)]
    assert figures
    found = {problem for figure in figures for problem in problems(figure)}
    # those of the extremes are about no claim
    assert not {problem for problem in found if not problem.startswith("bears on")}
