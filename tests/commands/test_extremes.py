"""``tt-precise extremes``: what it prints, and its exit status, on two cases of its own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tt_precise import cli
from tt_precise.extremes import ExtremeCase
from tt_precise.extremes.case import noted

GOOD = ExtremeCase(
    "contact", "mu = {mu}", "mu = 1", "all [well]", "theory", noted,
    {"measured": "1 eps", "value": 1.0}, quick=True,
)  # fmt: skip
BAD = ExtremeCase(
    "contact", "a start", "a start", "a refusal", "theory", noted,
    {"measured": "accepted", "holds": False},
)  # fmt: skip


@pytest.fixture(autouse=True)
def two_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    def chosen(topics: tuple[str, ...], quick: bool) -> tuple[ExtremeCase, ...]:
        return (GOOD,) if quick else (GOOD, BAD)

    monkeypatch.setattr("tt_precise.extremes.cases", chosen)


def test_a_failed_case_is_reported_and_fails_the_command(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "extremes.json"
    assert cli.main(["extremes", "--out", str(file)]) == 1
    printed = capsys.readouterr().out
    assert "FAIL" in printed
    assert "all [well]" in printed
    assert json.loads(file.read_text())["verdict"] == "fail"


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["extremes", "--quick", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.extremes/1"
    (case,) = printed["cases"]
    assert (case["name"], case["verdict"], case["value"]) == ("mu = 1", "pass", 1.0)
    assert (case["expected"], case["found"]) == ("all [well]", "1 eps")


def test_every_case_has_a_line_with_full(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["extremes", "--quick", "--full"]) == 0
    assert "mu = 1" in capsys.readouterr().out
