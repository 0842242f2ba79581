"""Columns beside the state follow from it, or somebody followed them."""

from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, refuses
from tests.conftest import more

SPOILT: dict[str, Any] = {
    "theta": lambda v: v + 3e-6,
    "omega_3": lambda v: 1.001 * v,
    "phi_dot": lambda v: numpy.roll(v, 1),
    "nu_x": lambda v: -v,
    "phi": lambda v: 2 * v,
    "psi_dot": lambda v: v + 1,
}


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("friction", ["scene", more("other")])
@pytest.mark.parametrize("name", SPOILT)
def test_columns_beside_the_state_agree_with_it(healthy: Healthy, name: str, friction: str) -> None:
    frame = tt.integrate("reference", record=("phi",)).frame(
        *VECTORS[1:], *EULER[1:], "phi", "psi_dot", times=[0.001 * n for n in range(201)]
    )
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    assert (right["agreement"].value or 0) < 1e-12
    wrong = check(frame.assign(**{name: SPOILT[name](frame[name].to_numpy())}), "reference")
    assert [one.name for one in wrong.failures][:1] == ["agreement"]
    assert f"{name} does not agree with the vectors columns" in wrong["agreement"].note


@pytest.mark.usefixtures("no_cause")
def test_vectors_beside_euler_angles_without_phi_are_left_open(healthy: Healthy) -> None:
    """They turn with the axis, whose direction is not known; their vertical parts are compared."""
    frame = tt.integrate("reference", until="0.2").frame(*EULER[1:], "Lx", "kz")
    assert check(frame, "reference", allow=("contact_momentum", "friction_power")).passed
    found = check(frame, "reference", friction="other")
    assert (found["agreement"].verdict, found.failures) == ("open", ())
    assert "Lx not looked at" in found["agreement"].note
    wrong = check(frame.assign(kz=frame["kz"] + 1e-3), "reference")
    assert "kz does not agree" in wrong["agreement"].note


@pytest.mark.usefixtures("no_cause")
def test_a_slip_beside_a_state_without_velocity_is_left_open() -> None:
    names = (*VECTORS[1:7], "nu_x")
    frame = tt.integrate("reference", until="0.2").frame(*names)
    found = check(frame, "reference", friction="other")["agreement"]
    assert (found.verdict, found.note) == ("open", "nu_x not looked at")


@pytest.mark.usefixtures("no_cause")
def test_an_entry_that_is_not_finite_is_counted_by_its_check_alone(healthy: Healthy) -> None:
    frame = healthy()[[*VECTORS, "theta"]].head(30)
    frame.loc[3, "theta"] = numpy.nan
    assert [one.name for one in check(frame, "reference", friction="other").failures] == ["finite"]


@pytest.mark.usefixtures("no_cause")
def test_columns_of_few_digits_say_what_would_go_unnoticed(healthy: Healthy) -> None:
    few = healthy()[[*VECTORS, "theta", "phi_dot"]].map(lambda x: float(f"{x:.4g}"))
    found = check(few.assign(t=healthy()["t"]), "reference", friction="other")["agreement"]
    assert found.verdict == "pass"
    assert (found.bound or 0) > 1e-3
    assert found.note == "checked theta, phi_dot; detects 2e-03"


@pytest.mark.usefixtures("no_cause")
def test_a_track_that_nobody_followed_is_incomplete(healthy: Healthy) -> None:
    frame = pandas.DataFrame(tt.golden.load("track"))[:401:8]
    assert check(frame, "track").passed
    found = check(frame, "track", friction="other", allow=("kinematics", "contact_momentum"))
    assert found.verdict == "incomplete"
    assert "could not check all columns (" in found.heading
    allowed = ("kinematics", "contact_momentum", "agreement")
    assert check(frame, "track", friction="other", allow=allowed).passed
    assert check(frame, "track", friction="other", allow=", ".join(allowed)).passed
    refuses("allow: got 'psi', expected one of: time, ", frame, "track", allow=("psi",))


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("friction", ["scene", "other"])
def test_a_quaternion_beside_vectors_is_followed(friction: str) -> None:
    """It agrees in its axis; kinematics follows its turn about the axis."""
    names = ("qw", "qx", "qy", "qz")
    run = tt.integrate("reference", record=("phi", "psi"))
    frame = run.frame(*VECTORS[1:], *names, times=[0.001 * n for n in range(201)])
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    angle = 0.1 * numpy.sin(frame["t"] * 20) / 2
    c, s = numpy.cos(angle), numpy.sin(angle)
    w, x, y, z = (frame[name] for name in names)
    turned = (w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s)
    wrong = frame.assign(**dict(zip(names, turned, strict=True)))
    failed = [one.name for one in check(wrong, "reference", friction=friction).failures]
    assert failed == ["kinematics"]
    tilted = check(frame.assign(qx=frame["qx"] + 1e-4), "reference", friction=friction)
    assert "qx does not agree with the vectors columns" in tilted["agreement"].note
    few = check(frame.head(5), "reference", friction=friction)["agreement"]
    assert (few.verdict, few.note) == ("open", "qw, qx, qy, qz not looked at")
    lacking = check(frame.drop(columns="qw"), "reference", friction=friction)
    assert (lacking.verdict, lacking["agreement"].note) == (
        "incomplete", "qx, qy, qz not looked at"
    )  # fmt: skip
