"""Steady spins are known without an integrator, and integration finds them again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal

import pytest

from tt_precise.golden.closed_form import closed_form
from tt_precise.golden.digits import agreement
from tt_precise.golden.runs import Task, perform, reconcile
from tt_precise.golden.table import Table
from tt_precise.scene.scene import Scene, load_scene

Shorten = Callable[[str, str], Scene]


@pytest.mark.parametrize("name", ["upright", "inverted"])
def test_integration_agrees_with_the_closed_form(shorten: Shorten, name: str) -> None:
    scene = shorten(name, "0.1")
    run = perform(Task(name, scene.text, "mp", 160, "newton"))
    oracle = closed_form(scene)
    assert oracle is not None
    consensus = reconcile(scene, [run, oracle])
    assert consensus.complete
    assert consensus.agreement > 45
    # L = I3 omega_3 k, k = z or -z; 28 digits are those of decimal's own context
    spin = scene.body.I3 * scene.start.omega_3
    printed = Decimal(consensus.trajectory.column("Lz")[-1])
    exact = Decimal(spin.numerator) / Decimal(spin.denominator)
    assert agreement(exact if name == "upright" else -exact, printed) > 27


def test_a_flight_is_found_again_with_its_events_and_its_landing() -> None:
    scene = load_scene("flight")
    oracle = closed_form(scene)
    assert oracle is not None
    consensus = reconcile(scene, [perform(Task("flight", scene.text, "mp", 160, "newton")), oracle])
    assert consensus.complete
    assert consensus.agreement > 44
    assert consensus.status == "landed"
    names = set(consensus.events.column("name"))
    assert names == {"theta_min", "theta_max", "equator", "phi_dot_zero", "landed"}
    higher = closed_form(scene.varied(height="0.010000000000000000000000000000000001"))
    assert higher is not None
    assert not reconcile(scene, [oracle, higher]).complete
    slower = closed_form(scene.varied(omega_3="149.999"))
    assert slower is not None
    assert reconcile(scene, [oracle, slower]).agreement < 6


def test_a_short_flight_does_not_land_and_a_plain_one_does_not_nutate() -> None:
    scene = load_scene("flight")
    short = closed_form(scene.varied(until="0.1"))
    assert short is not None
    assert (short.status, len(short.trajectory.rows)) == ("complete", 11)
    plain = closed_form(scene.varied(theta_dot="0", phi_dot="0"))
    assert plain is not None
    assert plain.events.rows == ()
    assert closed_form(replace(scene, record=("phi",))) is None


def test_a_wrong_steady_state_does_not_agree(shorten: Shorten) -> None:
    scene = shorten("upright", "0.1")
    oracle = closed_form(scene)
    assert oracle is not None
    other = closed_form(scene.varied(omega_3="200"))
    assert other is not None
    table = reconcile(scene, [oracle, other]).trajectory
    assert isinstance(table, Table)
    assert table.column("Lz")[-1] == ""


@pytest.mark.parametrize("name", ["reference", "beside-the-pole", "rolling"])
def test_other_scenes_have_none(name: str) -> None:
    assert closed_form(load_scene(name)) is None


@pytest.mark.parametrize("pushed", ["theta_dot", "nu_x", "nu_y"])
def test_a_push_off_the_pole_is_no_steady_state(pushed: str) -> None:
    assert closed_form(load_scene("upright").varied(**{pushed: "0.01"})) is None
