"""Claims, their list, and judging in this process and in others."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any
from unittest.mock import Mock

import pytest

from tt_precise.claims import claim, claim_named, claims, counts, judge_all
from tt_precise.claims.claim import claims_of
from tt_precise.claims.part import Part, rounds_to
from tt_precise.runtime.values import InputError

CHEAP = ("NUM-23", "EQ-26", "EQ-29", "TH-17")  # Fast claims of four chapters.
UNIT = "s"  # A constant of this module, in the words of the claim.


def ratio(printed: str = "1.5", value: float = 1.46, factor: int = 1) -> tuple[Part, Any]:
    """The ratio is 1.5.

    Sec. 2.3: "1.5"
    Definition: in {UNIT}.
    Note: It is {ratio:3} {UNIT}, printed {printed}.
    """
    return rounds_to(printed, value * factor), {"ratio": value * factor}


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """An empty list of claims."""
    entries: dict[str, Any] = {}
    monkeypatch.setattr(claim, "_registered", entries)
    return entries


def test_a_claim_is_a_function_with_words_a_rule_and_a_control(registered: dict[str, Any]) -> None:
    register = claims_of("2.3")("NUM-90", finding="NUM-20", control="refuted", printed="1.6")
    assert register(ratio) is ratio
    entry = registered["NUM-90"]
    judged = entry.judge()
    assert (judged.id, judged.kind, judged.section) == ("NUM-90", "number", "2.3")
    assert (judged.statement, judged.where, judged.quote) == (
        "The ratio is 1.5.",
        "Sec. 2.3",
        "1.5",
    )
    assert (judged.definition, judged.finding) == ("in s", "NUM-20")
    assert (judged.verdict, judged.note) == ("rounded", "It is 1.46 s, printed 1.5.")
    changed = entry.judge(**entry.changes)
    assert (changed.verdict, changed.note) == (entry.control, "It is 1.46 s, printed 1.6.")
    assert entry.group == __name__


def test_a_function_with_fixed_arguments_serves_several_claims(registered: dict[str, Any]) -> None:
    words = 'Twice.\n\nSec. 3: "3"\nNote: {factor} times {value:3}.'
    claims_of("3")("NUM-91", words)(partial(ratio, factor=3, printed="3"))
    judged = registered["NUM-91"].judge()
    assert (judged.verdict, judged.note) == ("refuted", "3 times 1.46.")
    assert registered["NUM-91"].judge(printed="4.4").verdict == "rounded"
    assert registered["NUM-91"].group == __name__


@pytest.mark.parametrize("id", ["NUM-2", "num-20", "NUM20", "XX-01", "NUM-200", "NUM-20 ", "EQ-02"])
def test_an_id_has_one_form_and_stands_once(id: str) -> None:
    assert "EQ-02" in claims()
    with pytest.raises(ValueError, match="each once"):
        claims_of("1")(id)(ratio)


@pytest.mark.parametrize("words", ["The ratio.", 'So.\n\nSec. 1: "a"\nDefinition: in {UNITS}'])
def test_wrong_words_name_the_claim(words: str) -> None:
    with pytest.raises(ValueError, match="claim NUM-92: "):
        claims_of("1")("NUM-92", words)(ratio)


def test_an_error_names_the_claim(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = claims()["NUM-23"]
    misspelt = replace(entry, words=entry.words._replace(note="{alhpa}"))
    failing = replace(entry, function=Mock(side_effect=ArithmeticError("no digits")))
    for spoiled in (misspelt, failing):
        monkeypatch.setattr(claim, "claim_named", lambda _, spoiled=spoiled: spoiled)
        with pytest.raises((ArithmeticError, ValueError)) as error:
            judge_all(["NUM-23"])
        assert error.value.__notes__ == ["while judging NUM-23"]


def test_claims_are_sentences_in_order() -> None:
    every = list(claims().values())
    assert every == sorted(every, key=lambda entry: entry.order)
    words = [entry.words for entry in every]
    assert all(each.statement.endswith(".") and len(each.quote) < 300 for each in words)
    assert claim_named("num-22") is claim_named("NUM-22")


def test_workers_judge_as_this_process_does() -> None:
    shares: list[float] = []
    judged = judge_all([*CHEAP, "num-23"], shares.append, workers=2)
    assert judged == judge_all(CHEAP)
    assert [each.id for each in judged] == ["EQ-26", "EQ-29", "TH-17", "NUM-23"]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    number = {name: count for name, count in counts(judged).items() if count}
    assert number == {"reproduced": 1, "rounded": 1, "misprint": 2}
    with pytest.raises(InputError):
        judge_all(["NUM-23", "NUM-99"])
    assert judge_all([]) == []
