"""Every claim has a control: made false, it comes to another verdict."""

from pathlib import Path
from typing import Any

import pytest

from tt_precise.claims import claims, judge

LISTED = Path(__file__).with_name("ids.txt").read_text("ascii").split()


def _every_claim() -> list[Any]:
    slow = pytest.mark.slow
    return [pytest.param(one.id, marks=slow if one.slow else ()) for one in claims().values()]


def test_the_list_has_174_ids() -> None:
    assert len(LISTED) == len(set(LISTED)) == 174


def test_judges_exactly_the_listed_ids() -> None:
    assert list(claims()) == sorted(LISTED, key=lambda one: claims()[one].order)


def test_most_controls_run_by_default() -> None:
    assert sum(not one.slow for one in claims().values()) >= 160


@pytest.mark.parametrize("one", _every_claim())
def test_control_changes_the_verdict(one: str) -> None:
    control = claims()[one].control
    found = judge(one)
    assert found.finding.note
    assert found.finding.printed
    if control is None:
        assert found.verdict == "untestable", f"{one} can be tested, so it needs a control"
    else:
        assert judge(one, **control).verdict != found.verdict
