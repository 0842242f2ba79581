"""Column sets: which one a table has, its names, and the checks of a rigid body."""

from collections.abc import Callable
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import BODY, EULER, POSE, VECTORS, check, refuses, solved
from tt_precise.check.columns import TRACK, choose_set, renaming

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def test_a_rigid_body_is_checked_like_its_vectors() -> None:
    frame = solved(BODY)
    result = check(frame, "reference", limits={"jellett": 1e-13})
    assert (result.verdict, result.columns) == ("pass", "rigid body")
    for name in ("contact_velocity", "quaternion_norm", "equations"):
        assert result[name].verdict == "pass"
    assert result["axis_norm"].verdict == "skipped"
    assert {*VECTORS[1:]} <= {*result["golden"].parts}
    assert (result["golden"].value or 0) > 8
    without_velocity = check(frame.drop(columns=["vcx", "vcy", "vcz"]), "reference")
    for name, verdict in (("jellett", "pass"), ("energy", "open"), ("equations", "open")):
        assert without_velocity[name].verdict == verdict


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("time kx", "f.csv: missing t, .* rename yours with --columns"),
        ("t kx ky Lx Ly Lz", "f.csv: missing kz of the vectors columns"),
        ("t a", "f.csv: missing kx, ky, kz, .* among the columns t, a"),
        ("t qpos0 qpos1", "--from ENGINE reads an engine's own state"),
    ],
)
def test_missing_columns_are_named(columns: str, message: str) -> None:
    with pytest.raises(tt.InputError, match=message):
        choose_set(columns.split(), "f.csv")


def test_renames() -> None:
    theirs = solved(EULER[:5]).rename(columns={"t": "time", "omega_3": "spin"})
    result = check(theirs, "reference", columns={"time": "t", "spin": "omega_3"})
    assert result.columns == "Euler"
    assert renaming(["time=t, spin=omega_3"]) == {"time": "t", "spin": "omega_3"}
    refuses("no column 'spun' to rename", theirs, columns={"spun": "omega_3"})
    refuses("column t occurs twice", theirs.assign(t=0), columns={"time": "t"})


TRACKED = [*EULER, *TRACK]
SIGNS = (-1.0) ** numpy.arange(201)
SPOILT: dict[str, tuple[Any, Callable[[pandas.DataFrame], pandas.DataFrame]]] = {
    "phi 0.1 % fast": (TRACKED, lambda f: f.assign(phi=1.001 * f["phi"])),
    "x half as far again": (TRACKED, lambda f: f.assign(x=1.5 * f["x"])),
    "phi holds phi_dot": (TRACKED, lambda f: f.assign(phi=f["phi_dot"])),
    "five metres too high": (POSE, lambda f: f.assign(z=f["z"] + 5.0)),
    "on the ground": (POSE, lambda f: f.assign(z=0 * f["z"])),
    "x drifts": (POSE, lambda f: f.assign(x=2 * f["x"] + f["t"])),
    "y holds x": (POSE, lambda f: f.assign(y=f["x"])),
    "signs of v": (VECTORS, lambda f: f.assign(vx=SIGNS * f["vx"], vy=SIGNS * f["vy"])),
    "signs of k": (VECTORS, lambda f: f.assign(kx=SIGNS * f["kx"], ky=SIGNS * f["ky"])),
    "vx a row late": (VECTORS, lambda f: f.assign(vx=f["vx"].shift(1).fillna(f["vx"]))),
}


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_spoilt_columns_are_not_green(friction: str) -> None:
    for columns in (TRACKED, POSE, VECTORS):
        assert check(solved(columns, 201, 200), "reference", friction=friction).passed
    for name, (columns, spoil) in SPOILT.items():
        spoilt = spoil(solved(columns, 201, 200))
        assert not check(spoilt, "reference", friction=friction).passed, name
