"""Own contexts, asked-for digits, and the count of digits that agree."""

from typing import Any

import mpmath
import pytest

from tt_precise.exact import arithmetic
from tt_precise.runtime.values import InputError


def test_contexts_are_ones_own() -> None:
    before = mpmath.mp.dps
    one, other = arithmetic.own_context(30), arithmetic.own_context(70)
    assert (one.dps, other.dps, mpmath.mp.dps) == (30, 70, before)
    assert arithmetic.decimal(other.mpf(5) / 2, 10, other) == "2.500000000"


@pytest.mark.parametrize(
    ("a", "b", "digits"),
    [
        ("1", "1", 50),
        ("1", "1 - 1e-60", 50),
        ("1", "1 - 2e-40", 39),
        ("1", "1 - 9e-41", 40),
        ("1", "0.5", 0),
        ("1", "4", 0),
        ("0", "0", 50),
        ("0", "1e-300", 0),
        ("nan", "1", 0),
        ("inf", "1", 0),
    ],
)
def test_agreed_digits(a: str, b: str, digits: int) -> None:
    context = arithmetic.own_context(80)
    one, other = (
        context.fsum(context.mpf(term) for term in text.replace("- ", "-").split())
        for text in (a, b)
    )
    assert arithmetic.agreed_digits(one, other, 50, context) == digits
    assert arithmetic.agreed_digits(other, one, 50, context) == digits


@pytest.mark.parametrize("digits", [0, -1, arithmetic.MOST_DIGITS + 1, 50.0, "50", True, None])
def test_refuses_digits(digits: Any) -> None:
    with pytest.raises(InputError, match=r"digits: got .*, expected a whole number between 1 and"):
        arithmetic.checked_digits(digits)
