"""The registry of cases, and what counts as a failure."""

from __future__ import annotations

import math
from typing import Any

import pytest
from msgspec import to_builtins

from tt_precise.extremes import case as registry
from tt_precise.extremes.case import (
    ExtremeCase,
    NotFiniteError,
    families,
    finite,
    noted,
    same,
    together,
    within,
)
from tt_precise.runtime.values import Check


def one(function: Any = noted, **arguments: Any) -> ExtremeCase:
    arguments = arguments or {"measured": "well"}
    return ExtremeCase("topic", "family", "name", "all well", "theory", function, arguments)


def test_an_exception_is_a_failure_in_one_line() -> None:
    outcome = one(int, x="two\nlines" + "x" * 1000).outcome()
    assert outcome.verdict == "fail"
    assert outcome.found.startswith("TypeError: ")
    failed = one().failed("two\nlines" + "x" * 1000)
    assert failed.found.startswith("two lines")
    assert len(failed.found) <= 200

    for number in (math.nan, math.inf):
        for where in ({"value": number}, {"steps": number}):
            assert one(measured="well", **where).outcome().verdict == "fail"


def test_within_and_same_and_together() -> None:
    assert [within(value, 3, "eps").holds for value in (3, 3.1, math.nan)] == [True, False, False]
    assert same("complete", "complete").holds
    assert same("pole", "complete").measured == "pole, not complete"
    both = together(within(1, 2), same("a", "b"))
    assert (both.holds, both.value) == (False, 1)
    assert together(same("a", "a"), within(3, 4)).value == 3
    assert finite([1.0, None, 2]) == [1.0, 2]
    with pytest.raises(NotFiniteError):
        finite([1.0, math.nan])


def test_over_makes_a_case_of_each_combination(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_registered", {})

    @registry.case(
        "k = {k}, {word}",
        expected="{word}",
        source="theory",
        over={"k": (1, 2), "word": ("a", "b")},
        quick=lambda k, word: k == 2,
        control={"truth": "c"},
    )
    def echo(k: int, word: str, truth: str = "") -> Check:
        return same(truth or word, word)

    made = list(registry._registered.values())
    assert [case.name for case in made] == ["k = 1, a", "k = 1, b", "k = 2, a", "k = 2, b"]
    assert [case.quick for case in made] == [False, False, True, True]
    outcomes = [case.outcome() for case in made]
    assert [outcome.verdict for outcome in outcomes] == ["pass"] * 4
    assert made[0].outcome(**made[0].control).verdict == "fail"
    (family,) = families(outcomes)
    ((name, _, _),) = registry.family_rows(family)
    assert name == "k = …, … (4 cases)"
    with pytest.raises(ValueError, match="got it twice"):
        registry.case("k = 1, a", expected="e", source="s", control={})(echo)


def test_the_document_has_the_agreed_keys() -> None:
    printed = to_builtins(registry.Extremes.of([one().outcome()]))
    assert printed["verdict"] == "pass"
    assert {"name", "expected", "found", "verdict", "value"} <= printed["cases"][0].keys()
    failed = registry.Extremes.of([one().outcome(), one(measured="badly", holds=False).outcome()])
    assert failed.verdict == "fail"
