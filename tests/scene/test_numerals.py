"""Exact numbers and units: the values read, the refusals, and the rounding into mpmath."""

import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.scene import numerals
from tt_precise.scene.numerals import LONGEST, WithPi, as_fraction, exact, parse, to_mpmath


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ("0.02", Fraction(1, 50)), ("131/350", Fraction(131, 350)), ("1e-9", Fraction(1, 10**9)),
        ("-2.5E+3", Fraction(-2500)), ("+.5", Fraction(1, 2)), (" 9.82 ", Fraction(491, 50)),
        ("1e-999", Fraction(1, 10**999)), ("pi/pi", 1), ("0.004/0.017", Fraction(4, 17)),
        ("2 * 3/4 / 5", Fraction(3, 10)), (3, 3), (Fraction(2, 3), Fraction(2, 3)),
    ],
)  # fmt: skip
def test_a_number_is_read_exactly(given: Any, value: Fraction) -> None:
    assert exact(given) == value


@pytest.mark.parametrize(
    "given",
    [
        "0,1", "nan", "inf", "-Infinity", "", "1 2", "1/0", "1/(2)", "2024-01-01", "1e9999",
        "pi*pi", "1/pi", "10 deg", "1*2*3*4*5", "1_000", "0x10", "1e", "e5", "--1", "\u0661",
        "\uff11", "1\n2", "9" * (LONGEST + 1), "9" * 1999, "1e-999/1e999",
        Fraction(10**5000),
        "1" * 400 + "e999*1e999*1e999*1e999", 0.1, float("nan"), True, None, b"1", [1], 1j,
    ],
)  # fmt: skip
def test_anything_else_is_refused_in_one_line(given: Any) -> None:
    with pytest.raises(InputError) as refusal:
        exact(given, "alpha")
    message = str(refusal.value)
    assert message.startswith("alpha: got ")
    assert "expected" in message
    assert "\n" not in message
    assert len(message) < 260


@pytest.mark.parametrize(
    ("text", "factor", "dimension"),
    [
        ("g mm^2", WithPi(Fraction(1, 10**9)), (1, 2, 0, 0)),
        ("N s/m", WithPi(Fraction(1)), (1, 0, -1, 0)),
        ("N/cm^1.5", WithPi(Fraction(1000)), (1, Fraction(-1, 2), -2, 0)),
        ("rev/ms", WithPi(Fraction(0), Fraction(2000)), (0, 0, -1, 1)),
        ("rpm", WithPi(Fraction(0), Fraction(1, 30)), (0, 0, -1, 1)),
    ],
)
def test_a_product_of_units_is_exact(text: str, factor: WithPi, dimension: tuple[Any, ...]) -> None:
    assert numerals.unit_named(text) == (factor, dimension)


def test_a_root_is_rounded_to_a_hundred_digits_and_another_unit_is_refused() -> None:
    factor = numerals.unit_named("N/mm^1.5")[0].plain  # 10^4.5
    assert 0 < abs(factor**2 / 10**9 - 1) < Fraction(1, 10**98)
    for text in ("stone", "m^", "deg^2", "1/deg", "rev rad/rpm", "m^0.3", "kg-m"):
        with pytest.raises(ValueError, match=r"is none of the units|stands once"):
            numerals.unit_named(text)


def test_a_multiple_of_pi_has_100_digits() -> None:
    """Against mpmath's own pi; ``parse`` keeps it apart, so that pi itself stays exact."""
    with mpmath.workdps(130):
        for text, value in (("-pi/18", -mpmath.pi / 18), ("pi/2 - 0.01", mpmath.pi / 2 - 0.01)):
            number = mpmath.mpf(exact(text).numerator) / exact(text).denominator
            assert 0 < abs(number / value - 1) < mpmath.mpf(10) ** (-99 if "18" in text else -16)
    assert parse("-1500rpm") == (WithPi(Fraction(-1500)), "rpm")
    assert parse("pi - 1e-9")[0] == WithPi(Fraction(-1, 10**9), Fraction(1))
    assert exact("pi/18") == exact("10*pi/180") != Fraction(math.pi / 18)


def test_a_time_may_stand_in_an_array_without_axes() -> None:
    assert as_fraction(numpy.array(0.5)) == as_fraction(numpy.float32(0.5)) == Fraction(1, 2)
    with pytest.raises(InputError, match="expected a finite time"):
        as_fraction(numpy.array(math.nan))


@pytest.mark.parametrize("digits", [15, 50, 200])
def test_a_number_is_rounded_once_into_mpmath(digits: int) -> None:
    text, context = "-123456789.987654321e40", mpmath.MPContext()
    context.dps = digits
    sign, mantissa, exponent, bits = to_mpmath(exact(text), context)._mpf_
    value = (-1) ** sign * mantissa * Fraction(2) ** exponent
    assert bits <= context.prec
    half_ulp = abs(exact(text)) * Fraction(1, 2**context.prec)
    assert abs(value - exact(text)) <= half_ulp
    # a float on the way would show
    assert digits == 15 or abs(Fraction(float(exact(text))) - exact(text)) > half_ulp
