"""The maps of the report: up to date, full grids, and no top inverts below the threshold."""

import json
from pathlib import Path

from tt_precise.golden import store
from tt_precise.report import maps
from tt_precise.runtime.cache import fingerprint, unpacked

FILE = Path(__file__).parents[2] / "reports" / maps.FILE


def test_the_committed_file_is_of_the_present_definition() -> None:
    assert unpacked(FILE.read_bytes(), fingerprint(maps.definition())) is not None


def test_maps_are_full_grids() -> None:
    for name, (x, y) in maps.MAPS.items():
        rows = maps.map_rows(name)
        pairs = set(zip(rows[x.name], rows[y.name], strict=True))
        assert len(pairs) == len(rows) == maps.COUNT**2


def test_nothing_inverts_below_the_threshold() -> None:
    for name in maps.MAPS:
        rows = maps.map_rows(name)
        inverts = rows["outcome"] == "inverts"
        assert inverts.any()
        assert (rows["lambda_ratio"][inverts] > 1).all()


def test_no_start_inverts_where_that_is_proved() -> None:
    proved = json.loads((store.home() / "reference" / "starts-map.json").read_text("utf-8"))
    sides = maps.MAPS["precession and spin"]
    for side, known in zip(sides, proved["sides"], strict=True):
        assert (known["name"], float(known["low"]), float(known["high"]), known["count"]) == (
            side.name, side.low, side.high, maps.COUNT,
        )  # fmt: skip
    rows = maps.map_rows("precession and spin").sort_values(["omega_3", "phi_dot"])
    computed = dict(enumerate(rows["outcome"]))
    letters = "".join(proved["cells"])
    assert {computed[i] for i, one in enumerate(letters) if one == "g"} == {"does_not_invert"}
    assert "inverts" not in {computed[i] for i, one in enumerate(letters) if one == "n"}
    assert "inverts" in {computed[i] for i, one in enumerate(letters) if one == "u"}
