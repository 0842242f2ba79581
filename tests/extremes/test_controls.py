"""Every family of cases has a control that fails: a wrong implementation would be seen."""

from __future__ import annotations

import pytest

from tt_precise.extremes import TOPICS, cases, contact
from tt_precise.extremes.case import merged
from tt_precise.extremes.horizons import there_and_back

AT_LEAST = 120  # cases


FAMILIES = {one.family.name: one for one in cases(quick=True)}
# the first family of each topic
SAMPLE = {one.family.topic: name for name, one in reversed(FAMILIES.items())}.values()


def test_there_are_enough_cases_and_each_says_what_it_expects() -> None:
    every = cases()
    assert len(every) >= AT_LEAST
    assert len({one.name for one in every}) == len(every)
    for one in every:
        assert one.family.control, one.name
        assert one.family.expected, one.name
        assert "{" not in one.name


def test_the_first_case_of_each_family_and_a_topic_can_be_chosen() -> None:
    quick, every = cases(quick=True), cases()
    assert [one.name for one in quick] == [one.name for one in FAMILIES.values()]
    assert {one.family.name for one in every} == set(FAMILIES)
    assert {one.family.topic for one in quick} == set(TOPICS)
    assert {one.family.topic for one in cases(["contact"])} == {"contact"}


@pytest.mark.parametrize(
    "family",
    [
        pytest.param(
            name,
            marks=[pytest.mark.slow] * (name not in SAMPLE)
            or [pytest.mark.evidence] * (FAMILIES[name].family.topic in ("machine", "time")),
        )
        for name in FAMILIES
    ],
)
def test_every_control_fails(family: str) -> None:
    one = FAMILIES[family]
    assert one.outcome().verdict == "pass", one.outcome().found
    assert one.outcome(**one.family.control).verdict == "fail"


def test_the_heavier_top_blows_up_unless_it_is_let_go() -> None:
    heavier = contact.NAMES[6]
    assert merged(contact.blow_up(heavier)).holds
    assert merged(contact.lost_first(heavier)).holds
    assert not merged(contact.lost_first(heavier, contact="bilateral")).holds


@pytest.mark.slow
def test_eight_seconds_and_back_in_mp() -> None:
    """It takes minutes, too long for a case of the command."""
    check = merged(there_and_back("8", "mp"))
    assert check.holds
    # in 200 bits, more than double has in all
    assert float(check.measured.split("; ")[1].split()[0]) > 20
