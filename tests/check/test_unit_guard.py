"""Other units and other bodies are refused; what is healthy, or only wrong, is not."""

from collections.abc import Callable
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, refuses
from tests.conftest import Patch
from tt_precise.check.checks import RowCheck
from tt_precise.check.units import LOOKED_AT
from tt_precise.golden import store
from tt_precise.runtime.values import Check
from tt_precise.scene.scene import parse_scene


def _not_made(check: RowCheck, rows: Any, limit: float) -> Check:
    return Check(check.name, "skipped")


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
    assert check(frame, "reference").passed
    refuses(convention, scaled(frame, factor, *names))


def turn(frame: pandas.DataFrame, vectors: numpy.ndarray, sign: int) -> numpy.ndarray:
    """Vectors turned by each row's quaternion, or by its inverse (``sign`` -1)."""
    q = sign * frame[["qx", "qy", "qz"]].to_numpy()
    half = numpy.cross(q, vectors)
    return vectors + 2 * frame[["qw"]].to_numpy() * half + 2 * numpy.cross(q, half)


def body_frame(frame: pandas.DataFrame) -> pandas.DataFrame:
    return with_vectors(frame, OMEGA, turn(frame, frame[OMEGA].to_numpy(), -1))


def with_vectors(
    frame: pandas.DataFrame, names: list[str], vectors: numpy.ndarray
) -> pandas.DataFrame:
    return frame.assign(**dict(zip(names, vectors.T, strict=True)))


def scalar_last(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.assign(qw=frame.qx, qx=frame.qy, qy=frame.qz, qz=frame.qw)


def inverse(frame: pandas.DataFrame) -> pandas.DataFrame:
    return scaled(frame, -1, "qx", "qy", "qz")


def centre_of_the_sphere(frame: pandas.DataFrame) -> pandas.DataFrame:
    lever = numpy.broadcast_to([0, 0, 0.3 * 0.02], (len(frame), 3))
    moved = numpy.cross(frame[OMEGA].to_numpy(), turn(frame, lever, 1))
    return with_vectors(frame, CENTRE, frame[CENTRE].to_numpy() + moved)


def y_up(frame: pandas.DataFrame) -> pandas.DataFrame:
    half = numpy.sqrt(0.5)
    w, x, y, z = (frame[name] for name in ("qw", "qx", "qy", "qz"))
    return frame.assign(
        qw=half * (w + x),
        qx=half * (x - w),
        qy=half * (y + z),
        qz=half * (z - y),
        wy=frame.wz,
        wz=-frame.wy,
        vcy=frame.vcz,
        vcz=-frame.vcy,
    )


OMEGA, CENTRE = ["wx", "wy", "wz"], ["vcx", "vcy", "vcz"]
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
    given = CONVENTIONS[convention](rigid_body(healthy("reference", 801)))
    refuses(f"if {convention}; expected SI", given, friction=friction)
    if not convention.startswith(("y is up", "the velocity", "the velocities")):
        given = given.drop(columns=CENTRE)
        refuses(f"if {convention}; expected SI", given, friction=friction)


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
    scene: str, rows: int | None, every: int, monkeypatch: Patch
) -> None:
    """By the guard; in all rows by every check too."""
    if rows:
        monkeypatch.setattr(RowCheck, "result", _not_made)
    golden = pandas.DataFrame(tt.golden.load(scene))[:rows:every]
    for columns in (VECTORS, EULER):
        if not golden[columns].isna().any(axis=None):
            for friction in ("scene", "other"):
                found = check(golden[columns], scene, friction=friction)
                assert not found.failures, str(found)
                assert rows or friction == "other" or found.passed, str(found)


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_rows_that_are_counted_instead_of_timed_are_refused(
    healthy: Healthy, rigid_body: Healthy, friction: str
) -> None:
    for rows, until in ((401, 0.8), (801, 8)):  # finely resolved, and as the scene is sampled
        frame = healthy("reference", rows, until)
        for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
            counted = given.assign(t=numpy.arange(float(rows)))
            refuses("if the time counts rows", counted, friction=friction)


def test_another_force_does_not_hide_a_convention(rigid_body: Healthy) -> None:
    """A top with dry friction, checked as if it were the reference's."""
    lines = tt.load_scene("reference").text.splitlines()
    text = "\n".join(line for line in lines if not line.startswith("mu"))
    dry = '[friction]\nlaw = "regularised"\nmu = "0.3"\nepsilon = "0.01"\n'
    scene = parse_scene(f"{text}\n{dry}", "dry", "dry.toml")
    frame = tt.integrate(scene).frame(*VECTORS[1:], times=[0.005 * i for i in range(170)])
    mine = rigid_body(frame)
    for friction in ("scene", "other"):
        check(mine, "reference", friction=friction)
        message = "if the angular velocity is in the body frame"
        refuses(message, body_frame(mine), friction=friction)


def test_another_body_is_refused(healthy: Healthy, rigid_body: Healthy) -> None:
    scene, both = tt.load_scene("reference"), healthy()
    body = rigid_body(both)
    slimmer = scene.varied(I3="8/25")
    refuses(r"column omega_3 is 0\.8 times what the vectors", both, slimmer)
    longer = scene.varied(alpha="0.5")
    refuses(r"vcz fits a centre of mass 0\.006 m .* expected 0.01", body, longer)
    faster = scaled(body, 1e3, *CENTRE)
    refuses("if the velocities are in mm/s", faster, friction="other")
    body.loc[3, ["qw", "qx", "qy", "qz"]] = 0
    refuses("a quaternion is 0, expected an orientation", body)


@pytest.mark.parametrize("rows", [41, 101, 401, 12001])
def test_no_sampling_makes_a_healthy_trajectory_suspicious(
    healthy: Healthy, rigid_body: Healthy, rows: int, monkeypatch: Patch
) -> None:
    frame = healthy("reference", rows)
    monkeypatch.setattr(RowCheck, "result", _not_made)  # that the guard refuses nothing
    for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
        for friction in ("scene", "other"):
            assert not check(given, "reference", friction=friction).failures


def test_a_wrong_simulator_is_checked_not_refused(healthy: Healthy) -> None:
    frame = healthy("reference", 401)[VECTORS]
    for name in ("Lz", "vx", "kz"):
        assert not check(scaled(frame, 1.05, name), "reference").passed
