"""Arithmetics in which the kernel evaluates a problem: power series, Taylor models, derivatives.

A ``TaylorModel`` contains a function on the interval of a step. A ``PowerSeries`` has Taylor
coefficients, which may be models. ``Rates`` is a right-hand side as a list of operations, with its
values and derivatives in any of these arithmetics.

**No NaN.** In FLINT the product of the polynomial 0 with NaN is 0, exactly. So a NaN must never
meet a model: reciprocals, roots and exponentials of models raise an error instead of returning NaN,
and ``Rates`` refuses a constant that is not finite.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partialmethod
from operator import add, call, mul, neg
from typing import NamedTuple

import flint
from flint import arb, arb_poly, arb_series, fmpq

from tt_precise.certify.balls import Balls, NotProved
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

    def _result(self, operation: Callable[..., Scalar], *others: Scalar) -> Operation:
        if any(isinstance(x, arb) and not x.is_finite() for x in others):
            raise NotProved("balls", "a constant of the equations is not finite")
        formula = (operation, self, *others)
        key = tuple(x.repr() if isinstance(x, arb) else x for x in formula)
        return self.all.setdefault(key, Operation(self.all, *formula))

    __add__ = partialmethod(_result, add)
    __neg__ = partialmethod(_result, neg)
    __mul__ = partialmethod(_result, mul)
    inverse = partialmethod(_result, inverse)
    sqrt = partialmethod(_result, Balls.sqrt)
    exp = partialmethod(_result, Balls.exp)


class Rates:
    """A function of the ``size`` components of a state, as a list of operations.

    ``bits`` and ``order`` are those of polynomials near the solutions of y' = f(y).

    Raises ``NotProved``: a constant in it is not finite.
    """

    def __init__(
        self,
        function: Callable[[Sequence[Scalar]], Sequence[Scalar]],
        size: int,
        bits: int = 0,
        order: int = 0,
    ):
        self.bits, self.order = bits, order
        operations: dict[Scalar, Operation] = {}
        self.components = [Operation(operations) for _ in range(size)]
        self.results = function(self.components)
        needed = {id(x) for x in self.results}
        for node in reversed(operations.values()):
            if id(node) in needed:
                needed |= {id(x) for x in node.formula}
        self.operations = [node for node in operations.values() if id(node) in needed]

    def __call__(
        self,
        state: Sequence[Scalar],
        apply: Callable[..., Scalar] = call,
        constant: Callable[[Scalar], Scalar] = lambda x: x,
    ) -> list[Scalar]:
        """Return its values, in the arithmetic of a state."""
        values = dict(zip(self.components, state, strict=True))

        def value(x: Scalar) -> Scalar:
            return values[x] if isinstance(x, Operation) else constant(x)

        for node in self.operations:
            operation, *operands = node.formula
            values[node] = apply(operation, *map(value, operands))
        return [value(x) for x in self.results]

    def derivatives(self, state: Sequence[Scalar], free: Sequence[int]) -> list[Differential]:
        """Return its values with their derivatives by the components ``free`` of a state."""
        numbers = [Differential(x, {i: 1} if i in free else {}) for i, x in enumerate(state)]
        return self(numbers, differential, lambda x: Differential(x, {}))


class Differential(NamedTuple):
    """A value with its derivatives by components of a state; missing derivatives are zero."""

    value: Scalar
    slopes: dict[int, Scalar]


# The partial derivatives of an operation by its operands a and b, from its result c.
PARTIAL: dict[Callable[..., Scalar], Callable[..., tuple[Scalar, ...]]] = {
    add: lambda c, a, b: (1, 1),
    neg: lambda c, a: (-1,),
    mul: lambda c, a, b: (b, a),
    inverse: lambda c, a: (-(c * c),),
    Balls.sqrt: lambda c, a: (inverse(c * 2),),
    Balls.exp: lambda c, a: (c,),
}


def differential(operation: Callable[..., Scalar], *operands: Differential) -> Differential:
    """Return the result of an operation, by the chain rule."""
    values = [x.value for x in operands]
    result, slopes = operation(*values), dict[int, Scalar]()
    for x, factor in zip(operands, PARTIAL[operation](result, *values), strict=True):
        for j, slope in x.slopes.items():
            change = slope if factor == 1 else slope * factor
            slopes[j] = slopes[j] + change if j in slopes else change
    return Differential(result, slopes)


class PowerSeries(Field):
    """Coefficients in any arithmetic; ``rule(c, n)`` is the n-th, from the earlier ones ``c``."""

    def __init__(self, rule: Callable[[list[Scalar], int], Scalar], first: Sequence[Scalar] = ()):
        self.rule, self.c = rule, list(first)

    def __getitem__(self, n: int) -> Scalar:
        while len(self.c) <= n:
            self.c.append(self.rule(self.c, len(self.c)))
        return self.c[n]

    def upto(self, n: int) -> list[Scalar]:
        """Return the coefficients up to the n-th."""
        _ = self[n]
        return self.c[: n + 1]

    def __add__(self, other: Scalar) -> PowerSeries:
        if isinstance(other, PowerSeries):
            return PowerSeries(lambda c, n: self[n] + other[n])
        return PowerSeries(lambda c, n: self[n] if n else self[0] + other)

    def __neg__(self) -> PowerSeries:
        return PowerSeries(lambda c, n: -self[n])

    def __mul__(self, other: Scalar) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            return PowerSeries(lambda c, n: self[n] * other)
        return PowerSeries(lambda c, n: sum(map(mul, self.upto(n), reversed(other.upto(n)))))

    def inverse(self) -> PowerSeries:
        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return inverse(self[0])
            return -(sum(map(mul, c, self.upto(n)[:0:-1])) * c[0])

        return PowerSeries(rule)

    def sqrt(self, root: Callable[[Scalar], Scalar] = Balls.sqrt) -> PowerSeries:
        """The square root, by ``root`` of the first coefficient."""

        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return root(self[0])
            return (self[n] - sum(map(mul, c[1:], c[:0:-1]))) / (2 * c[0])

        return PowerSeries(rule)

    def exp(self) -> PowerSeries:
        """The exponential e, from e' = f' e."""

        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return Balls.exp(self[0])
            slopes = [k * x for k, x in enumerate(self.upto(n)) if k]
            return sum(map(mul, slopes, c[::-1])) / n

        return PowerSeries(rule)


def solution(
    rates: Callable[[list[PowerSeries]], Sequence[Scalar]], start: Sequence[Scalar]
) -> list[PowerSeries]:
    """Return the power series of the solution of y' = ``rates``(y) through ``start``."""
    slopes: list[PowerSeries] = []

    def component(i: int, first: Scalar) -> PowerSeries:
        return PowerSeries(lambda c, n: slopes[i][n - 1] / n if n > 1 else slopes[i][0], [first])

    components = [component(i, first) for i, first in enumerate(start)]
    for rate in rates(components):
        varies = isinstance(rate, PowerSeries)
        slopes.append(rate if varies else PowerSeries(lambda c, n: 0, [rate]))
    return components


