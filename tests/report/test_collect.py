"""Sections and verdicts, computed by worker processes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tt_precise.claims.claim import calls_for
from tt_precise.report import collect as computing
from tt_precise.report.collect import SHARING, compute, sections_in


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


def test_sections_and_claims_are_collected_in_order(
    tmp_path: Path, few: Callable[..., None]
) -> None:
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


def test_a_section_that_fails_fails_the_report(tmp_path: Path, few: Callable[..., None]) -> None:
    (tmp_path / "extremes.json").write_text("{")
    few(list(sections_in(tmp_path)), "Extremes", [])
    with pytest.raises(Exception, match=r"extremes\.json"):
        compute(tmp_path)
