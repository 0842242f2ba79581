"""Polynomials through values at Chebyshev's nodes, many at once: their signs, extrema and zeros.

Values at the nodes of an interval determine a polynomial whose distance from an analytic function
is about its last coefficients in Chebyshev's basis. Bernstein coefficients enclose its values: a
polynomial has at most as many zeros as the coefficients have sign changes, and the two counts
differ by an even number. So counts of none and one are exact; for other counts the interval is
halved.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy

from tt_precise.runtime.values import Array

# Halvings of an interval between two zeros of a derivative; nearer zeros count as one.
MOST_BISECTIONS = 30
LAST = 4  # Chebyshev's coefficients that bound what a polynomial leaves out.
COSINE_BITS = 200  # Bits of the cosines of the nodes, of which conversions lose some 20.
# Length of a step of Newton's that is not taken. Lengths are squared from step to step, so that the
# next one is a length times the square of its ratio to the one before.
SETTLED = 2.0**-53
MOST_PRODUCTS = 2**18  # Multiplications of a matrix product; of more BLAS makes several threads.
MOST_NEWTONS = 60  # steps to a zero, of which most are halvings where Newton's leave the bracket


class Polynomials(NamedTuple):
    """Polynomials on intervals, the last axis of each array.

    ``bernstein`` has their coefficients on [0, 1], ``monomials`` those of powers of u in [-1, 1].
    ``tail`` bounds what is left out: the sum of the last three of Chebyshev's coefficients, where
    these fall by a factor of 2 or more; that of the last four times the number of nodes, where the
    function may have one bend anywhere.
    """

    bernstein: Array
    tail: Array
    monomials: Array


@cache
def nodes(count: int) -> Array:
    """Chebyshev's extrema on [0, 1], both ends included."""
    return (1 - numpy.cos(math.pi * numpy.arange(count) / (count - 1))) / 2


@cache
def _matrix(count: int) -> Array:
    """Matrix from values at the nodes to coefficients: Bernstein's, the last Chebyshev's, monomial.

    One product with it is faster than three, whose results need new memory each. Cosines are
    integers of ``COSINE_BITS``, and the rest is exact, so that each entry is rounded once.
    """
    from mpmath import mp, mpf

    n, numbers = count - 1, range(count)
    with mp.workprec(2 * COSINE_BITS):
        turn = [int(mp.ldexp(mp.cospi(mpf(j) / n), COSINE_BITS)) for j in range(2 * n)]
    ends = [1 if j in (0, n) else 2 for j in numbers]
    # the discrete cosine transform, at nodes that rise from -1
    chebyshev = numpy.array(
        [[(-1) ** k * ends[j] * ends[k] * turn[j * k % (2 * n)] for j in numbers] for k in numbers],
        dtype=object,
    )
    monomial = numpy.zeros((count, count), dtype=object)
    monomial[0, 0] = monomial[1, 1] = 1
    for k in numbers[2:]:
        monomial[1:, k] = 2 * monomial[:-1, k - 1]
        monomial[:, k] -= monomial[:, k - 2]
    bernstein = numpy.array([[_shares(n, i, j) for j in numbers] for i in numbers], dtype=object)
    scale = 2 * n * 2**COSINE_BITS
    shares = numpy.array([[scale * math.comb(n, i)] for i in numbers], dtype=object)
    monomial = monomial @ chebyshev
    parts = bernstein @ monomial / shares, chebyshev[-LAST:] / scale, monomial / scale
    return numpy.concatenate(parts).astype(float)


def _shares(n: int, i: int, j: int) -> int:
    """C(n, i) times Bernstein's coefficient i, in degree n, of u^j.

    The power is a product of j factors x - (1 - x) and n - j factors x + (1 - x).
    """
    terms = range(min(i, j) + 1)
    return sum((-1) ** (j - k) * math.comb(j, k) * math.comb(n - j, i - k) for k in terms)


