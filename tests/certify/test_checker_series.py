"""What the second checker computes with: series with a bound, in balls."""

import pytest

pytest.importorskip("flint", reason="python-flint is not installed")

import flint
from flint import arb, arb_poly

from tt_precise.certify import checker


def test_a_root_is_bounded_by_what_its_square_is_off() -> None:
    low = checker.Room(arb(1) / 4, checker.LOW)
    root = checker.Poly(arb_poly([4, 1]), low).sqrt().p
    for x in (arb(0), arb(1) / 8, arb(1) / 4):
        assert root(x).contains((4 + x).sqrt())
        assert root(x).rad() < 1e-10


def test_a_series_that_does_not_exist_leaves_the_length_of_others() -> None:
    low, before = checker.Room(arb(1) / 4, checker.LOW), flint.ctx.cap
    with pytest.raises(ValueError, match="would not be a power series"):
        1 / checker.Poly(arb_poly([0, 1]), low)
    assert flint.ctx.cap == before


def test_the_flow_of_constant_coefficients_is_the_exponential() -> None:
    """Of J = [[0, 1], [-1, 0]] a rotation; and J P - P' is what is left of its series."""
    low = checker.Room(arb(1) / 2, checker.LOW)
    jacobian = [[checker.Poly(arb_poly([x]), low) for x in row] for row in ((0, 1), (-1, 0))]
    flow, error = checker._flow(jacobian, low)
    assert error < 1e-15
    assert abs(flow[0][1](arb(1) / 2) - (arb(1) / 2).sin()) < 1e-15
    assert abs(flow[1][1](arb(1) / 2) - (arb(1) / 2).cos()) < 1e-15
