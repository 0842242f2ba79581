"""The arithmetics of the second checker, its own: integers, balls, derivatives, formal numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt
from operator import mul

from flint import arb, arb_poly, arb_series, fmpq, fmpq_mpoly_ctx

from tt_precise.certify.balls import Ring, series_length
from tt_precise.certify.certificate import Refused
from tt_precise.runtime.values import Scalar


class PowerSeries(Ring):
    """A power series with coefficients in units of 2^-bits, each computed when it is needed."""

    def __init__(self, bits: int, coefficients: list[int], rule: Callable[[int], int]):
        self.bits, self.c, self.rule = bits, coefficients, rule

    def at(self, n: int) -> int:
        """The n-th coefficient."""
        while len(self.c) <= n:
            self.c.append(self.rule(len(self.c)))
        return self.c[n]

    def _other(self, other: Scalar) -> PowerSeries:
        if isinstance(other, PowerSeries):
            return other
        return PowerSeries(self.bits, [fixed(arb(other), self.bits)], lambda n: 0)

    def __add__(self, other: Scalar) -> PowerSeries:
        y = self._other(other)
        return PowerSeries(self.bits, [], lambda n: self.at(n) + y.at(n))

    def __neg__(self) -> PowerSeries:
        return PowerSeries(self.bits, [], lambda n: -self.at(n))

    def __mul__(self, other: Scalar) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            factor = self._other(other).at(0)
            return PowerSeries(self.bits, [], lambda n: self.at(n) * factor >> self.bits)

        def rule(n: int) -> int:
            self.at(n), other.at(n)
            return sum(map(mul, self.c[: n + 1], other.c[n::-1])) >> self.bits

        return PowerSeries(self.bits, [], rule)

    def __truediv__(self, other: Scalar) -> PowerSeries:
        y = self._other(other)
        found = PowerSeries(self.bits, [], lambda n: 0)

        def rule(n: int) -> int:
            y.at(n)
            known = sum(map(mul, found.c[:n], y.c[n:0:-1]))
            return ((self.at(n) << self.bits) - known) // y.at(0)

        found.rule = rule
        return found

    def __rtruediv__(self, other: Scalar) -> PowerSeries:
        return self._other(other) / self

    def sqrt(self) -> PowerSeries:
        found = PowerSeries(self.bits, [isqrt(self.at(0) << self.bits)], lambda n: 0)

        def rule(n: int) -> int:
            known = sum(map(mul, found.c[1:n], found.c[n - 1 : 0 : -1]))
            return ((self.at(n) << self.bits) - known) // (2 * found.at(0))

        found.rule = rule
        return found


class Poly(Ring):
    """All functions on [0, end] within polynomials with balls as coefficients."""

    def __init__(self, p: arb_poly, room: Room):
        self.p, self.room = p, room

    def __add__(self, other: Scalar) -> Poly:
        return Poly(self.p + (other.p if isinstance(other, Poly) else other), self.room)

    def __neg__(self) -> Poly:
        return Poly(-self.p, self.room)

    def __mul__(self, other: Scalar) -> Poly:
        if isinstance(other, Poly):
            return self.room.cut(self.p * other.p)
        return Poly(self.p * other, self.room)

    def __truediv__(self, other: Scalar) -> Poly:
        return self * (_inverse(other) if isinstance(other, Poly) else 1 / arb(other))

    def __rtruediv__(self, other: Scalar) -> Poly:
        return _inverse(self) * other

    def sqrt(self) -> Poly:
        """Where |g/r^2 - 1| <= e < 1 the root is r within e, relatively."""
        close = self.room.near(self, lambda series: series.sqrt())
        inverse = _inverse(close)
        return close * (1 + arb(0, _less_than_one(self * inverse * inverse - 1)))


def _inverse(g: Poly) -> Poly:
    """1/g: r with |1 - g r| <= e < 1 is right within e/(1 - e), relatively."""
    close = g.room.near(g, lambda series: 1 / series)
    error = _less_than_one(1 - g * close)
    return close * (1 + arb(0, error / (1 - error)))


def _less_than_one(f: Poly) -> arb:
    error = f.p(f.room.interval).abs_upper()
    if not error < 1:
        raise Refused("a divisor, or what has a root, may be zero")
    return error


class Room:
    """The interval [0, end] and the degree to which polynomials on it are computed."""

    def __init__(self, end: arb, degree: int):
        self.degree, self.interval = degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def near(self, g: Poly, function: Callable[[arb_series], arb_series]) -> Poly:
        """A polynomial, exact, near a function of one: nothing more is known of it."""
        middle = arb_poly([c.mid() for c in g.p.coeffs()])
        with series_length(self.degree + 1):
            found = function(arb_series(middle, self.degree + 1))
        return Poly(arb_poly([c.mid() for c in found.coeffs()]), self)

    def cut(self, p: arb_poly) -> Poly:
        """A polynomial of any length; what is cut off goes into the constant term."""
        if p.degree() > self.degree:
            tail = p.right_shift(self.degree + 1)(self.interval) * self.beyond
            p = p.truncate(self.degree + 1) + tail
        return Poly(p, self)


class Dual(Ring):
    """A value and its derivatives (None for zero), over any arithmetic."""

    def __init__(self, value: Scalar, by: Sequence[Scalar]):
        self.value, self.by = value, by

    def _map(self, value: Scalar, factor: Scalar) -> Dual:
        return Dual(value, [None if d is None else d * factor for d in self.by])

    def __add__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return Dual(self.value + other, self.by)
        pairs = zip(self.by, other.by, strict=True)
        by = [b if a is None else a if b is None else a + b for a, b in pairs]
        return Dual(self.value + other.value, by)

    def __neg__(self) -> Dual:
        return self._map(-self.value, -1)

    def __mul__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return self._map(self.value * other, other)
        left, right = self._map(0, other.value), other._map(0, self.value)
        return Dual(self.value * other.value, (left + right).by)

    def __truediv__(self, other: Scalar) -> Dual:
        if isinstance(other, Dual):
            inverse = 1 / other.value
            return self * other._map(inverse, -1 * (inverse * inverse))
        return Dual(self.value / other, [None if d is None else d / other for d in self.by])

    def __rtruediv__(self, other: Scalar) -> Dual:
        inverse = 1 / self.value
        return self._map(inverse, -1 * (inverse * inverse)) * other

    def sqrt(self) -> Dual:
        root = self.value.sqrt()
        return self._map(root, 1 / (2 * root))


FORMAL = fmpq_mpoly_ctx.get(("t", "r", "pi"), "lex")
ONE = FORMAL.constant(1)


class Formal(Ring):
    """A number as a rational function of t = tan(theta/2), of a root r and of pi.

    What is zero as such a function is zero. (What is not may still be; balls decide.)
    """

    def __init__(self, above: Scalar, below: Scalar = ONE):
        common = above.gcd(below)
        self.above, self.below = above / common, below / common

    @classmethod
    def of(cls, x: Scalar) -> Formal:
        if isinstance(x, Formal):
            return x
        exact = Fraction(x)
        return cls(FORMAL.constant(fmpq(exact.numerator, exact.denominator)))

    def __add__(self, other: Scalar) -> Scalar:
        if isinstance(other, Dual):
            return NotImplemented
        y = Formal.of(other)
        return Formal(self.above * y.below + y.above * self.below, self.below * y.below)

    def __neg__(self) -> Formal:
        return Formal(-self.above, self.below)

    def __mul__(self, other: Scalar) -> Scalar:
        if isinstance(other, Dual):
            return NotImplemented
        y = Formal.of(other)
        return Formal(self.above * y.above, self.below * y.below)

    def __truediv__(self, other: Scalar) -> Scalar:
        if isinstance(other, Dual):
            return NotImplemented
        y = Formal.of(other)
        if not y.above:
            raise Refused("a division by zero at t = 0")
        return Formal(self.above * y.below, self.below * y.above)

    def __rtruediv__(self, other: Scalar) -> Formal:
        return Formal.of(other) / self


class FormalFunctions:
    """Functions at one start: of its inclination, and the root of one number."""

    def __init__(self) -> None:
        t, self.root, self.pi = (Formal(x) for x in FORMAL.gens())
        self.sine, self.cosine = 2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)
        self.radicand: Formal | None = None

    def sin(self, angle: Formal) -> Formal:
        return self.sine

    def cos(self, angle: Formal) -> Formal:
        return self.cosine

    def acos(self, x: Formal) -> Formal:
        return self.pi

    def sqrt(self, x: Scalar) -> Scalar:
        if isinstance(x, Dual):
            root = self.sqrt(x.value)
            return x._map(root, 1 / (2 * root))
        if self.radicand is None:
            self.radicand = Formal.of(x)
        if (Formal.of(x) - self.radicand).above:
            raise Refused("the roots of two numbers at t = 0")
        return self.root


def fixed(x: arb, bits: int) -> int:
    """A number in units of 2^-bits."""
    return int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz())
