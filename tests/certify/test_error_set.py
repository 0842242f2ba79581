"""Lohner sets contain what moves, and balls round outward."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction

import flint
import pytest
from flint import arb, arb_mat

from tt_precise.certify import balls
from tt_precise.certify.balls import NotProved
from tt_precise.certify.error_set import LohnerSet


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(80):
        yield


def test_a_moved_set_contains_the_moved_points() -> None:
    dice = random.Random(1)
    point = [arb(dice.uniform(-1, 1)) for _ in range(4)]
    errors = LohnerSet.of([arb(0, 1)] * 4)
    for _ in range(40):
        flow = arb_mat([[arb(dice.uniform(-1, 1)) for _ in range(4)] for _ in range(4)])
        more = arb(dice.uniform(-1, 1))
        point = [x + more for x in (flow * arb_mat(4, 1, point)).entries()]
        errors = errors.moved(flow, [arb(0, 1)] * 4)
        assert all(h.contains(x) for h, x in zip(errors.hull, point, strict=True))


def test_a_rotated_box_does_not_grow_by_wrapping() -> None:
    c, s = arb(1).cos(), arb(1).sin()
    errors = LohnerSet.of([arb(0, 1), arb(0, 1)])
    for _ in range(100):
        errors = errors.moved(arb_mat([[c, -s], [s, c]]), [arb(0), arb(0)])
    assert max(h.rad() for h in errors.hull) < 1.42


def test_a_flat_set_stays_flat_whichever_edge_is_the_long_one() -> None:
    """Nearly parallel edges: the long one keeps its direction, or its length would go across."""
    for edges, across in (((1, 1e-6), (0, 1)), ((1e-6, 1), (-1e-8, 1))):
        errors = LohnerSet.of([arb(0, edge) for edge in edges])
        moved = errors.moved(arb_mat([[1, 1], [0, 1e-8]]), [arb(0), arb(0)])
        along = arb_mat([[arb(x) for x in across]]) * moved._basis * moved._box
        assert along[0, 0].rad() < 1e-13


def test_what_is_not_finite_is_not_proved() -> None:
    with pytest.raises(NotProved):
        LohnerSet.of([arb("nan")])
    with pytest.raises(NotProved):
        LohnerSet.of([arb(1)] * 2).moved(arb_mat([[0, 0], [0, 0]]), [arb("inf")] * 2)
    with pytest.raises(NotProved, match="not finite"):
        balls.largest([arb(1), arb("nan")])
    assert balls.largest([arb(1), arb(2, 1)]) >= 3


def test_balls_round_outward_and_their_bounds_lose_nothing() -> None:
    balls.require_outward_rounding()
    low, high = balls.bounds(arb(3, 0.5))
    assert Fraction(5, 2) - Fraction(1, 10**8) < low <= Fraction(5, 2)
    assert high == 6 - low
