"""The distance of a number from the true one, in significant correct digits.

What an error counts beside is said by ``mechanics.digits``. Digits lie between 0 and 34, which is
what golden data have.
"""

from __future__ import annotations

import math
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import TYPE_CHECKING

from tt_precise.golden.digits import COARSE, DIGITS, EXACT
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError

if TYPE_CHECKING:
    pass

INFINITE = Decimal("Infinity")


def relative_error(value: Decimal | None, true: Decimal, size: Decimal) -> Decimal:
    """What ``value`` differs from ``true`` by, in terms of ``size``; infinite if it is missing."""
    if value is None:
        return INFINITE
    error = EXACT.subtract(value, true).copy_abs()
    return COARSE.divide(error, size) if size else error and INFINITE


def correct_digits(error: Decimal | float) -> float:
    """The digits that a relative error leaves, between 0 and 34."""
    size = float(error)
    return min(float(DIGITS), max(0.0, -math.log10(size))) if size else float(DIGITS)


def as_decimal(value: Scalar) -> Decimal | None:
    """The exact value of a float, a decimal string or an mpmath number.

    None where there is none: a missing entry, NaN, infinity.

    Raises
    ------
    InputError
        It is no number.
    """
    if value is None or value == "":
        return None
    if hasattr(value, "_mpf_"):
        return _from_mpmath(value)
    try:
        if isinstance(value, str) and "_" in value:
            raise ValueError
        number = Decimal(value) if isinstance(value, str | int | Decimal) else Decimal(float(value))
    except (InvalidOperation, TypeError, ValueError, OverflowError):
        raise InputError(f"trajectory: got {str(value)[:60]!r}, expected a number") from None
    return number if number.is_finite() else None


def _from_mpmath(value: Scalar) -> Decimal | None:
    sign, mantissa, power, _ = value._mpf_
    if not mantissa:
        return None if power else Decimal(0)
    exact = Fraction(int(mantissa)) * Fraction(2) ** int(power)
    quotient = EXACT.divide(Decimal(exact.numerator), Decimal(exact.denominator))
    # an operator's minus would round to the 28 digits of decimal's own context
    return quotient.copy_negate() if sign else quotient
