"""The figures of other starts: complete, small, bound to claims that exist; full grids."""

from pathlib import Path
from typing import Any

import pytest

from tests.conftest import more
from tests.report.conftest import problems
from tt_precise.report import starts
from tt_precise.runtime.cache import fingerprint, unpacked

FILE = Path(__file__).parents[2] / "reports/measured" / starts.FILE


@pytest.mark.parametrize(
    "draw",
    [
        starts.times_by_precession,
        more(starts.times_by_inclination),
        more(starts.map_of_inclination_and_lambda),
        more(starts.map_of_friction_and_spin),
        starts.map_of_precession_and_spin,
    ],
)
def test_a_figure_is_complete(draw: Any) -> None:
    assert problems(draw()) == []


def test_the_committed_file_is_of_the_present_definition() -> None:
    assert unpacked(FILE.read_bytes(), fingerprint(starts.definition())) is not None


def test_maps_are_full_grids_and_nothing_stands_inverted_below_the_threshold() -> None:
    for name, (x, y) in starts.MAPS.items():
        rows = starts.map_rows(name)
        pairs = set(zip(rows[x.name], rows[y.name], strict=True))
        assert len(pairs) == len(rows) == starts.COUNT**2
        inverted = rows["end_theta"] > 3.1
        assert inverted.any()
        assert (rows["outcome"][inverted] == "inverts").all()
        assert (rows["lambda_ratio"][inverted] > 1).all()


def test_the_spin_of_a_map_is_that_of_the_ratio_asked_for() -> None:
    rows = starts.map_rows("inclination and lambda")[::97]
    spins = starts._spins(rows["theta"].to_numpy(), rows["lambda_ratio"].to_numpy())
    assert spins == pytest.approx(rows["omega_3"].to_numpy(), rel=1e-9)
