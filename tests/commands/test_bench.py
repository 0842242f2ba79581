"""The command bench, with bars of no time."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas
import pytest

from benchmarks import bars
from tt_precise import cli

ROW = {
    "name": "drift", "against": "integrate()", "value": 0.75, "aim": "at most 0.5", "met": False,
    "milliseconds": 1.5, "turns": 3,
}  # fmt: skip
MEASURED = bars.measured
UNKNOWN = {**ROW, "name": "a peer", "value": None, "met": None}


@pytest.fixture(autouse=True)
def measured(monkeypatch: pytest.MonkeyPatch) -> None:
    def rows(scratch: Path, scenes: int, only: Any, *others: Any) -> Iterator[dict[str, Any]]:
        yield from (row for row in (ROW, UNKNOWN) if not only or row["name"] in only)

    monkeypatch.setattr(bars, "measured", rows)


def test_a_missed_bar_is_a_finding(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "bench.csv"
    assert cli.main(["bench", "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "drift: 0.75 [at most 0.5: NOT met]  (integrate())"
    assert lines[1].startswith("a peer: not measured")
    assert list(pandas.read_csv(out)["met"].fillna("")) == ["NOT met", ""]


def test_json_has_the_bars(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bench", "--json", "--only", "drift"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == {"schema": "tt_precise.bench/1", "bars": [ROW]}


@pytest.mark.parametrize("others", [[], ["--only", "drift"]])
def test_a_bar_that_does_not_exist_is_refused_before_any_is_measured(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, others: list[str]
) -> None:
    monkeypatch.setattr(bars, "measured", MEASURED)
    monkeypatch.setattr(bars, "_row", lambda _: pytest.fail("measured"))
    assert cli.main(["bench", *others, "--only", "nothing"]) == 2
    captured = capsys.readouterr()
    assert "--only: got 'nothing', expected a part of one of: fastest peer" in captured.err
    assert captured.out == ""
