"""Exact numbers: what is read, what is refused, and that mpmath gets them unrounded."""

import math
import re
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.scene.numerals import LONGEST, WithPi, as_fraction, exact, parse, to_mpmath


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ("0.02", Fraction(1, 50)),
        ("131/350", Fraction(131, 350)),
        ("1e-9", Fraction(1, 10**9)),
        ("-2.5E+3", Fraction(-2500)),
        ("+.5", Fraction(1, 2)),
        ("7.", Fraction(7)),
        (" 9.82 ", Fraction(491, 50)),
        ("1e-999", Fraction(1, 10**999)),
        ("pi/pi", Fraction(1)),
        ("0.004/0.017", Fraction(4, 17)),
        ("2 * 3/4 / 5", Fraction(3, 10)),
        (3, Fraction(3)),
        (Fraction(2, 3), Fraction(2, 3)),
    ],
)
def test_reads_exactly(given: Any, value: Fraction) -> None:
    assert exact(given) == value


@pytest.mark.parametrize(
    "given",
    [
        "0,1", "nan", "NaN", "inf",
        "-Infinity", "", " ", "1 2", "1/0", "1/(2)", "2024-01-01", "1e9999",
        "pi*pi", "1/pi", "10 deg", "1*2*3*4*5",
        "1_000", "0x10", "1e", "e5", "--1", "\u0661",
        "\uff11", "\u0661/2", "1\n2", "9" * (LONGEST + 1),
        0.1, float("nan"), True, None, b"1", [1], 1j,
    ],
)  # fmt: skip
def test_refuses_with_one_line(given: Any) -> None:
    with pytest.raises(InputError) as refusal:
        exact(given, "alpha")
    message = str(refusal.value)
    assert message.startswith("alpha: got ")
    assert "expected" in message
    assert "\n" not in message
    assert len(message) < 200


@pytest.mark.parametrize(
    "given",
    [
        "1" * 400 + "e999*1e999*1e999*1e999", "1e-999/1e999", Fraction(10**5000), 10**5000,
        "9" * 1999,
    ],
    ids=["product", "quotient", "fraction", "integer", "long"],
)  # fmt: skip
def test_refuses_a_number_that_python_could_not_print(given: Any) -> None:
    with pytest.raises(InputError, match=r"^m: got .*, expected a number of at most 1000 digits$"):
        exact(given, "m")
    assert exact("1e999").numerator == 10**999


def test_a_time_may_stand_in_an_array_without_axes() -> None:
    assert as_fraction(numpy.array(0.5)) == as_fraction(numpy.float32(0.5)) == Fraction(1, 2)
    assert as_fraction(numpy.array(3)) == 3
    with pytest.raises(InputError, match="expected a finite time"):
        as_fraction(numpy.array(math.nan))


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("25 rev/s", "rad/s", WithPi(Fraction(0), Fraction(50))),
        ("-1500rpm", "rad/s", WithPi(Fraction(0), Fraction(-50))),
        ("6 g", "kg", WithPi(Fraction(3, 500))),
        ("1.4cm", "m", WithPi(Fraction(7, 500))),
        ("981/100 m/s^2", "m/s^2", WithPi(Fraction(981, 100))),
        ("10 deg/s", "rad/s", WithPi(Fraction(0), Fraction(1, 18))),
        ("pi/2 rad", "rad", WithPi(Fraction(0), Fraction(1, 2))),
    ],
)
def test_a_unit_follows_its_number(text: str, unit: str, value: WithPi) -> None:
    assert parse(text, unit=unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("1 deg", "rad/s", 'or, with a unit, "10 rad/s", "10 deg/s", "10 rev/s", "10 rpm"'),
        ("pi deg", "rad", 'or, with a unit, "10 rad", "10 deg"'),
        ("20 mm", "", "a string without a unit, such as"),
        ("1190 g mm^2", "m R^2", "a string in units of m R^2 (a size has the key I1_g_mm2 or"),
    ],
)
def test_another_unit_is_refused(text: str, unit: str, said: str) -> None:
    with pytest.raises(InputError, match=f"got '{re.escape(text)}', expected .*{re.escape(said)}"):
        parse(text, unit=unit)


def test_a_multiple_of_pi_has_100_digits() -> None:
    """Against mpmath's own pi; ``read`` keeps it apart, so that pi itself stays exact."""
    with mpmath.workdps(130):
        for text, value in (("-pi/18", -mpmath.pi / 18), ("pi/2 - 0.01", mpmath.pi / 2 - 0.01)):
            found = mpmath.mpf(exact(text).numerator) / exact(text).denominator
            assert 0 < abs(found / value - 1) < mpmath.mpf(10) ** (-99 if "18" in text else -16)
    assert parse("10deg", unit="rad") == parse("pi/18") == WithPi(Fraction(0), Fraction(1, 18))
    assert parse("pi - 1e-9") == WithPi(Fraction(-1, 10**9), Fraction(1))
    assert exact("pi/18") == exact("10*pi/180") != Fraction(math.pi / 18)


@pytest.mark.parametrize("digits", [15, 50, 71, 200])
@pytest.mark.parametrize("text", ["9.82", "131/350", "1e-30", "-123456789.987654321e40"])
def test_rounds_once_into_mpmath(text: str, digits: int) -> None:
    context = mpmath.MPContext()
    context.dps = digits
    precision = context.prec
    rounded = to_mpmath(exact(text), context)
    assert context.prec == precision
    sign, mantissa, exponent, bits = rounded._mpf_
    value = (-1) ** sign * mantissa * Fraction(2) ** exponent
    assert bits <= context.prec
    half_ulp = abs(exact(text)) * Fraction(1, 2**context.prec)
    assert abs(value - exact(text)) <= half_ulp
    # a float on the way would show
    assert digits == 15 or abs(Fraction(float(exact(text))) - exact(text)) > half_ulp
