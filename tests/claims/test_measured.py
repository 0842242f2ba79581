"""Numbers with the digits they have."""

from fractions import Fraction

import mpmath
import pytest

from tt_precise.claims.measured import (
    MOST_DIGITS,
    Settled,
    decade,
    decimal,
    fraction_of,
    measured_text,
)


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        ("0", 5, "0"),
        ("1.5", 3, "1.50"),
        ("0.005106366", 4, "0.005106"),
        ("-82.86640856", 4, "-82.87"),
        ("9.996", 3, "10.0"),
        ("99999", 2, "1.0e5"),
        ("1.5e-33", 2, "1.5e-33"),
        ("0.00009", 1, "9e-5"),
        ("155", 3, "155"),
        ("155", 1, "2e2"),
    ],
)
def test_decimal(value: str, digits: int, text: str) -> None:
    assert decimal(Fraction(value), digits) == text


@pytest.mark.parametrize(
    ("other", "digits"),
    [("1.0001", 3), ("1.00004", 4), ("1.0000001", 6), ("2", 0), ("-1", 0)],
)
def test_settled_counts_agreeing_digits(other: str, digits: int) -> None:
    assert Settled.of(Fraction(1), Fraction(other)).digits == digits


def test_settled_never_claims_more_than_the_most() -> None:
    assert Settled.of(1, 1).digits == MOST_DIGITS
    assert Settled.of(Fraction(1), 1 + Fraction(1, 10**60), most=40).digits == 40


@pytest.mark.parametrize("number", [3, 0.1, Fraction(1, 3), mpmath.mpf("-0.3"), mpmath.mpf(0)])
def test_fraction_of_is_exact(number: object) -> None:
    assert fraction_of(number) == fraction_of(Settled(number, 5))
    assert float(fraction_of(number)) == float(number)  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [mpmath.nan, mpmath.inf, float("nan")])
def test_no_number_is_no_measurement(bad: object) -> None:
    with pytest.raises(ValueError, match=r"finite|NaN"):
        fraction_of(bad)


def test_bare_numbers_show_twelve_digits_and_exact_ones_all() -> None:
    assert measured_text(2 / 3) == "0.666666666667"
    assert measured_text(Fraction(2, 3)) == "0.66666666666666666667"
    assert measured_text(350) == "350"


@pytest.mark.parametrize(
    ("value", "power"), [("1", 0), ("9.99", 0), ("10", 1), ("1e-40", -40), ("9.9e-41", -41)]
)
def test_decade(value: str, power: int) -> None:
    assert decade(Fraction(value)) == power
