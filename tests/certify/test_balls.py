from fractions import Fraction

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import flint
from flint import arb

from tt_precise.certify import balls
from tt_precise.certify.balls import NotProved


def test_balls_round_outward_here() -> None:
    with flint.ctx.workprec(100):
        balls.require_outward_rounding()


def test_balls_that_do_not_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def nearest(value: Fraction) -> arb:
        return arb(flint.fmpq(value.numerator, value.denominator)).mid()

    monkeypatch.setattr(balls, "ball", nearest)
    with flint.ctx.workprec(100), pytest.raises(NotProved, match="excludes the result"):
        balls.require_outward_rounding()


def test_largest_does_not_pass_over_nan() -> None:
    assert balls.largest([arb(1), arb(2, 1)]) >= 3
    with pytest.raises(NotProved, match="not finite"):
        balls.largest([arb(1), arb("nan")])


def test_bounds_lose_nothing() -> None:
    low, high = balls.bounds(arb(3, 0.5))
    assert Fraction(5, 2) - Fraction(1, 10**8) < low <= Fraction(5, 2)
    assert high == 6 - low
