"""The motion of the first screen is that of the golden data, and a claim is one line."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy
import pytest
from msgspec.structs import replace

from tt_precise import golden
from tt_precise.claims import JudgedClaim, part
from tt_precise.claims.committed import committed, run_record
from tt_precise.claims.rauch_rutstam import ANSWERS
from tt_precise.claims.verdicts import conclude
from tt_precise.report import overview
from tt_precise.report.document import Card, ClaimList, Section, Text
from tt_precise.report.overview import TRACK, answer, findings, motion, verdict
from tt_precise.report.render import names
from tt_precise.runtime import player
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

CLIMB = (3.19, 7.82)  # s


@pytest.fixture(scope="module")
def found() -> Any:
    return motion(CLIMB)


def test_the_courses_are_those_of_the_golden_scene(found: Any) -> None:
    trajectory = golden.load(TRACK)
    played = found["played"]
    assert len(played["theta"]) == len(trajectory) == 801
    for name in ("theta", "phi", "psi"):
        for row in (0, 400, 800):
            truth = float(trajectory[name].iloc[row])
            assert played[name][row] == pytest.approx(truth, abs=10 ** -player.DECIMALS[name])
    assert played["every"] == 0.01
    assert found["end"] == 8.0


def test_the_contact_point_glides_as_the_sphere_rolls_and_slips(found: Any) -> None:
    """Its path's rate is that of the sphere's centre: v_A + omega x R z, horizontally."""
    frame = golden.load(TRACK).astype(float)
    body = load_scene(TRACK).body.numbers(float)
    k, L = (frame[list(names)].to_numpy() for names in (("kx", "ky", "kz"), ("Lx", "Ly", "Lz")))
    omega = L / body.I1 + (1 / body.I3 - 1 / body.I1) * (L * k).sum(axis=1)[:, None] * k
    rates = {
        "x": frame["vx"].to_numpy() + omega[:, 1] * body.R,
        "y": frame["vy"].to_numpy() - omega[:, 0] * body.R,
    }
    for name, rate in rates.items():
        way = numpy.trapezoid(rate, dx=0.01) / body.R
        # a nutation lasts 37 ms, of which the trapezoids of 10 ms leave some percent of a radius
        assert found["played"][name][-1] - found["played"][name][0] == pytest.approx(way, abs=0.2)
    assert abs(found["played"]["x"][-1]) > 20


def test_map_and_graph_lie_inside_the_drawing(found: Any) -> None:
    for path, (left, top, width, height) in (
        (found["track"], player.MAP), (found["curve"], player.GRAPH),
    ):  # fmt: skip
        for point in path[1:].split("L"):
            x, y = map(float, point.split())
            assert left - 0.1 <= x <= left + width + 0.1
            assert top - 0.1 <= y <= top + height + 0.1
    assert found["graph"]["sy"] * math.pi == pytest.approx(player.GRAPH[3], rel=1e-3)


def test_no_animation_without_golden_data(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overview, "TRACK", "no such scene")
    assert motion(CLIMB) is None


def test_the_essential_part_is_the_correction_or_the_first_failure(
    judged: list[JudgedClaim],
) -> None:
    by_id = {claim.id: claim for claim in judged}
    misprint = by_id["EQ-01"]  # what should stand
    assert misprint.essential.printed == misprint.correction
    assert "- R*I3" in misprint.correction
    assert misprint.remark == "A factor R."  # not what stands beside it already
    assert [line.name for line in misprint.lines] == ["as printed", "as corrected"]
    failing = [by_id[id].essential for id in ("NUM-02", "NUM-05")]  # the part that fails
    assert [(part.name, part.printed, part.measured) for part in failing] == [
        ("", "2", "3 | 4"), ("second", "2", "3 | 4"),
    ]  # fmt: skip
    assert by_id["NUM-05"].verdict == "partly"
    ambiguous = by_id["NUM-04"]  # which one holds
    assert names(ambiguous, holding=True) == "so"
    undecided = {"so": part.statement(True, "so", "so"), "or so": part.untestable("so")}
    judgement = conclude("interpretations", undecided, "A note.")
    assert names(judgement, holding=False) == "or so (open)"
    assert [(line.name, line.outcome) for line in ambiguous.lines] == [
        ("so", "reproduced"), ("or so", "refuted"),
    ]  # fmt: skip


def test_the_answer_follows_from_the_verdicts() -> None:
    known = committed()
    assert known is not None
    every = list(known.claims)
    first = ANSWERS[0]
    last = first.claims[-1]  # one that fails is enough
    assert first.holding in answer(every)
    spoiled = [replace(claim, verdict="refuted") if claim.id == last else claim for claim in every]
    assert first.failing in answer(spoiled)
    assert first.holding not in answer(spoiled)
    assert answer([]) == ""


def test_a_finding_counts_once() -> None:
    known = committed()
    assert known is not None
    some = [claim for claim in known.claims if claim.id in ("EQ-26", "EQ-27", "TH-19")]
    assert [claim.verdict for claim in some] == ["misprint"] * 3
    assert findings(some)["misprint"] == 1
    assert "The other 3 are 1 findings" in verdict(some)


RUN = run_record(1, 1, {"date": "today", "commit": "abc", "versions": "heyoka 1"})


def _claims(section: Section) -> dict[str, list[str]]:
    blocks = [block for block in section.blocks if isinstance(block, ClaimList)]
    return {block.title: [one.id for one in block.entries] for block in blocks}


def test_errata_hold_what_fails_and_only_that(judged: list[JudgedClaim]) -> None:
    section = overview.errata(judged)
    assert _claims(section) == {
        "Misprints (1 statement)": ["EQ-01"],
        "Refuted (1 statement)": ["NUM-02"],
        "Partly right (1 statement)": ["NUM-05"],
        "Ambiguous (1 statement)": ["NUM-04"],
    }
    first, *others = section.blocks
    assert isinstance(first, Text)
    assert first.text.startswith("2 statements of the paper fail as printed; they are 2 findings")
    assert all(isinstance(block, ClaimList) and block.errata for block in others)


def test_all_claims_stand_by_section_of_the_paper(
    judged: list[JudgedClaim], tmp_path: Path
) -> None:
    section = overview.all_claims(judged, RUN)
    proved = sum(claim.proved for claim in judged)
    assert 0 < proved < 7
    assert section.blocks[0] == Text(f"7 claims, {proved} of them decided by a proof.")
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
    agrees = {claim.id: overview.agreement(claim.verdict) for claim in judged}
    assert [agrees[id] for id in ("NUM-01", "NUM-02", "NUM-04")] == [True, False, None]


def test_what_the_card_says_of_the_paper_s_time_follows_from_the_verdict() -> None:
    shown = overview.HEADLINES[overview.END]
    headlines = overview.Headlines(
        {overview.END: Card("end of the climb", "7.8 s", shown, "")}, None, {}
    )
    known = committed()
    assert known is not None
    claim = known.by_id[overview.END]
    for word, good in (("rounded", True), ("refuted", False), ("ambiguous", None)):
        (card,) = overview.overview([replace(claim, verdict=word)], headlines).cards
        assert card.good is good
        assert str(len(claim.parts)) in card.comment
