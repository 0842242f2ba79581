"""Polynomials through values at nodes: what they leave out."""

from __future__ import annotations

import numpy
import pytest

from tt_precise.taylor.interpolation import nodes, through


@pytest.mark.parametrize("count", [8, 14])
def test_the_tail_bounds_what_a_bend_leaves_out(count: int) -> None:
    """And that of smooth functions does not, which is the control."""
    bends = numpy.linspace(0, 1, 2000)[1:-1]
    at = nodes(count)
    u = numpy.linspace(-1, 1, 2001)
    table, true = (abs(x[:, None] - bends) for x in (at, (u + 1) / 2))
    tails = []
    for bent in (True, False):
        polynomials = through(table, numpy.full(len(bends), bent))
        values = numpy.vander(u, count, increasing=True) @ polynomials.monomials
        tails.append(abs(values - true).max(axis=0) / polynomials.tail)
    assert tails[0].max() <= 1
    assert tails[1].max() > 5


@pytest.mark.parametrize("count", [8, 14])
def test_the_tail_bounds_what_a_smooth_function_leaves_out(count: int) -> None:
    """Coefficients of a pole beside the interval fall by a factor of 2.8."""
    table, u = 1 / (nodes(count)[:, None] + 0.3), numpy.linspace(-1, 1, 101)
    polynomials = through(table, numpy.array([False]))
    values = numpy.vander(u, count, increasing=True) @ polynomials.monomials[:, 0]
    assert abs(values - 1 / ((u + 1) / 2 + 0.3)).max() <= polynomials.tail[0]
