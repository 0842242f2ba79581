"""The command ``claims``."""

import pytest

from tests.conftest import Printed, Said
from tt_precise.claims.committed import JudgingRun

CHEAP = "claims --workers 1 NUM-23 EQ-26 EQ-29 TH-17"


def test_looked_up_and_computed_verdicts_are_the_same(printed: Printed) -> None:
    looked_up, computed = printed(CHEAP), printed(CHEAP, "--again")
    assert set(looked_up["run"]) >= {"date", "commit", "versions", "stale"}
    assert "run" not in computed
    assert looked_up["claims"] == computed["claims"]


def test_the_run_behind_the_verdicts_is_named(said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    for stale in (False, True):
        monkeypatch.setattr(JudgingRun, "outdated", stale)
        text = said("claims NUM-23")
        assert "From the run" in text
        assert ("STALE" in text) == stale
    # without committed verdicts they are computed
    monkeypatch.setattr("tt_precise.claims.committed.committed", lambda: None)
    assert "From the run" not in said("claims NUM-23 --workers 1")


def test_filters_combine(printed: Printed) -> None:
    asked = "--verdict misprint,refuted --kind equation,theorem,number"
    assert printed(CHEAP, asked)["counts"] == printed(CHEAP, "--verdict misprint")["counts"]
    found = printed(CHEAP, "--verdict misprint --kind equation")
    assert [claim["id"] for claim in found["claims"]] == ["EQ-26", "EQ-29"]
    assert found["counts"]["misprint"] == sum(found["counts"].values()) == 2


def test_a_table_on_a_pipe_is_not_cut(said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    full = said("claims --verdict misprint --full")
    assert "corrected: discriminant of d(z): 0 for the toy's alpha and gamma" in full
    text = said("claims --verdict misprint")
    assert "The last step takes w0 out of -w0 + w." in text
    assert max(map(len, text.splitlines())) <= 100
    assert "\u2026" not in text
    assert not any(line.endswith(" ") for line in text.splitlines())


def test_many_claims_make_a_table_that_fits(said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = said(CHEAP).splitlines()
    assert all(len(line) <= 80 for line in lines)
    rows = [line for line in lines[1:5] if not line.startswith(" ")]  # a long claim is wrapped
    assert [" ".join(line.split()[:2]) for line in rows[:2]] == ["EQ-26 misprint", "EQ-29 misprint"]
    assert "gamma and alpha makes d(z) a square." in " ".join(" ".join(lines[1:3]).split())
    assert "\u2026" not in "".join(lines)
