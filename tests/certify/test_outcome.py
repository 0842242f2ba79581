"""The outcome of a trajectory: what is proved about its end, and what is not."""

import pytest

from tt_precise.certify.outcome import Outcome, _last_state, outcome_of
from tt_precise.integration import Trajectory, integrate
from tt_precise.scene.scene import Scene, load_scene


def outcome(scene: str | Scene, precision: str = "double", **how: str) -> Outcome:
    run = integrate(scene, precision, **how)  # type: ignore[arg-type]
    return outcome_of(run, run.inversion.equator)


@pytest.mark.parametrize("precision", ["double", "double-double"])
@pytest.mark.parametrize("formulation", ["newton", "euler"])
def test_the_reference_top_approaches_the_inverted_spin(precision: str, formulation: str) -> None:
    if (precision, formulation) == ("double-double", "euler"):
        pytest.skip("double-double integrates vectors only")
    found = outcome("reference", precision, formulation=formulation)
    assert (found.equator.verdict, found.end.verdict) == ("passed", "inverted")
    assert float(found.equator.t) == pytest.approx(5.87974951858, abs=1e-9)
    assert found.theorem.inverts is True


def test_a_top_in_the_other_direction_does_the_same() -> None:
    mirrored = load_scene("reference").varied(omega_3="-155")
    assert outcome(mirrored).end.verdict == "inverted"


@pytest.mark.parametrize(
    ("name", "equator", "end", "reason"),
    [
        ("stays-upright", "never", "upright", "confine it"),
        ("below-threshold", "passed", "not_inverted", "too low"),
        ("frictionless", "not_passed", "undecided", "without friction"),
        ("rolling", "not_passed", "undecided", "without friction"),
        ("upright", "not_passed", "undecided", "vertical from the start"),
        ("contact-lost", "not_passed", "undecided", "the motion ended: contact_lost"),
        ("stribeck", "passed", "undecided", "the contact force, or the spin, may vanish"),
        ("coulomb-gliding", "not_passed", "undecided", "coulomb has no derivative"),
        ("elastic-linear", "not_passed", "undecided", "may leave the table"),
    ],
)
def test_equator_and_end_of_each_scene(name: str, equator: str, end: str, reason: str) -> None:
    scene = load_scene(name)
    # of a top that rolls, friction takes no energy
    found = outcome(scene.varied(mu="0.3") if name == "rolling" else scene)
    assert (found.equator.verdict, found.end.verdict) == (equator, end)
    assert reason in found.end.reason


def test_a_top_that_begins_below_the_equator_never_passes_it() -> None:
    assert outcome(load_scene("reference").varied(theta="3", until="4")).equator.verdict == "never"


def test_what_settles_inclined_is_not_inverted() -> None:
    """Just below the threshold: the axis passes the equator and settles at an inclination."""
    scene = load_scene("reference").varied(omega_3="75", until="40", sample_every="1")
    found = outcome(scene)
    assert (found.theorem.verdict, found.equator.verdict) == ("does_not_invert", "passed")
    assert found.end.verdict == "not_inverted"


def test_a_barrier_before_the_inverted_spin_is_named() -> None:
    """The energy is above that of the inverted spin, and below that of a top at 60 deg."""
    body = {"m": "0.015", "R": "0.015", "alpha": "0.1", "I1": "0.32", "g": "9.8"}
    scene = load_scene("reference").varied(**body, omega_3="300", until="1")
    end = outcome(scene).end
    assert end.verdict == "not_inverted"
    assert "theta = 60 deg" in end.reason
    # of a slow top the energy itself is too low
    slow = outcome(load_scene("reference").varied(omega_3="40", until="1")).end
    assert slow.reason == "its energy is too low for the inverted spin"


def test_nothing_is_stated_of_a_state_that_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """The control: with no right digit every end is within the error."""
    run = integrate("reference")
    monkeypatch.setattr(Trajectory, "digits", 0.0)
    assert outcome_of(run, None).end.verdict == "undecided"
    run = integrate("stays-upright")
    assert outcome_of(run, None)[1:] == (("not_passed", None), outcome_of(run, None).end)
    assert outcome_of(run, None).end.verdict == "undecided"


def test_a_component_is_as_wide_as_its_error_and_ten_times_that() -> None:
    """Also the velocity, which has decayed: its error is relative to sqrt(g R)."""
    run = integrate("stays-upright")
    last = _last_state(run)
    assert abs(last.vx) < 1e-3
    assert last.vx.rad() > 9.9 * 10.0 ** -int(run.digits)
