"""Guesses for the kernel, none of which is trusted: a bad one is refused, or widens an enclosure.

The theorem holds for any polynomials, positive weights, invertible basis and length of a step. Good
ones are Taylor polynomials, the eigenvector of Perron and Frobenius, an orthogonal basis, and a
length that follows from the costs of the step before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import add, mul, neg
from typing import Any

import numpy
from flint import arb, arb_mat, arb_poly, fmpz
from gmpy2 import isqrt, mpz

from tt_precise.certify.balls import Balls, NotProved
from tt_precise.certify.models import Frame, Operation, Rates, inverse

FINER = 8  # Bits of the polynomials beyond those that are asked for.
TERMS = 80  # The flow's polynomial has at most so many; strong damping makes them large at first.
SMALL = 1e-12  # The flow's polynomial ends where its terms are smaller: q is about as large.
LEAST = 2.0**-5  # Least off-diagonal entry, relative to the largest, where weights are chosen.

FIRST = 2.0**-3  # Length of the first step.
LONGER = 1.25  # A step is at most so much longer than the one before it.
AGAIN = 0.8  # A step that should have been shorter than this, relatively, is made again.
SHORTER = 0.95  # A step that is made again has this part of the length that its costs ask for.
MOST_FAILURES = 12  # Steps in a row that are made again, most half as long as the one before.
# Before an undecided instant steps get ever shorter; in golden scenes they are 1000 times as long.
SHORTEST = 2.0**-24
DEFECT_BITS = 5  # A step may add this many bits to a rounding error of its polynomials.
FLOW_ERROR = 1e-5  # Largest q G: growth of an error in a step by the error of its flow, relative.
GROWTH = 1e5  # Largest exp(a S): the bound within a step over the bound at its end.


def moving(rates: Rates, start: Sequence[arb], tube: arb) -> list[int]:
    """Return the components that do not stay zero, where errors are as large as ``tube``."""
    free = [i for i, x in enumerate(start) if not x.is_zero()]
    while True:
        changes = rates([x + tube if i in free else arb(0) for i, x in enumerate(start)])
        more = [i for i, x in enumerate(changes) if i in free or not arb(x).is_zero()]
        if more == free:
            return free
        free = more


def taylor(rates: Rates, start: Sequence[arb], length: arb) -> list[arb_poly]:
    """Return the Taylor polynomials of the solution through ``start``.

    Coefficients are whole numbers in units of 2^-bits, and of the same size, as time is in units of
    a power of two in which the step is 1/2 to 1 long.
    """
    bits, (mantissa, exponent) = rates.bits + FINER, length.man_exp()
    power = int(exponent) + int(mantissa).bit_length()
    unit = mpz(1) << max(0, bits + power)
    series = {x: [_whole(y, bits)] for x, y in zip(rates.components, start, strict=True)}

    def operand(x: Any) -> list[mpz]:
        """Coefficients, to be computed; a constant has one."""
        if not isinstance(x, Operation):
            return [_whole(arb(x), bits)]
        return series.setdefault(x, [])

    steps = [
        (RULES[node.formula[0]], operand(node), [operand(x) for x in node.formula[1:]])
        for node in rates.operations
    ]
    slopes = [operand(x) for x in rates.results]
    for n in range(rates.order):
        for rule, coefficients, operands in steps:
            coefficients.append(rule(coefficients, n, bits, *operands))
        for x, slope in zip(rates.components, slopes, strict=True):
            series[x].append((slope[n] * unit >> bits) // (n + 1) if n < len(slope) else mpz(0))
    scales = [arb(2) ** (-power * n - bits) for n in range(rates.order + 1)]
    return [
        arb_poly([(arb(fmpz(int(c))) * y).mid() for c, y in zip(series[x], scales, strict=True)])
        for x in rates.components
    ]


def _whole(x: arb, bits: int) -> mpz:
    """Return the whole number near the middle of a ball, in units of 2^-bits.

    Raises ``NotProved``: the ball is not finite.
    """
    if not x.is_finite():
        raise NotProved("S2", "a number of the equations is not finite")
    return mpz(int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz()))


def _product(c: list[mpz], n: int, bits: int, a: list[mpz], b: list[mpz]) -> mpz:
    return (sum(map(mul, a, b[::-1])) if n < len(b) else a[n] * b[0]) >> bits


def _reciprocal(c: list[mpz], n: int, bits: int, a: list[mpz]) -> mpz:
    if not n:
        return (1 << 2 * bits) // a[0]
    return -((sum(map(mul, c, a[:0:-1])) >> bits) * c[0] >> bits)


def _root(c: list[mpz], n: int, bits: int, a: list[mpz]) -> mpz:
    if not n:
        return isqrt(abs(a[0]) << bits)
    return ((a[n] << bits) - sum(map(mul, c[1:], c[:0:-1]))) // (2 * c[0])


def _exponential(c: list[mpz], n: int, bits: int, a: list[mpz]) -> mpz:
    """From c' = a' c."""
    if not n:
        return _whole((arb(fmpz(int(a[0]))) * arb(2) ** -bits).exp(), bits)
    return (sum(map(mul, [k * x for k, x in enumerate(a) if k], c[::-1])) >> bits) // n


# The n-th coefficient c[n] of an operation, from those before and the operands a and b.
RULES: dict[Callable[..., Any], Callable[..., mpz]] = {
    add: lambda c, n, bits, a, b: a[n] + b[n] if n < len(b) else a[n],
    neg: lambda c, n, bits, a: -a[n],
    mul: _product,
    inverse: _reciprocal,
    Balls.sqrt: _root,
    Balls.exp: _exponential,
}


def weights(band: Sequence[Sequence[arb]]) -> list[arb]:
    """Return weights for which the logarithmic norm of a matrix is small.

    The rows of a matrix with positive entries off the diagonal have equal sums in the norm that
    belongs to its eigenvector of Perron and Frobenius, and no other norm has a smaller largest sum.
    """
    entries = numpy.array([[float(x.abs_upper()) for x in row] for row in band])
    if not entries.size or not numpy.isfinite(entries).all():
        return [arb(1)] * len(band)
    diagonal = [float(row[i].upper()) for i, row in enumerate(band)]
    entries = numpy.maximum(entries, (entries.max() or 1.0) * LEAST)
    numpy.fill_diagonal(entries, diagonal)
    values, vectors = numpy.linalg.eig(entries)
    vector = numpy.abs(vectors[:, values.real.argmax()].real)
    return [arb(x) for x in (vector / vector.max()).tolist()]


def flow(jacobian: Sequence[Sequence[arb_poly]], low: Frame) -> list[list[arb_poly]]:
    """Return polynomials near the solution of P' = M P, P(0) = 1, for the middle M of a band."""
    n = len(jacobian)
    M = numpy.zeros((low.degree + 1, n, n))
    for i, row in enumerate(jacobian):
        for j, entry in enumerate(row):
            for k, c in enumerate(entry.coeffs()):
                M[k, i, j] = float(c.mid())
    terms, length, sizes = [numpy.eye(n)], float(low.end), [1.0]
    # two terms in turn, as even or odd ones may vanish
    while n and len(terms) < TERMS and max(sizes[-2:]) > SMALL:
        k = len(terms)
        terms.append(sum(M[i] @ terms[k - 1 - i] for i in range(min(k, len(M)))) / k)
        sizes.append(numpy.abs(terms[k]).max() * length**k)
    return [[arb_poly([term[i, j] for term in terms]) for j in range(n)] for i in range(n)]


