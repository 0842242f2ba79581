"""Arithmetics in which the kernel evaluates a problem: power series, Taylor models, dual numbers.

A ``TaylorModel`` contains a function on the interval of a step. A ``PowerSeries`` in whole numbers
needs no trust, since the theorem holds for any polynomial. A ``Dual`` has derivatives by components
of a state. ``Rates`` is a right-hand side as a list of operations.

**No NaN.** In FLINT the product of the polynomial 0 with NaN is 0, exactly. So a NaN must never
meet a model: reciprocals, roots and exponentials of models raise an error instead of returning NaN,
and ``Rates`` refuses a constant that is not finite.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import add, mul, neg

from flint import arb, arb_poly, arb_series, fmpq, fmpz
from gmpy2 import isqrt, mpz

from tt_precise.certify.balls import Balls, NotProved, series_length
from tt_precise.runtime.values import Ring, Scalar


def inverse(x: Scalar) -> Scalar:
    """Return 1/x, exact for whole and rational numbers."""
    return x.inverse() if hasattr(x, "inverse") else fmpq(1) / x


class Field(Ring):
    """Quotients from products and a reciprocal."""

    def __truediv__(self: Scalar, other: Scalar) -> Scalar:
        return self * inverse(other)

    def __rtruediv__(self: Scalar, other: Scalar) -> Scalar:
        return inverse(self) * other


class Operation(Field):
    """A node of a right-hand side: an operation on operands, or a component of the state.

    ``all`` has every operation once, in the order of their evaluation.
    """

    def __init__(self, operations: dict[Scalar, Operation], *formula: Scalar):
        self.all, self.formula = operations, formula

    def _result(self, *formula: Scalar) -> Operation:
        if any(isinstance(x, arb) and not x.is_finite() for x in formula):
            raise NotProved("balls", "a constant of the equations is not finite")
        key = tuple(x.repr() if isinstance(x, arb) else x for x in formula)
        return self.all.setdefault(key, Operation(self.all, *formula))

    def __add__(self, other: Scalar) -> Operation:
        return self._result(add, self, other)

    def __neg__(self) -> Operation:
        return self._result(neg, self)

    def __mul__(self, other: Scalar) -> Operation:
        return self._result(mul, self, other)

    def inverse(self) -> Operation:
        return self._result(inverse, self)

    def sqrt(self) -> Operation:
        return self._result(Balls.sqrt, self)

    def exp(self) -> Operation:
        return self._result(Balls.exp, self)


class Rates:
    """A function of the ``size`` components of a state, as a list of operations.

    Raises ``NotProved``: a constant in it is not finite.
    """

    def __init__(self, function: Callable[[Sequence[Scalar]], Sequence[Scalar]], size: int):
        operations: dict[Scalar, Operation] = {}
        self.components = [Operation(operations) for _ in range(size)]
        self.results = function(self.components)
        needed = {id(x) for x in self.results}
        for node in reversed(operations.values()):
            if id(node) in needed:
                needed |= {id(x) for x in node.formula}
        self.operations = [node for node in operations.values() if id(node) in needed]

    def __call__(self, state: Sequence[Scalar]) -> list[Scalar]:
        """Return its values, in the arithmetic of a state."""
        values = dict(zip(self.components, state, strict=True))

        def value(x: Scalar) -> Scalar:
            return values[x] if isinstance(x, Operation) else x

        for node in self.operations:
            operation, *operands = node.formula
            values[node] = operation(*map(value, operands))
        return [value(x) for x in self.results]


class PowerSeries(Field):
    """A power series; ``rule(c, n)`` is the n-th coefficient from the earlier coefficients ``c``.

    Coefficients are of any arithmetic. With ``bits`` they are whole numbers in units of 2^-bits.
    """

    def __init__(
        self,
        rule: Callable[[list[Scalar], int], Scalar],
        first: Sequence[Scalar] = (),
        bits: int = 0,
    ):
        self.rule, self.c, self.bits = rule, list(first), bits

    def __getitem__(self, n: int) -> Scalar:
        while len(self.c) <= n:
            self.c.append(self.rule(self.c, len(self.c)))
        return self.c[n]

    def _series(self, rule: Callable[[list[Scalar], int], Scalar]) -> PowerSeries:
        return PowerSeries(rule, bits=self.bits)

    def _number(self, x: Scalar) -> Scalar:
        return fixed(arb(x), self.bits) if self.bits else x

    def _product(self, x: Scalar) -> Scalar:
        return x >> self.bits if self.bits else x

    def _dot(self, a: list[Scalar], b: list[Scalar]) -> Scalar:
        return self._product(sum(map(mul, a, b)))

    def _ratio(self, a: Scalar, b: Scalar) -> Scalar:
        return (a << self.bits) // b if self.bits else a / b

    def __add__(self, other: Scalar) -> PowerSeries:
        if isinstance(other, PowerSeries):
            return self._series(lambda c, n: self[n] + other[n])
        constant = self._number(other)
        return self._series(lambda c, n: self[n] if n else self[0] + constant)

    def __neg__(self) -> PowerSeries:
        return self._series(lambda c, n: -self[n])

    def __mul__(self, other: Scalar) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            factor = self._number(other)
            return self._series(lambda c, n: self._product(self[n] * factor))

        def rule(c: list[Scalar], n: int) -> Scalar:
            _ = self[n], other[n]
            return self._dot(self.c[: n + 1], other.c[n::-1])

        return self._series(rule)

    def inverse(self) -> PowerSeries:
        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return self._ratio(1 << self.bits, self[0])
            _ = self[n]
            return -self._product(self._dot(c, self.c[n:0:-1]) * c[0])

        return self._series(rule)

    def sqrt(self, root: Callable[[Scalar], Scalar] = Balls.sqrt) -> PowerSeries:
        """The square root, by ``root`` of the first coefficient."""

        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return isqrt(self[0] << self.bits) if self.bits else root(self[0])
            return self._ratio(self[n] - self._dot(c[1:], c[:0:-1]), 2 * c[0])

        return self._series(rule)

    def exp(self) -> PowerSeries:
        """The exponential e, from e' = f' e."""

        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return self._exponential(self[0])
            _ = self[n]
            total = self._dot([k * x for k, x in enumerate(self.c[1 : n + 1], 1)], c[::-1])
            return total // n if self.bits else total / n

        return self._series(rule)

    def _exponential(self, x: Scalar) -> Scalar:
        if not self.bits:
            return Balls.exp(x)
        return fixed((arb(fmpz(int(x))) * arb(2) ** -self.bits).exp(), self.bits)


def solution(
    rates: Callable[[list[PowerSeries]], Sequence[Scalar]], start: Sequence[Scalar], bits: int = 0
) -> list[PowerSeries]:
    """Return the power series of the solution of y' = ``rates``(y) through ``start``."""
    slopes: list[PowerSeries] = []

    def component(i: int, first: Scalar) -> PowerSeries:
        def rule(c: list[Scalar], n: int) -> Scalar:
            slope = slopes[i][n - 1]
            return slope // n if bits else slope / n if n > 1 else slope

        return PowerSeries(rule, [first], bits)

    components = [component(i, first) for i, first in enumerate(start)]
    nothing = PowerSeries(lambda c, n: 0, bits=bits)
    slopes += [rate + nothing for rate in rates(components)]
    return components


