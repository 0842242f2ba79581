"""Shared values: lists of names, the result of a check, and the derived operations of a ring."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from functools import partial
from types import SimpleNamespace

import pytest

from tt_precise.runtime.values import Check, InputError, Memory, Ring, Scalar, distinct, listed


@pytest.mark.parametrize("names", ["a, b,,c ", ["a", "b", "c"], ("a", "b", "c")])
def test_names_are_given_as_one_text_or_several(names: str | list[str]) -> None:
    assert listed(names) == ("a", "b", "c")


def test_a_thing_that_is_given_twice_counts_once_and_two_of_one_name_are_refused() -> None:
    one, other = (SimpleNamespace(name="E", power=power) for power in (1, 2))
    assert distinct("quantities", ["a", one, "a", one]) == ("a", one)
    with pytest.raises(InputError, match="got two called E"):
        distinct("quantities", [one, other])


FAILED = Check("jellett", "fail", value=2e-3, limit=1e-6, at=1.5, note="a note", bound=math.inf)


def test_a_check_is_a_sentence_and_json_without_infinity() -> None:
    assert not FAILED.holds
    assert all(replace(FAILED, verdict=word).holds for word in ("pass", "open", "skipped"))
    assert FAILED.sentence() == "jellett: 0.002 at t = 1.5 s, expected at most 1e-06 (a note)"
    assert Check("golden", "skipped", note="no rows").sentence() == "golden: no rows"
    document = replace(FAILED, value=math.inf).as_dict()
    assert (document["value"], document["bound"], document["reason"]) == (None, None, "a note")
    json.dumps(document, allow_nan=False)


@dataclass
class Number(Ring):
    """A number that knows sums, products and its negative alone."""

    x: int

    @classmethod
    def of(cls, other: Scalar) -> Number:
        return other if isinstance(other, Number) else cls(other)

    def __add__(self, other: Scalar) -> Number:
        return Number(self.x + Number.of(other).x)

    def __mul__(self, other: Scalar) -> Number:
        return Number(self.x * Number.of(other).x)

    def __neg__(self) -> Number:
        return Number(-self.x)


def test_the_other_operations_follow() -> None:
    one, two = Number(5), Number(3)
    assert (one - two).x == 2
    assert (1 + one).x == 6
    assert (1 - one).x == -4
    assert (one - 1).x == 4
    assert (2 * one).x == 10


def test_a_result_is_computed_once_for_each_key_and_object() -> None:
    asked: list[str] = []

    def compute(key: str) -> str:
        asked.append(key)
        return key

    one, other = Memory(), Memory()
    for memory, key in ((one, "a"), (one, "a"), (one, "b"), (other, "a")):
        assert memory.once(key, partial(compute, key)) == key
    assert asked == ["a", "b", "a"]