def basis(image: arb_mat, box: arb_mat) -> arb_mat:
    """Return an orthogonal basis for the next set of errors, its longest edge first."""
    edges = numpy.array([float(x.abs_upper()) for x in box.entries()])
    if not edges.size:
        return image
    columns = numpy.array([[float(x.mid()) for x in row] for row in image.tolist()])
    lengths = numpy.linalg.norm(columns, axis=0) * (edges / (edges.max() or 1.0) + 1e-30)
    factor, _ = numpy.linalg.qr(columns[:, numpy.argsort(-lengths, kind="stable")])
    return arb_mat(factor.tolist())


class Lengths:
    """Lengths of steps, each from the costs of the step before."""

    def __init__(self, rates: Rates):
        self.rates, self._length, self.failures = rates, FIRST, 0
        self._why: ArithmeticError = NotProved("time", "the solution may end here")

    def next(self, left: float) -> arb:
        """Return the length of a step that goes little further than a time ``left``.

        Raises ``NotProved``: steps have become too short.
        """
        if self._length < SHORTEST:
            raise self._why
        self._length = min(self._length, left * (1 + 1e-9) + 1e-9)
        mantissa, exponent = math.frexp(self._length)
        # a short mantissa, which is exact in any arithmetic
        return arb(int(mantissa * 2**24)) * arb(2) ** (exponent - 24)

    def accepts(self, length: arb, costs: Sequence[arb]) -> bool:
        """Choose the next length by the costs of a step; False if the step should be repeated."""
        defect, error, growth = (float(x) for x in costs)
        order = self.rates.order
        allowed = 2.0 ** (DEFECT_BITS - self.rates.bits) * order
        factor = min(
            LONGER,
            (allowed / max(defect, 1e-300)) ** (1 / order),
            (FLOW_ERROR / max(error, 1e-30)) ** (1 / 11),  # models of degree 10 bound the flow
            math.log(GROWTH) / max(math.log(growth), 1e-9),
        )
        # where shorter steps do not cost less, the enclosure is as good as the precision allows
        good = factor >= AGAIN or self.failures >= MOST_FAILURES
        self._length = float(length) * (factor if good else max(factor, 0.1) * SHORTER)
        self.failures += not good
        return good

    def shorten(self, why: ArithmeticError) -> None:
        """Halve the length of a step that could not be verified.

        Raises ``NotProved``: shorter steps do not help.
        """
        self.failures += 1
        self._length /= 2
        self._why = why if isinstance(why, NotProved) else NotProved("S2", str(why))
        if self.failures > MOST_FAILURES:
            raise self._why from None
