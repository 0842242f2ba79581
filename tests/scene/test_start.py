"""Starts: exact entries, psi_dot, the point at rest, and refusals."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.integration import integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import load_scene
from tt_precise.scene.start import Inclination, Start

PLAIN = {"theta": "0.1", "omega_3": "155"}
PI_40 = "3.141592653589793238462643383279502884197"  # pi to 40 digits, rounded down
REFERENCE = load_scene("reference")
MP = mpmath.MPContext()
MP.dps = 120


def start(**given: Any) -> Start:
    return Start.of(REFERENCE.body, given)


def test_equal_starts_written_differently_are_equal() -> None:
    given: dict[str, Any]
    for given in (
        {"theta": 0.1, "omega_3": 155.0},  # floats are the decimals that a user writes
        {"theta": "0.1", "psi_dot": "155"},
        {**PLAIN, "at_rest": "contact point"},
        {"theta": "0.1 rad", "omega_3": "0.155 rad/ms"},
    ):
        assert start(**given) == Start(Inclination(Fraction(1, 10)), Fraction(155))
    for text, same in {"180 deg": "pi", "pi/1": "pi", "0 deg": "0", "90 deg": "pi/2"}.items():
        assert Inclination.parse(text) == Inclination.parse(same)


def test_an_inclination_below_pi_keeps_its_distance_from_pi() -> None:
    for near, offset in (
        (PI_40, "1.6939937510582097494459230781640628620899862803482e-40"),
        (3.141592653589793, "2.3846264338327950288419716939937510582097494459231e-16"),
        ("179.999999 deg", "1.7453292519943295769236907684886127134428718885417e-8"),
    ):
        theta = Inclination.parse(near)
        assert theta.from_pi
        assert float(abs(theta.offset / Fraction(offset) - 1)) < 1e-48
        assert Inclination.parse(str(theta)) == theta


@pytest.mark.parametrize("text", ["0", "1/10", "3/2", "pi", f"pi - 1/{10**300}", "pi - 3"])
def test_inclination_is_accurate_beside_the_poles(text: str) -> None:
    work, finer = mpmath.MPContext(), mpmath.MPContext()
    work.dps, finer.dps = 30, 700
    angle = Inclination.parse(text)
    assert str(angle) == text
    assert angle.at_pole == (text in ("0", "pi"))
    sine, cosine = angle.sine_cosine(work, lambda value: to_mpmath(value, work))
    offset = to_mpmath(angle.offset, finer)
    theta = finer.pi - offset if angle.from_pi else offset
    bound_eps = 2  # offset rounded once, sine rounded once; relative condition at most 1
    true_sine = finer.sin(theta) if not angle.at_pole else finer.mpf(0)
    assert abs(finer.mpf(sine) - true_sine) <= bound_eps * work.eps * true_sine
    assert abs(finer.mpf(cosine) - finer.cos(theta)) <= bound_eps * 3 * work.eps
    radians = angle.radians(work, lambda value: to_mpmath(value, work))
    assert abs(finer.mpf(radians) - theta) <= bound_eps * 3 * work.eps
    if text.endswith(f"{10**300}"):  # the control: the sine of a rounded theta has no digit
        assert abs(work.sin(radians) / sine - 1) > 1


def test_psi_dot_to_a_hundred_digits() -> None:
    omega_3 = start(theta="0.1", psi_dot="150", phi_dot="7/3").omega_3
    expected = 150 + MP.mpf(7) / 3 * MP.cos(MP.mpf(1) / 10)
    error = abs(MP.mpf(omega_3.numerator) / omega_3.denominator / expected - 1)
    assert 0 < error < MP.mpf(10) ** -99
    scene = REFERENCE.varied(psi_dot="150", phi_dot="-12", until="0")
    assert integrate(scene).frame("psi_dot")["psi_dot"][0] == pytest.approx(150, abs=1e-12)


def test_centre_of_mass_at_rest_is_the_start_of_another_team() -> None:
    """TippeTopSim's start, which its scene has with nu_y rounded to 50 digits."""
    theirs = load_scene("tippetopsim")
    ours = Start.of(theirs.body, {"theta": "0.1", "psi_dot": "250", "at_rest": "centre of mass"})
    assert ours.nu_x == 0
    assert 0 < abs(ours.nu_y - theirs.start.nu_y) < Fraction(1, 10**49)
    assert theirs.at_rest == "centre of mass"
    assert theirs.varied(nu_y="0.1").at_rest == ""
    # with all rates
    scene = REFERENCE.varied(theta_dot="3", phi_dot="-5", at_rest="centre of mass", until="0")
    row = integrate(scene).frame("s_dot_x", "s_dot_y", "nu_x", "nu_y").iloc[0]
    assert (row[["s_dot_x", "s_dot_y"]].abs() < 1e-16).all()
    assert (row[["nu_x", "nu_y"]].abs() > 0.01).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"theta": "0.1"}, r"missing key start\.omega_3"),
        ({"omega_3": "1"}, r"missing key start\.theta"),
        ({**PLAIN, "psi_dot": "1"}, r"start\.psi_dot: got omega_3 too"),
        ({**PLAIN, "psi": "1"}, r"unknown key start\.psi, expected only: at_rest, height, nu_x"),
        ({**PLAIN, "phidot": "1"}, "did you mean phi_dot"),
        ({**PLAIN, "at_rest": "peg"}, r"start\.at_rest: got 'peg', expected \"contact point\""),
        ({**PLAIN, "at_rest": "contact point", "nu_x": "0"}, r"start\.at_rest: got nu_x too"),
        ({"theta": "4", "omega_3": "1"}, "theta: got 4, expected 0 <= theta <= pi"),
        ({"theta": PI_40[:-1] + "8", "omega_3": "1"}, "expected 0 <= theta <= pi"),
        ({**PLAIN, "omega_3": float("nan")}, "omega_3: got nan"),
        ({**PLAIN, "nu_x": "1 deg/s"}, "nu_x: got '1 deg/s', expected a speed"),
    ],
)
def test_wrong_entries_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        start(**given)


def test_derived_entries_follow_a_varied_one() -> None:
    scene = REFERENCE.varied(psi_dot="150", at_rest="centre of mass")
    assert {*scene.derived_from} == {"theta", "theta_dot", "phi_dot", "psi_dot", "at_rest"}
    moved = scene.varied(phi_dot="10")
    expected = 150 + 10 * MP.cos(MP.mpf(1) / 10)
    assert float(moved.start.omega_3) == pytest.approx(float(expected), abs=1e-12)
    assert moved.start.nu_y != scene.start.nu_y
    assert moved.varied(omega_3="9").start.omega_3 == 9
    assert scene.varied(R="0.03").start.nu_y == pytest.approx(1.5 * float(scene.start.nu_y))


def test_one_gliding_velocity_is_varied_alone() -> None:
    """In a start at rest, too, the other component keeps the value that was computed."""
    scene = REFERENCE.varied(theta_dot="3", phi_dot="-5", at_rest="centre of mass")
    moved = scene.varied(nu_x="0.01")
    assert moved.start.nu_x == Fraction(1, 100)
    assert moved.start.nu_y == scene.start.nu_y != 0
    assert moved.varied(phi_dot="7").start.nu_x == moved.start.nu_x
    # a replaced start forgets the entries of the file
    scene = REFERENCE.varied(psi_dot="150", phi_dot="10")
    plain = replace(scene, start=start(**PLAIN))
    assert plain.varied(phi_dot="3").start == start(**PLAIN, phi_dot="3")
    assert replace(scene.start, phi_dot=Fraction(0)).source == {}
