"""StartSeries in the start: what they say of every u, against exact values."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

from flint import arb

from tt_precise.certify.balls import ball
from tt_precise.certify.series import Fan, FanFunctions, StartSeries, monomials
from tt_precise.certify.verdict import NotProved

CORNERS = [(Fraction(a, 2), Fraction(b, 2)) for a in range(-2, 3) for b in range(-2, 3)]


def value(series: StartSeries, u: tuple[Fraction, Fraction]) -> arb:
    return sum(
        (term * ball(math.prod((u[i] for i in key), start=Fraction(1)))
         for key, term in series.terms.items()),
        start=arb(0),
    )  # fmt: skip


def pair(degree: int) -> tuple[Fan, Fan]:
    x = Fan({(): arb(3), (0,): arb(1) / 4, (1,): arb(-1) / 8}, degree)
    y = Fan({(): arb(-2), (0, 1): arb(1) / 16} if degree > 1 else {(): arb(-2)}, degree)
    return x, y


def test_monomials() -> None:
    assert monomials(2, 2) == [(), (0,), (1,), (0, 0), (0, 1), (1, 1)]


@pytest.mark.parametrize("degree", [1, 2, 4])
def test_results_hold_for_every_start(degree: int) -> None:
    x, y = pair(degree)
    for u in CORNERS:
        a, b = value(x, u), value(y, u)
        exact = {
            "+": (x + y, a + b), "-": (1 - x - y, 1 - a - b), "*": (x * y * x, a * b * a),
            "/": (x / y, a / b), "1/": (2 / x, 2 / a), "number": (x / 3, a / 3),
            "sin": (FanFunctions.sin(x), a.sin()), "cos": (FanFunctions.cos(x), a.cos()),
        }  # fmt: skip
        for name, (found, expected) in exact.items():
            assert value(found, u).contains(expected), name
            assert found.range.contains(expected), name


def test_what_is_cut_off_counts() -> None:
    """The negative control: without it the square of a linear series misses values."""
    x = pair(1)[0]
    plain = StartSeries(x.terms, 1)
    u = CORNERS[0]
    square = value(x, u) ** 2
    assert value(x * x, u).contains(square)
    assert not value(plain * plain, u).contains(square)
    assert not value(1 / plain, u).contains(1 / value(x, u))


def test_higher_degrees_are_sharper() -> None:
    widths = [value(1 / pair(degree)[0], CORNERS[0]).rad() for degree in (1, 2, 4, 8)]
    assert all(b < a / 5 for a, b in pairwise(widths))


def test_a_divisor_that_may_be_zero_is_none() -> None:
    with pytest.raises(NotProved, match="divisor"):
        1 / Fan({(): arb(1), (0,): arb(1)}, 3)
