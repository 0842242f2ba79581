"""Intervals of decimals, rounded outwards: products of every pair of signs."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import product

import pytest

from tt_precise.golden.outward import Outward

ENDS = [Decimal(x) for x in ("-3", "-0.5", "0", "0.25", "2")]
INTERVALS = [(a, b) for a, b in product(ENDS, ENDS) if a <= b]


@pytest.mark.parametrize("one", INTERVALS, ids=str)
def test_a_product_reaches_from_its_least_corner_to_its_largest(
    one: tuple[Decimal, Decimal],
) -> None:
    for other in INTERVALS:
        found = Outward(*one) * Outward(*other)
        corners = [Fraction(a) * Fraction(b) for a, b in product(one, other)]
        assert (Fraction(found.low), Fraction(found.high)) == (min(corners), max(corners))


@pytest.mark.parametrize("ball", [("nan", "1"), ("1", "inf"), ("1", "-1"), ("-inf", "0")])
def test_what_is_no_ball_is_refused(ball: tuple[str, str]) -> None:
    with pytest.raises(ArithmeticError, match="expected a middle and a radius"):
        Outward.around(*ball)
    assert Outward.around("1", "0").rounds_to("1", Decimal(0))
