"""Other units and other bodies are refused; what is healthy, or only wrong, is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy
import pandas
import pytest

import tt_precise as tt

VECTORS = ["t", "kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy"]
EULER = ["t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"]
RATES = ["theta_dot", "phi_dot", "omega_3"]
Healthy = Callable[..., pandas.DataFrame]
DEGREE = 180 / numpy.pi


def scaled(frame: pandas.DataFrame, factor: float, *names: str) -> pandas.DataFrame:
    return frame.assign(**{name: factor * frame[name] for name in names})


@pytest.mark.parametrize("rows", [801, 4001])
@pytest.mark.parametrize(
    ("columns", "factor", "names", "told"),
    [
        (VECTORS, 1e3, ["t"], "if the time is in ms; expected SI"),
        (EULER, 1e3, ["t"], "if the time is in ms; expected SI"),
        (EULER, DEGREE, RATES, "if the angular velocities are in deg/s"),
        (EULER, 1 / (2 * numpy.pi), RATES, "if the angular velocities are in revolutions/s"),
        (EULER, DEGREE, ["theta"], "degrees"),
        (VECTORS, 1e6, ["Lx", "Ly", "Lz"], r"if the angular momentum is in kg mm\^2/s"),
        (VECTORS, 1e3, ["vx", "vy"], "if the velocities are in mm/s"),
    ],
)
def test_other_units_are_named(
    healthy: Healthy, rows: int, columns: list[str], factor: float, names: list[str], told: str
) -> None:
    frame = healthy("reference", rows)[columns]
    assert tt.check.conservation(frame, "reference").passed
    with pytest.raises(tt.InputError, match=told):
        tt.check.conservation(scaled(frame, factor, *names), "reference")


def body_frame(frame: pandas.DataFrame) -> pandas.DataFrame:
    w = frame[["wx", "wy", "wz"]].to_numpy()
    q = -frame[["qx", "qy", "qz"]].to_numpy()  # the inverse rotation
    half = numpy.cross(q, w)
    turned = w + 2 * frame[["qw"]].to_numpy() * half + 2 * numpy.cross(q, half)
    return frame.assign(wx=turned[:, 0], wy=turned[:, 1], wz=turned[:, 2])


def scalar_last(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.assign(qw=frame.qx, qx=frame.qy, qy=frame.qz, qz=frame.qw)


@pytest.mark.parametrize("velocity", [True, False], ids=["velocity", "no velocity"])
@pytest.mark.parametrize(
    ("convert", "told"),
    [
        (body_frame, "if the angular velocity is in the body frame"),
        (scalar_last, "if the quaternion has its scalar last"),
        (lambda f: scaled(f, DEGREE, "wx", "wy", "wz"), "angular velocities are in deg/s"),
    ],
)
def test_other_conventions_are_named(
    healthy: Healthy,
    rigid_body: Healthy,
    convert: Callable[[pandas.DataFrame], pandas.DataFrame],
    told: str,
    velocity: bool,
) -> None:
    frame = rigid_body(healthy("reference", 4001))
    if not velocity:
        frame = frame.drop(columns=["vcx", "vcy", "vcz"])
    assert tt.check.conservation(frame, "reference").passed
    with pytest.raises(tt.InputError, match=told):
        tt.check.conservation(convert(frame), "reference")


def test_another_body_is_refused(healthy: Healthy, rigid_body: Healthy) -> None:
    scene = tt.load_scene("reference")
    both = healthy()
    slimmer = replace(scene, body=replace(scene.body, I3=scene.body.I3 * 4 / 5))
    with pytest.raises(tt.InputError, match=r"column omega_3 is 0\.8 times what the vectors"):
        tt.check.conservation(both, slimmer)
    longer = replace(scene, body=replace(scene.body, alpha="0.5"))
    with pytest.raises(tt.InputError, match=r"vcz fits a centre of mass 0\.006 m .* expected 0.01"):
        tt.check.conservation(rigid_body(both), longer)
    with pytest.raises(tt.InputError, match="vcz fits a centre of mass 6 m"):
        tt.check.conservation(
            scaled(rigid_body(both), 1e3, "vcx", "vcy", "vcz"), scene, friction="other"
        )


@pytest.mark.parametrize("rows", [41, 101, 401, 12001])
def test_no_sampling_makes_a_healthy_trajectory_suspicious(
    healthy: Healthy, rigid_body: Healthy, rows: int
) -> None:
    frame = healthy("reference", rows)
    for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
        for friction in ("scene", "other"):
            assert tt.check.conservation(given, "reference", friction=friction).passed


def test_a_wrong_simulator_is_judged_not_refused(healthy: Healthy) -> None:
    frame = healthy("reference", 1601)[VECTORS]
    for name in ("Lz", "vx", "kz"):
        assert not tt.check.conservation(scaled(frame, 1.05, name), "reference").passed


def test_a_null_quaternion_is_refused(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())
    frame.loc[3, ["qw", "qx", "qy", "qz"]] = 0
    with pytest.raises(tt.InputError, match="a quaternion is 0, expected an orientation"):
        tt.check.conservation(frame, "reference")
