"""Sections, which a failing claim cannot hide, and how they are collected."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pandas
import pytest

from tests.report.conftest import tables
from tt_precise.claims import JudgedClaim, judge
from tt_precise.claims.claim import calls_for
from tt_precise.claims.committed import committed, run_record
from tt_precise.integration import integrate
from tt_precise.integration.precision import is_available
from tt_precise.report import build, overview, sections
from tt_precise.report import collect as computing
from tt_precise.report.collect import SHARING, compute, sections_in
from tt_precise.report.document import Card, Claims, Section, Text
from tt_precise.report.measured import jellett_alone
from tt_precise.report.overview import verdict
from tt_precise.report.precision import SCENE, precision_runs, state_distance
from tt_precise.runtime.values import InputError

RUN = run_record(1, 1, {"date": "today", "commit": "abc", "versions": "heyoka 1"})


def _claims(section: Section) -> dict[str, list[str]]:
    blocks = [block for block in section.blocks if isinstance(block, Claims)]
    return {block.title: [one.id for one in block.entries] for block in blocks}


def test_errata_hold_what_fails_and_only_that(judged: list[JudgedClaim]) -> None:
    section = overview.errata(judged)
    assert _claims(section) == {
        "Misprints (1)": ["EQ-01"],
        "Refuted (1)": ["NUM-02"],
        "Partly right (1)": ["NUM-05"],
        "Ambiguous (1)": ["NUM-04"],
    }
    first, *others = section.blocks
    assert isinstance(first, Text)
    assert first.text.startswith("2 statements of the paper fail as printed; they are 2 findings")
    assert all(isinstance(block, Claims) and block.errata for block in others)


def test_all_claims_stand_by_section_of_the_paper(
    judged: list[JudgedClaim], tmp_path: Path
) -> None:
    section = overview.all_claims(judged, RUN)
    assert list(_claims(section).values()) == [
        ["EQ-01"],
        ["NUM-01", "NUM-05", "NT-01"],
        ["NUM-02"],
        ["NUM-03"],
        ["NUM-04"],
    ]
    assert section.results["counts"]["refuted"] == 1
    assert len(section.results["claims"]) == 7
    assert section.results["run"]["date"] == "today"
    # verdicts of a report are read again
    file = tmp_path / "results.json"
    file.write_text(json.dumps({"claims": section.results}), "utf-8")
    found = committed(file)
    assert found is not None
    assert found.by_id["NUM-02"].verdict == "refuted"
    file.write_text(file.read_text("utf-8").replace('"refuted"', '"exact"', 1), "utf-8")
    with pytest.raises(InputError, match=r"exact.*--again"):
        committed(file)


def test_the_verdict_counts_findings_and_a_card_says_whether_the_paper_agrees(
    judged: list[JudgedClaim],
) -> None:
    numbers = re.findall(r"\d+", verdict(judged))
    assert numbers == ["7", "2", "1", "4", "4", "1", "1", "1", "1"]
    agrees = {claim.id: overview._agrees(claim.verdict) for claim in judged}
    assert [agrees[id] for id in ("NUM-01", "NUM-02", "NUM-04")] == [True, False, None]


def test_thresholds_state_forty_agreeing_digits() -> None:
    table = tables(sections.threshold_values())[0]
    assert len(table.rows) == 9
    assert min(int(row[3]) for row in table.rows) >= 40


def test_what_lambda_alone_would_show() -> None:
    rows = [("1e-3", "True"), ("2e-7", "True"), ("", "False")]
    table = pandas.DataFrame(
        [*(("dropped term", *row) for row in rows), ("healthy", "1e-3", "True")],
        columns=["kind", "jellett", "at_1e-06"],
    )
    numbers = re.findall(r"(?<![\de-])\d+(?!e)", jellett_alone(table))
    assert [one for one in numbers if one in "123"] == ["3", "1", "2"]


def test_what_the_card_says_of_the_paper_s_time_follows_from_the_verdict() -> None:
    shown = overview.PRINTED[overview.END]
    headlines = overview.Headlines(
        {overview.END: Card("end of the climb", "7.8 s", shown, "")}, None, {}
    )
    for printed, good in (("7.87", False), ("7.83", None)):
        (card,) = overview.overview([judge("NUM-05", printed=printed)], headlines).cards
        assert card.good is good


def test_the_commit_is_that_of_the_package_itself(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Not that of a repository in which the package happens to be installed."""
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


@pytest.mark.slow
@pytest.mark.skipif(not is_available("triple-double"), reason="no llvmlite on this machine")
def test_the_finest_run_is_what_200_bits_give() -> None:
    *others, finest = precision_runs()
    assert finest.trajectory.precision.name == "triple-double"
    wide = integrate(SCENE, "mp")
    assert state_distance(finest.trajectory, wide) < 1e-40
    for one in others:
        apart = state_distance(one.trajectory, wide)
        assert apart == pytest.approx(one.state_error, rel=1e-6)
        assert apart > 1e-34  # what the first bound would not let pass


def test_claims_are_grouped_by_their_evidence() -> None:
    groups = {call.key: call.group for call in calls_for(["EQ-33", "EQ-37", "NUM-11"])}
    name = "tt_precise.claims.rauch_rutstam."
    assert groups["EQ-33"] == groups["EQ-37"] == f"{name}section23_energy"
    assert groups["NUM-11"] == f"{name}section22_starts"


@pytest.fixture
def few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Some sections and claims in place of all."""

    def chosen(titles: list[str], sharing: str, claims: list[str]) -> None:
        every = sections_in(tmp_path)
        monkeypatch.setattr(computing, "SHARING", {sharing: SHARING["Conservation"]})
        monkeypatch.setattr(computing, "CONSERVATION", sharing)
        monkeypatch.setattr(
            computing, "sections_in", lambda _: {name: every[name] for name in titles}
        )
        monkeypatch.setattr(computing, "calls_for", lambda: calls_for(claims))
        monkeypatch.setattr(computing, "headlines", dict)
        monkeypatch.setattr(computing, "precisions", str)

    return chosen


def test_every_part_finds_its_place(tmp_path: Path, few: Callable[..., None]) -> None:
    """Cheap sections and claims, in processes as ever."""
    every = sections_in(tmp_path)
    assert set(SHARING) <= set(every)
    titles = [title for title in every if title not in SHARING][-3:]
    few(titles, titles[1], ["NUM-23", "EQ-01"])
    shares: list[float] = []
    found = compute(tmp_path, shares.append)
    assert [one.id for one in found.judged] == ["EQ-01", "NUM-23"]
    assert [one.title for one in found.sections] == [every[title]().title for title in titles]
    assert found.precisions == ""
    assert found.seconds > 0
    assert shares == sorted(shares)
    assert len(shares) == len(titles) + 4


def test_a_part_that_fails_fails_the_report(tmp_path: Path, few: Callable[..., None]) -> None:
    (tmp_path / "extremes.json").write_text("{")
    few(list(sections_in(tmp_path)), "Extremes", [])
    with pytest.raises(Exception, match=r"extremes\.json"):
        compute(tmp_path)
