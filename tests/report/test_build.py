"""Building a report: its commit, its files, and when nothing is written."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tt_precise.claims import JudgedClaim
from tt_precise.report import build
from tt_precise.report.collect import Computed
from tt_precise.report.document import Report, Section, Text
from tt_precise.report.overview import Headlines

from .conftest import FACTS


def test_the_commit_is_that_of_the_package_itself(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A repository in which the package happens to be installed is not asked."""
    subprocess.run(["git", "-C", tmp_path, "init", "-q"], check=True)
    identity = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
    empty = ["commit", "-q", "--allow-empty", "-m", "Begun"]
    subprocess.run(["git", "-C", tmp_path, *identity, *empty], check=True)
    commits = []
    for package in (tmp_path / "site-packages" / "tt_precise", tmp_path / "tt_precise"):
        (package / "report").mkdir(parents=True)
        monkeypatch.setattr(build, "__file__", str(package / "report" / "build.py"))
        commits.append(build.commit())
    assert commits[0].startswith("none, version ")
    assert len(commits[1]) in range(7, 13)


def test_the_files_of_a_report(small_report: Report, tmp_path: Path) -> None:
    written = build.write(small_report, tmp_path)
    assert {path.relative_to(tmp_path).as_posix() for path in written} == {
        "precision-report.html", "precision-report.md", "results.json", "figures/circle.svg",
        "figures/ring.svg",
    }  # fmt: skip
    results = json.loads((tmp_path / "results.json").read_text("utf-8"))
    assert results["summary"] == {"a": 1}
    assert results["claims"]["counts"]["refuted"] == 1


def test_a_report_that_changes_nothing_writes_nothing(
    judged: list[JudgedClaim], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(day: str, commit: str, drift: str, seconds: float) -> dict[str, str]:
        """The files after a run of that day and commit."""
        section = Section("extremes", "E", [Text(drift)], {"cases": drift})
        computed = Computed(judged, [section], Headlines({}, None, {}), "all", seconds)
        facts = {**FACTS, "date": day, "commit": commit}
        monkeypatch.setattr(build, "compute", lambda progress: computed)
        monkeypatch.setattr(build, "provenance", lambda *_: facts)
        return {path.name: path.read_text("utf-8") for path in build.build(tmp_path, "c")}

    first = run("Monday", "abc", "1e-15", 10.2)
    assert run("Tuesday", "def", "1e-15", 13.8) == first
    third = run("Wednesday", "fed", "2e-15", 12.1)
    assert all("Monday" in text and "Tuesday" not in text for text in first.values())
    assert all("Wednesday" in text and "Monday" not in text for text in third.values())
    (tmp_path / "precision-report.md").write_text("spoiled")  # written anew, and by whom
    assert "Friday" in run("Friday", "fed", "2e-15", 12.1)["precision-report.md"]
    (tmp_path / "results.json").write_text("{}")
    assert "Sunday" in run("Sunday", "fed", "2e-15", 12.1)["results.json"]
