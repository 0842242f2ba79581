"""The sizes that errors count beside."""

import math

import mpmath
import numpy
import pytest

from tt_precise.golden import store
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.scene import load_scene

BODY = load_scene("reference").body.numbers(float)
RATE, SPEED = math.sqrt(BODY.g / BODY.R), math.sqrt(BODY.g * BODY.R)


def of_euler(**given: float) -> dict[str, float]:
    """A state in which nothing moves but what is given, with extra columns."""
    rest = {**dict.fromkeys(EulerState._fields, 0.0), "theta": 1.0}
    return sizes(BODY, rest | given, numpy)


def test_at_rest_sizes_are_the_natural_ones() -> None:
    found = of_euler(phi=0.0, x=0.0, y=0.0, psi_dot=0.0, g_n=3.0, E=0.0)
    assert found["theta"] == found["phi"] == 1
    assert found["theta_dot"] == found["omega_3"] == pytest.approx(RATE)
    assert found["nu_x"] == found["nu_y"] == pytest.approx(SPEED)
    assert found["x"] == found["y"] == BODY.R
    assert found["E"] == pytest.approx(BODY.m * BODY.g * BODY.R)
    assert found["g_n"] == 3.0


def test_each_entry_counts_beside_what_it_belongs_to() -> None:
    s, spin = math.sin(1.0), 150.0
    found = of_euler(omega_3=spin, nu_x=0.3, x=3.0, y=4.0)
    arm = BODY.R * math.sqrt(1 + BODY.alpha**2 - 2 * BODY.alpha * math.cos(1.0))
    assert [found["theta_dot"], found["omega_3"]] == pytest.approx([spin, spin])
    assert found["phi_dot"] == pytest.approx(spin / s)
    # the centre of mass moves as v_A - omega x a does, omega = spin k, a = R (alpha k - z)
    moving = math.hypot(0.3, spin * BODY.R * s) + spin * arm
    assert found["nu_x"] == pytest.approx(moving)
    assert found["x"] == found["y"] == pytest.approx(5)
    fast = of_euler(theta=1e-3, phi_dot=1e5, nu_y=30.0)
    assert fast["phi_dot"] == pytest.approx(1e5)
    assert fast["nu_y"] == pytest.approx(30 / math.sin(1e-3))
    # |k_dot|: of 40 rad/s through the pole the direction is uncertain; of a small precession not
    through = of_euler(theta=1e-3, theta_dot=-40.0, omega_3=150.0)
    assert through["theta_dot"] == pytest.approx(40 / math.sin(1e-3))
    assert sizes(BODY, EulerState(0.0, 1.0, 2.0, 3.0, 0.5, 0.0)._asdict(), math)["nu_x"] > 1e300
    assert of_euler(theta=1e-3, phi_dot=40.0, omega_3=150.0)["theta_dot"] == pytest.approx(
        math.hypot(150 - 0, 40 * math.sin(1e-3)), rel=1e-3
    )


def test_vectors_and_angles_agree_in_any_arithmetic() -> None:
    stored = store.read_files("reference")
    row = dict(zip(stored.trajectory.columns, stored.trajectory.rows[319], strict=True))
    names = [*NewtonState._fields, *EulerState._fields]
    doubles = {name: numpy.array([float(row[name])]) for name in names}
    found = sizes(BODY, doubles, numpy)
    angles = sizes(BODY, {name: doubles[name] for name in EulerState._fields}, numpy)
    with mpmath.workdps(30):
        body = BODY.numbers(mpmath.mpf)
        exact = sizes(body, {name: mpmath.mpf(row[name]) for name in names}, mpmath)
        pole = dict(zip(names[:8], map(mpmath.mpf, (0, 0, 1, 2, 2, 2, 0, 0)), strict=True))
        alone = sizes(body, {**pole, "phi_dot": None}, mpmath)
    for name in names:
        assert found[name] == pytest.approx(float(exact[name]), rel=1e-13), name
    for name, size in angles.items():
        assert size == pytest.approx(found[name], rel=1e-12), name
    assert "phi_dot" not in alone  # undefined at the pole