def through(table: Array, bent: Array) -> Polynomials:
    """Return the polynomials through values at ``nodes``; the nodes are the last axis but one.

    ``bent`` marks those whose functions may have a bend.
    """
    count, matrix = table.shape[-2], _matrix(table.shape[-2])
    coefficients = numpy.empty((*table.shape[:-2], len(matrix), table.shape[-1]))
    for first in range(0, table.shape[-1], MOST_PRODUCTS // matrix.size):
        columns = slice(first, first + MOST_PRODUCTS // matrix.size)
        numpy.matmul(matrix, table[..., columns], out=coefficients[..., columns])
    last = abs(coefficients[..., count : count + LAST, :])
    tail = last[..., 1:, :].sum(axis=-2)
    if bent.any():
        tail = numpy.where(bent, count * (tail + last[..., 0, :]), tail)
    return Polynomials(coefficients[..., :count, :], tail, coefficients[..., count + LAST :, :])


def sign_changes(bernstein: Array, error: Array) -> tuple[Array, Array]:
    """Return the count of sign changes of the coefficients, and if errors keep it at 0 or 1.

    Without a change the polynomial has no zero on the interval, with one it has one.
    """
    counts = []
    for aside in (0.0, error, -error):
        negative = bernstein < aside
        counts.append(numpy.add.reduce(negative[1:] ^ negative[:-1], axis=0, dtype=numpy.int8))
    certain = (counts[0] == counts[1]) & (counts[0] == counts[2]) & (counts[0] <= 1)
    return counts[0], certain


def extrema(polynomials: Polynomials) -> tuple[Array, Array]:
    """Return the polynomials' local extrema: index of the polynomial, position in [0, 1]."""
    slopes = numpy.diff(polynomials.bernstein, axis=0).T
    which, low, high, rising = isolated(slopes, MOST_BISECTIONS)
    degrees = numpy.arange(1, len(polynomials.monomials))[:, None]
    rates = (polynomials.monomials[1:] * degrees)[:, which]
    u, _ = zero_between(rates, 2 * low - 1, 2 * high - 1, numpy.where(rising, 1, -1))
    return which, (1 + u) / 2


def zero_between(
    polynomials: Array, low: Array, high: Array, direction: Array, start: Array | None = None
) -> tuple[Array, Array]:
    """Return the zero of each polynomial between two positions, and the derivative at it.

    By Newton's steps, which begin at ``start``, and halvings where these leave the bracket.
    ``polynomials`` are coefficients of 1, x, x^2 ..., shape (terms, polynomials); they rise (+1) or
    fall (-1) through zero in the bracket. The bits of a zero do not depend on other polynomials.
    """
    at = (low + high) / 2 if start is None else start
    zero, slope, open_, last = at.copy(), 0 * at, numpy.arange(len(at)), high - low
    both = numpy.zeros((len(polynomials), 2, len(at)))  # coefficients of values and derivatives
    both[:, 0] = polynomials
    both[:-1, 1] = polynomials[1:] * numpy.arange(1, len(polynomials))[:, None]
    with numpy.errstate(all="ignore"):
        for _ in range(MOST_NEWTONS):
            value, rate = sums = both[-1].copy()
            for coefficients in both[-2::-1]:
                sums *= at
                sums += coefficients
            behind = value * direction >= 0
            low, high = numpy.where(behind, low, at), numpy.where(behind, at, high)
            nearer = at - value / rate
            nearer = numpy.where((nearer >= low) & (nearer <= high), nearer, (low + high) / 2)
            zero[open_], slope[open_] = nearer, rate
            length = abs(nearer - at)
            moving = numpy.flatnonzero(length * (length / last) ** 2 > SETTLED)
            if not len(moving):
                break
            if len(moving) < len(at):
                open_, nearer, length = open_[moving], nearer[moving], length[moving]
                low, high, direction = low[moving], high[moving], direction[moving]
                both = numpy.take(both, moving, axis=2)
            at, last = nearer, length
    return zero, slope


def isolated(bernstein: Array, halvings: int) -> tuple[Array, Array, Array, Array]:
    """Intervals with one zero each, of polynomials given by Bernstein's coefficients on [0, 1].

    Returns which polynomial, the two ends, and whether it rises there, in the order of positions.
    After the last halving two zeros count as none, and three as one.
    """
    which, low = numpy.arange(len(bernstein)), numpy.zeros(len(bernstein))
    width, intervals = 1.0, []
    for halving in range(halvings + 1):
        negative = bernstein < 0
        changes = numpy.count_nonzero(negative[:, 1:] != negative[:, :-1], axis=1)
        single = changes % 2 == 1 if halving == halvings else changes == 1
        intervals.append((which[single], low[single], low[single] + width, negative[single, 0]))
        several = changes > 1
        if not several.any():
            break
        which, low, (lower, upper) = which[several], low[several], halves(bernstein[several])
        width /= 2
        which, low = numpy.tile(which, 2), numpy.concatenate((low, low + width))
        bernstein = numpy.concatenate((lower, upper))
    which, low, high, rising = (numpy.concatenate(limb) for limb in zip(*intervals, strict=True))
    order = numpy.lexsort((low, which))
    return which[order], low[order], high[order], rising[order]


def halves(bernstein: Array) -> tuple[Array, Array]:
    """Bernstein's coefficients between 0 and 1/2, and between 1/2 and 1; de Casteljau."""
    lower, upper, row = numpy.empty_like(bernstein), numpy.empty_like(bernstein), bernstein
    for k in range(bernstein.shape[1]):
        lower[:, k], upper[:, -1 - k] = row[:, 0], row[:, -1]
        row = (row[:, 1:] + row[:, :-1]) / 2
    return lower, upper
