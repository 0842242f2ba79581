"""Column sets: which one a table has, its names, and the checks of a rigid body."""

from collections.abc import Callable
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, pose
from tt_precise.check.columns import choose_set, renamed, renaming

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def test_a_rigid_body_is_checked_like_its_vectors(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())
    result = check(frame, "reference", limits={"jellett": 1e-13})
    assert result.passed, str(result)
    assert result.columns == "rigid body"
    for name in ("contact_velocity", "quaternion_norm", "equations"):
        assert result[name].verdict == "pass"
    assert result["axis_norm"].verdict == "skipped"
    # as vectors
    assert {*VECTORS[1:]} <= {*result["golden"].parts}
    assert (result["golden"].value or 0) > 8
    # off the table, and with a drifting quaternion
    lifted = frame.assign(vcz=frame["vcz"] + numpy.where(frame["t"] > 6, 1e-4, 0))
    assert check(lifted, "reference")["contact_velocity"].verdict == "fail"
    longer = frame.assign(qw=frame["qw"] * 1.00001)
    assert check(longer, "reference")["quaternion_norm"].verdict == "fail"
    resting = check(frame.drop(columns=["vcx", "vcy", "vcz"]), "reference")
    assert resting["jellett"].verdict == "pass"
    assert resting["energy"].verdict == "open"


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("time kx", "f.csv: missing t, .* rename yours with --columns"),
        ("t kx ky Lx Ly Lz", "f.csv: missing kz of the vectors columns"),
        ("t a", "f.csv: missing kx, ky, kz, .* among the columns t, a"),
        ("t theta theta_dot phi_dot", "missing omega_3 .* or give psi_dot: omega_3 = psi_dot"),
        ("t qpos0 qpos1", "--from ENGINE reads an engine's own state"),
        ("t qw qx qy qz wx wy wz vx vy vz", "add --columns vx=vcx,vy=vcy,vz=vcz"),
    ],
)
def test_what_is_missing_is_named(columns: str, message: str) -> None:
    with pytest.raises(tt.InputError, match=message):
        choose_set(columns.split(), "f.csv")


def test_renames(healthy: Healthy) -> None:
    theirs = healthy()[EULER[:5]].rename(columns={"t": "time", "omega_3": "spin"})
    result = check(theirs, "reference", columns={"time": "t", "spin": "omega_3"})
    assert result.columns == "Euler"
    assert renaming(["time=t, spin=omega_3"]) == {"time": "t", "spin": "omega_3"}
    wrong: list[tuple[Callable[[], Any], str]] = [
        (lambda: renaming(["time"]), "got 'time', expected theirs=ours"),
        (lambda: renaming(["w=omega3"]), "expected one of ours: .* did you mean 'omega_3'"),
        (lambda: renamed(["t"], {"spin": "omega_3"}, "f.csv"), "no column 'spin' to rename"),
        (lambda: renamed(["t", "time"], {"time": "t"}, "f.csv"), "column t occurs twice"),
    ]
    for call, message in wrong:
        with pytest.raises(tt.InputError, match=message):
            call()


def track(scene: str = "reference") -> pandas.DataFrame:
    """Return Euler angles with the recorded columns of the track."""
    run = tt.integrate(scene, record=("phi", "psi", "x", "y"))
    times = [0.005 * i for i in range(200)]
    return run.frame(*EULER[1:], "phi", "psi", "x", "y", times=times, numbers="float")


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_recorded_columns_are_followed(friction: str) -> None:
    frame = track()
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    for name, factor in (("phi", 1.001), ("psi", 1.001), ("x", 1.5), ("y", 1.5)):
        wrong = frame.assign(**{name: frame[name] * factor})
        assert not check(wrong, "reference", friction=friction).passed, name
    # phi that holds its own rate
    assert not check(frame.assign(phi=frame["phi_dot"]), "reference", friction=friction).passed


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_a_position_belongs_to_the_motion(friction: str) -> None:
    frame = pose([0.005 * i for i in range(200)])
    assert check(frame, "reference", friction=friction).passed
    for name, wrong in (
        ("z", frame["z"] + 5.0), ("z", 0 * frame["z"]), ("x", 2 * frame["x"] + frame["t"]),
        ("y", frame["x"]),
    ):  # fmt: skip
        found = check(frame.assign(**{name: wrong}), "reference", friction=friction)
        assert not found.passed, name


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_spoilt_columns_are_not_green(healthy: Healthy, friction: str) -> None:
    """Other signs in half of the rows, shifted columns, columns that hold others."""
    frame = healthy("reference", 401, 1)[VECTORS]
    half = numpy.where(frame.index % 2, -1.0, 1.0)
    for spoilt in (
        frame.assign(vx=half * frame["vx"], vy=half * frame["vy"]),
        frame.assign(kx=half * frame["kx"], ky=half * frame["ky"]),
        frame.assign(Lz=frame["Lz"].shift(1).fillna(frame["Lz"]) * (1 + 1e-4 * frame["t"])),
        frame.assign(kx=frame["kx"].shift(1).fillna(frame["kx"])),
        frame.assign(vx=frame["vx"].shift(1).fillna(frame["vx"])),
        frame.assign(Lx=frame["Ly"], Ly=frame["Lx"]),
    ):
        assert not check(spoilt, "reference", friction=friction).passed
