"""Precisions: numbers pass exactly in and out of heyoka's types."""

from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration.precision import Precision, finer, precision_named
from tt_precise.runtime.values import InputError

PRECISIONS = [precision_named(name) for name in ("double", "extended", "quad")]
PRECISIONS += [precision_named("mp", bits) for bits in (54, 200, 1001)]
# decimal exponents: inside the range of double, at its ends, and beyond, where there is a beyond
EXPONENTS = {"double": (-300, -5, 0, 300), "mp": (-5000, -308, 0, 308, 5000)}
WIDE = (-4900, -4000, -330, -308, -300, -30, 0, 30, 308, 310, 4000, 4900)
CASES = [(p, exponent) for p in PRECISIONS for exponent in EXPONENTS.get(p.name, WIDE)]

each = pytest.mark.parametrize("precision", PRECISIONS, ids=lambda p: f"{p.name}{p.bits}")


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


@pytest.mark.parametrize(
    ("precision", "exponent"), CASES, ids=lambda v: f"{v.name}{v.bits}" if hasattr(v, "bits") else v
)
@pytest.mark.parametrize("mantissa", ["1/3", "-9.82", "1.2345678901234567890123456789"])
def test_a_number_is_rounded_once(precision: Precision, exponent: int, mantissa: str) -> None:
    exact = Fraction(mantissa) * Fraction(10) ** exponent
    number = precision.number(precision.exact(exact))
    out = precision.with_guard_bits(number)
    assert fraction(out) == nearest(exact, precision.bits)
    assert precision.number(out) == number
    assert precision.number(precision.context.mpf(precision.text(out))) == number


@each
@pytest.mark.parametrize("special", ["nan", "inf", "-inf", "0"])
def test_what_has_no_digits_stays_as_it_is(precision: Precision, special: str) -> None:
    kind = precision.fp_type
    number = kind(special, precision.bits) if precision.name == "mp" else kind(special)
    out = precision.with_guard_bits(number)
    assert precision.context.isnan(out) if special == "nan" else out == float(special)


@each
def test_finer_has_at_least_three_more_digits(precision: Precision) -> None:
    assert finer(precision).eps < precision.eps / 1000


@pytest.mark.parametrize(
    ("name", "bits", "expected"),
    [
        ("octuple", None, "expected one of: double, extended, double-double, quad"),
        ("quad", 200, "expected bits only with mp"),
        ("mp", 53, "expected a whole number between 54 and 20000"),
        ("mp", 20_001, "expected a whole number between 54 and 20000"),
        ("mp", 200.5, "got 200.5, expected a whole number between 54 and 20000"),
    ],
)
def test_refuses(name: str, bits: Any, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        precision_named(name, bits)


def test_extended_is_refused_where_it_is_not_wider(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tt_precise.integration.precision._has_80_bit_floats", lambda: False)
    with pytest.raises(InputError, match="expected quad"):
        precision_named("extended")
    assert finer(precision_named("double")).name == "quad"


@each
@pytest.mark.parametrize("text", ["1/3", "-2/7", "154.3", "1e-30", "-1e20"])
def test_the_other_side_is_the_next_number(precision: Precision, text: str) -> None:
    exact = precision.exact(Fraction(text))
    rounded = precision.with_guard_bits(precision.number(exact))
    other = precision.opposite_neighbour(exact)
    if rounded == exact:
        assert other == exact
    else:
        assert min(rounded, other) < exact < max(rounded, other)
        assert precision.with_guard_bits(precision.number(other)) == other
        assert 0 < abs(other - rounded) <= precision.eps * abs(exact)
