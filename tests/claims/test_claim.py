"""Claims with their words, their list, and judging in this process and in others."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any
from unittest.mock import Mock

import pytest

from tt_precise.claims import claim, claim_named, claims, counts, judge_all
from tt_precise.claims.claim import (
    CLAIM_KINDS,
    HEADLINES,
    SECTIONS,
    Wording,
    claims_of,
    fill,
    look_up,
)
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


WHERE = '\n\n    Sec. 2.1, Fig. 3: "a\n    quote"\n'


def test_a_docstring_has_all_words_in_one_line_each() -> None:
    words = Wording.of(
        f'A claim\n    of two lines.{WHERE}    Definition: so: "x"\n    Note: A\n    note.\n'
    )
    assert words == ("A claim of two lines.", "Sec. 2.1, Fig. 3", "a quote", 'so: "x"', "A note.")
    assert Wording.of(f"A claim.{WHERE}") == ("A claim.", "Sec. 2.1, Fig. 3", "a quote", "", "")


@pytest.mark.parametrize("docstring", ["", "A claim.", f"A claim.{WHERE}\nRemark: so", WHERE])
def test_other_docstrings_are_refused(docstring: str) -> None:
    with pytest.raises(ValueError, match="expected a statement"):
        Wording.of(docstring)


NAMES = {"x": 2 / 3, "n": 12, "row": {"a": 1.2345}, "names": ("D", "E~")}


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("{x:3} s, {x:.1%}", "0.667 s, 66.7 %"),
        ("{n} of {n:.0f}, {n:1}", "12 of 12, 1e1"),
        ("{point.real:2} at {row[a]:.3g}", "0.50 at 1.23"),
        ("{names}, {{x}}", "D, E~, {x}"),
    ],
)
def test_braces_take_numbers_and_texts(text: str, filled: str) -> None:
    assert fill(text, {**NAMES, "point": 0.5 + 2j}) == filled


@pytest.mark.parametrize("text", ["{y}", "{x.t}", "{x[a]}", "{names[9]}"])
def test_a_misspelt_name_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="expected a known one"):
        fill(text, NAMES)


def test_sections_kinds_and_headlines_are_those_of_the_claims() -> None:
    assert {claim.section for claim in claims().values()} == set(SECTIONS)
    assert {claim.kind for claim in claims().values()} == set(CLAIM_KINDS.values())
    assert set(HEADLINES) <= set(claims())


@pytest.mark.parametrize(
    ("id", "expected"), [("num-22", "NUM-22"), ("NUM-99", None), ("EQ", None), ("x" * 999, None)]
)
def test_an_id_is_looked_up_in_any_case(id: str, expected: str | None) -> None:
    table = {"EQ-02": "EQ-02", "NUM-22": "NUM-22"}
    if expected:
        assert look_up(id, table) == expected
        return
    with pytest.raises(InputError, match="expected an id") as error:
        look_up(id, table)
    assert len(str(error.value)) < 200
