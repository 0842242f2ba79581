"""Steady spins are known without an integrator, and integration finds them again."""

from dataclasses import replace
from decimal import Decimal

import pytest

from tests.golden.conftest import shortened
from tt_precise.golden.closed_form import closed_form
from tt_precise.golden.digits import agreement
from tt_precise.golden.runs import Run, Task, perform, reconcile
from tt_precise.scene.scene import Scene, load_scene


def known(scene: Scene) -> Run:
    """The closed form, of a scene that has one."""
    found = closed_form(scene)
    assert found is not None
    return found


def computed(scene: Scene) -> Run:
    return perform(Task(scene.name, scene.text, "mp", 160, "newton"))


@pytest.mark.parametrize("name", ["upright", "inverted"])
def test_integration_agrees_with_the_closed_form(name: str) -> None:
    scene = shortened(name, "0.1")
    consensus = reconcile(scene, [computed(scene), known(scene)])
    assert consensus.complete
    assert consensus.agreement > 45
    # L = I3 omega_3 k, k = z or -z; 28 digits are those of decimal's own context
    spin = scene.body.I3 * scene.start.omega_3
    printed = Decimal(consensus.trajectory.column("Lz")[-1])
    exact = Decimal(spin.numerator) / Decimal(spin.denominator)
    assert agreement(exact if name == "upright" else -exact, printed) > 27
    # a wrong steady state does not agree
    table = reconcile(scene, [known(scene), known(scene.varied(omega_3="200"))]).trajectory
    assert table.column("Lz")[-1] == ""


def test_a_flight_is_found_again_with_its_events_and_its_landing() -> None:
    scene = load_scene("flight")
    oracle = known(scene)
    consensus = reconcile(scene, [computed(scene), oracle])
    assert consensus.complete
    assert consensus.agreement > 44
    assert consensus.status == "landed"
    names = set(consensus.events.column("name"))
    assert names == {"theta_min", "theta_max", "equator", "phi_dot_zero", "landed"}
    higher = known(scene.varied(height="0.010000000000000000000000000000000001"))
    assert not reconcile(scene, [oracle, higher]).complete
    slower = known(scene.varied(omega_3="149.999"))
    assert reconcile(scene, [oracle, slower]).agreement < 6


def test_a_short_flight_does_not_land_and_a_plain_one_does_not_nutate() -> None:
    scene = load_scene("flight")
    short = known(scene.varied(until="0.1"))
    assert (short.status, len(short.trajectory.rows)) == ("complete", 11)
    assert known(scene.varied(theta_dot="0", phi_dot="0")).events.rows == ()
    assert closed_form(replace(scene, record=("phi",))) is None


@pytest.mark.parametrize(
    ("name", "pushed"),
    [
        ("reference", {}), ("beside-the-pole", {}), ("rolling", {}),
        *(("upright", {push: "0.01"}) for push in ("theta_dot", "nu_x", "nu_y")),  # off the pole
    ],
)  # fmt: skip
def test_other_motions_have_none(name: str, pushed: dict[str, str]) -> None:
    assert closed_form(load_scene(name).varied(**pushed)) is None
