"""The command tradeoff, with a plan of a second."""

import json
from pathlib import Path

import pandas
import pytest

from tests.conftest import Said
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
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "tt_precise.tradeoff/2"
    assert [row["method"] for row in document["rows"]] == [trial.method for trial in CASES]
    assert all(row.keys() >= KEYS for row in document["rows"])
    loose, tight, peer = document["rows"]
    assert tight["error"] < 1e-12 < loose["error"]
    assert (loose["peer"], peer["peer"]) == (False, True)
    assert all(row["seconds"] > 0 and row["jellett_drift"] < 1e-4 for row in document["rows"])
    for name, exponent in (("lambda", 0.5), ("E", 1)):
        found = document["ratios"][f"growth of {name}, rolling, to 1e+03 s"]
        assert found == pytest.approx(exponent)
    assert document["skipped"] == []


def test_tables_and_figures_are_written_where_they_are_wanted(
    tmp_path: Path, said: Said, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["tradeoff", "--quick", "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "drift of the machine" in out
    for name in (TABLE, GROWTH, "figures/work-precision.svg"):
        assert str(tmp_path / name) in err
        assert (tmp_path / name).stat().st_size > 100
    said("tradeoff --quick --out", tmp_path / TABLE / "x", status=2)  # no folder


def test_what_is_missing_and_what_fails_is_skipped_with_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = Method("SciPy DOP853, Python", ("nowhere",), lambda p, s: None)  # type: ignore[arg-type, return-value]
    monkeypatch.setitem(measure.METHODS, missing.name, missing)
    at_pole = Trial("heyoka", 0.0, "extended", scene="upright", coordinates="euler", until="0.03")
    trials = (CASES[0], at_pole, CASES[2])
    monkeypatch.setattr(measure, "quick", lambda: iter([Group("small", trials, 1, 0.1)]))
    assert cli.main(["tradeoff", "--quick", "--json"]) == 0
    out, err = capsys.readouterr()
    line = "SciPy DOP853, Python: needs nowhere (the extra peers)"
    assert f"skipped: {line}" in err
    document = json.loads(out)
    assert len(document["rows"]) == 1
    assert document["skipped"][0].startswith("upright, heyoka")
    assert document["skipped"][1] == line
