"""``tt-precise claims`` and ``report``: verdicts, and what the report's command opens."""

from pathlib import Path

import pytest

from tests.conftest import Printed, Said
from tt_precise.claims.verdicts import JudgingRun
from tt_precise.report import build

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
    monkeypatch.setattr("tt_precise.claims.verdicts.committed", lambda: None)
    assert "From the run" not in said("claims NUM-23 --workers 1")


def test_filters_combine(printed: Printed) -> None:
    asked = "--verdict misprint,refuted --kind equation,theorem,number"
    assert printed(CHEAP, asked)["counts"] == printed(CHEAP, "--verdict misprint")["counts"]
    found = printed(CHEAP, "--verdict misprint --kind equation")
    assert [claim["id"] for claim in found["claims"]] == ["EQ-26", "EQ-29"]
    assert found["counts"]["misprint"] == sum(found["counts"].values()) == 2


def test_many_claims_are_a_line_each_and_few_have_all_words(said: Said) -> None:
    lines = said(CHEAP).splitlines()
    assert {line.split()[0] for line in lines[:4]} == {"NUM-23", "EQ-26", "EQ-29", "TH-17"}
    assert lines[4].startswith("4 claims: ")
    text = said("claims --verdict misprint --full")
    assert "corrected: discriminant of d(z): 0 for the toy's alpha and gamma" in text
    assert "  the paper   " in said("claims EQ-26")


def test_the_command_names_and_opens_the_page_that_it_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: Said
) -> None:
    page = tmp_path / "out" / f"{build.NAME}.html"
    opened: list[str] = []

    def opens(address: str) -> bool:
        opened.append(address)
        return True

    def written(folder: Path, command: str, progress: object) -> list[Path]:
        assert command == f"tt-precise report --out {folder}"
        page.parent.mkdir(exist_ok=True)
        page.write_text("a page", "utf-8")
        return [page]

    monkeypatch.setattr(build, "build", written)
    monkeypatch.setattr("webbrowser.open", opens)
    assert str(page) in said("report --open --out", page.parent)
    assert opened == [page.resolve().as_uri()]
