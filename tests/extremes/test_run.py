"""Test the records of cases, the command on two cases, and a scene at its edges."""

import json
from fractions import Fraction
from pathlib import Path

import pytest

import tt_precise as tt
from tests.conftest import Printed, Said
from tt_precise.extremes import EdgeCase, cases, run
from tt_precise.extremes.judges import Measurement, is_refused

REFERENCE = tt.load_scene("reference")


def test_an_exception_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def judge(case: EdgeCase) -> Measurement:
        """Expect nothing."""
        raise ValueError("why")

    case = EdgeCase("poles", "bad", judge)
    monkeypatch.setattr(run, "cases", lambda: [case])
    record = run.record(case, run.judge("bad"))
    assert (record.verdict, record.expected, record.limit) == ("fail", "Expect nothing.", None)
    assert record.found == "ValueError: why"
    assert run.run_cases([]).verdict == "fail"  # nothing was tested


def test_a_failed_case_fails_the_command(
    said: Said, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = next(case for case in cases() if case.judge is is_refused)
    bad = EdgeCase("poles", "no such case", is_refused)
    monkeypatch.setattr("tt_precise.commands.numerics.cases", lambda: [good, bad])
    file = tmp_path / "extremes.json"
    assert "2 cases, 1 failed." in said("extremes --workers 1 --out", file, status=1)
    document = json.loads(file.read_text())
    assert [case["verdict"] for case in document["cases"]] == ["pass", "fail"]
    assert "1 cases, 0 failed." in said("extremes --workers 1 --topic contact")


def test_changes_are_exact_and_horizons_follow_the_rates() -> None:
    changes = dict(run.edges(REFERENCE))
    assert len(changes) == 1 + 2 * 8 + 6 + 7
    assert changes["theta = pi - 1e-300"].start.theta == (Fraction(1, 10**300), True)
    assert changes["omega_3 times 1e-6"].start.omega_3 == REFERENCE.start.omega_3 / 10**6
    fast, slow = changes["mu times 1e3"], changes["mu times 1e-12"]
    assert (fast.body.mu, fast.until) == (1000 * REFERENCE.body.mu, Fraction(8, 100))
    assert (slow.body.mu, slow.until) == (REFERENCE.body.mu / 10**12, REFERENCE.until)
    assert {scene.until <= 10 for _, scene in run.edges(REFERENCE.varied(until="99"))} == {True}
    assert not any(name.startswith("mu") for name, _ in run.edges(tt.load_scene("rolling")))


def test_outcomes_are_those_of_the_run() -> None:
    lost = tt.load_scene("contact-lost")
    outcome, trajectory = run.outcome("", lost, "double"), tt.integrate(lost)
    assert (outcome.status, outcome.t_end_s) == ("contact_lost", trajectory.t_end)
    assert outcome.digits == pytest.approx(float(trajectory.digits_throughout))
    pulled = lost.varied(theta="2", theta_dot="100", omega_3="0", mu="0")
    refusal = run.outcome("pulled", pulled, "double")
    assert (refusal.status, refusal.digits) == ("refused", None)
    assert "expected" in refusal.note
    *_, line = run.table([refusal, refusal])
    assert line.split() == ["pulled", "-", "-", "-", "refused"]


def test_the_command(printed: Printed, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "TILTS", ("1e-300",))
    monkeypatch.setattr(run, "POWERS_OF_SPIN", ())
    monkeypatch.setattr(run, "POWERS_OF_FRICTION", (-6,))
    outcomes = printed("extremes contact-lost")["outcomes"]
    assert [each["precision"] for each in outcomes] == ["double", "double-double"] * 4
    assert [each["status"] for each in outcomes[:2]] == ["contact_lost"] * 2
    assert "contact_lost at 1.33" in said("extremes contact-lost").splitlines()[1]
