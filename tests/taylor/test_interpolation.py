"""Polynomials through values at nodes: what they leave out; zeros of polynomials."""

from __future__ import annotations

import numpy
import pytest

from tt_precise.taylor.interpolation import (
    MOST_BISECTIONS,
    bernstein_of,
    isolated,
    nodes,
    through,
    zero_between,
)


@pytest.mark.parametrize("count", [8, 14])
def test_the_tail_bounds_what_a_bend_leaves_out(count: int) -> None:
    """The tail of smooth functions does not, which is the control."""
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


@pytest.mark.parametrize("count", [8, 14])
def test_the_three_bases_have_one_polynomial(count: int) -> None:
    values = numpy.random.default_rng(count).normal(size=(count, 1))
    polynomials = through(values, numpy.array([False]))
    powers = numpy.vander(2 * nodes(count) - 1, count, increasing=True)
    assert powers @ polynomials.monomials == pytest.approx(values, abs=1e-11)
    assert (polynomials.bernstein[[0, -1]] == values[[0, -1]]).all()
    last = numpy.polynomial.chebyshev.chebfit(2 * nodes(count) - 1, values[:, 0], count - 1)
    assert polynomials.tail[0] == pytest.approx(abs(last[-3:]).sum(), rel=1e-10)
    middle = polynomials.bernstein
    while len(middle) > 1:  # de Casteljau at 1/2
        middle = (middle[1:] + middle[:-1]) / 2
    assert middle[0] == pytest.approx(polynomials.monomials[0], abs=1e-11)


def with_zeros(zeros: list[float]) -> numpy.ndarray:
    return numpy.polynomial.polynomial.polyfromroots(zeros)


def found(*polynomials: numpy.ndarray) -> list[tuple[int, float, int]]:
    return zeros_of(numpy.array(polynomials))


def zeros_of(
    table: numpy.ndarray, first: numpy.ndarray | None = None
) -> list[tuple[int, float, int]]:
    """Polynomial, position and direction of each zero; ``first`` replaces the values at 0."""
    bernstein = bernstein_of(table)
    bernstein[:, 0] = table[:, 0] if first is None else first
    which, low, high, rising = isolated(bernstein, MOST_BISECTIONS)
    half = numpy.polynomial.Polynomial([0.5, 0.5])
    of_u = [numpy.polynomial.Polynomial(table[k])(half).coef for k in which]
    monomials = numpy.zeros((table.shape[1], len(which)))
    for column, coefficients in zip(monomials.T, of_u, strict=True):
        column[: len(coefficients)] = coefficients
    direction = numpy.where(rising, 1, -1)
    u, _ = zero_between(monomials, 2 * low - 1, 2 * high - 1, direction)
    return list(zip(which.tolist(), ((1 + u) / 2).tolist(), direction.tolist(), strict=True))


def test_every_zero_of_a_chebyshev_polynomial_is_found() -> None:
    n = 8
    shifted = numpy.polynomial.Chebyshev.basis(n, domain=[0, 1])
    power = shifted.convert(kind=numpy.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1])
    known = sorted((1 - numpy.cos((numpy.arange(n) + 0.5) * numpy.pi / n)) / 2)
    positions = [position for _, position, _ in found(power.coef)]
    # its coefficients of powers of x go up to 3e5
    assert numpy.allclose(positions, known, rtol=0, atol=1e-9)
    assert [sign for *_, sign in found(power.coef)] == [-1, 1] * 4


@pytest.mark.parametrize(
    ("zeros", "expected"),
    [
        ([0.25], [0.25]),
        ([-0.5, 1.5], []),
        ([0.3, 0.3 + 1e-6], [0.3, 0.3 + 1e-6]),
        ([0.3, 0.3], []),  # it touches and does not cross
        ([0.4, 0.4, 0.4], [0.4]),
        ([1e-12], [1e-12]),
    ],
)
def test_crossings_of_few_zeros(zeros: list[float], expected: list[float]) -> None:
    positions = [position for _, position, _ in found(with_zeros(zeros))]
    # a zero of order k is off by the k-th root of what rounding does
    assert positions == pytest.approx(expected, rel=1e-9, abs=1e-4 if len(set(zeros)) < 2 else 1e-9)


def test_several_polynomials_at_once_keep_apart() -> None:
    rows = [with_zeros([0.2, 0.7, 2.0]), with_zeros([3.0, 4.0, 5.0]), -with_zeros([0.5, 2.0, 3.0])]
    assert [(k, round(position, 9), sign) for k, position, sign in found(*rows)] == [
        (0, 0.2, 1), (0, 0.7, -1), (2, 0.5, -1),
    ]  # fmt: skip


@pytest.mark.parametrize("shift", [-1e-17, 0.0, 1e-17])
def test_a_zero_between_two_pieces_is_found_once(shift: float) -> None:
    """The function x - 1 in two pieces, whose roundings may disagree about its sign at 1."""
    pieces = numpy.array([[-1.0, 1.0 + shift], [shift, 1.0]])
    first = numpy.array([-1.0, pieces[0].sum()])
    ((piece, position, direction),) = zeros_of(pieces, first)
    assert direction == 1
    assert piece + position == pytest.approx(1)
