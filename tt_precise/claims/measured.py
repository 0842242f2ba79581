"""Measured numbers with the digits they have.

A value is computed twice, in two arithmetics that err independently; the digits in which they
agree are the digits it has, and no more are printed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from tt_precise.runtime.arithmetic import Scalar

MOST_DIGITS = 20  # printed; the fine runs have more
DEFAULT_DIGITS = 12  # printed of a bare number, for which nobody states an error


@dataclass(frozen=True)
class Settled:
    """A value, and how many of its significant digits were seen twice."""

    value: Scalar
    digits: int

    @classmethod
    def of(cls, value: Measured, other: Measured, most: int = MOST_DIGITS) -> Settled:
        """``value`` with the digits (at most ``most``) in which independent ``other`` agrees."""
        exact, second = fraction_of(value), fraction_of(other)
        if exact == second:
            return cls(value, most)
        # a difference of half a unit in digit n still leaves n digits
        difference = 2 * abs(exact - second) / max(abs(exact), abs(second))
        return cls(value, max(0, min(most, -decade(difference) - 1)))


Measured: TypeAlias = Any  # a Settled, an mpmath number, a float, an int or a Fraction


def fraction_of(number: Measured) -> Fraction:
    """The exact value of a number of any arithmetic; comparisons need no precision then."""
    if isinstance(number, Settled):
        return fraction_of(number.value)
    if hasattr(number, "_mpf_"):
        sign, mantissa, power, _ = number._mpf_
        if not mantissa and power:
            raise ValueError(f"measured number: got {number}, expected a finite one")
        value = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        return -value if sign else value
    return Fraction(number)


def measured_text(number: Measured) -> str:
    """A number in decimals: settled and exact ones with all their digits, others with twelve."""
    if isinstance(number, Settled):
        return decimal(number.value, number.digits)
    if isinstance(number, int):
        return str(number)
    if isinstance(number, Fraction):
        return decimal(number, MOST_DIGITS)
    return decimal(number, DEFAULT_DIGITS)


def decimal(number: Measured, digits: int) -> str:
    """``number`` rounded to ``digits`` significant digits, plain or with an exponent."""
    value = fraction_of(number)
    if not value:
        return "0"
    digits = max(1, digits)
    power = decade(abs(value))
    unit = Fraction(10) ** (power - digits + 1)
    whole = round(abs(value) / unit)
    if whole >= 10**digits:
        power, whole = power + 1, whole // 10
    text = str(whole)
    sign = "-" if value < 0 else ""
    if -4 <= power < digits and power < 16:
        if power < 0:
            return f"{sign}0.{'0' * (-power - 1)}{text}"
        return f"{sign}{text[: power + 1]}.{text[power + 1 :]}".rstrip(".")
    return f"{sign}{text[0]}.{text[1:]}".rstrip(".") + f"e{power}"


def decade(value: Fraction) -> int:
    """The largest power of ten, as its exponent, that is at most ``value``."""
    power = math.floor((math.log2(value.numerator) - math.log2(value.denominator)) * 0.30103)
    while Fraction(10) ** power > value:
        power -= 1
    while Fraction(10) ** (power + 1) <= value:
        power += 1
    return power
