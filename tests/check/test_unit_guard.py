"""Other units and other bodies are refused; what is healthy, or only wrong, is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy
from tt_precise.check import run
from tt_precise.check.units import LOOKED_AT
from tt_precise.golden import store
from tt_precise.scene.scene import parse_scene

RATES = ["theta_dot", "phi_dot", "omega_3"]
DEGREE = 180 / numpy.pi


def scaled(frame: pandas.DataFrame, factor: float, *names: str) -> pandas.DataFrame:
    return frame.assign(**{name: factor * frame[name] for name in names})


@pytest.mark.parametrize("rows", [201, 1001])
@pytest.mark.parametrize(
    ("columns", "factor", "names", "convention"),
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
    healthy: Healthy,
    rows: int,
    columns: list[str],
    factor: float,
    names: list[str],
    convention: str,
) -> None:
    frame = healthy("reference", rows, 2)[columns]
    assert tt.check.conservation(frame, "reference").passed
    with pytest.raises(tt.InputError, match=convention):
        tt.check.conservation(scaled(frame, factor, *names), "reference")


def turn(frame: pandas.DataFrame, vectors: numpy.ndarray, sign: int) -> numpy.ndarray:
    """Vectors turned by each row's quaternion, or by its inverse (``sign`` -1)."""
    q = sign * frame[["qx", "qy", "qz"]].to_numpy()
    half = numpy.cross(q, vectors)
    return vectors + 2 * frame[["qw"]].to_numpy() * half + 2 * numpy.cross(q, half)


def body_frame(frame: pandas.DataFrame) -> pandas.DataFrame:
    turned = turn(frame, frame[["wx", "wy", "wz"]].to_numpy(), -1)
    return frame.assign(wx=turned[:, 0], wy=turned[:, 1], wz=turned[:, 2])