def coefficient(x: Scalar, n: int) -> Scalar:
    """Return the n-th coefficient of a series, or of a constant."""
    if isinstance(x, PowerSeries):
        return x[n]
    return 0 if n else x


def polynomial(x: Scalar, n: int = 0) -> arb_poly:
    """Return the polynomial of the n-th coefficient, which is a Taylor model or a number."""
    terms = coefficient(x, n)
    return terms.p if isinstance(terms, TaylorModel) else arb_poly([terms])


def middle(p: arb_poly) -> arb_poly:
    """Return the exact polynomial in the middle of one with balls as coefficients."""
    return arb_poly([c.mid() for c in p.coeffs()])


class Frame:
    """The interval [0, ``end``] of a step, and the degree of the polynomials on it."""

    def __init__(self, end: arb, degree: int):
        self.end, self.degree, self.interval = end, degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def near(self, exact: arb_poly, function: Callable[[arb_series], arb_series]) -> TaylorModel:
        """Return an exact polynomial near a function of another; its error is not bounded."""
        before, flint.ctx.cap = flint.ctx.cap, self.degree + 1
        try:
            series = function(arb_series(exact, self.degree + 1))
        finally:
            flint.ctx.cap = before
        return TaylorModel(middle(arb_poly(series.coeffs())), self)

    def cut(self, p: arb_poly) -> TaylorModel:
        """Return the model of a polynomial; its tail is bounded and goes into the constant term."""
        if p.degree() > self.degree:
            tail = p.right_shift(self.degree + 1)(self.interval) * self.beyond
            p = p.truncate(self.degree + 1) + tail
        return TaylorModel(p, self)


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
        close = self.frame.near(self._positive(abs(self.p[0].mid())), lambda series: 1 / series)
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
        m, on = middle(self.p), self.frame.interval
        close = self.frame.near(m, lambda series: series.exp()).p
        defect = m.derivative() * close - close.derivative()
        error = (defect(on) / close(on)).abs_upper() * self.frame.end
        error = (error + (self.p - m)(on).abs_upper()).upper()
        if not error.is_finite():
            raise NotProved("S2", "an exponential is not bounded")
        scale = m(arb(0)).exp() / close(arb(0))
        return TaylorModel(close * (scale * arb(0, error).exp()), self.frame)

    def _positive(self, number: arb) -> arb_poly:
        if not number > 0:
            raise NotProved("S2", "a divisor, or the argument of a root, may be zero")
        return middle(self.p)

    def below_one(self) -> arb:
        """Return a bound of the size.

        Raises ``NotProved``: it is not less than one.
        """
        error = self.p(self.frame.interval).abs_upper()
        if not error < 1:
            raise NotProved("S2", "a divisor, or the argument of a root, may be zero")
        return error
