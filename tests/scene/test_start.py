"""Starts: exact entries, psi_dot, what is at rest, and what is refused."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.integration import integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.scene.start import Inclination, Start

PLAIN = {"theta": "0.1", "omega_3": "155"}
MP = mpmath.MPContext()
MP.dps = 120


REFERENCE = load_scene("reference")


def start(**given: Any) -> Start:
    return Start.of(REFERENCE.body, given)


def test_equal_starts_written_differently_are_equal() -> None:
    plain = Start(Inclination(Fraction(1, 10)), Fraction(155), nu_x=Fraction(1, 3))
    assert start(**PLAIN, nu_x="1/3") == plain
    # floats are the decimals that one writes
    assert start(theta=0.1, omega_3=155.0) == start(**PLAIN)
    assert start(theta="0.1", psi_dot="155") == start(**PLAIN)
    assert start(**PLAIN, at_rest="contact point") == start(**PLAIN)
    with pytest.raises(InputError, match="omega_3: got nan"):
        start(theta=0.1, omega_3=float("nan"))


PI_40 = "3.141592653589793238462643383279502884197"  # 40 digits, rounded down.


@pytest.mark.parametrize(
    ("near", "offset"),
    [
        (PI_40, "1.6939937510582097494459230781640628620899862803482e-40"),
        (3.141592653589793, "2.3846264338327950288419716939937510582097494459231e-16"),
        ("179.999999 deg", "1.7453292519943295769236907684886127134428718885417e-8"),
    ],
)
def test_an_inclination_below_pi_keeps_its_distance_from_pi(near: str | float, offset: str) -> None:
    theta = Inclination.parse(near)
    assert theta.from_pi
    assert float(abs(theta.offset / Fraction(offset) - 1)) < 1e-48
    assert Inclination.parse(str(theta)) == theta
    upright = Inclination.parse(f"pi - {near}") if near == PI_40 else None
    assert upright in (None, Inclination(theta.offset))


def test_an_inclination_just_above_pi_is_refused() -> None:
    with pytest.raises(InputError, match="expected 0 <= theta <= pi"):
        Inclination.parse(PI_40[:-1] + "8")


def test_psi_dot_to_a_hundred_digits() -> None:
    found = start(theta="0.1", psi_dot="150", phi_dot="7/3").omega_3
    expected = 150 + MP.mpf(7) / 3 * MP.cos(MP.mpf(1) / 10)
    error = abs(MP.mpf(found.numerator) / found.denominator / expected - 1)
    assert 0 < error < MP.mpf(10) ** -99


def test_the_run_has_the_psi_dot_that_was_given() -> None:
    scene = REFERENCE.varied(psi_dot="150", phi_dot="-12", until="0")
    assert integrate(scene).frame("psi_dot")["psi_dot"][0] == pytest.approx(150, abs=1e-12)


def test_centre_of_mass_at_rest_is_what_another_team_starts_from() -> None:
    """TippeTopSim's start, which its scene has with nu_y rounded to 50 digits."""
    theirs = load_scene("tippetopsim")
    ours = Start.of(theirs.body, {"theta": "0.1", "psi_dot": "250", "at_rest": "centre of mass"})
    assert ours.nu_x == 0
    assert 0 < abs(ours.nu_y - theirs.start.nu_y) < Fraction(1, 10**49)


def test_centre_of_mass_at_rest_with_all_rates() -> None:
    scene = REFERENCE.varied(theta_dot="3", phi_dot="-5", at_rest="centre of mass", until="0")
    row = integrate(scene).frame("s_dot_x", "s_dot_y", "nu_x", "nu_y").iloc[0]
    assert (row[["s_dot_x", "s_dot_y"]].abs() < 1e-16).all()
    assert (row[["nu_x", "nu_y"]].abs() > 0.01).all()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"theta": "0.1"}, r"missing key start\.omega_3, expected a value \(or psi_dot\)"),
        ({"omega_3": "1"}, r"missing key start\.theta"),
        ({**PLAIN, "psi_dot": "1"}, r"start\.psi_dot: got omega_3 too"),
        (
            {"theta_deg": "5", "omega_3": "1"},
            'unknown key start.theta_deg, expected theta = "5 deg", or',
        ),
        ({**PLAIN, "nu_x_mm_s": 9}, 'expected nu_x = "9 mm/s", or nu_x in SI'),
        ({**PLAIN, "omega_3_rpm": 9}, 'expected omega_3 = "9 rpm", or omega_3 in SI'),
        ({**PLAIN, "omega_3_deg_s": 9}, 'expected omega_3 = "9 deg/s", or omega_3 in SI'),
        ({**PLAIN, "psi": "1"}, r"unknown key start\.psi, expected only: at_rest, height, nu_x"),
        ({**PLAIN, "at_rest": "peg"}, r"start\.at_rest: got 'peg', expected \"contact point\""),
        ({**PLAIN, "at_rest": "contact point", "nu_x": "0"}, "expected either at_rest or"),
        ({"theta": "4", "omega_3": "1"}, "theta: got 4, expected 0 <= theta <= pi"),
    ],
)
def test_what_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        start(**given)


def test_a_scene_takes_a_mapping_and_checks_it() -> None:
    def scene(begun: Any, body: Any = REFERENCE.body) -> Scene:
        return Scene("mine", "gliding", body, begun, Fraction(1), Fraction(1, 10))

    assert scene(PLAIN).start == start(**PLAIN)
    with pytest.raises(InputError, match=r"missing key start\.omega_3"):
        scene({"theta": "0.1"})
    with pytest.raises(InputError, match="start: got a str, expected a Start or a mapping"):
        scene("upright")
    with pytest.raises(InputError, match="body: got a dict, expected a TippeTop"):
        scene(PLAIN, {"m": "1"})


def test_derived_entries_follow_what_is_varied() -> None:
    scene = REFERENCE.varied(psi_dot="150", at_rest="centre of mass")
    moved = scene.varied(phi_dot="10")
    expected = 150 + 10 * MP.cos(MP.mpf(1) / 10)
    assert float(moved.start.omega_3) == pytest.approx(float(expected), abs=1e-12)
    assert moved.start.nu_y != scene.start.nu_y
    assert moved.varied(omega_3="9").start.omega_3 == 9
    assert moved.varied(nu_y="0").start.nu_y == 0
    assert scene.varied(R="0.03").start.nu_y == pytest.approx(1.5 * float(scene.start.nu_y))


@pytest.mark.parametrize(("changed", "kept"), [("nu_x", "nu_y"), ("nu_y", "nu_x")])
def test_one_gliding_velocity_is_varied_alone(changed: str, kept: str) -> None:
    """In a start at rest, too, the other component keeps the value that it was resolved to."""
    scene = REFERENCE.varied(theta_dot="3", phi_dot="-5", at_rest="centre of mass")
    moved = scene.varied(**{changed: "0.01"})
    assert getattr(moved.start, changed) == Fraction(1, 100)
    assert getattr(moved.start, kept) == getattr(scene.start, kept) != 0
    assert moved.varied(phi_dot="7").start.nu_x == moved.start.nu_x


def test_a_start_that_was_replaced_forgets_what_was_given() -> None:
    scene = REFERENCE.varied(psi_dot="150", phi_dot="10")
    plain = replace(scene, start=start(**PLAIN))
    assert plain.varied(phi_dot="3").start == start(**PLAIN, phi_dot="3")
