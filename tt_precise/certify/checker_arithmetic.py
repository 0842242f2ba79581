"""The second checker's own arithmetics: power series, Taylor models, formal numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import add, mul, neg

from flint import arb, arb_poly, arb_series, fmpq, fmpq_poly
from gmpy2 import isqrt, mpz

from tt_precise.certify.balls import Balls, series_length
from tt_precise.certify.certificate import Refused
from tt_precise.runtime.values import Ring, Scalar

NONE, ONE, ZERO = fmpq_poly([]), fmpq_poly([1]), fmpq(0)


def inverse(x: Scalar) -> Scalar:
    """1/x, exact of whole and rational numbers."""
    return x.inverse() if hasattr(x, "inverse") else fmpq(1) / x


class Field(Ring):
    """What follows from a reciprocal, too."""

    def __truediv__(self: Scalar, other: Scalar) -> Scalar:
        return self * inverse(other)

    def __rtruediv__(self: Scalar, other: Scalar) -> Scalar:
        return inverse(self) * other


class Operation(Field):
    """What is made of entries of a state, each operation once; ``known`` has all, in order."""

    def __init__(self, known: dict[Scalar, Operation], *made: Scalar):
        self.known, self.made = known, made

    def _result(self, *made: Scalar) -> Operation:
        key = tuple(x.repr() if isinstance(x, arb) else x for x in made)
        return self.known.setdefault(key, Operation(self.known, *made))

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


class Rates:
    """A function of ``size`` entries of a state, as the operations that it needs."""

    def __init__(self, function: Callable[[Sequence[Scalar]], Sequence[Scalar]], size: int):
        known: dict[Scalar, Operation] = {}
        self.entries = [Operation(known) for _ in range(size)]
        self.results = function(self.entries)
        needed = {id(x) for x in self.results}
        for node in reversed(known.values()):
            if id(node) in needed:
                needed |= {id(x) for x in node.made}
        self.operations = [node for node in known.values() if id(node) in needed]

    def __call__(self, state: Sequence[Scalar]) -> list[Scalar]:
        """Its values in the arithmetic of a state."""
        values = dict(zip(self.entries, state, strict=True))

        def value(x: Scalar) -> Scalar:
            return values[x] if isinstance(x, Operation) else x

        for node in self.operations:
            operation, *operands = node.made
            values[node] = operation(*map(value, operands))
        return [value(x) for x in self.results]


class Series(Field):
    """A power series; ``rule(c, n)`` gives the n-th coefficient from those before it, ``c``.

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

    def _made(self, rule: Callable[[list[Scalar], int], Scalar]) -> Series:
        return Series(rule, bits=self.bits)

    def _number(self, x: Scalar) -> Scalar:
        return fixed(arb(x), self.bits) if self.bits else x

    def _product(self, x: Scalar) -> Scalar:
        return x >> self.bits if self.bits else x

    def _dot(self, a: list[Scalar], b: list[Scalar]) -> Scalar:
        return self._product(sum(map(mul, a, b)))

    def _ratio(self, a: Scalar, b: Scalar) -> Scalar:
        return (a << self.bits) // b if self.bits else a / b

    def __add__(self, other: Scalar) -> Series:
        if isinstance(other, Series):
            return self._made(lambda c, n: self[n] + other[n])
        constant = self._number(other)
        return self._made(lambda c, n: self[n] if n else self[0] + constant)

    def __neg__(self) -> Series:
        return self._made(lambda c, n: -self[n])

    def __mul__(self, other: Scalar) -> Series:
        if not isinstance(other, Series):
            factor = self._number(other)
            return self._made(lambda c, n: self._product(self[n] * factor))

        def rule(c: list[Scalar], n: int) -> Scalar:
            _ = self[n], other[n]
            return self._dot(self.c[: n + 1], other.c[n::-1])

        return self._made(rule)

    def inverse(self) -> Series:
        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return self._ratio(1 << self.bits, self[0])
            _ = self[n]
            return -self._product(self._dot(c, self.c[n:0:-1]) * c[0])

        return self._made(rule)

    def sqrt(self, root: Callable[[Scalar], Scalar] = Balls.sqrt) -> Series:
        """The square root, by ``root`` of the first coefficient."""

        def rule(c: list[Scalar], n: int) -> Scalar:
            if not n:
                return isqrt(self[0] << self.bits) if self.bits else root(self[0])
            return self._ratio(self[n] - self._dot(c[1:], c[:0:-1]), 2 * c[0])

        return self._made(rule)


def solution(
    rates: Callable[[list[Series]], Sequence[Scalar]], start: Sequence[Scalar], bits: int = 0
) -> list[Series]:
    """The power series of the solution through ``start`` of y' = ``rates``(y)."""
    slopes: list[Series] = []

    def entry(i: int, first: Scalar) -> Series:
        def rule(c: list[Scalar], n: int) -> Scalar:
            slope = slopes[i][n - 1]
            return slope // n if bits else slope / n if n > 1 else slope

        return Series(rule, [first], bits)

    entries = [entry(i, first) for i, first in enumerate(start)]
    nothing = Series(lambda c, n: 0, bits=bits)
    slopes += [rate + nothing for rate in rates(entries)]
    return entries


