"""``tt-precise extremes``: what it prints, and its exit status, on two cases of its own."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import Printed, Said
from tt_precise.extremes import ExtremeCase
from tt_precise.extremes.case import CaseOutcome, Family


def found(**outcome: Any) -> CaseOutcome:
    """All is [well]."""
    return CaseOutcome(**outcome)


GOOD = ExtremeCase(
    Family("contact", "mu = 1", "theory", found, {}), {"measured": "1 eps", "value": 1.0}
)
BAD = ExtremeCase(
    Family("contact", "a start", "theory", found, {}), {"measured": "accepted", "holds": False}
)


@pytest.fixture(autouse=True)
def two_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "tt_precise.extremes.cases", lambda _, quick=False: (GOOD,) if quick else (GOOD, BAD)
    )


def test_a_failed_case_is_reported_and_fails_the_command(said: Said, tmp_path: Path) -> None:
    file = tmp_path / "extremes.json"
    text = said("extremes --out", file, status=1)
    assert "FAIL" in text
    assert "All is [well]." in text
    assert "not run" not in text
    document = json.loads(file.read_text())
    assert (document["verdict"], document["not_run"]) == ("fail", 0)


def test_json_and_a_line_for_every_case_with_full(printed: Printed, said: Said) -> None:
    document = printed("extremes --quick")
    assert document["schema"] == "tt_precise.extremes/1"
    assert document["not_run"] == 1
    (case,) = document["cases"]
    assert (case["name"], case["verdict"], case["value"]) == ("mu = 1", "pass", 1.0)
    assert (case["expected"], case["found"]) == ("All is [well].", "1 eps")
    text = said("extremes --quick --full")
    assert "mu = 1" in text
    assert "--quick ran the first case of each family; not run: 1." in text
