"""The last digits of an enclosure, and the enclosure that comes back from them."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import pytest

from tt_precise.golden.tails import enclosed, last_place, tail

SCALE = Decimal("0.5")


@pytest.mark.parametrize(
    ("text", "place"),
    [("1.234567890123456789012345678901234e-1", -34), ("-4.2e3", 2), ("0", -35)],
)
def test_the_place_of_the_last_digit(text: str, place: int) -> None:
    """A zero is printed to 34 digits of the largest entry of its column."""
    assert last_place(text, SCALE) == place


@pytest.mark.parametrize("sign", ["", "-"])
@pytest.mark.parametrize("off", ["0.4721", "-0.3499"])
def test_it_comes_back_to_a_unit_of_the_sixteenth_digit(sign: str, off: str) -> None:
    text = f"{sign}1.234567890123456789012345678901234e-1"
    unit = Fraction(1, 10**34)
    exact = Fraction(text) + Fraction(off) * unit
    width = unit / 10**5
    digits = tail(text, exact - width, exact + width, SCALE)
    found = enclosed(text, digits, SCALE)
    assert len(digits) == 16
    assert Fraction(found.low) <= exact - width < exact + width <= Fraction(found.high)
    assert Fraction(found.high) - Fraction(found.low) == 2 * unit / 1000


def test_an_enclosure_wider_than_the_last_digit_has_none() -> None:
    text, unit = "1.000000000000000000000000000000000e0", Fraction(1, 10**33)
    assert tail(text, 1 - unit / 500, 1 + unit / 500, SCALE) == ""
