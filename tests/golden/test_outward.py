"""Intervals of decimals, rounded outwards: products of every pair of signs."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from itertools import product

import mpmath
import pytest

from tt_precise.golden.outward import FIGURES, IntervalFunctions, Outward, pi

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


@pytest.mark.parametrize("tilt", ["1e-300", "1e-20", "0.1", "1.5707963267948966", "3.1", "3.14159"])
def test_an_angle_is_enclosed_closely(tilt: str) -> None:
    """The truth in mpmath, of sine and cosine rounded to as many digits as intervals have."""
    with mpmath.workdps(2 * FIGURES):
        exact = [mpmath.sin(mpmath.mpf(tilt)), mpmath.cos(mpmath.mpf(tilt))]
        y, x = (Decimal(mpmath.nstr(one, FIGURES)) for one in exact)
        truth = Decimal(str(mpmath.atan2(mpmath.mpf(str(y)), mpmath.mpf(str(x)))))
    found = IntervalFunctions.atan2(Outward(y, y), Outward(x, x))
    assert found.low <= truth <= found.high
    closely = abs(truth) * Decimal(10) ** (10 - FIGURES)
    assert found.high - found.low < closely
    off = Outward(truth, truth) + Outward(closely, closely)
    assert not found.meets(off)


def test_pi_is_enclosed() -> None:
    with mpmath.workdps(2 * FIGURES):
        truth = Decimal(str(+mpmath.pi))
    assert pi().low < truth < pi().high
    assert pi().high - pi().low < Decimal(10) ** (10 - FIGURES)
