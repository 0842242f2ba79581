"""Every claim has a control: made false, it comes to another verdict."""

from pathlib import Path

import pytest

from tt_precise.claims import claims, judge

LISTED = Path(__file__).with_name("ids.txt").read_text("ascii").split()


def test_judges_exactly_the_listed_ids() -> None:
    missing = [one for one in LISTED if one not in claims()]
    assert not set(claims()) - set(LISTED)
    if missing:
        pytest.xfail(f"{len(missing)} claims are still to be written: {', '.join(missing)}")


def test_the_list_has_174_ids() -> None:
    assert len(LISTED) == len(set(LISTED)) == 174


@pytest.mark.parametrize("one", claims())
def test_control_changes_the_verdict(one: str) -> None:
    control = claims()[one].control
    found = judge(one)
    assert found.finding.note
    if control is None:
        assert found.verdict == "untestable", f"{one} can be tested, so it needs a control"
    else:
        assert judge(one, **control).verdict != found.verdict
