"""Test the changes of a scene at its edges, and their outcomes."""

from fractions import Fraction

import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise.extremes import edges

REFERENCE = tt.load_scene("reference")


def test_changes_are_exact_and_horizons_follow_the_rates() -> None:
    changes = dict(edges.edges(REFERENCE))
    assert len(changes) == 1 + 2 * 8 + 6 + 7
    assert changes["theta = pi - 1e-300"].start.theta == (Fraction(1, 10**300), True)
    assert changes["omega_3 times 1e-6"].start.omega_3 == REFERENCE.start.omega_3 / 10**6
    fast, slow = changes["mu times 1e3"], changes["mu times 1e-12"]
    assert (fast.body.mu, fast.until) == (1000 * REFERENCE.body.mu, Fraction(8, 100))
    assert (slow.body.mu, slow.until) == (REFERENCE.body.mu / 10**12, REFERENCE.until)
    assert {scene.until <= 10 for _, scene in edges.edges(REFERENCE.varied(until="99"))} == {True}
    rolling = tt.load_scene("rolling")  # which has no friction coefficient
    assert not any(change.startswith("mu") for change, _ in edges.edges(rolling))


def test_outcomes_are_those_of_the_run() -> None:
    lost = tt.load_scene("contact-lost")
    outcome, run = edges.outcome("", lost, "double"), tt.integrate(lost)
    assert (outcome.status, outcome.t_end_s) == ("contact_lost", run.t_end)
    assert outcome.digits == pytest.approx(float(run.digits_throughout))
    pulled = lost.varied(theta="2", theta_dot="100", omega_3="0", mu="0")
    refusal = edges.outcome("pulled", pulled, "double")
    assert (refusal.status, refusal.digits) == ("refused", None)
    assert "expected" in refusal.note
    *_, line = edges.table([refusal, refusal])
    assert line.split() == ["pulled", "-", "-", "-", "refused"]


def test_the_command(printed: Printed, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edges, "TILTS", ("1e-300",))
    monkeypatch.setattr(edges, "POWERS_OF_SPIN", ())
    monkeypatch.setattr(edges, "POWERS_OF_FRICTION", (-6,))
    outcomes = printed("extremes contact-lost")["outcomes"]
    assert [each["precision"] for each in outcomes] == ["double", "double-double"] * 4
    assert [each["status"] for each in outcomes[:2]] == ["contact_lost"] * 2
    assert "contact_lost at 1.33" in said("extremes contact-lost").splitlines()[1]