def coefficient(x: Scalar, n: int) -> Scalar:
    """The n-th coefficient of a series, or of a constant."""
    if isinstance(x, Series):
        return x[n]
    return 0 if n else x


def polynomial(x: Scalar, n: int) -> arb_poly:
    """The polynomial of the n-th coefficient, a Taylor model or a number."""
    terms = coefficient(x, n)
    return terms.p if isinstance(terms, TaylorModel) else arb_poly([terms])


def fixed(x: arb, bits: int) -> mpz:
    """A number in units of 2^-bits."""
    return mpz(int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz()))


class Frame:
    """The interval [0, end] and the degree to which polynomials on it are computed."""

    def __init__(self, end: arb, degree: int):
        self.degree, self.interval = degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def near(self, g: TaylorModel, function: Callable[[arb_series], arb_series]) -> TaylorModel:
        """A polynomial, exact, near a function of one: nothing more is known of it."""
        middle = arb_poly([c.mid() for c in g.p.coeffs()])
        with series_length(self.degree + 1):
            series = function(arb_series(middle, self.degree + 1))
        return TaylorModel(arb_poly([c.mid() for c in series.coeffs()]), self)

    def cut(self, p: arb_poly) -> TaylorModel:
        """A polynomial of any length; what is cut off goes into the constant term."""
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
        """Where |1 - g r| <= e < 1 the inverse of g is r within e/(1 - e), relatively."""
        close = self.frame.near(self, lambda series: 1 / series)
        error = (1 - self * close).below_one()
        return close * (1 + arb(0, error / (1 - error)))

    def sqrt(self) -> TaylorModel:
        """Where |g/r^2 - 1| <= e < 1 the root of g is r within e, relatively."""
        close = self.frame.near(self, lambda series: series.sqrt())
        inverse = close.inverse()
        return close * (1 + arb(0, (self * inverse * inverse - 1).below_one()))

    def below_one(self) -> arb:
        """A bound of the size; ``Refused`` unless it is less than one."""
        error = self.p(self.frame.interval).abs_upper()
        if not error < 1:
            raise Refused("a divisor, or what has a root, may be zero")
        return error


class Dual(Field):
    """A value with those of its derivatives, by entries of a state, that are not simply zero."""

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


class Formal(Field):
    """An exact number (a + r b)/c: polynomials in t = tan(theta/2), r the root of ``square``.

    It is zero if a and b are. (What has another a or b may still be; balls decide.)
    """

    def __init__(self, a: fmpq_poly, b: fmpq_poly, c: fmpq_poly, square: fmpq = ZERO):
        common = a.gcd(b).gcd(c) * c.leading_coefficient()  # a gcd leads with 1, and so will c
        self.a, self.b, self.c, self.square = a / common, b / common, c / common, square

    @classmethod
    def of(cls, x: Scalar) -> Formal:
        """A rational number, or the formal one itself."""
        return x if isinstance(x, Formal) else cls(fmpq_poly([x]), NONE, ONE)

    def __bool__(self) -> bool:
        return bool(self.a) or bool(self.b)

    def __add__(self, other: Scalar) -> Formal:
        y = Formal.of(other)
        a, b = self.a * y.c + y.a * self.c, self.b * y.c + y.b * self.c
        return Formal(a, b, self.c * y.c, self.square or y.square)

    def __neg__(self) -> Formal:
        return Formal(-self.a, -self.b, self.c, self.square)

    def __mul__(self, other: Scalar) -> Formal:
        y, square = Formal.of(other), self.square or Formal.of(other).square
        a, b = self.a * y.a + self.b * y.b * square, self.a * y.b + self.b * y.a
        return Formal(a, b, self.c * y.c, square)

    def inverse(self) -> Formal:
        norm = self.a * self.a - self.b * self.b * self.square
        if not norm:
            raise Refused("a division by zero at t = 0")
        return Formal(self.a * self.c, -self.b * self.c, norm, self.square)


class FormalFunctions:
    """Functions at one start, which may contain the root of one number that is not a square."""

    square = ZERO

    def sin(self, angle: Scalar) -> Formal:
        return Formal(fmpq_poly([0, 2]), NONE, fmpq_poly([1, 0, 1]))

    def cos(self, angle: Scalar) -> Formal:
        return Formal(fmpq_poly([1, 0, -1]), NONE, fmpq_poly([1, 0, 1]))

    def acos(self, x: Scalar) -> arb:
        """No number, and neither is what is made of it: only the angle itself should be."""
        return arb.nan()

    def sqrt(self, x: Scalar) -> Scalar:
        if isinstance(x, Series):
            return x.sqrt(self.sqrt)
        y = Formal.of(x)
        if y.b or max(y.a.degree(), y.c.degree()) > 0:
            raise Refused("the root of no rational number at t = 0")
        square = y.a[0] / y.c[0]
        if all(whole.is_square() for whole in (square.p, square.q)):
            return Formal.of(fmpq(square.p.isqrt(), square.q.isqrt()))
        if self.square not in (ZERO, square):
            raise Refused("the roots of two numbers at t = 0")
        self.square = square
        return Formal(NONE, ONE, ONE, square)