def coefficient(x: Scalar, n: int) -> Scalar:
    """Return the n-th coefficient of a series, or of a constant."""
    if isinstance(x, PowerSeries):
        return x[n]
    return 0 if n else x


def polynomial(x: Scalar, n: int) -> arb_poly:
    """Return the polynomial of the n-th coefficient, which is a Taylor model or a number."""
    terms = coefficient(x, n)
    return terms.p if isinstance(terms, TaylorModel) else arb_poly([terms])


def fixed(x: arb, bits: int) -> mpz:
    """Return a number near the middle of a ball, in units of 2^-bits.

    Raises ``NotProved``: it is not finite.
    """
    if not x.is_finite():
        raise NotProved("S2", "a number of the equations is not finite")
    return mpz(int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz()))


class Frame:
    """The interval [0, ``end``] of a step, and the degree of the polynomials on it."""

    def __init__(self, end: arb, degree: int):
        self.end, self.degree, self.interval = end, degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def near(self, middle: arb_poly, function: Callable[[arb_series], arb_series]) -> TaylorModel:
        """Return an exact polynomial near a function of another; its error is not bounded."""
        with series_length(self.degree + 1):
            series = function(arb_series(middle, self.degree + 1))
        return TaylorModel(_middle(arb_poly(series.coeffs())), self)

    def cut(self, p: arb_poly) -> TaylorModel:
        """Return the model of a polynomial; its tail is bounded and goes into the constant term."""
        if p.degree() > self.degree:
            tail = p.right_shift(self.degree + 1)(self.interval) * self.beyond
            p = p.truncate(self.degree + 1) + tail
        return TaylorModel(p, self)


