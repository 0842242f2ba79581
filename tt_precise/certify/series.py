"""Power series in the start: a whole set of solutions as polynomials in u, |u_i| <= 1.

Terms are keyed by their monomial: () for 1, (0,) for u_0, (0, 1) for u_0 u_1, (1, 1) for u_1^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Self

from flint import arb

from tt_precise.certify.balls import Balls, around
from tt_precise.certify.bands import Band
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar

Monomial = tuple[int, ...]


def monomials(variables: int, degree: int) -> list[Monomial]:
    """All of at most this degree."""
    return [
        one
        for size in range(degree + 1)
        for one in combinations_with_replacement(range(variables), size)
    ]


class StartSeries:
    """A power series in u over any arithmetic, cut off behind ``degree``."""

    def __init__(self, terms: Mapping[Monomial, Scalar], degree: int):
        self.terms, self.degree = terms, degree

    def _like(self, terms: Mapping[Monomial, Scalar]) -> Self:
        return type(self)(terms, self.degree)

    def __add__(self, other: Scalar) -> Self:
        found = dict(self.terms)
        for key, term in (other.terms if isinstance(other, StartSeries) else {(): other}).items():
            found[key] = found[key] + term if key in found else term
        return self._like(found)

    __radd__ = __add__

    def __neg__(self) -> Self:
        return self._like({key: -term for key, term in self.terms.items()})

    def __sub__(self, other: Scalar) -> Self:
        return self + (-other)

    def __rsub__(self, other: Scalar) -> Self:
        return -self + other

    def __mul__(self, other: Scalar) -> Self:
        if not isinstance(other, StartSeries):
            return self._like({key: term * other for key, term in self.terms.items()})
        found: dict[Monomial, Scalar] = {}
        for i, a in self.terms.items():
            for j, b in other.terms.items():
                if len(i) + len(j) <= self.degree:
                    key = tuple(sorted(i + j))
                    found[key] = found[key] + a * b if key in found else a * b
        return self._like(found)

    __rmul__ = __mul__

    def inverse(self) -> Self:
        """1/g = (1 - z + z^2 - ...)/g_0, where g = g_0 (1 + z)."""
        first = 1 / self.terms[()]
        z = self._like({key: term * first for key, term in self.terms.items() if key})
        return (z.polynomial([(-1) ** k for k in range(self.degree + 1)]) + z.beyond()) * first

    def beyond(self) -> Scalar:
        """What (1 - z + z^2 - ...) has behind the terms that are kept."""
        return 0

    def polynomial(self, coefficients: Sequence[Scalar]) -> Self:
        """That polynomial of it, which begins with the constant coefficient."""
        *rest, last = coefficients
        total = self._like({(): last})
        for coefficient in reversed(rest):
            total = self * total + coefficient
        return total

    def __truediv__(self, other: Scalar) -> Self:
        if isinstance(other, StartSeries):
            return self * other.inverse()
        return self._like({key: term / other for key, term in self.terms.items()})

    def __rtruediv__(self, other: Scalar) -> Self:
        return self.inverse() * other


class Fan(StartSeries):
    """All functions of u within a series over balls or bands: what is cut off is added to these."""

    @cached_property
    def sizes(self) -> list[arb]:
        """Bounds of the terms of each degree, summed up."""
        found = [arb(0)] * (self.degree + 1)
        for key, term in self.terms.items():
            found[len(key)] += arb(term.range if isinstance(term, Band) else term).abs_upper()
        return [one.upper() for one in found]

    @property
    def size(self) -> arb:
        """A bound of its absolute value."""
        return sum(self.sizes, start=arb(0)).upper()

    @property
    def range(self) -> arb:
        """A ball that contains it, over balls."""
        return arb(self.terms.get((), 0)) + around(sum(self.sizes[1:], start=arb(0)).upper())

    def __mul__(self, other: Scalar) -> Self:
        found = super().__mul__(other)
        if not isinstance(other, Fan):
            return found
        lost = sum(
            (
                a * sum(other.sizes[max(0, self.degree + 1 - i) :], start=arb(0))
                for i, a in enumerate(self.sizes)
            ),
            start=arb(0),
        )
        return found + around(lost.upper()) if lost > 0 else found

    def beyond(self) -> Scalar:
        """z^(n + 1)/(1 + z), but for its sign; ``NotProved`` where 1 + z may be zero."""
        size = self.size
        if not size < 1:
            raise NotProved("division", "a divisor may be zero for some start")
        return around((size ** (self.degree + 1) / (1 - size)).upper())


class FanFunctions(Balls):
    """Sine and cosine of a fan over balls."""

    @staticmethod
    def sin(x: Scalar) -> Scalar:
        """Sine."""
        return _wave(x, 0) if isinstance(x, Fan) else Balls.sin(x)

    @staticmethod
    def cos(x: Scalar) -> Scalar:
        """Cosine."""
        return _wave(x, 1) if isinstance(x, Fan) else Balls.cos(x)


def _wave(x: Fan, quarters: int) -> Fan:
    """sin(x + quarters pi/2), by Taylor's theorem: no derivative is larger than 1."""
    middle = x.terms[()]
    sine, cosine = middle.sin(), middle.cos()
    turns = (sine, cosine, -sine, -cosine)
    z = Fan({key: term for key, term in x.terms.items() if key}, x.degree)
    factorial, coefficients = arb(1), []
    for k in range(x.degree + 2):
        factorial *= max(k, 1)
        coefficients.append(turns[(k + quarters) % 4] / factorial)
    rest = around((z.size ** (x.degree + 1) / factorial).upper())
    return z.polynomial(coefficients[:-1]) + rest
