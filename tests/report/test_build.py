"""Building a report: sections and verdicts, its commit, its files, and when nothing is written."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from tt_precise.claims import JudgedClaim
from tt_precise.claims.claim import calls_for
from tt_precise.report import build
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
    # a plus where a file of the package is not as committed
    module = package / "module.py"
    module.write_text("x = 1\n")
    for words in (["add", "tt_precise"], [*identity, "commit", "-q", "-m", "More"]):
        subprocess.run(["git", "-C", tmp_path, *words], check=True)
    assert not build.commit().endswith("+")
    module.write_text("x = 2\n")
    assert build.commit().endswith("+")


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
        computed = build.Computed(judged, [section], Headlines({}, None, {}), "all", seconds)
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


@pytest.fixture
def few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Some sections and claims in place of all."""

    def chosen(titles: list[str], sharing: str, claims: list[str]) -> None:
        every = build.sections_in(tmp_path)
        monkeypatch.setattr(build, "SHARING", {sharing: build.SHARING["Conservation"]})
        monkeypatch.setattr(build, "CONSERVATION", sharing)
        monkeypatch.setattr(build, "sections_in", lambda _: {name: every[name] for name in titles})
        monkeypatch.setattr(build, "calls_for", lambda: calls_for(claims))
        monkeypatch.setattr(build.overview, "headlines", dict)
        monkeypatch.setattr(build, "precisions", str)

    return chosen


def test_sections_and_claims_are_collected_in_order(
    tmp_path: Path, few: Callable[..., None]
) -> None:
    """Cheap sections and claims, in processes as ever."""
    every = build.sections_in(tmp_path)
    assert set(build.SHARING) <= set(every)
    titles = [title for title in every if title not in build.SHARING][-3:]
    few(titles, titles[1], ["NUM-23", "EQ-01"])
    shares: list[float] = []
    found = build.compute(tmp_path, shares.append)
    assert [one.id for one in found.judged] == ["EQ-01", "NUM-23"]
    assert [one.title for one in found.sections] == [every[title]().title for title in titles]
    assert found.precisions == ""
    assert found.seconds > 0
    assert shares == sorted(shares)
    assert len(shares) == len(titles) + 4


def test_a_section_that_fails_fails_the_report(tmp_path: Path, few: Callable[..., None]) -> None:
    (tmp_path / "extremes.json").write_text("{")
    few(list(build.sections_in(tmp_path)), "Extremes", [])
    with pytest.raises(Exception, match=r"extremes\.json"):
        build.compute(tmp_path)