def _middle(p: arb_poly) -> arb_poly:
    return arb_poly([c.mid() for c in p.coeffs()])


class TaylorModel(Field):
    """All functions on the interval within a polynomial ``p`` with balls as coefficients."""

    def __init__(self, p: arb_poly, frame: Frame):
        self.p, self.frame = p, frame

    def __add__(self, other: Scalar) -> TaylorModel:
        more = other.p if isinstance(other, TaylorModel) else other
        return TaylorModel(self.p + more, self.frame)

    def __neg__(self) -> TaylorModel:
        return TaylorModel(-self.p, self.frame)

    def __mul__(self, other: Scalar) -> TaylorModel:
        if isinstance(other, TaylorModel):
            return self.frame.cut(self.p * other.p)
        return TaylorModel(self.p * other, self.frame)

    def inverse(self) -> TaylorModel:
        """Enclose 1/g in r within e/(1 - e), relatively, where |1 - g r| <= e < 1."""
        middle = self._positive(abs(self.p[0].mid()))
        close = self.frame.near(middle, lambda series: 1 / series)
        error = (1 - self * close).below_one()
        return close * (1 + arb(0, error / (1 - error)))

    def sqrt(self) -> TaylorModel:
        """Enclose sqrt(g) in r within e, relatively, where |g/r^2 - 1| <= e < 1."""
        close = self.frame.near(self._positive(self.p[0].mid()), lambda series: series.sqrt())
        inverse = close.inverse()
        return close * (1 + arb(0, (self * inverse * inverse - 1).below_one()))

    def exp(self) -> TaylorModel:
        """With m' r - r' = d, exp(m) = r exp(m(0))/r(0) exp(integral of d/r) for polynomials m, r.

        (The derivative of r exp(-m) is -d exp(-m).) Here m is the middle of the model.
        """
        middle, on = _middle(self.p), self.frame.interval
        close = self.frame.near(middle, lambda series: series.exp()).p
        defect = middle.derivative() * close - close.derivative()
        error = (defect(on) / close(on)).abs_upper() * self.frame.end
        error = (error + (self.p - middle)(on).abs_upper()).upper()
        if not error.is_finite():
            raise NotProved("S2", "an exponential is not bounded")
        scale = middle(arb(0)).exp() / close(arb(0))
        return TaylorModel(close * (scale * arb(0, error).exp()), self.frame)

    def _positive(self, number: arb) -> arb_poly:
        if not number > 0:
            raise NotProved("S2", "a divisor, or the argument of a root, may be zero")
        return _middle(self.p)

    def below_one(self) -> arb:
        """Return a bound of the size.

        Raises ``NotProved``: it is not less than one.
        """
        error = self.p(self.frame.interval).abs_upper()
        if not error < 1:
            raise NotProved("S2", "a divisor, or the argument of a root, may be zero")
        return error


class Dual(Field):
    """A value with its derivatives by components of a state; missing derivatives are zero."""

    def __init__(self, value: Scalar, slopes: dict[int, Scalar]):
        self.value, self.slopes = value, slopes

    def _scaled(self, value: Scalar, factor: Scalar) -> Dual:
        return Dual(value, {j: slope * factor for j, slope in self.slopes.items()})

    def __add__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return Dual(self.value + other, self.slopes)
        slopes = dict(self.slopes)
        for j, slope in other.slopes.items():
            slopes[j] = slopes[j] + slope if j in slopes else slope
        return Dual(self.value + other.value, slopes)

    def __neg__(self) -> Dual:
        return self._scaled(-self.value, -1)

    def __mul__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return self._scaled(self.value * other, other)
        value = self.value * other.value
        return self._scaled(value, other.value) + other._scaled(0, self.value)

    def inverse(self) -> Dual:
        reciprocal = inverse(self.value)
        return self._scaled(reciprocal, -(reciprocal * reciprocal))

    def sqrt(self) -> Dual:
        root = self.value.sqrt()
        return self._scaled(root, inverse(root * 2))

    def exp(self) -> Dual:
        power = self.value.exp()
        return self._scaled(power, power)
