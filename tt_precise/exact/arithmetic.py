"""mpmath contexts, and the number of digits on which two numbers agree."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from mpmath import MPContext

from tt_precise.runtime.values import Arithmetic, Functions, Scalar
from tt_precise.scene.numerals import to_mpmath


def own_context(digits: int) -> Functions:
    """A new mpmath context of ``digits`` decimal digits; the global context does not change."""
    context = MPContext()
    context.dps = digits
    return context


def arithmetic_of(context: Functions) -> Arithmetic:
    """An mpmath context as an ``Arithmetic``."""
    return Arithmetic(context, rounding_to(context))


def rounding_to(context: Functions) -> Callable[[Fraction], Scalar]:
    """The function that rounds an exact number once into ``context``."""
    return lambda value: to_mpmath(value, context)


def agreed_digits(a: Scalar, b: Scalar, most: int, context: Functions) -> int:
    """Decimal digits on which ``a`` and ``b`` agree: -log10 |a - b|/max, at most ``most``.

    0 if they differ by more than their size, or one of them is infinite or NaN.
    """
    difference = abs(a - b)
    if difference == 0:
        return most
    relative = difference / max(abs(a), abs(b))
    if not relative < 1:
        return 0
    return min(most, int(context.floor(-context.log10(relative))))


def decimal(value: Scalar, digits: int, context: Functions) -> str:
    """``value`` as a decimal string of ``digits`` significant digits."""
    return context.nstr(value, digits, strip_zeros=False)
