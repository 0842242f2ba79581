"""The maps of the report: full grids of the present definition."""

from pathlib import Path

from tt_precise.report import maps
from tt_precise.runtime.cache import fingerprint, unpacked

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
