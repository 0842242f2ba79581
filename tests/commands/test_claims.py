"""The command ``claims``."""

import json
import subprocess
import sys

import pytest

from tt_precise.claims.committed import JudgingRun
from tt_precise.cli import main

CHEAP = ["NUM-23", "EQ-26", "EQ-29", "TH-17"]


def run(*arguments: str) -> int:
    return main(["claims", "--workers", "1", *arguments])


def test_looked_up_and_computed_verdicts_are_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*CHEAP, "--json") == 0
    looked_up = json.loads(capsys.readouterr().out)
    assert set(looked_up["run"]) >= {"date", "commit", "versions", "stale"}
    assert run(*CHEAP, "--again", "--json") == 0
    computed = json.loads(capsys.readouterr().out)
    assert "run" not in computed
    assert looked_up["claims"] == computed["claims"]


def test_it_says_from_which_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for stale in (False, True):
        monkeypatch.setattr(JudgingRun, "outdated", stale)
        assert run("NUM-23") == 0
        assert ("STALE" in capsys.readouterr().out) == stale


def test_without_committed_verdicts_they_are_computed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tt_precise.claims.committed.committed", lambda: None)
    assert run("NUM-23") == 0
    assert "From the run" not in capsys.readouterr().out


def test_looking_up_needs_nothing_heavy() -> None:
    code = (
        "import sys; from tt_precise.cli import main\n"
        "assert main(['claims', '--verdict', 'misprint', '--json']) == 0\n"
        "assert not {'heyoka', 'sympy', 'pandas', 'numpy', 'mpmath'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_filters_combine(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*CHEAP, "--verdict", "misprint", "--kind", "equation", "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert [one["id"] for one in printed["claims"]] == ["EQ-26", "EQ-29"]
    assert printed["counts"]["misprint"] == sum(printed["counts"].values()) == 2


def test_many_claims_make_a_table_that_fits(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert run(*CHEAP) == 0
    out = capsys.readouterr().out
    assert all(len(line) <= 80 for line in out.splitlines())
    assert [line.split()[:2] for line in out.splitlines()[1:3]] == [
        ["EQ-26", "misprint"],
        ["EQ-29", "misprint"],
    ]
