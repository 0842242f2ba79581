"""The rows of the figures of other starts: full grids, of the present definition."""

from __future__ import annotations

from pathlib import Path

import pandas

from tt_precise.report import starts
from tt_precise.runtime.cache import fingerprint, unpacked

FILE = Path(__file__).parents[2] / "reports/measured" / starts.FILE


def test_the_shaded_intervals_are_those_of_the_starts_that_lose_contact() -> None:
    contact = ["bilateral", "", "", "bilateral", "bilateral", ""]
    rows = pandas.DataFrame({"x": [0.0, 1, 2, 3, 4, 8], "contact": contact})
    assert starts.lost_contact(rows, "x") == [(0, 0.5), (2.5, 6)]
    assert starts.lost_contact(rows[1:3].reset_index(drop=True), "x") == []
    assert starts.lost_contact(rows[3:5].reset_index(drop=True), "x") == [(3, 4)]


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
