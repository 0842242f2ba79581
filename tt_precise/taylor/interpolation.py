"""Polynomials through values at Chebyshev's nodes, many at once: their signs, extrema and zeros.

Values at the nodes of an interval determine a polynomial whose distance from an analytic function
is about its last coefficients in Chebyshev's basis. Bernstein coefficients enclose its values.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy

from tt_precise.runtime.values import Array
from tt_precise.taylor.crossings import isolated, values

# Halvings of an interval between two zeros of a derivative; nearer zeros count as one.
MOST_BISECTIONS = 30
LAST = 4  # Chebyshev's coefficients that bound what a polynomial leaves out.
# Newton's steps square their length: behind one as short nothing is left in double.
SETTLED = 2.0**-26
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

    One product with it is faster than three, whose results need new memory each.
    """
    from mpmath import chebyt, cos, matrix, mp, pi

    n = count - 1
    with mp.workdps(60):
        positions = [-cos(pi * j / n) for j in range(count)]
        bases = (
            lambda u, k: math.comb(n, k) * (1 + u) ** k * (1 - u) ** (n - k) / 2**n,
            lambda u, k: chebyt(k, u),
            lambda u, k: u**k,
        )
        found = [
            matrix([[base(u, k) for k in range(count)] for u in positions]) ** -1 for base in bases
        ]
        bernstein, chebyshev, monomials = (
            numpy.array(inverse.tolist(), dtype=float) for inverse in found
        )
    return numpy.concatenate([bernstein, chebyshev[-LAST:], monomials])


def through(table: Array, bent: Array) -> Polynomials:
    """Return the polynomials through values at ``nodes``; the nodes are the last axis but one.

    ``bent`` marks those whose functions may have a bend.
    """
    count = table.shape[-2]
    coefficients = _matrix(count) @ table
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
    position, _ = zero_between(rates, low, high, numpy.where(rising, 1, -1))
    return which, position


def zero_between(
    monomials: Array, low: Array, high: Array, direction: Array
) -> tuple[Array, Array]:
    """Return the zero of each polynomial in a bracket of [0, 1], and the derivative at it.

    The polynomial rises (+1) or falls (-1) through zero in the bracket.
    """
    rows = monomials.T
    rates = rows[:, 1:] * numpy.arange(1, rows.shape[1])
    low, high = 2 * low - 1, 2 * high - 1
    u, rate = (low + high) / 2, 0 * low
    with numpy.errstate(all="ignore"):
        for _ in range(MOST_NEWTONS):
            value, rate = values(rows, u), values(rates, u)
            behind = value * direction >= 0
            low, high = numpy.where(behind, low, u), numpy.where(behind, u, high)
            nearer = u - value / rate
            nearer = numpy.where((nearer >= low) & (nearer <= high), nearer, (low + high) / 2)
            moved, u = abs(nearer - u), nearer
            if (moved <= SETTLED).all():
                break
    return (1 + u) / 2, 2 * rate
