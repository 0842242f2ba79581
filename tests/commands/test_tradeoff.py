"""The command tradeoff, with a plan of a second."""

import json
from pathlib import Path

import pandas
import pytest

from tt_precise import cli
from tt_precise.tradeoff import error_growth, measure
from tt_precise.tradeoff.findings import GROWTH, TABLE
from tt_precise.tradeoff.measure import Group, Trial
from tt_precise.tradeoff.methods import Method

KEYS = {"method", "setting", "precision", "error", "seconds", "steps", "jellett_drift"}
CASES = (
    Trial("heyoka", 1e-6, "extended", until="0.03"),  # compiled in a third of a second
    Trial("heyoka", 0.0, "extended", until="0.03"),
    Trial("SciPy DOP853, Python", 1e-9, until="0.03"),
)


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "quick", lambda: iter([Group("small", CASES, 2, 0.1)]))
    monkeypatch.setattr(measure, "IMPORTED", ())
    monkeypatch.setattr(measure, "WORKLOAD_ROUNDS", 2)
    frame = pandas.DataFrame(
        [{"scene": "rolling", "seed": seed, "t_s": t,
          "jellett": 1e-16 * t**0.5, "energy": 1e-16 * t}
         for seed in range(3) for t in (1.0, 10.0, 1000.0)]
    )  # fmt: skip
    monkeypatch.setattr(error_growth, "table", lambda spans, progress: frame)


def test_json_has_the_rows_and_the_ratios(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tradeoff", "--quick", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.tradeoff/2"
    assert [row["method"] for row in printed["rows"]] == [trial.method for trial in CASES]
    assert all(row.keys() >= KEYS for row in printed["rows"])
    loose, tight, peer = printed["rows"]
    assert tight["error"] < 1e-12 < loose["error"]
    assert (loose["peer"], peer["peer"]) == (False, True)
    assert all(row["seconds"] > 0 and row["jellett_drift"] < 1e-4 for row in printed["rows"])
    exponents = {name: value for name, value in printed["ratios"].items() if "growth" in name}
    assert exponents["growth of lambda, rolling, to 1e+03 s"] == pytest.approx(0.5)
    assert exponents["growth of E, rolling, to 1e+03 s"] == pytest.approx(1)
    assert printed["skipped"] == []


def test_tables_and_figures_are_written_where_they_are_wanted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["tradeoff", "--quick", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert "drift of the machine" in printed.out
    for name in (TABLE, GROWTH, "figures/work-precision.svg"):
        assert str(tmp_path / name) in printed.err
        assert (tmp_path / name).stat().st_size > 100


def test_what_is_missing_and_what_fails_is_skipped_with_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = Method("SciPy DOP853, Python", ("nowhere",), lambda p, s: None)  # type: ignore[arg-type, return-value]
    monkeypatch.setitem(measure.METHODS, missing.name, missing)
    at_pole = Trial("heyoka", 0.0, "extended", scene="upright", coordinates="euler", until="0.03")
    trials = (CASES[0], at_pole, CASES[2])
    monkeypatch.setattr(measure, "quick", lambda: iter([Group("small", trials, 1, 0.1)]))
    assert cli.main(["tradeoff", "--quick", "--json"]) == 0
    printed = capsys.readouterr()
    line = "SciPy DOP853, Python: needs nowhere (the extra peers)"
    assert f"skipped: {line}" in printed.err
    found = json.loads(printed.out)
    assert len(found["rows"]) == 1
    assert found["skipped"][0].startswith("upright, heyoka")
    assert found["skipped"][1] == line


def test_a_folder_that_cannot_be_written_is_reported_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert cli.main(["tradeoff", "--quick", "--out", str(tmp_path / "file" / "x")]) == 2
