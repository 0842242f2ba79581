"""The measurement of work and precision, with a plan of a second."""

from pathlib import Path

import pandas
import pytest

from benchmarks.work_precision import long_runs, measure
from benchmarks.work_precision.__main__ import main
from benchmarks.work_precision.findings import GROWTH, TABLE
from benchmarks.work_precision.measure import Group, Trial
from benchmarks.work_precision.peers import Method

KEYS = {"method", "setting", "precision", "error", "seconds", "steps", "jellett_drift"}
CASES = (
    Trial("heyoka", 1e-6, until="0.03"),
    Trial("heyoka", 0.0, until="0.03"),
    Trial("SciPy DOP853, Python", 1e-9, until="0.03"),
)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "whole", lambda: iter([Group("small", CASES, 2, 0.1)]))
    monkeypatch.setattr(measure, "WORKLOAD_ROUNDS", 2)
    frame = pandas.DataFrame(
        [{"scene": "rolling", "seed": seed, "t_s": t,
          "jellett": 1e-16 * t**0.5, "energy": 1e-16 * t}
         for seed in range(3) for t in (1.0, 10.0, 1000.0)]
    )  # fmt: skip
    monkeypatch.setattr(long_runs, "table", lambda spans, progress: frame)


def test_it_writes_the_tables_and_prints_the_findings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["--out", str(tmp_path)])
    out, err = capsys.readouterr()
    assert "skipped" not in err
    for name, exponent in (("lambda", "0.5"), ("E", "1")):
        assert f"growth of {name}, rolling, to 1e+03 s: {exponent}" in out
    assert len(pandas.read_csv(tmp_path / GROWTH)) == 9
    rows = pandas.read_csv(tmp_path / TABLE).dropna(subset="error")
    assert rows["method"].tolist() == [trial.method for trial in CASES]
    assert set(rows) >= KEYS
    loose, tight, _ = rows["error"]
    assert tight < 1e-12 < loose
    assert [str(peer) for peer in rows["peer"]] == ["False", "False", "True"]
    assert (rows["seconds"] > 0).all()
    assert (rows["jellett_drift"] < 1e-4).all()


def test_what_is_missing_and_what_fails_is_skipped_with_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    missing = Method("SciPy DOP853, Python", ("nowhere",), lambda p, s: None)  # type: ignore[arg-type, return-value]
    monkeypatch.setitem(measure.METHODS, missing.name, missing)
    at_pole = Trial("heyoka", 0.0, scene="upright", coordinates="euler", until="0.03")
    lines: list[str] = []
    plan = [Group("small", (CASES[0], at_pole, CASES[2]), 1, 0.1)]
    measured = measure.measure(plan, lines.append)
    assert len(measured.rows) == 1
    assert measured.skipped[0].startswith("upright, heyoka")
    assert "needs nowhere" in measured.skipped[1]
    assert f"skipped: {measured.skipped[1]}" in lines
