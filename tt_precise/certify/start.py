"""The order to which a function vanishes at the start of a motion, and the sign that follows.

A ball around zero cannot decide that a number is zero; ``Formal`` numbers can. Formal numbers are
exact in t = tan(theta/2) and in one square root, for the scene's own start. A function vanishes to
the order n if its Taylor coefficients before the n-th are formally zero and the ball of the n-th
excludes zero. Both decisions are about exact numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from flint import arb, fmpq, fmpq_poly

from tt_precise.certify.balls import NotProved
from tt_precise.certify.models import Field, PowerSeries, coefficient
from tt_precise.runtime.values import Scalar

VANISHING = 6  # The highest order that is tried; each costs a term of two power series.
NONE, ONE, ZERO = fmpq_poly([]), fmpq_poly([1]), fmpq(0)

Function = Callable[[Any], Scalar]  # Of the motion in a state.


class Onset:
    """Orders and signs of functions of a motion at t = 0.

    ``formal`` and ``balls`` are the motion as power series in time, in the two arithmetics.
    """

    def __init__(self, formal: Callable[[], Any], balls: Callable[[], Any]):
        self.formal, self.balls = cache(formal), cache(balls)

    def order(self, function: Function) -> int:
        """Return the order to which a function vanishes.

        Raises ``NotProved``: that is undecided.
        """
        for order in range(VANISHING + 1):
            if not self._coefficient(function, order).contains(0):
                return order
            if Formal.of(coefficient(function(self.formal()), order)):
                break
        raise NotProved("zeros", f"a sign at t = 0 is undecided, in order {order}")

    def sign(self, function: Function, order: int) -> int:
        """Return the sign of the coefficient of that ``order``, which is not zero."""
        return 1 if self._coefficient(function, order) > 0 else -1

    def _coefficient(self, function: Function, order: int) -> arb:
        return arb(coefficient(function(self.balls()), order))


class Formal(Field):
    """An exact number (a + r b)/c: polynomials in t = tan(theta/2), r the root of ``square``.

    It is zero if a and b are. (What has another a or b may still be zero; balls decide.)
    """

    def __init__(self, a: fmpq_poly, b: fmpq_poly, c: fmpq_poly, square: fmpq = ZERO):
        common = a.gcd(b).gcd(c) * c.leading_coefficient()  # a gcd leads with 1, and so will c
        self.a, self.b, self.c, self.square = a / common, b / common, c / common, square

    @classmethod
    def of(cls, x: Scalar) -> Formal:
        """Return a rational number as a formal number; a formal number stays unchanged."""
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
        """Return the reciprocal.

        Raises ``NotProved``: the number is formally zero.
        """
        norm = self.a * self.a - self.b * self.b * self.square
        if not norm:
            raise NotProved("zeros", "a division by zero at t = 0")
        return Formal(self.a * self.c, -self.b * self.c, norm, self.square)

    def exp(self) -> Formal:
        raise NotProved("zeros", "an exponential at t = 0 is no formal number")


class FormalFunctions:
    """Functions at one start, which may contain the root of one number that is not a square."""

    square = ZERO

    sin = staticmethod(lambda angle: Formal(fmpq_poly([0, 2]), NONE, fmpq_poly([1, 0, 1])))
    cos = staticmethod(lambda angle: Formal(fmpq_poly([1, 0, -1]), NONE, fmpq_poly([1, 0, 1])))
    acos = staticmethod(lambda x: arb.nan())  # an angle is no formal number

    def exp(self, x: Scalar) -> Scalar:
        return x.exp() if isinstance(x, PowerSeries) else Formal.of(x).exp()

    def sqrt(self, x: Scalar) -> Scalar:
        """Return the root of a rational number.

        Raises ``NotProved``: it is not rational, or the second irrational root.
        """
        if isinstance(x, PowerSeries):
            return x.sqrt(self.sqrt)
        y = Formal.of(x)
        if y.b or max(y.a.degree(), y.c.degree()) > 0:
            raise NotProved("zeros", "the root of a number that is not rational, at t = 0")
        square = y.a[0] / y.c[0]
        if all(whole.is_square() for whole in (square.p, square.q)):
            return Formal.of(fmpq(square.p.isqrt(), square.q.isqrt()))
        if self.square not in (ZERO, square):
            raise NotProved("zeros", "the roots of two numbers at t = 0")
        self.square = square
        return Formal(NONE, ONE, ONE, square)
