"""Intervals of decimals, rounded outward: enough arithmetic to derive columns from enclosures.

Euler angles and times of the climb follow from enclosed vectors and events by the formulas of
``mechanics`` and ``integrate.inversion``, which take any arithmetic; this one needs no extra.
"""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from functools import cache

from tt_precise.runtime.arithmetic import Functions, Scalar

FIGURES = 60
_DOWN = Context(prec=FIGURES, rounding=ROUND_FLOOR)
_UP = Context(prec=FIGURES, rounding=ROUND_CEILING)
GUARD = 4
_NEAR = Context(prec=FIGURES + GUARD)
_ZERO = Decimal(0)
# mpmath's inverse tangent is right to a unit in its last place or two; many more are allowed
_SLACK = Decimal(10) ** (8 - FIGURES)
_NEARLY_ONE = Decimal("0.99"), Decimal("1.01")


class Outward:
    """All numbers from ``low`` to ``high``. A comparison is true if it is so for all of them."""

    __slots__ = ("high", "low")

    def __init__(self, low: Decimal, high: Decimal):
        self.low, self.high = low, high

    @classmethod
    def of(cls, number: Scalar) -> Outward:
        """The interval of a rational number, or the interval itself."""
        if isinstance(number, Outward):
            return number
        if isinstance(number, int):
            return cls(Decimal(number), Decimal(number))
        top, bottom = Decimal(number.numerator), Decimal(number.denominator)
        return cls(_DOWN.divide(top, bottom), _UP.divide(top, bottom))

    @classmethod
    def around(cls, middle: str, radius: str) -> Outward:
        """From the decimals of a ball.

        Raises
        ------
        ArithmeticError
            Either is no finite number.
        """
        centre, reach = Decimal(middle), Decimal(radius)
        if not (centre.is_finite() and reach.is_finite() and reach >= 0):
            raise ArithmeticError(f"got {middle} and {radius}, expected a middle and a radius")
        return cls(_DOWN.subtract(centre, reach), _UP.add(centre, reach))

    def meets(self, other: Outward) -> bool:
        """Whether it has a number in common with another interval."""
        return self.low <= other.high and other.low <= self.high

    def rounds_to(self, text: str, slack: Decimal) -> bool:
        """Whether one of them is within ``slack`` of a printed number."""
        printed = Decimal(text)
        return self.meets(Outward(_DOWN.subtract(printed, slack), _UP.add(printed, slack)))

    def contains_zero(self) -> bool:
        """Whether zero is among them."""
        return self.low <= 0 <= self.high

    def __add__(self, other: Scalar) -> Outward:
        y = Outward.of(other)
        return Outward(_DOWN.add(self.low, y.low), _UP.add(self.high, y.high))

    __radd__ = __add__

    def __neg__(self) -> Outward:
        return Outward(self.high.copy_negate(), self.low.copy_negate())

    def __sub__(self, other: Scalar) -> Outward:
        y = Outward.of(other)
        return Outward(_DOWN.subtract(self.low, y.high), _UP.subtract(self.high, y.low))

    def __rsub__(self, other: Scalar) -> Outward:
        return Outward.of(other) - self

    def __mul__(self, other: Scalar) -> Outward:
        y = Outward.of(other)
        a, b, c, d = self.low, self.high, y.low, y.high
        if a >= 0:
            low, high = (a if c >= 0 else b, c), (b if d >= 0 else a, d)
        elif b <= 0:
            low, high = (a if d >= 0 else b, d), (a if c <= 0 else b, c)
        elif c >= 0:
            low, high = (a, d), (b, d)
        elif d <= 0:
            low, high = (b, c), (a, c)
        else:
            low = min((a, d), (b, c), key=lambda pair: _DOWN.multiply(*pair))
            high = max((a, c), (b, d), key=lambda pair: _UP.multiply(*pair))
        return Outward(_DOWN.multiply(*low), _UP.multiply(*high))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Outward:
        y = Outward.of(other)
        if y.contains_zero():
            raise ZeroDivisionError("an interval that contains zero")
        return self * Outward(_DOWN.divide(1, y.high), _UP.divide(1, y.low))

    def __rtruediv__(self, other: Scalar) -> Outward:
        return Outward.of(other) / self

    def __lt__(self, other: Scalar) -> bool:
        return self.high < Outward.of(other).low

    def __gt__(self, other: Scalar) -> bool:
        return self.low > Outward.of(other).high

    def sqrt(self) -> Outward:
        """Square root; what lies below zero is rounding."""
        return Outward(_DOWN.sqrt(max(self.low, _ZERO)), _UP.sqrt(max(self.high, _ZERO)))


class IntervalFunctions:
    """The elementary functions that ``mechanics.conversion`` asks for."""

    @staticmethod
    def sqrt(x: Outward) -> Outward:
        """Square root."""
        return x.sqrt()

    @staticmethod
    def atan2(y: Outward, x: Outward) -> Outward:
        """The angle of a point (x, y) near the unit circle, y > 0.

        Its derivatives are -y and x over x^2 + y^2, which is nearly 1.
        """
        square = x * x + y * y
        if not (square.low > _NEARLY_ONE[0] and square.high < _NEARLY_ONE[1]):
            raise ZeroDivisionError("a point that is not near the unit circle")
        angle = _decimal(_context().atan2(_binary(y.low), _binary(x.low)))
        widths = _UP.subtract(x.high, x.low), _UP.subtract(y.high, y.low)
        sizes = max(abs(x.low), abs(x.high)), max(abs(y.low), abs(y.high))
        reach = _UP.add(_UP.multiply(widths[0], sizes[1]), _UP.multiply(widths[1], sizes[0]))
        reach = _UP.add(_UP.multiply(reach, Decimal("1.1")), _UP.multiply(abs(angle), _SLACK))
        return Outward(_DOWN.subtract(angle, reach), _UP.add(angle, reach))


def pi() -> Outward:
    """The number pi."""
    near = _decimal(+_context().pi)
    return Outward(_DOWN.subtract(near, _SLACK), _UP.add(near, _SLACK))


@cache
def _context() -> Functions:
    import mpmath

    context = mpmath.MPContext()
    context.dps = FIGURES + GUARD
    return context


def _binary(value: Decimal) -> Scalar:
    """Rounded once; a third of the time that text takes."""
    if not value:
        return _context().zero
    places = FIGURES + GUARD - value.adjusted()
    whole = int(value.scaleb(places, _NEAR))
    return _context().mpf(whole) / _ten_to(places)


@cache
def _ten_to(power: int) -> Scalar:
    return _context().mpf(10) ** power


def _decimal(value: Scalar) -> Decimal:
    mantissa, power = value.man_exp
    if power >= 0:
        return _NEAR.create_decimal(int(mantissa) << power)
    return _NEAR.divide(Decimal(int(mantissa)), Decimal(1 << -power))
