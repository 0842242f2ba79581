"""Every claim has a counterexample: made false, it comes to another verdict."""

from types import SimpleNamespace
from typing import Any

import pytest

from tt_precise.claims import claims, judge
from tt_precise.claims.evidence.run import Run, variant


def _every_claim() -> list[Any]:
    slow = pytest.mark.slow
    return [pytest.param(one.id, marks=slow if one.slow else ()) for one in claims().values()]


@pytest.mark.parametrize("one", _every_claim())
def test_control_changes_the_verdict(one: str) -> None:
    counterexample = claims()[one].counterexample
    judged = judge(one)
    assert judged.note
    assert judged.printed
    if counterexample is None:
        assert judged.verdict == "untestable", f"{one} can be tested, so it needs a counterexample"
    else:
        assert judge(one, **counterexample).verdict != judged.verdict


@pytest.mark.parametrize(
    ("id", "changes"),
    [
        ("TH-15", {"run": Run(variant(phi_dot="-300"))}),  # leaves the table
        ("SWP-02", {"beyond": "300"}),  # no start is there
        ("SWP-22", {"limit": "-300"}),
    ],
)
def test_what_nothing_shows_does_not_hold(id: str, changes: dict[str, Any]) -> None:
    assert judge(id, **changes).verdict == "refuted"


def test_contact_in_a_run_that_failed_is_not_contact_all_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = Run(variant(until="0.3"))
    assert judge("QUAL-15", run=run).verdict == "reproduced"
    monkeypatch.setattr(Run, "trajectory", lambda *_: SimpleNamespace(status="failed"))
    assert judge("QUAL-15", run=run).verdict == "refuted"
