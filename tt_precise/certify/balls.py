"""Ball arithmetic: python-flint's ``arb`` as one more arithmetic for the mechanics.

An ``arb`` is a midpoint with a radius, and represents every real number of this ball; each
operation returns a ball that contains every result (Johansson, "Arb: efficient arbitrary-precision
midpoint-radius interval arithmetic", IEEE Trans. Comput. 66, 2017).
"""

from __future__ import annotations

from collections.abc import Iterable
from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Decimal, localcontext
from fractions import Fraction
from itertools import product
from operator import methodcaller

from flint import arb, arb_poly, fmpq

from tt_precise.runtime.values import Scalar


class NotProved(ArithmeticError):  # noqa: N818 - a verdict, not a mistake
    """A hypothesis could not be verified, so nothing is claimed; the hypothesis may be true.

    ``hypothesis`` names it as in the docstring of ``tt_precise.certify``.
    """

    def __init__(self, hypothesis: str, reason: str):
        super().__init__(f"not proved ({hypothesis}): {reason}")
        self.hypothesis, self.reason = hypothesis, reason


class Balls:
    """The elementary functions of the mechanics, on balls.

    Roots and exponentials also work on power series, Taylor models and operations. The root of a
    ball that reaches below zero is not a number.
    """

    mpf = arb  # of a whole number
    sin = staticmethod(lambda x: arb(x).sin())
    cos = staticmethod(lambda x: arb(x).cos())
    acos = staticmethod(lambda x: arb(x).acos())
    sqrt = staticmethod(methodcaller("sqrt"))
    exp = staticmethod(methodcaller("exp"))

    @staticmethod
    def atan2(y: Scalar, x: Scalar) -> Scalar:
        """Angle of the point (x, y) for y >= 0: an inclination, all that the mechanics ask for.

        What a ball has below zero is rounding. Of anything but balls it is NaN, and spoils its
        user.
        """
        if not (isinstance(y, arb) and isinstance(x, arb)):
            return arb("nan")
        return arb.pi() - arb.atan2(y, -x) if x < 0 else arb.atan2(y, x)

    @staticmethod
    def hypot(x: Scalar, y: Scalar) -> Scalar:
        """Length of (x, y); the part of the ball of x^2 + y^2 below zero is rounding."""
        square = x * x + y * y
        return square.nonnegative_part().sqrt() if isinstance(square, arb) else square.sqrt()


def ball(value: Fraction) -> arb:
    """The smallest ball of the working precision around an exact number."""
    return arb(fmpq(value.numerator, value.denominator))


def largest(numbers: Iterable[arb]) -> arb:
    """An exact number, at least 0, that none of the balls exceeds.

    Raises ``NotProved``: a ball is not finite (``max`` would ignore NaN).
    """
    tops = [number.upper() for number in numbers]
    if not all(top.is_finite() for top in tops):
        raise NotProved("balls", "a bound is not finite")
    return max([arb(0), *tops])


def fraction(number: arb) -> Fraction:
    """The exact value of a ball without radius."""
    mantissa, exponent = number.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def bounds(number: arb) -> tuple[Fraction, Fraction]:
    """Exact lower and upper end of a finite ball."""
    middle, radius = fraction(number.mid()), fraction(number.rad())
    return middle - radius, middle + radius


def outward(exact: arb, figures: int) -> dict[str, str]:
    """Return a decimal ``middle`` with ``figures`` figures and a ``radius`` that contain a ball.

    The radius is one unit of the last figure, or more where the ball is wider.
    """
    low, high = bounds(exact)
    middle = round_to((low + high) / 2, ROUND_HALF_EVEN, figures)
    number = Decimal(middle)
    distance = max(high - Fraction(number), Fraction(number) - low)
    unit = Fraction(10) ** (number.adjusted() - figures + 1 if number else -figures)
    radius = max(distance, unit) if distance else distance
    return {"middle": middle, "radius": round_to(radius, ROUND_CEILING, 1)}


def round_to(number: Fraction, rounding: str, figures: int) -> str:
    """Round an exact number to a decimal with ``figures`` figures in the given direction."""
    if not number:
        return "0"
    with localcontext(prec=figures, rounding=rounding):
        return f"{Decimal(number.numerator) / Decimal(number.denominator):.{figures - 1}e}"


def require_outward_rounding() -> None:
    """Compare balls with exact rational arithmetic before the first proof.

    Raises ``NotProved``: a ball excludes the exact result, so the library is unsound here.
    """
    samples = [Fraction(n, d) for n, d in ((1, 3), (-22, 7), (10**9 + 7, 998_244_353), (5, 2**70))]
    for a, b in product(samples, samples):
        x, y = ball(a), ball(b)
        crossed = (arb_poly([x, y]) * arb_poly([y, x]))[1]
        results = (x + y, x - y, x * y, x / y, crossed, ball(a * a).sqrt())
        exact = (a + b, a - b, a * b, a / b, a * a + b * b, abs(a))
        for result, number in zip(results, exact, strict=True):
            low, high = bounds(result)
            if not low <= number <= high:
                raise NotProved("balls", f"a ball excludes the result {number} of {a} and {b}")
