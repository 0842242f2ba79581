"""Every claim has a control: made false, it comes to another verdict."""

from pathlib import Path
from typing import Any

import pytest

from tt_precise.claims import claims, judge

LISTED = Path(__file__).with_name("ids.txt").read_text("ascii").split()

# modules whose claims integrate many starts or compile many events, half of the time of all
SLOW = {
    "conservation", "contact", "contact_forces", "direct_climb", "energy_decreases",
    "energy_transfer", "equations_of_motion", "gliding", "limits", "main_equation_curve",
    "motion_in_the_potential", "printed_constants", "robustness", "spin", "summary",
    "synchronisation",
}  # fmt: skip


def _every_claim() -> list[Any]:
    slow = pytest.mark.slow
    return [
        pytest.param(one.id, marks=slow if one.group.rpartition(".")[2] in SLOW else ())
        for one in claims().values()
    ]


def test_the_list_has_174_ids() -> None:
    assert len(LISTED) == len(set(LISTED)) == 174


def test_judges_exactly_the_listed_ids() -> None:
    assert list(claims()) == sorted(LISTED, key=lambda one: claims()[one].order)


def test_slow_modules_exist() -> None:
    assert {one.group.rpartition(".")[2] for one in claims().values()} >= SLOW


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
