"""Claims as entries, papers as values, and judging in this process and in others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from unittest.mock import Mock

import pytest

from tt_precise.claims import (
    claim,
    claim_named,
    claims,
    counts,
    judge,
    judge_all,
    paper,
)
from tt_precise.claims.claim import Claim, calls_for, claims_of
from tt_precise.claims.paper import CLAIM_KINDS, RAUCH_RUTSTAM
from tt_precise.claims.verdicts import untestable
from tt_precise.runtime.values import InputError

CHEAP = ("NUM-23", "EQ-26", "EQ-29", "TH-17")  # Fast claims of four chapters.


def entry(**changes: Any) -> Claim:
    given: dict[str, Any] = {
        "id": "NUM-20", "paper": RAUCH_RUTSTAM, "section": "2.3", "statement": "E_pot.",
        "quote": "0.005106", "where": "Sec. 2.3", "definition": "",
        "function": lambda: (untestable("so"), "Why."), "control": ("refuted", {"a": 1}),
    }  # fmt: skip
    return Claim(**given | changes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        *(({"id": bad}, "claim id") for bad in ("NUM-2", "num-20", "NUM20", "XX-01", "NUM-200",
                                                "NUM-20 ")),
        *(({name: ""}, name) for name in ("statement", "quote", "where", "section")),
    ],
)  # fmt: skip
def test_ids_have_one_form_and_nothing_is_left_out(change: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        entry(**change)


def test_nothing_is_registered_twice() -> None:
    again = claims()["NUM-20"].function
    with pytest.raises(ValueError, match="got it twice"):
        claims_of(RAUCH_RUTSTAM, "2.3")("NUM-20", quote="0.005106", control=None)(again)


def test_one_function_judges_several_claims_by_what_is_given() -> None:
    functions: list[Any] = [claims()[id].function for id in ("TH-02", "TH-23")]
    assert functions[0].func is functions[1].func
    assert [each.keywords["name"] for each in functions] == ["lambda_thres", "lambda_up"]
    assert claims()["TH-02"].statement != claims()["TH-23"].statement


@pytest.mark.parametrize("unknown", ["NUM-99", "", "x" * 1000, "EQ"])
def test_an_unknown_id_is_bad_input(unknown: str) -> None:
    with pytest.raises(InputError, match="expected") as error:
        claim_named(unknown)
    assert len(str(error.value)) < 200
    assert claim_named("num-22") is claim_named("NUM-22")


def test_claims_are_sentences_in_order() -> None:
    every = list(claims().values())
    assert every == sorted(every, key=lambda one: one.order)
    assert {one.kind for one in every} == set(CLAIM_KINDS.values())
    assert {(one.paper.name, one.section) for one in every} == {
        (each.name, section.key) for each in paper.PAPERS for section in each.sections
    }
    assert all(one.statement.endswith(".") and len(one.quote) < 300 for one in every)


def test_a_judged_claim_has_its_parts_and_its_correction() -> None:
    record = judge("EQ-29")
    assert (record.verdict, record.kind, record.proved) == ("misprint", "equation", True)
    assert [part.name for part in record.parts] == ["as printed", "as corrected"]
    assert all(part.proved and part.formula for part in record.parts)
    assert record.correction == record.parts[1].printed
    assert record.note == f"Should read {record.correction}. {record.remark}"
    # changes reach the claim
    assert judge("NUM-23", printed="1.9").verdict == "rounded"
    other = judge("NUM-23", printed="1.8")
    assert other.verdict == "refuted"
    assert other != judge("NUM-23")


def test_workers_judge_as_this_process_does() -> None:
    seen: list[float] = []
    judged = judge_all([*CHEAP, "num-23"], seen.append, workers=2)
    assert judged == judge_all(CHEAP)
    assert [one.id for one in judged] == ["EQ-26", "EQ-29", "TH-17", "NUM-23"]
    assert seen == sorted(seen)
    assert seen[-1] == 1
    assert counts(judged) == {
        "reproduced": 1,
        "rounded": 1,
        "partly": 0,
        "ambiguous": 0,
        "refuted": 0,
        "misprint": 2,
        "untestable": 0,
    }
    with pytest.raises(InputError):
        judge_all(["NUM-23", "NUM-99"])
    assert judge_all([]) == []


def test_an_error_names_the_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    fail = Mock(side_effect=ArithmeticError("no digits"))
    spoiled = replace(claims()["NUM-23"], function=fail)
    monkeypatch.setattr(claim, "claim_named", lambda _: spoiled)
    with pytest.raises(ArithmeticError) as error:
        judge_all(["NUM-23"])
    assert error.value.__notes__ == ["while judging NUM-23"]


def test_claims_are_grouped_by_their_evidence() -> None:
    groups = {call.key: call.group for call in calls_for(["EQ-33", "EQ-37", "NUM-11"])}
    name = "tt_precise.claims.rauch_rutstam."
    assert groups["EQ-33"] == groups["EQ-37"] == f"{name}section23_energy"
    assert groups["NUM-11"] == f"{name}section22_starts"
