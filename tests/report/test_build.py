"""Building a report: sections and verdicts, its commit, its files, and when nothing is written."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.report.conftest import FACTS
from tt_precise.claims import JudgedClaim
from tt_precise.claims.claim import calls_for
from tt_precise.report import build, overview
from tt_precise.report.document import Overview, Report, Section, Text


def git(folder: Path, *words: str) -> None:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
    subprocess.run(["git", "-C", folder, *identity, *words], check=True)


def test_the_commit_is_that_of_the_package_itself(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A repository in which the package happens to be installed is not asked."""
    git(tmp_path, "init", "-q")
    git(tmp_path, "commit", "-q", "--allow-empty", "-m", "Begun")
    for package in (tmp_path / "site-packages" / "tt_precise", tmp_path / "tt_precise"):
        (package / "report").mkdir(parents=True)
        monkeypatch.setattr(build, "__file__", str(package / "report" / "build.py"))
        assert build.commit().startswith("none, version ") == (package.parent != tmp_path)
    # a plus where a file of the package is not as committed
    module = package / "module.py"
    module.write_text("x = 1\n")
    git(tmp_path, "add", "tt_precise")
    git(tmp_path, "commit", "-q", "-m", "More")
    assert not build.commit().endswith("+")
    module.write_text("x = 2\n")
    assert build.commit().endswith("+")


def test_the_files_of_a_report(small_report: Report, tmp_path: Path) -> None:
    paths = build.write(small_report, tmp_path)
    assert {path.relative_to(tmp_path).as_posix() for path in paths} == {
        "precision-report.html", "precision-report.md", "results.json", "figures/circle.svg",
        "figures/ring.svg",
    }  # fmt: skip
    results = json.loads((tmp_path / "results.json").read_text("utf-8"))
    assert results["summary"] == {"a": 1}
    assert results["claims"]["counts"]["refuted"] == 1


def test_a_report_that_changes_nothing_writes_nothing(
    judged: list[JudgedClaim], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = Overview({}, overview.motion(3.19, 7.82), {})

    def run(day: str, commit: str, text: str, seconds: float) -> str:
        sections = {key: Section(key, key, [Text(text)]) for key in build.SECTIONS}
        content = {"judged": judged, "headlines": screen, "precisions": "p", "seconds": seconds}
        facts = FACTS | {"date": day, "commit": commit}
        monkeypatch.setattr(build, "compute", lambda _: sections | content)
        monkeypatch.setattr(build, "provenance", lambda *_: facts)
        build.build(tmp_path, "command")
        page = (tmp_path / "precision-report.md").read_text("utf-8")
        return page + (tmp_path / "results.json").read_text("utf-8")

    first = run("Friday", "abc", "1e-15", 10.1)
    assert "Friday" in first
    assert run("Saturday", "def", "1e-15", 11.9) == first
    second = run("Saturday", "def", "2e-15", 11.9)
    assert "Saturday" in second
    assert "Friday" not in second
    (tmp_path / "results.json").write_text("{}")
    assert "Sunday" in run("Sunday", "fed", "2e-15", 12.1)


def _section() -> Section:
    return Section("one", "One", [])


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two sections and two claims in place of all."""
    calls = calls_for(["NUM-23", "EQ-01"])
    monkeypatch.setattr(build, "calls_for", lambda: calls)
    monkeypatch.setattr(build, "SECTIONS", {"one": (_section, ""), "two": (_section, "runs")})
    monkeypatch.setattr(build.overview, "headlines", dict)
    monkeypatch.setattr(build, "precisions", str)


@pytest.mark.usefixtures("few")
def test_sections_and_claims_are_computed_in_processes() -> None:
    shares: list[float] = []
    content: dict[str, Any] = build.compute(shares.append)
    assert [claim.id for claim in content["judged"]] == ["EQ-01", "NUM-23"]
    assert content["one"] == content["two"] == _section()
    assert (content["headlines"], content["precisions"]) == ({}, "")
    assert content["seconds"] > 0
    assert shares == sorted(shares)
    assert len(shares) == 6


def _failure() -> Section:
    raise OSError("no such table")


@pytest.mark.usefixtures("few")
def test_a_section_that_fails_fails_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(build.SECTIONS, "one", (_failure, ""))
    with pytest.raises(OSError, match="no such table"):
        build.compute()