def scalar_last(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.assign(qw=frame.qx, qx=frame.qy, qy=frame.qz, qz=frame.qw)


def inverse(frame: pandas.DataFrame) -> pandas.DataFrame:
    return scaled(frame, -1, "qx", "qy", "qz")


def centre_of_the_sphere(frame: pandas.DataFrame) -> pandas.DataFrame:
    if "vcx" not in frame:
        return frame
    lever = numpy.array([0, 0, 0.3 * 0.02])
    away = turn(frame, numpy.broadcast_to(lever, (len(frame), 3)), 1)
    v = frame[["vcx", "vcy", "vcz"]].to_numpy()
    v = v + numpy.cross(frame[["wx", "wy", "wz"]].to_numpy(), away)
    return frame.assign(vcx=v[:, 0], vcy=v[:, 1], vcz=v[:, 2])


def y_up(frame: pandas.DataFrame) -> pandas.DataFrame:
    half = numpy.sqrt(0.5)
    w, x, y, z = (frame[name] for name in ("qw", "qx", "qy", "qz"))
    turned = frame.assign(
        qw=half * (w + x), qx=half * (x - w), qy=half * (y + z), qz=half * (z - y),
        wy=frame.wz, wz=-frame.wy,
    )  # fmt: skip
    return turned.assign(vcy=frame.vcz, vcz=-frame.vcy) if "vcx" in frame else turned


OMEGA, CENTRE = ("wx", "wy", "wz"), ("vcx", "vcy", "vcz")
CONVENTIONS: dict[str, Callable[[pandas.DataFrame], pandas.DataFrame]] = {
    "the angular velocity is in the body frame": body_frame,
    "the quaternion has its scalar last": scalar_last,
    "the quaternion is the inverse one, from the inertial to the body frame": inverse,
    "the angular velocity has the other sign": lambda f: scaled(f, -1, *OMEGA),
    "the angular velocities are in deg/s": lambda f: scaled(f, DEGREE, *OMEGA),
    "the angular velocities are in revolutions/min": lambda f: scaled(f, 30 / numpy.pi, *OMEGA),
    "the time is in ms": lambda f: scaled(f, 1e3, "t"),
    "the time is in microseconds": lambda f: scaled(f, 1e6, "t"),
    "the time is in ns": lambda f: scaled(f, 1e9, "t"),
    "the time is in minutes": lambda f: scaled(f, 1 / 60, "t"),
    "y is up": y_up,
    "the velocity is that of the sphere's centre": centre_of_the_sphere,
    "the velocities are in mm/s": lambda f: scaled(f, 1e3, *CENTRE),
    "the velocities are in cm/s": lambda f: scaled(f, 1e2, *CENTRE),
    "the quaternion has its scalar last and the angular velocity is in the body frame": (
        lambda f: scalar_last(body_frame(f))
    ),
}


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_other_conventions_are_named(
    healthy: Healthy, rigid_body: Healthy, convention: str, friction: str
) -> None:
    frame = rigid_body(healthy("reference", 801))
    of_the_velocity = convention.startswith(("y is up", "the velocity", "the velocities"))
    for given in (frame, *(() if of_the_velocity else (frame.drop(columns=list(CENTRE)),))):
        with pytest.raises(tt.InputError, match=f"if {convention}; expected SI"):
            tt.check.conservation(CONVENTIONS[convention](given), "reference", friction=friction)


@pytest.mark.parametrize(
    ("rows", "every"),
    [
        (LOOKED_AT + 1, 1),
        pytest.param(None, 1, marks=pytest.mark.slow),
        pytest.param(None, 10, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("scene", store.scenes())
def test_golden_data_are_above_suspicion(
    scene: str, rows: int | None, every: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the guard; in all rows by every check too."""
    if rows:
        monkeypatch.setattr(run, "checks_of", lambda scene: ())
    golden = pandas.DataFrame(tt.golden.load(scene))[:rows:every]
    for columns in (VECTORS, EULER):
        if not golden[columns].isna().any(axis=None):
            for friction in ("scene", "other"):
                found = tt.check.conservation(golden[columns], scene, friction=friction)
                assert found.passed, str(found)


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_rows_that_are_counted_instead_of_timed_are_refused(
    healthy: Healthy, rigid_body: Healthy, friction: str
) -> None:
    frame = healthy("reference", 401, 0.8)
    for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
        counted = given.assign(t=numpy.arange(401.0))
        with pytest.raises(tt.InputError, match="if the time counts rows"):
            tt.check.conservation(counted, "reference", friction=friction)


def test_another_force_does_not_hide_a_convention(rigid_body: Healthy) -> None:
    """A top with dry friction, checked as if it were the reference's."""
    lines = tt.load_scene("reference").text.splitlines()
    text = "\n".join(line for line in lines if not line.startswith("mu"))
    dry = '[friction]\nlaw = "regularised"\nmu = "0.3"\nepsilon = "0.01"\n'
    scene = parse_scene(f"{text}\n{dry}", "dry", "dry.toml")
    frame = tt.integrate(scene).frame(*VECTORS[1:], times=[0.005 * i for i in range(170)])
    mine = rigid_body(frame)
    for friction in ("scene", "other"):
        tt.check.conservation(mine, "reference", friction=friction)
        with pytest.raises(tt.InputError, match="if the angular velocity is in the body frame"):
            tt.check.conservation(body_frame(mine), "reference", friction=friction)


def test_another_body_is_refused(healthy: Healthy, rigid_body: Healthy) -> None:
    scene = tt.load_scene("reference")
    both = healthy()
    slimmer = replace(scene, body=replace(scene.body, I3=scene.body.I3 * 4 / 5))
    with pytest.raises(tt.InputError, match=r"column omega_3 is 0\.8 times what the vectors"):
        tt.check.conservation(both, slimmer)
    longer = replace(scene, body=replace(scene.body, alpha="0.5"))
    with pytest.raises(tt.InputError, match=r"vcz fits a centre of mass 0\.006 m .* expected 0.01"):
        tt.check.conservation(rigid_body(both), longer)
    with pytest.raises(tt.InputError, match="if the velocities are in mm/s"):
        tt.check.conservation(
            scaled(rigid_body(both), 1e3, "vcx", "vcy", "vcz"), scene, friction="other"
        )


@pytest.mark.parametrize("rows", [41, 101, 401, 12001])
def test_no_sampling_makes_a_healthy_trajectory_suspicious(
    healthy: Healthy, rigid_body: Healthy, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = healthy("reference", rows)
    monkeypatch.setattr(run, "checks_of", lambda scene: ())  # that the guard refuses nothing
    for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
        for friction in ("scene", "other"):
            assert tt.check.conservation(given, "reference", friction=friction).passed


def test_a_wrong_simulator_is_checked_not_refused(healthy: Healthy) -> None:
    frame = healthy("reference", 401)[VECTORS]
    for name in ("Lz", "vx", "kz"):
        assert not tt.check.conservation(scaled(frame, 1.05, name), "reference").passed


def test_a_null_quaternion_is_refused(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())
    frame.loc[3, ["qw", "qx", "qy", "qz"]] = 0
    with pytest.raises(tt.InputError, match="a quaternion is 0, expected an orientation"):
        tt.check.conservation(frame, "reference")
