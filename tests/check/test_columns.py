"""Column sets: one motion in each of them, and the rigid body's way to vectors."""

from __future__ import annotations

import mpmath
import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy
from tt_precise.check.columns import choose_set, renamed, renaming
from tt_precise.mechanics.conversion import RigidBodyState, vectors_from_rigid_body
from tt_precise.mechanics.newton import contact_arm
from tt_precise.mechanics.vectors import cross


def test_a_rigid_body_is_checked_like_its_vectors(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())
    result = tt.check.conservation(frame, "reference", limits={"jellett": 1e-13})
    assert result.passed, str(result)
    assert result.columns == "rigid body"
    for name in ("contact_velocity", "quaternion_norm", "equations"):
        assert result[name].verdict == "pass"
    assert result["axis_norm"].verdict == "skipped"
    # off the table, and with a drifting quaternion
    lifted = frame.assign(vcz=frame["vcz"] + numpy.where(frame["t"] > 6, 1e-4, 0))
    assert tt.check.conservation(lifted, "reference")["contact_velocity"].verdict == "fail"
    longer = frame.assign(qw=frame["qw"] * 1.00001)
    assert tt.check.conservation(longer, "reference")["quaternion_norm"].verdict == "fail"


def test_a_rigid_body_without_velocity_keeps_jellett(healthy: Healthy, rigid_body: Healthy) -> None:
    frame = rigid_body(healthy())[["t", "qw", "qx", "qy", "qz", "wx", "wy", "wz"]]
    result = tt.check.conservation(frame, "reference")
    assert result["jellett"].verdict == "pass"
    assert result["energy"].note == "needs the velocity: columns vcx, vcy, vcz"


def test_the_conversion_in_exact_numbers() -> None:
    # a quarter turn about y lays the axis along x; spinning about it, the centre at rest
    body = tt.load_scene("reference").body.numbers(
        lambda value: mpmath.mpf(value.numerator) / value.denominator
    )
    half = mpmath.sqrt(mpmath.mpf(1) / 2)
    state = RigidBodyState(half, 0, half, 0, 5, 0, 0, 0, 0, 0)
    vectors, lift = vectors_from_rigid_body(body, state)
    eps = mpmath.mp.eps
    assert abs(vectors.kx - 1) < eps
    assert abs(vectors.kz) < eps
    assert abs(vectors.Lx - 5 * body.I3) < eps
    v = cross((5, 0, 0), contact_arm(body, (1, 0, 0)))
    assert (abs(vectors.vx - v[0]) < eps, abs(vectors.vy - v[1]) < eps) == (True, True)
    assert vectors.vy == 5 * body.R
    assert abs(lift) < eps


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("time kx", "f.csv: no column t .* rename yours with --columns"),
        ("t kx ky Lx Ly Lz", "f.csv: missing kz of the vectors columns"),
        ("t a", "f.csv: no column set among the columns t, a"),
    ],
)
def test_what_is_missing_is_named(columns: str, message: str) -> None:
    with pytest.raises(tt.InputError, match=message):
        choose_set(columns.split(), "f.csv")


def test_half_a_velocity_is_refused(healthy: Healthy) -> None:
    with pytest.raises(tt.InputError, match="has vx but not vy, expected all of the velocity"):
        tt.check.conservation(healthy()[VECTORS[:-1]], "reference")


def test_renames(healthy: Healthy) -> None:
    frame = healthy()[["t", "theta", "theta_dot", "phi_dot", "omega_3"]]
    theirs = frame.rename(columns={"t": "time", "omega_3": "spin"})
    result = tt.check.conservation(theirs, "reference", columns={"time": "t", "spin": "omega_3"})
    assert result.columns == "Euler"
    assert renaming(["time=t, spin=omega_3"]) == {"time": "t", "spin": "omega_3"}
    with pytest.raises(tt.InputError, match="got 'time', expected theirs=ours"):
        renaming(["time"])
    with pytest.raises(tt.InputError, match="got 'omega3' as one of ours, expected one of: "):
        renaming(["w=omega3"])
    with pytest.raises(tt.InputError, match="no column 'spin' to rename"):
        renamed(["t"], {"spin": "omega_3"}, "f.csv")
    with pytest.raises(tt.InputError, match="column t occurs twice"):
        renamed(["t", "time"], {"time": "t"}, "f.csv")
