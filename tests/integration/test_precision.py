"""Precisions: numbers pass exactly in and out of heyoka's types."""

from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration.precision import LONG_DOUBLES, Precision, precision_named

PRECISIONS = [precision_named(name) for name in ("double", "quad")]
PRECISIONS += [precision_named("mp", bits) for bits in (54, 200, 1001)]
# decimal exponents: inside the range of double, at its ends, and beyond, where there is a beyond
EXPONENTS = {"double": (-300, -5, 0, 300), "mp": (-5000, -308, 0, 308, 5000)}
WIDE = (-4900, -4000, -330, -308, -300, -30, 0, 30, 308, 310, 4000, 4900)


def nearest(value: Fraction, bits: int) -> Fraction:
    """The nearest number with so many bits, in integers alone."""
    exponent = abs(value.numerator).bit_length() - value.denominator.bit_length() - bits
    for power in (exponent, exponent + 1, exponent + 2):
        mantissa = round(value / Fraction(2) ** power)
        if abs(mantissa).bit_length() <= bits:
            return mantissa * Fraction(2) ** power
    raise AssertionError(value)


def fraction(number: Any) -> Fraction:
    sign, mantissa, power, _ = number._mpf_
    return (-1) ** sign * int(mantissa) * Fraction(2) ** power


@pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: f"{p.name}{p.bits}")
@pytest.mark.parametrize("mantissa", ["1/3", "-9.82", "1.2345678901234567890123456789"])
def test_a_number_is_rounded_once(precision: Precision, mantissa: str) -> None:
    for exponent in EXPONENTS.get(precision.name, WIDE):
        exact = Fraction(mantissa) * Fraction(10) ** exponent
        number = precision.number(precision.exact(exact))
        out = precision.with_guard_bits(number)
        assert fraction(out) == nearest(exact, precision.bits)
        assert precision.number(out) == number
        assert precision.number(precision.context.mpf(precision.text(out))) == number
    for special in ("inf", "-inf", "0"):  # what has no digits stays as it is
        arguments = (special, precision.bits) if precision.name == "mp" else (special,)
        assert precision.with_guard_bits(precision.fp_type(*arguments)) == float(special)


@pytest.mark.parametrize("text", ["1/3", "7/100", "123456789/1000000007", "1/9007199254740993007"])
def test_exact_times_and_wide_numbers_are_long_doubles(text: str) -> None:
    (time,), exact = LONG_DOUBLES.of_fractions([Fraction(text)]), Fraction(text)
    for number in (time, LONG_DOUBLES.number(PRECISIONS[-1].exact(exact))):
        rounded = Fraction(*float(number).as_integer_ratio())
        rounded += Fraction(*float(number - float(number)).as_integer_ratio())
        assert abs(rounded / exact - 1) <= Fraction(1, 2**63)
    # the control: a double is further off
    assert abs(Fraction(float(exact)) / exact - 1) > Fraction(1, 2**60)
