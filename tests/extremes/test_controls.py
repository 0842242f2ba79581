"""Every family of cases has a control that fails: a wrong implementation would be seen."""

from __future__ import annotations

import pytest

from tt_precise.extremes import TOPICS, ExtremeCase, cases
from tt_precise.extremes.horizons import there_and_back

AT_LEAST = 120  # cases


def controlled() -> dict[str, ExtremeCase]:
    """The case of each family that its control is tried on: the first quick one, or the first."""
    chosen: dict[str, ExtremeCase] = {}
    for one in cases():
        held = chosen.get(one.family)
        if held is None or (one.quick and not held.quick):
            chosen[one.family] = one
    return chosen


FAMILIES = controlled()
SAMPLE = [
    next(name for name, one in FAMILIES.items() if one.topic == topic and one.quick)
    for topic in TOPICS
    if any(one.topic == topic and one.quick for one in FAMILIES.values())
]


def test_there_are_enough_cases_and_each_says_what_it_expects() -> None:
    every = cases()
    assert len(every) >= AT_LEAST
    assert len({one.name for one in every}) == len(every)
    for one in every:
        assert one.control, one.name
        assert "{" not in one.expected + one.name


def test_quick_cases_are_some_of_all() -> None:
    quick, every = cases(quick=True), cases()
    assert {one.name for one in quick} < {one.name for one in every}
    assert {one.topic for one in quick} == {one.topic for one in every}


def test_a_topic_can_be_chosen() -> None:
    assert {one.topic for one in cases(["contact"])} == {"contact"}


@pytest.mark.parametrize("family", SAMPLE)
def test_a_control_of_each_topic_fails(family: str) -> None:
    one = FAMILIES[family]
    assert one.outcome().verdict == "pass", one.outcome().found
    assert one.outcome(**one.control).verdict == "fail"


@pytest.mark.slow
@pytest.mark.parametrize("family", [name for name in FAMILIES if name not in SAMPLE])
def test_every_control_fails(family: str) -> None:
    test_a_control_of_each_topic_fails(family)


@pytest.mark.slow
def test_eight_seconds_and_back_in_mp() -> None:
    """It takes minutes, too long for a case of the command."""
    check = there_and_back("8", "mp")
    assert check.holds
    # in 200 bits, more than double has in all
    assert float(check.measured.split("; ")[1].split()[0]) > 20
