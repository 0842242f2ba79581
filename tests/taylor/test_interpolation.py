"""Polynomials through values at nodes: what they leave out; zeros of polynomials."""

import math

import numpy
import pytest

from tt_precise.taylor.interpolation import (
    MOST_BISECTIONS,
    MOST_PRODUCTS,
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


def test_many_polynomials_are_those_of_each() -> None:
    """More than one product of matrices holds, in two tables."""
    table = numpy.random.default_rng(1).normal(size=(2, 6, MOST_PRODUCTS // 50))
    polynomials = through(table, SMOOTH)
    for k in (0, 1, 2001, table.shape[2] - 1):
        alone = through(table[1, :, [k]].T, SMOOTH)
        assert polynomials.bernstein[1, :, k] == pytest.approx(alone.bernstein[:, 0], abs=1e-13)
        assert polynomials.tail[1, k] == pytest.approx(alone.tail[0], rel=1e-13)


def bernstein_of(table: Array) -> Array:
    """Return the coefficients in Bernstein's basis, from those of 1, x, x^2 ..."""
    last, numbers = table.shape[1] - 1, range(table.shape[1])
    shares = [[math.comb(i, j) / math.comb(last, j) for i in numbers] for j in numbers]
    bernstein: Array = table @ numpy.array(shares)
    return bernstein


def zeros_of(table: Array, first: Array | None = None) -> list[tuple[int, float, int]]:
    """Polynomial, position and direction of each zero; ``first`` replaces the values at 0."""
    bernstein = bernstein_of(table)
    bernstein[:, 0] = table[:, 0] if first is None else first
    which, low, high, rising = isolated(bernstein, MOST_BISECTIONS)
    direction = numpy.where(rising, 1, -1)
    x, _ = zero_between(table[which].T, low, high, direction)
    return list(zip(which.tolist(), x.tolist(), direction.tolist(), strict=True))


def with_zeros(zeros: list[float]) -> Array:
    return numpy.polynomial.polynomial.polyfromroots(zeros)


def test_every_zero_of_a_chebyshev_polynomial() -> None:
    shifted = numpy.polynomial.Chebyshev.basis(8, domain=[0, 1])
    power = shifted.convert(kind=numpy.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1])
    exact = sorted((1 - numpy.cos((numpy.arange(8) + 0.5) * numpy.pi / 8)) / 2)
    zeros = zeros_of(power.coef[None])
    # its coefficients of powers of x go up to 3e5
    assert [position for _, position, _ in zeros] == pytest.approx(exact, rel=0, abs=1e-9)
    assert [sign for *_, sign in zeros] == [-1, 1] * 4


@pytest.mark.parametrize(
    ("zeros", "expected"),
    [
        ([0.25], [0.25]),
        ([-0.5, 1.5], []),
        ([0.3, 0.3 + 1e-6], [0.3, 0.3 + 1e-6]),
        ([0.3, 0.3], []),  # a double zero
        ([0.4, 0.4, 0.4], [0.4]),
        ([1e-12], [1e-12]),
    ],
)
def test_crossings_of_few_zeros(zeros: list[float], expected: list[float]) -> None:
    positions = [position for _, position, _ in zeros_of(with_zeros(zeros)[None])]
    # a zero of order k is off by the k-th root of a rounding
    assert positions == pytest.approx(expected, rel=1e-9, abs=1e-4 if len(set(zeros)) < 2 else 1e-9)


def test_several_polynomials_at_once_keep_apart() -> None:
    rows = [with_zeros([0.2, 0.7, 2.0]), with_zeros([3.0, 4.0, 5.0]), -with_zeros([0.5, 2.0, 3.0])]
    zeros = [(k, round(position, 9), sign) for k, position, sign in zeros_of(numpy.array(rows))]
    assert zeros == [(0, 0.2, 1), (0, 0.7, -1), (2, 0.5, -1)]


@pytest.mark.parametrize("shift", [-1e-17, 0.0, 1e-17])
def test_a_zero_between_two_polynomials_counts_once(shift: float) -> None:
    """The function x - 1 in two pieces, whose roundings may disagree about its sign at 1."""
    pieces = numpy.array([[-1.0, 1.0 + shift], [shift, 1.0]])
    first = numpy.array([-1.0, pieces[0].sum()])
    ((piece, position, direction),) = zeros_of(pieces, first)
    assert direction == 1
    assert piece + position == pytest.approx(1)
