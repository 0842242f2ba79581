"""The summary of a sweep: of its rows alone, whatever the order of its chunks."""

import json
from pathlib import Path

import pytest

from tt_precise.sweeps import SweepSpec, run_sweep
from tt_precise.sweeps.columns import FIXED

SPEC = SweepSpec.of("reference", until="0.05", vary={"phi_dot": "-20:20:12"})
CHUNK = 4  # three chunks


def test_columns_and_summary() -> None:
    swept = run_sweep(SPEC, recheck=0, chunk=5)
    assert list(swept.rows.columns) == ["index", "phi_dot", *FIXED]
    assert list(swept.rows["index"]) == list(range(12))
    found = swept.summary
    assert found["schema"] == "tt_precise.sweep/1"
    assert found["rows"] == found["expected"] == found["outcomes"]["undecided"] == 12
    assert found["columns"]["phi_dot"] == {"min": -20, "max": 20, "mean": 0, "missing": 0}
    assert found["columns"]["t_end_A"]["missing"] == 12
    assert found["how"]["rows_computed"] == 12
    json.dumps(found)


def test_the_summary_does_not_depend_on_the_order_of_chunks(tmp_path: Path) -> None:
    run_sweep(SPEC, out=tmp_path / "sweep", chunk=CHUNK, recheck=0)
    written = json.loads((tmp_path / "sweep" / "summary.json").read_text())
    memory = run_sweep(SPEC, chunk=CHUNK, recheck=0).summary
    assert written["columns"] == memory["columns"]
    assert written["outcomes"] == memory["outcomes"]
    assert written["columns"]["phi_dot"]["mean"] == pytest.approx(0, abs=1e-14)
