"""Ball arithmetic: outward rounding, and bounds that lose nothing."""

from fractions import Fraction

import pytest
from flint import arb

from tests.conftest import Patch
from tt_precise.certify import NotProved, balls
from tt_precise.certify.balls import ball


def test_balls_round_outward_and_their_bounds_lose_nothing() -> None:
    balls.require_outward_rounding()
    low, high = balls.bounds(arb(3, 0.5))
    assert Fraction(5, 2) - Fraction(1, 10**8) < low <= Fraction(5, 2)
    assert high == 6 - low


def test_without_outward_rounding_nothing_is_proved(monkeypatch: Patch) -> None:
    monkeypatch.setattr(balls, "ball", lambda value: ball(value).mid())
    with pytest.raises(NotProved, match="excludes the result"):
        balls.require_outward_rounding()


def test_the_largest_of_numbers_is_finite() -> None:
    assert balls.largest([arb(1), arb(2, 1)]) >= 3
    for numbers in ([arb(1), arb("nan")], [arb("nan"), arb(1)], [arb("inf")]):
        with pytest.raises(NotProved, match="not finite"):
            balls.largest(numbers)
