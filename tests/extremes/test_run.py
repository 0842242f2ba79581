"""Test the records of cases, and the command on two cases."""

import json
from pathlib import Path

import pytest

from tests.conftest import Said
from tt_precise.extremes import EdgeCase, cases, run
from tt_precise.extremes.judges import Measurement, is_refused


def test_an_exception_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def judge(case: EdgeCase) -> Measurement:
        """Expect nothing."""
        raise ValueError("why")

    case = EdgeCase("poles", "bad", judge)
    monkeypatch.setattr(run, "cases", lambda: [case])
    record = run.record(case, run.judge("bad"))
    assert (record.verdict, record.expected, record.limit) == ("fail", "Expect nothing.", None)
    assert record.found == "ValueError: why"
    assert run.run_cases([]).verdict == "fail"  # nothing was tested


def test_a_failed_case_fails_the_command(
    said: Said, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = next(case for case in cases() if case.judge is is_refused)
    bad = EdgeCase("poles", "no such case", is_refused)
    monkeypatch.setattr("tt_precise.commands.numerics.cases", lambda: [good, bad])
    file = tmp_path / "extremes.json"
    assert "2 cases, 1 failed." in said("extremes --workers 1 --out", file, status=1)
    document = json.loads(file.read_text())
    assert [case["verdict"] for case in document["cases"]] == ["pass", "fail"]
    assert "1 cases, 0 failed." in said("extremes --workers 1 --topic contact")
