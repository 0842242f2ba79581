"""Own contexts, asked-for digits, and the count of digits that agree."""

from typing import Any

import mpmath
import pytest

from tt_precise.exact.arithmetic import (
    MOST_DIGITS,
    agreed_digits,
    checked_digits,
    decimal,
    own_context,
)
from tt_precise.runtime.values import InputError


def test_contexts_are_ones_own() -> None:
    before = mpmath.mp.dps
    one, other = own_context(30), own_context(70)
    assert (one.dps, other.dps, mpmath.mp.dps) == (30, 70, before)


@pytest.mark.parametrize(
    ("difference", "digits"),
    [("0", 50), ("1e-60", 50), ("2e-40", 39), ("9e-41", 40), ("0.5", 0), ("-3", 0)],
)
def test_agreed_digits(difference: str, digits: int) -> None:
    context = own_context(80)
    a = context.mpf(1)
    assert agreed_digits(a, a - context.mpf(difference), 50, context) == digits
    assert agreed_digits(a - context.mpf(difference), a, 50, context) == digits


def test_zero_agrees_with_zero_only() -> None:
    context = own_context(80)
    zero = context.mpf(0)
    assert agreed_digits(zero, zero, 50, context) == 50
    assert agreed_digits(zero, context.mpf("1e-300"), 50, context) == 0


@pytest.mark.parametrize("bad", ["nan", "inf"])
def test_nothing_agrees_with_what_is_no_number(bad: str) -> None:
    context = own_context(80)
    for pair in ((context.mpf(bad), context.mpf(1)), (context.mpf(1), context.mpf(bad))):
        assert agreed_digits(*pair, 50, context) == 0


@pytest.mark.parametrize("digits", [0, -1, MOST_DIGITS + 1, 50.0, "50", True, None])
def test_refuses_digits(digits: Any) -> None:
    with pytest.raises(InputError, match=r"digits: got .*, expected a whole number between 1 and"):
        checked_digits(digits)


def test_decimal_strings_have_all_digits() -> None:
    context = own_context(60)
    assert decimal(context.mpf(5) / 2, 10, context) == "2.500000000"
