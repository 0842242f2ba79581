"""Healthy trajectories pass; every check has been seen failing."""

from __future__ import annotations

from dataclasses import replace

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy
from tt_precise.check.checks import CHECKS
from tt_precise.mechanics.conserved import INTEGRALS

# Double holds the integrals to some eps (2e-16); the state passed 1,400 steps of one eps each,
# the sums over 801 rows add as much again.
DOUBLE = 1e-13
RELATIVE = [check.name for check in CHECKS if check.sense == "at most"]


@pytest.mark.parametrize("columns", [VECTORS, EULER], ids=["vectors", "Euler"])
@pytest.mark.parametrize("scene", ["reference", "frictionless", "rolling", "phi-dot-195"])
def test_a_healthy_trajectory_passes_at_the_limit_of_double(
    healthy: Healthy, scene: str, columns: list[str]
) -> None:
    result = tt.check.conservation(
        healthy(scene)[columns], scene, limits=dict.fromkeys(RELATIVE, DOUBLE)
    )
    assert result.passed, str(result)
    assert result.rows == 801
    values = {f.name: f.value for f in result.checks if f.verdict == "pass"}
    assert {"time", "jellett", "energy", "contact"} <= values.keys()
    if scene == "rolling":
        assert {"routh", "modified_energy", "contact_velocity"} <= values.keys()
    if scene == "frictionless":
        assert {"spin", "vertical_angular_momentum"} <= values.keys()
        assert ("momentum_x" in values) == (columns is VECTORS)


@pytest.mark.parametrize("scene", ["upright", "inverted"])
def test_a_vertical_axis_is_no_obstacle_and_keeps_its_length(healthy: Healthy, scene: str) -> None:
    frame = healthy(scene, 81)
    assert tt.check.conservation(frame, scene).passed
    frame["kz"] *= 1 + 1e-5
    assert tt.check.conservation(frame, scene)["axis_norm"].verdict == "fail"


def test_every_integral_of_mechanics_is_checked() -> None:
    assert set(INTEGRALS) <= {check.name for check in CHECKS}


def spoiled(frame: pandas.DataFrame, name: str, factor: float) -> pandas.DataFrame:
    """The second half of a column, multiplied."""
    frame = frame.copy()
    frame.loc[len(frame) // 2 :, name] *= factor
    return frame


@pytest.mark.parametrize(
    ("scene", "column", "check"),
    [
        ("reference", "Lz", "jellett"),
        ("reference", "kz", "axis_norm"),
        ("reference", "Lz", "equations"),
        ("reference", "vx", "energy_balance"),
        ("frictionless", "Lz", "energy"),
        ("frictionless", "Lz", "spin"),
        ("frictionless", "Lz", "vertical_angular_momentum"),
        ("frictionless", "vx", "momentum_x"),
        ("frictionless", "vy", "momentum_y"),
        ("rolling", "Lz", "routh"),
        ("rolling", "Lz", "modified_energy"),
    ],
)
def test_a_small_error_fails(healthy: Healthy, scene: str, column: str, check: str) -> None:
    limits = {check: 1e-9}
    frame = healthy(scene)[VECTORS]
    assert tt.check.conservation(frame, scene, limits=limits)[check].verdict == "pass"
    found = tt.check.conservation(spoiled(frame, column, 1 + 1e-7), scene, limits=limits)[check]
    assert found.verdict == "fail"
    assert 1e-9 < (found.value or 0) < 1e-5
    assert (found.at or 0) >= 4


def test_energy_may_fall_but_not_rise(healthy: Healthy) -> None:
    frame = healthy()[VECTORS]
    # run backwards in time the same states gain energy: L and v change sign with the time
    back = frame.iloc[::-1].reset_index(drop=True)
    back["t"] = 8 - back["t"]
    back[["Lx", "Ly", "Lz", "vx", "vy"]] *= -1
    assert tt.check.conservation(frame, "reference")["energy"].value == 0
    found = tt.check.conservation(back, "reference")["energy"]
    assert found.verdict == "fail"
    assert found.value == pytest.approx(2.6, rel=0.5)


def test_a_pulling_table_fails(healthy: Healthy) -> None:
    frame = healthy()[EULER]
    frame.loc[700, "theta_dot"] = 200.0  # swings over the top faster than gravity pulls
    found = tt.check.conservation(frame, "reference")["contact"]
    assert found.verdict == "fail"
    assert found.at == 7.0


def test_gliding_fails_a_rolling_scene(healthy: Healthy) -> None:
    frame = healthy("rolling")[VECTORS].assign(vx=1e-3)
    assert tt.check.conservation(frame, "rolling")["contact_velocity"].verdict == "fail"


def test_another_friction_law_is_held_to_what_every_law_keeps(healthy: Healthy) -> None:
    result = tt.check.conservation(healthy()[VECTORS], "reference", friction="other")
    done = {finding.name for finding in result.checks if finding.verdict != "skipped"}
    assert done == {"finite", "time", "jellett", "energy", "axis_norm", "friction_power"}
    with pytest.raises(tt.InputError, match="friction: got 'mine', expected one of: scene, other"):
        tt.check.conservation(healthy()[VECTORS], "reference", friction="mine")


def test_without_velocity_what_needs_it_is_skipped(healthy: Healthy) -> None:
    result = tt.check.conservation(healthy()[VECTORS[:7]], "reference")
    assert result["jellett"].verdict == "pass"
    for name in ("energy", "energy_balance", "equations", "contact"):
        assert result[name].verdict == "skipped"
        assert result[name].note == "needs the velocity: columns vx, vy"


def test_until_cuts_a_tail_off(healthy: Healthy) -> None:
    frame = spoiled(healthy()[VECTORS], "Lz", 2)
    frame.loc[700, "kx"] = numpy.nan
    assert tt.check.conservation(frame, "reference", until=3.9).passed
    assert tt.check.conservation(frame, "reference", until=3.9).t_last == 3.9
    assert not tt.check.conservation(frame, "reference", until=6).passed


def test_a_wrong_parameter_of_the_file_is_reported_from_conservation_alone(
    healthy: Healthy,
) -> None:
    scene = tt.load_scene("reference")
    heavier = replace(scene, body=replace(scene.body, mu=scene.body.mu * 1001 / 1000))
    result = tt.check.conservation(healthy()[VECTORS], heavier)
    assert {finding.name for finding in result.failures} == {"energy_balance", "equations"}


def test_limits_are_checked(healthy: Healthy) -> None:
    with pytest.raises(tt.InputError, match="limit: got 'jelett', expected one of: time, jellett"):
        tt.check.conservation(healthy(), "reference", limits={"jelett": 1})
    with pytest.raises(tt.InputError, match="limit of jellett: got nan, expected a finite number"):
        tt.check.conservation(healthy(), "reference", limits={"jellett": numpy.nan})
    # of a check that the scene has not
    with pytest.raises(AssertionError, match=r"fall: a limit was given, but .* of flight only"):
        tt.check.assert_conserves(healthy(), "reference", fall=1e-6)


def test_a_trajectory_can_be_checked_and_the_callers_table_is_left_alone(healthy: Healthy) -> None:
    assert tt.check.conservation(tt.integrate("rolling"), "rolling").passed
    frame = healthy()
    tt.check.conservation(frame, "reference")
    pandas.testing.assert_frame_equal(frame, healthy())
