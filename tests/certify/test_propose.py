"""Guesses: good polynomials, and lengths that follow the costs of the steps."""

import flint
import pytest
from flint import arb, arb_poly

from tt_precise.certify import propose
from tt_precise.certify.balls import NotProved
from tt_precise.certify.models import Rates
from tt_precise.certify.propose import LONGER, MOST_FAILURES, Lengths

RATES = Rates(lambda y: [y[0]], 1, 200, 40)
# What the defect adds, the error of the flow, the growth of errors: all far below their bounds.
FREE = (2.0**-250, 1e-12, 1.0 + 1e-9)


def test_taylor_polynomials_are_those_of_the_solution() -> None:
    """With t: exp(-t), 1/(1 + t), sqrt(1 + 2 t) and -log(1 - t/2), on steps of any size."""
    with flint.ctx.workprec(240):
        rates = Rates(
            lambda y: [-y[0], -(y[1] * y[1]), 1 / y[2], y[3].exp() / 2, y[2] * 0 + 1], 5, 200, 3
        )
        root = Rates(lambda y: [y[0] * 0 + 2, y[0].sqrt()], 2, 200, 3)
        for size in (arb(2) ** -5, arb(2), arb(2) ** -30):
            start = [arb(1), arb(1), arb(1), arb(0), arb(0)]
            p = propose.taylor(rates, start, size)
            half, sixth = arb(1) / 2, arb(1) / 6
            known = (
                [1, -1, half, -sixth], [1, -1, 1, -1], [1, 1, -half, half],
                [0, half, half / 4, sixth / 4], [0, 1],
            )  # fmt: skip
            for q, exact in zip(p, known, strict=True):
                difference = (q - arb_poly(exact)).coeffs()
                assert all(abs(c) * size**n < 1e-55 for n, c in enumerate(difference))
            _, area = propose.taylor(root, [arb(1), arb(0)], size)
            assert abs(area[3] + sixth) * size**3 < 1e-55  # (1 + 2 t)^(3/2)/3


def test_a_step_ends_just_beyond_the_horizon() -> None:
    for left in (1e-3, 1e-12):
        assert left < float(Lengths(RATES).next(left)) < left * (1 + 1e-5) + 1e-8


def test_a_cheap_step_is_followed_by_a_longer_one_and_a_dear_one_is_made_again() -> None:
    lengths = Lengths(RATES)
    first = lengths.next(1e9)
    assert lengths.accepts(first, FREE)
    assert float(lengths.next(1e9)) == pytest.approx(LONGER * float(first), rel=1e-5)
    for costs in ((1.0, *FREE[1:]), (FREE[0], 1.0, FREE[2]), (*FREE[:2], 1e30)):
        lengths = Lengths(RATES)
        assert not lengths.accepts(lengths.next(1e9), costs)
        assert lengths.next(1e9) < 0.8 * first


def test_steps_that_do_not_verify_are_halved_until_none_helps() -> None:
    lengths = Lengths(RATES)
    first = float(lengths.next(1e9))
    for failures in range(MOST_FAILURES):
        lengths.shorten(ArithmeticError("the tube is left"))
        assert float(lengths.next(1e9)) == pytest.approx(first / 2.0 ** (failures + 1), rel=1e-5)
    with pytest.raises(NotProved, match="the tube is left"):
        lengths.shorten(ArithmeticError("the tube is left"))
