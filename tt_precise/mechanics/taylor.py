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

from tt_precise.runtime.arithmetic import Array, Scalar


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

    def exp(self) -> TaylorSeries:
        """The exponential: e' = self' e."""
        found = numpy.empty_like(self.c)
        found[0] = numpy.exp(self.c[0])
        for k in range(1, len(found)):
            found[k] = sum(j * self.c[j] * found[k - j] for j in range(1, k + 1)) / k
        return TaylorSeries(found)

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

    @staticmethod
    def exp(value: TaylorSeries) -> TaylorSeries:
        """The exponential."""
        return value.exp()


class Growing:
    """A series that gets its coefficients one after the other, each from those of its parts.

    ``step(c, k)`` gives coefficient k from those of ``parts``, which stand before it on the tape.
    """

    __slots__ = ("c", "parts", "step", "tape")
    __array_ufunc__ = None

    def __init__(
        self,
        tape: SeriesTape,
        step: Callable[[numpy.ndarray, int], Array],
        *parts: Scalar,
    ):
        self.c = numpy.zeros(tape.shape, tape.kind)
        self.tape, self.step = tape, step
        self.parts = [part for part in parts if isinstance(part, Growing)]
        tape.nodes.append(self)

    def _once(
        self, what: str, other: Scalar, step: Callable[[numpy.ndarray, int], Array]
    ) -> Growing:
        """The series of an operation with ``other``; the same one where it was asked for before."""
        # 0 is equal to -0, and arrays to nothing
        if not isinstance(other, Growing) and (type(other) not in (int, float) or not other):
            return Growing(self.tape, step, self)
        known, key = self.tape.known, (what, self, type(other), other)
        if key not in known:
            known[key] = Growing(self.tape, step, self, other)
        return known[key]

    def __add__(self, other: Scalar) -> Growing:
        a = self.c
        if isinstance(other, Growing):
            b = other.c
            return self._once("+", other, lambda c, k: a[k] + b[k])
        return self._once("+", other, lambda c, k: a[k] + other if k == 0 else a[k])

    __radd__ = __add__

    def __neg__(self) -> Growing:
        a = self.c
        return self._once("-", self, lambda c, k: -a[k])

    def __sub__(self, other: Scalar) -> Growing:
        a = self.c
        if isinstance(other, Growing):
            b = other.c
            return self._once("a - b", other, lambda c, k: a[k] - b[k])
        return self + -other

    def __rsub__(self, other: Scalar) -> Growing:
        return -self + other

    def __mul__(self, other: Scalar) -> Growing:
        a = self.c
        if not isinstance(other, Growing):
            return self._once("*", other, lambda c, k: a[k] * other)
        b, product = other.c, self.tape.product
        return self._once("*", other, lambda c, k: product(a[: k + 1], b[k::-1]))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Growing:
        a = self.c
        if not isinstance(other, Growing):
            return self._once("/", other, lambda c, k: a[k] / other)
        b, product = other.c, self.tape.product
        return self._once("/", other, lambda c, k: (a[k] - product(c[:k], b[k:0:-1])) / b[0])

    def __rtruediv__(self, other: Scalar) -> Growing:
        b, product = self.c, self.tape.product
        return self._once(
            "1/",
            other,
            lambda c, k: ((other if k == 0 else 0.0) - product(c[:k], b[k:0:-1])) / b[0],
        )

    def sqrt(self) -> Growing:
        """The positive root; its first coefficient is not zero."""
        a, product = self.c, self.tape.product
        return self._once(
            "root",
            self,
            lambda c, k: (
                (a[k] - product(c[1:k], c[k - 1 : 0 : -1])) / (2 * c[0]) if k else numpy.sqrt(a[0])
            ),
        )

    def exp(self) -> Growing:
        """The exponential: e' = self' e."""
        a, product = self.c, self.tape.product

        def step(c: numpy.ndarray, k: int) -> Array:
            if not k:
                return numpy.exp(a[0])
            return product(numpy.arange(1, k + 1)[:, None] * a[1 : k + 1], c[k - 1 :: -1]) / k

        return self._once("exp", self, step)


class SeriesTape:
    """Series in the order in which their coefficients can be computed.

    ``dot`` is the scalar product of one row of numbers that are objects, such as mpmath's.
    """

    def __init__(self, terms: int, rows: int, dot: Callable[[Array, Array], Scalar] | None = None):
        self.shape, self.kind = (terms + 1, rows), object if dot else float
        self.product = (lambda a, b: dot(a[:, 0], b[:, 0])) if dot else _product
        self.nodes: list[Growing] = []
        self.known: dict[tuple[Any, ...], Growing] = {}  # by operation and operands

    def needed(self, wanted: Sequence[Scalar]) -> list[Growing]:
        """The series that those ``wanted`` are made of, these included, in order."""
        found = {one for one in wanted if isinstance(one, Growing)}
        for node in reversed(self.nodes):
            if node in found:
                found.update(node.parts)
        return [node for node in self.nodes if node in found]


def _product(a: numpy.ndarray, b: numpy.ndarray) -> numpy.ndarray:
    found: numpy.ndarray = numpy.einsum("kr,kr->r", a, b)
    return found


PIECE = 2048  # rows at a time, so that all intermediate series stay in the cache


def solution(
    rates: Callable[[tuple[Scalar, ...]], Sequence[Scalar]],
    start: Sequence[numpy.ndarray],
    terms: int,
) -> tuple[TaylorSeries, ...]:
    """Taylor series, with ``terms`` + 1 coefficients, of the solution through every row.

    ``rates`` is an autonomous right-hand side that holds for every row alike; ``start`` holds one
    array for each entry of the state.
    """
    rows = len(start[0])
    c = numpy.empty((len(start), terms + 1, rows))
    for first in range(0, rows, PIECE):
        piece = slice(first, min(first + PIECE, rows))
        tape = SeriesTape(terms, piece.stop - piece.start)
        entries = [Growing(tape, lambda c, k: c[k]) for _ in start]
        slopes = rates(tuple(entries))
        for entry, value in zip(entries, start, strict=True):
            entry.c[0] = value[piece]
        operations = [node for node in tape.needed(slopes) if node not in entries]
        for k in range(terms):
            for node in operations:
                node.c[k] = node.step(node.c, k)
            for entry, slope in zip(entries, slopes, strict=True):
                if isinstance(slope, Growing):
                    entry.c[k + 1] = slope.c[k] / (k + 1)
                else:
                    entry.c[1] = slope
        for whole, entry in zip(c, entries, strict=True):
            whole[:, piece] = entry.c
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
