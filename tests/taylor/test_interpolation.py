"""Polynomials through values at nodes: what they leave out; zeros of polynomials."""

from typing import Any

import numpy
import pytest

from tt_precise.taylor.interpolation import (
    MOST_BISECTIONS,
    isolated,
    nodes,
    through,
    zero_between,
)

Array = numpy.ndarray
COUNTS = pytest.mark.parametrize("count", [8, 14])
SMOOTH = numpy.array([False])


def values(monomials: Array, u: Array) -> Array:
    return numpy.vander(u, len(monomials), increasing=True) @ monomials


@COUNTS
def test_the_tail_bounds_what_a_polynomial_leaves_out(count: int) -> None:
    """Functions with one bend; the tail of smooth functions does not bound them: the control."""
    bends, u, tails = numpy.linspace(0, 1, 2000)[1:-1], numpy.linspace(-1, 1, 2001), []
    table, exact = (abs(x[:, None] - bends) for x in (nodes(count), (u + 1) / 2))
    for bent in (True, False):
        polynomials = through(table, numpy.full(len(bends), bent))
        tails.append(abs(values(polynomials.monomials, u) - exact).max(axis=0) / polynomials.tail)
    assert tails[0].max() <= 1
    assert tails[1].max() > 5
    # coefficients of a pole beside the interval fall by a factor of 2.8
    polynomials = through(1 / (nodes(count)[:, None] + 0.3), SMOOTH)
    distance = values(polynomials.monomials, u)[:, 0] - 1 / ((u + 1) / 2 + 0.3)
    assert abs(distance).max() <= polynomials.tail[0]


@COUNTS
def test_the_three_bases_have_one_polynomial(count: int) -> None:
    table = numpy.random.default_rng(count).normal(size=(count, 1))
    polynomials, u = through(table, SMOOTH), 2 * nodes(count) - 1
    assert values(polynomials.monomials, u) == pytest.approx(table, abs=1e-11)
    assert (polynomials.bernstein[[0, -1]] == table[[0, -1]]).all()
    last = numpy.polynomial.chebyshev.chebfit(u, table[:, 0], count - 1)
    assert polynomials.tail[0] == pytest.approx(abs(last[-3:]).sum(), rel=1e-10)
    middle = polynomials.bernstein
    while len(middle) > 1:  # de Casteljau at 1/2
        middle = (middle[1:] + middle[:-1]) / 2
    assert middle[0] == pytest.approx(polynomials.monomials[0], abs=1e-11)


def zeros_of(*polynomials: Any) -> list[list[tuple[float, int]]]:
    """Position in [0, 1] and direction of the zeros of each polynomial, all searched at once."""
    interpolants = through(numpy.array([p(nodes(9)) for p in polynomials]).T, SMOOTH)
    which, low, high, rising = isolated(interpolants.bernstein.T, MOST_BISECTIONS)
    direction = numpy.where(rising, 1, -1)
    u, _ = zero_between(interpolants.monomials[:, which], 2 * low - 1, 2 * high - 1, direction)
    zeros: list[list[tuple[float, int]]] = [[] for _ in polynomials]
    for k, position, sign in zip(which, (1 + u) / 2, direction, strict=True):
        zeros[k].append((float(position), int(sign)))
    return zeros


def test_every_zero_of_a_chebyshev_polynomial() -> None:
    (zeros,) = zeros_of(numpy.polynomial.Chebyshev.basis(8, domain=[0, 1]))
    exact = sorted((1 - numpy.cos((numpy.arange(8) + 0.5) * numpy.pi / 8)) / 2)
    assert [position for position, _ in zeros] == pytest.approx(exact, rel=0, abs=1e-14)
    assert [sign for _, sign in zeros] == [-1, 1] * 4


def test_crossings_of_polynomials_with_few_zeros() -> None:
    roots = {
        (0.25,): [0.25],
        (-0.5, 1.5): [],
        (0.3, 0.3 + 1e-6): [0.3, 0.3 + 1e-6],
        (0.4, 0.4, 0.4): [0.4],
        (1e-9,): [1e-9],
        (0.2, 0.7, 2.0): [0.2, 0.7],
    }
    polynomials = [numpy.polynomial.Polynomial.fromroots(zeros) for zeros in roots]
    for zeros, (known, inside) in zip(zeros_of(*polynomials), roots.items(), strict=True):
        # a zero of order k is off by the k-th root of a rounding
        bound = 1e-4 if len(set(known)) < len(known) else 1e-9
        assert [position for position, _ in zeros] == pytest.approx(inside, abs=bound)
        signs = [(-1) ** (len(known) + i + 1) for i in range(len(zeros))]
        assert [sign for _, sign in zeros] == signs
