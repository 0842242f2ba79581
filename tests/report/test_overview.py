"""The first screen and the lists of claims: counts, answers, verdicts, the motion of the top."""

from __future__ import annotations

import re
from typing import Any

import pytest
from msgspec.structs import replace

from tests.report.conftest import CLAIM
from tt_precise import golden
from tt_precise.claims import JudgedClaim
from tt_precise.claims.verdicts import committed, run_record
from tt_precise.report import overview
from tt_precise.report.document import Card, ClaimList, Overview, Section, Text, table
from tt_precise.report.overview import DRIFT, END, RATIO, TRACK, answer, findings, motion, verdict
from tt_precise.runtime import player


@pytest.fixture(scope="module")
def drawing() -> Any:
    return motion(3.19, 7.82)


@pytest.fixture(scope="module")
def every() -> list[JudgedClaim]:
    judged = committed()
    assert judged is not None
    return list(judged.claims)


def test_the_motion_is_that_of_the_golden_scene(drawing: Any) -> None:
    trajectory = golden.load(TRACK)
    played = drawing["played"]
    assert len(played["theta"]) == len(trajectory) == 801
    for name in ("theta", "phi", "psi"):
        truth = trajectory[name].astype(float).to_numpy()
        assert played[name] == pytest.approx(truth, abs=10 ** -player.DECIMALS[name])
    assert (played["every"], drawing["end"]) == (0.01, 8.0)


def test_the_answer_follows_from_the_verdicts(every: list[JudgedClaim]) -> None:
    ids, holding, failing = table("answers").rows[0]
    last = ids.split(", ")[-1]  # one that fails is enough
    assert holding in answer(every)
    spoiled = [replace(claim, verdict="refuted") if claim.id == last else claim for claim in every]
    assert failing in answer(spoiled)
    assert holding not in answer(spoiled)
    assert answer([]) == ""
    named = {id for row in table("answers").rows for id in row[0].split(", ")}
    named |= {id for row in table("untested").rows for id in CLAIM.findall(row[2])}
    assert named <= {claim.id for claim in every}


def test_counts_are_of_statements_and_findings_are_named_as_such(
    every: list[JudgedClaim], judged: list[JudgedClaim]
) -> None:
    same = [claim for claim in every if claim.id in ("EQ-26", "EQ-27", "TH-19")]
    assert findings(same) == 1  # one mistake in three places
    assert "these 3 statements have 1 findings" in verdict(same)
    assert re.findall(r"\d+", verdict(judged)) == ["7", "2", "1", "4", "1", "1", "1", "1", "4", "4"]
    # the titles of the errata have the same count
    titles = {each.title for each in _lists(overview.errata(every))}
    for name, word in (("misprint", "Misprints"), ("refuted", "Refuted")):
        count = sum(claim.verdict == name for claim in every)
        assert f"{word} ({count} statements)" in titles
        assert re.search(rf"\b{count} {name}", verdict(every))


def test_every_card_has_the_verdict_of_its_claim(every: list[JudgedClaim]) -> None:
    cards = {id: Card(id, "1", "2", "") for id in (DRIFT, RATIO, END)}
    for spoiled in ("refuted", "rounded"):
        claims = [replace(c, verdict=spoiled) if c.id == RATIO else c for c in every]
        screen = overview.overview(claims, Overview(cards, {}, {}))
        assert screen.cards[RATIO].verdict == spoiled
    assert screen.cards[DRIFT].verdict == "reproduced"
    assert screen.cards[END].comment == "definitions that give the paper's time: 0 of 4"


def _lists(section: Section) -> list[ClaimList]:
    return [block for block in section.blocks if isinstance(block, ClaimList)]


def _ids(section: Section) -> dict[str, list[str]]:
    return {block.title: [claim.id for claim in block.entries] for block in _lists(section)}


def test_errata_hold_what_fails_and_only_that(judged: list[JudgedClaim]) -> None:
    section = overview.errata(judged)
    assert _ids(section) == {
        "Misprints (1 statement)": ["EQ-01"], "Refuted (1 statement)": ["NUM-02"],
        "Partly right (1 statement)": ["NUM-05"], "Ambiguous (1 statement)": ["NUM-04"],
    }  # fmt: skip
    text = section.blocks[0]
    assert isinstance(text, Text)
    assert text.text.startswith("2 statements of the paper fail as printed; they are 2 findings")
    assert all(block.errata for block in _lists(section))
    assert len(_ids(overview.errata([judged[1], judged[2]]))) == 1


def test_all_claims_stand_by_section_of_the_paper(judged: list[JudgedClaim]) -> None:
    run = run_record(1, 1, {"date": "today", "commit": "abc", "versions": "heyoka 1"})
    section = overview.all_claims(judged, run)
    assert section.blocks[0] == Text("7 claims, 1 of them decided by a proof.")
    assert [*_ids(section).values()] == [
        ["EQ-01"], ["NUM-01", "NUM-05", "NT-01"], ["NUM-02"], ["NUM-03"], ["NUM-04"],
    ]  # fmt: skip
    assert section.results["counts"]["refuted"] == 1
