"""Rows as a motion: rates with errors, velocities from positions, the attitude's sign."""

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, check
from tests.check.test_force_free import pose, samples_of
from tt_precise.check.force_free_flow import Way, rates_in_rows
from tt_precise.check.movement import (
    azimuth,
    movement_of,
    rates_with_errors,
    sufficient_spacing,
)


def test_rates_are_exact_for_their_shapes() -> None:
    """Polynomials at any times; a cosine of the nutation."""
    rng = numpy.random.default_rng(3)
    uneven = numpy.cumsum(rng.uniform(0.5, 1.5, 23))
    for t in (uneven, numpy.arange(23.0)):
        rate = rates_in_rows(t, (t**4)[None], Way(5, False), 0 * t[1:])[0]
        assert rate == pytest.approx(4 * t**3, rel=1e-9)
        angle = 1.7 * numpy.diff(t)
        seen = rates_in_rows(t, (t + numpy.cos(1.7 * t))[None], Way(7, True), angle)[0]
        assert seen == pytest.approx(1 - 1.7 * numpy.sin(1.7 * t), abs=1e-9)
        without = rates_in_rows(t, (t + numpy.cos(1.7 * t))[None], Way(7, False), angle)[0]
        assert abs(without - seen).max() > 0.01


@pytest.mark.parametrize("hertz", [60, 240, 960])
def test_the_error_of_a_rate_is_within_its_bound(hertz: int) -> None:
    """The position's rate is the velocity, also where decimals are cut off."""
    movement = movement_of(samples_of(pose("reference", hertz, 150), "reference"))
    rows = movement.rows
    assert rows.x is not None
    for digits in (15, 7):
        rounding = numpy.full(len(rows.t), 0.5 * 10.0**-digits)
        found, error = rates_with_errors(movement.body, rows, rows.x.round(digits), rounding)
        off = numpy.sqrt(((found - rows.v) ** 2).sum(axis=0))
        assert (off <= error + 1e-12).all()
        assert (off > error / 1000).any()  # and not far below it


def test_quaternions_of_either_sign_are_one_attitude() -> None:
    frame = pose("reference", 240, 60)
    signs = numpy.where(numpy.arange(len(frame)) % 3, 1.0, -1.0)
    turned = frame.assign(**{name: signs * frame[name] for name in ("qw", "qx", "qy", "qz")})
    same, other = (movement_of(samples_of(f, "reference")).rows.q for f in (frame, turned))
    assert other == pytest.approx(signs[0] * same, abs=1e-15)


def test_the_spacing_that_would_do_falls_with_the_bound() -> None:
    movement = movement_of(samples_of(pose("reference", 60, 60), "reference"))
    body, rows = movement.body, movement.rows
    much, more = (
        sufficient_spacing(body, rows, numpy.full(59, share)) for share in (8.0, numpy.inf)
    )
    assert more < much < 1 / 60


AXIS = ["t", "kx", "ky", "kz", "Lx", "Ly", "Lz"]


def test_velocities_from_positions_have_their_error() -> None:
    """At 60 Hz the rates of positions are off by up to 3 mm/s, and say so."""
    frame = tt.integrate("stribeck", record=("phi", "psi", "x", "y")).frame(
        *AXIS, "pose", "vx", "vy", times=[i / 60 for i in range(90)], numbers="float"
    )
    given = movement_of(samples_of(frame[[*AXIS, "vx", "vy"]], "stribeck"))
    derived = movement_of(samples_of(frame[[*AXIS, "x", "y", "z"]], "stribeck"))
    off = numpy.hypot(*(derived.rows.v - given.rows.v)[:2])
    assert off.max() > 1e-4
    assert (off <= derived.rounding.v + 1e-12).all()


def test_an_azimuth_that_is_integrated_has_its_error() -> None:
    """Velocities of Euler angles without phi are turned by its integral, off by 0.25 rad here."""
    run = tt.integrate("reference", record=("phi",))
    times = [i / 60 for i in range(60)]
    frame = run.frame(*EULER[1:], "phi", times=times, numbers="float")
    movement = movement_of(samples_of(frame[EULER], "reference"))
    turned = numpy.diff(azimuth(frame["t"].to_numpy(), frame["phi_dot"].to_numpy())[0])
    off = abs(turned - numpy.diff(frame["phi"])) * numpy.hypot(*movement.rows.v[:2])[1:]
    assert off.max() > 1e-2
    assert (off <= movement.rounding.v[1:]).all()


@pytest.mark.parametrize("known", [["vx", "vy"], ["x", "y", "z"]])
def test_without_the_height_in_flight_only_the_turning_is_looked_at(
    known: list[str], no_cause: None
) -> None:
    """Velocities that a contact would give are not those of the flight."""
    run = tt.integrate("flight", record=("phi", "psi", "x", "y"))
    frame = run.frame(*AXIS, "pose", "vx", "vy", times=[i / 500 for i in range(75)])
    found = check(frame[[*AXIS, *known]].astype(float), "flight", friction="other", start="other")
    assert (found["kinematics"].verdict, found["kinematics"].value) == ("pass", 0.0)
    assert found["kinematics"].note == "checked axis, not at spin, x, y, z (columns missing)"
