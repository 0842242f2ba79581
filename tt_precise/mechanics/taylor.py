"""Truncated power series in time: an arithmetic in which the equations give derivatives.

A ``TaylorSeries`` is a scalar like any other to the functions of ``mechanics``; its coefficients
are NumPy arrays over the rows of a trajectory. Run through the equations of motion it yields the
Taylor coefficients of the solution through every row, with no formula written again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy

from tt_precise.arithmetic import Scalar


class TaylorSeries:
    """``sum(c[k] h**k)``, truncated; ``c`` has shape (terms, rows)."""

    __slots__ = ("c",)
    __array_ufunc__ = None  # so that array * TaylorSeries is left to TaylorSeries

    def __init__(self, c: numpy.ndarray):
        self.c = c

    def __add__(self, other: Scalar) -> TaylorSeries:
        if isinstance(other, TaylorSeries):
            return TaylorSeries(self.c + other.c)
        c = self.c.copy()
        c[0] += other
        return TaylorSeries(c)

    __radd__ = __add__

    def __neg__(self) -> TaylorSeries:
        return TaylorSeries(-self.c)

    def __sub__(self, other: Scalar) -> TaylorSeries:
        return self + -other

    def __rsub__(self, other: Scalar) -> TaylorSeries:
        return -self + other

    def __mul__(self, other: Scalar) -> TaylorSeries:
        if not isinstance(other, TaylorSeries):
            return TaylorSeries(self.c * other)
        terms = len(self.c)
        product = self.c[0] * other.c
        for k in range(1, terms):
            product[k:] += self.c[k] * other.c[: terms - k]
        return TaylorSeries(product)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> TaylorSeries:
        if not isinstance(other, TaylorSeries):
            return TaylorSeries(self.c / other)
        quotient = numpy.empty(numpy.broadcast_shapes(self.c.shape, other.c.shape))
        for k in range(len(quotient)):
            known = sum(quotient[j] * other.c[k - j] for j in range(k))
            quotient[k] = (self.c[k] - known) / other.c[0]
        return TaylorSeries(quotient)

    def __rtruediv__(self, other: Scalar) -> TaylorSeries:
        constant = numpy.zeros_like(self.c)
        constant[0] = other
        return TaylorSeries(constant) / self

    def sqrt(self) -> TaylorSeries:
        """The positive root; its first coefficient is not zero."""
        root = numpy.empty_like(self.c)
        root[0] = numpy.sqrt(self.c[0])
        for k in range(1, len(root)):
            known = sum(root[j] * root[k - j] for j in range(1, k))
            root[k] = (self.c[k] - known) / (2 * root[0])
        return TaylorSeries(root)

    @property
    def rate(self) -> numpy.ndarray:
        """Coefficients of the time derivative, shape (terms - 1, rows)."""
        return self.c[1:] * numpy.arange(1, len(self.c))[:, None]


class SeriesFunctions:
    """The elementary functions of series, as the ``fn`` of ``mechanics``."""

    @staticmethod
    def sqrt(value: TaylorSeries) -> TaylorSeries:
        """The positive root."""
        return value.sqrt()


def solution(
    rates: Callable[[tuple[TaylorSeries, ...]], Sequence[Any]],
    start: Sequence[numpy.ndarray],
    terms: int,
) -> tuple[TaylorSeries, ...]:
    """Taylor series, with ``terms`` + 1 coefficients, of the solution through every row.

    ``rates`` is an autonomous right-hand side; ``start`` holds one array for each entry of the
    state.
    """
    rows = len(start[0])
    c = numpy.zeros((len(start), terms + 1, rows))
    c[:, 0] = start
    for k in range(terms):
        truncated = tuple(TaylorSeries(entry[: k + 1]) for entry in c)
        for entry, rate in zip(c, rates(truncated), strict=True):
            entry[k + 1] = rate.c[k] / (k + 1) if isinstance(rate, TaylorSeries) else 0
    return tuple(map(TaylorSeries, c))


def integral(
    left: numpy.ndarray, right: numpy.ndarray, steps: numpy.ndarray, terms: int
) -> numpy.ndarray:
    """Integrals over intervals of functions with these Taylor coefficients at both ends.

    Hermite's two-point rule with ``terms`` coefficients at either end, exact for polynomials of
    degree 2 ``terms`` - 1. ``left`` and ``right`` have shape (functions, terms or more,
    intervals); the result has shape (functions, intervals).
    """
    total = numpy.zeros((len(left), len(steps)))
    power = numpy.array(steps)
    for j, weight in enumerate(_hermite_weights(terms)):
        other = right[:, j] if j % 2 == 0 else -right[:, j]
        total += weight * power * (left[:, j] + other)
        power = power * steps
    return total


def _hermite_weights(terms: int) -> list[float]:
    f, m = math.factorial, terms
    return [f(m) * f(2 * m - j - 1) / (f(2 * m) * f(m - j - 1) * (j + 1)) for j in range(m)]
