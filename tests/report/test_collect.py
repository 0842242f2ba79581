"""What the worker processes of a report are handed."""

from pathlib import Path

import pytest

from tt_precise.claims.claim import calls_for
from tt_precise.report import collect as computing
from tt_precise.report.collect import SHARING, compute, sections_in
from tt_precise.report.document import Section

FIRST, SECOND = "EQ-01", "NUM-23"


def test_what_shares_runs_is_there(tmp_path: Path) -> None:
    assert set(SHARING) <= set(sections_in(tmp_path))


def test_claims_are_grouped_by_their_evidence() -> None:
    groups = {call.key: call.group for call in calls_for(["EQ-33", "EQ-37", "NUM-11"])}
    name = "tt_precise.claims.rauch_rutstam."
    assert groups["EQ-33"] == groups["EQ-37"] == f"{name}section23_energy"
    assert groups["NUM-11"] == f"{name}section22_starts"


def test_every_part_finds_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cheap sections and claims, in processes as ever."""
    titles = [title for title in sections_in(tmp_path) if title not in SHARING][-3:]
    every = sections_in(tmp_path)
    monkeypatch.setattr(computing, "SHARING", {titles[1]: SHARING["Conservation"]})
    monkeypatch.setattr(computing, "CONSERVATION", titles[1])
    monkeypatch.setattr(computing, "sections_in", lambda _: {name: every[name] for name in titles})
    monkeypatch.setattr(computing, "calls_for", lambda: calls_for([SECOND, FIRST]))
    monkeypatch.setattr(computing, "headlines", dict)
    monkeypatch.setattr(computing, "precisions", str)
    shares: list[float] = []
    found = compute(tmp_path, shares.append)
    assert [one.id for one in found.judged] == [FIRST, SECOND]
    assert [one.title for one in found.sections] == [every[title]().title for title in titles]
    assert all(isinstance(one, Section) for one in found.sections)
    assert found.precisions == ""
    assert found.seconds > 0
    assert shares == sorted(shares)
    assert len(shares) == len(titles) + 4


def test_a_part_that_fails_fails_the_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "extremes.json").write_text("{")
    monkeypatch.setattr(computing, "SHARING", {"Extremes": SHARING["Conservation"]})
    monkeypatch.setattr(computing, "CONSERVATION", "Extremes")
    monkeypatch.setattr(computing, "calls_for", lambda: [])
    monkeypatch.setattr(computing, "headlines", dict)
    monkeypatch.setattr(computing, "precisions", str)
    with pytest.raises(Exception, match=r"extremes\.json"):
        compute(tmp_path)
