"""Shared values: names, whole numbers, the result of a check, cached results."""

from __future__ import annotations

import itertools
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

from tt_precise.runtime.values import Check, InputError, Memory, distinct, whole_number, wrong_name


def test_a_thing_that_is_given_twice_counts_once_and_two_of_one_name_are_refused() -> None:
    one, other = (SimpleNamespace(name="E", power=power) for power in (1, 2))
    assert distinct("quantities", ["a", one, "a", one]) == ("a", one)
    with pytest.raises(InputError, match="got two called E"):
        distinct("quantities", [one, other])


@pytest.mark.parametrize("value", [10**400, 10**5000, -1, 1.0, True, "3"], ids=lambda _: "")
def test_a_whole_number_is_one_within_its_bounds(value: Any) -> None:
    assert [whole_number(number, "n", 0, 9) for number in (0, numpy.int64(9))] == [0, 9]
    with pytest.raises(InputError, match=r"n: got .{1,60}, expected .* between 0 and 9"):
        whole_number(value, "n", 0, 9)


def test_a_check_is_a_sentence() -> None:
    failed = Check("jellett", "fail", value=2e-3, limit=1e-6, at=1.5, note="a note")
    assert [replace(failed, verdict=word).holds for word in ("fail", "pass", "open")] == [0, 1, 1]
    assert failed.sentence() == "jellett: 0.002, allowed 1e-06, at t = 1.5 s: a note"
    late = replace(failed, since=1.25, sense="at least", note="")
    assert late.sentence() == "jellett: 0.002, expected at least 1e-06, from t = 1.25 s on"
    assert Check("golden", "skipped", note="no rows").sentence() == "golden: no rows"


def test_a_result_is_computed_once_for_each_key_and_object() -> None:
    count = itertools.count()
    one, other = Memory(), Memory()
    calls = ((one, "a"), (one, "a"), (one, "b"), (other, "a"))
    assert [memory.once(key, lambda: next(count)) for memory, key in calls] == [0, 0, 1, 2]


def test_a_wrong_name_has_the_nearest() -> None:
    names = ["drift:E", "drift:jellett", "theta", "omega_3"]
    for name, near in {"omega3": "omega_3", "drift:jellet": "drift:jellett", "lean": ""}.items():
        message = str(wrong_name("column", name, names))
        assert message.startswith(f"column: got {name!r}, expected one of: {', '.join(names)}")
        assert message.endswith(f"; did you mean {near!r}?" if near else names[-1])
