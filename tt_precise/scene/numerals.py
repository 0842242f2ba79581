"""Exact numbers with units: decimals and fractions, stored as ``Fraction``."""

from __future__ import annotations

import decimal
import math
import re
from contextlib import suppress
from fractions import Fraction
from numbers import Integral
from typing import Any, NamedTuple

from tt_precise.runtime.values import Array, Functions, InputError, Scalar, shortened, whole

_DECIMAL = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = rf"(?:{_DECIMAL}|pi)"
_PRODUCT = rf"{_FACTOR}(?:\s*[*/]\s*{_FACTOR}){{0,3}}"
_EXPRESSION = re.compile(
    rf"(?P<sign>[+-]?)\s*(?P<first>{_PRODUCT})"
    rf"(?:\s*(?P<operator>[+-])\s*(?P<second>{_PRODUCT}))?"
    r"(?:\s*(?P<unit>[a-zA-Z][a-zA-Z0-9^./ -]{0,40}))?",
    re.ASCII,
)
_POWER = re.compile(r"([a-zA-Z]+)(?:\^(-?\d(?:\.5)?))?")  # A unit and its power: m, m^2, mm^1.5.
LONGEST = 2000  # Characters of a numeral: a hostile file cannot build a huge integer.
# Bits of a numerator or denominator, about 1,000 digits: a moment of inertia, a product of four
# such numbers, stays below the 4,300 digits that Python prints.
MOST_BITS = 3400
LARGEST = 10**300
IRRATIONAL_DIGITS = 100
PI = Fraction(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534"
    "211706798214808651328230664709384460955058223172535940812848111745028410270193852110555964462"
    "2948954930381964428810975665933446128475648233"
)


class WithPi(NamedTuple):
    """The exact number ``plain`` + ``of_pi`` times pi."""

    plain: Fraction
    of_pi: Fraction = Fraction(0)

    def __mul__(self, other: Any) -> WithPi:
        """The product; raises ``ArithmeticError`` if it has pi squared."""
        if self.of_pi and other.of_pi:
            raise ArithmeticError("the number has pi squared")
        mixed = self.plain * other.of_pi + self.of_pi * other.plain
        return WithPi(self.plain * other.plain, mixed)

    @property
    def rational(self) -> Fraction:
        """The number itself, or the decimal of ``IRRATIONAL_DIGITS`` digits nearest to it."""
        if not self.of_pi:
            return self.plain
        value = self.plain + self.of_pi * PI
        with decimal.localcontext(prec=IRRATIONAL_DIGITS):
            return Fraction(decimal.Decimal(value.numerator) / value.denominator)


Dimension = tuple[Fraction, ...]  # powers of kg, m, s and rad
UNITS: dict[str, tuple[WithPi, tuple[int, int, int, int]]] = {
    "kg": (WithPi(Fraction(1)), (1, 0, 0, 0)), "g": (WithPi(Fraction(1, 1000)), (1, 0, 0, 0)),
    "m": (WithPi(Fraction(1)), (0, 1, 0, 0)), "cm": (WithPi(Fraction(1, 100)), (0, 1, 0, 0)),
    "mm": (WithPi(Fraction(1, 1000)), (0, 1, 0, 0)), "s": (WithPi(Fraction(1)), (0, 0, 1, 0)),
    "ms": (WithPi(Fraction(1, 1000)), (0, 0, 1, 0)), "N": (WithPi(Fraction(1)), (1, 1, -2, 0)),
    "rad": (WithPi(Fraction(1)), (0, 0, 0, 1)),
    "deg": (WithPi(Fraction(0), Fraction(1, 180)), (0, 0, 0, 1)),
    "rev": (WithPi(Fraction(0), Fraction(2)), (0, 0, 0, 1)),
    "rpm": (WithPi(Fraction(0), Fraction(1, 30)), (0, 0, -1, 1)),
}  # fmt: skip


def unit_named(text: str) -> tuple[WithPi, Dimension]:
    """Return the factor to SI and the dimension of a product of units: "g mm^2", "N/mm^1.5".

    The root of a factor that is no square, as in mm^1.5, is rounded to ``IRRATIONAL_DIGITS``
    digits.

    Raises ``ValueError``: it is no product of ``UNITS``, or pi has another power than 1.
    """
    factor, radicand, dimension = WithPi(Fraction(1)), Fraction(1), [Fraction(0)] * 4
    for sign, words in zip((1, -1, -1), text.split("/"), strict=False):
        for word in words.split():
            form = _POWER.fullmatch(word)
            if form is None or form[1] not in UNITS:
                raise ValueError(f"{word} is none of the units {', '.join(UNITS)}")
            scale, powers = UNITS[form[1]]
            power = sign * Fraction(form[2] or 1)
            if scale.of_pi:
                if power != 1 or factor.of_pi:
                    raise ValueError(f"{word} stands once, and not below a fraction's line")
                factor *= scale
            else:
                factor *= WithPi(scale.plain ** math.floor(power))
                radicand *= scale.plain if power.denominator == 2 else 1
            dimension = [a + power * b for a, b in zip(dimension, powers, strict=True)]
    with decimal.localcontext(prec=IRRATIONAL_DIGITS):
        root = (decimal.Decimal(radicand.numerator) / radicand.denominator).sqrt()
    return factor * WithPi(Fraction(root)), tuple(dimension)


def exact(value: Any, what: str = "number") -> Fraction:
    """Return the exact value of a decimal ("0.02", "1e-9"), a fraction, a quotient or a product.

    A value with pi ("pi/18") is rounded to ``IRRATIONAL_DIGITS`` digits.

    Raises ``InputError`` for anything else: a float is already rounded; NaN, infinity and a number
    with a unit are refused.
    """
    number, unit = parse(value, what)
    if unit:
        raise InputError(f"{what}: got {shortened(value)}, expected a number without a unit")
    return number.rational


def parse(value: Any, what: str = "number") -> tuple[WithPi, str]:
    """Return an exact number with pi apart, and the text of the unit that follows the number.

    Raises ``InputError``: it is no exact number, or has more than 1000 digits.
    """
    number, unit = None, ""
    if isinstance(value, Fraction):
        number = WithPi(value)
    elif (integer := whole(value)) is not None:
        number = WithPi(Fraction(integer))
    elif isinstance(value, str) and len(value) <= LONGEST:
        form = _EXPRESSION.fullmatch(value.strip())
        with suppress(ArithmeticError, ValueError):
            number = _evaluated(form) if form else None
        unit = (form["unit"] or "") if form else ""
    if number is None:
        raise InputError(
            f"{what}: got {shortened(value)}, expected an exact number as a string, such as "
            '"0.02", "1e-9", "131/350" or "0.004/0.017", or with a unit, such as "15 g"'
        )
    for part in number:
        if max(part.numerator.bit_length(), part.denominator.bit_length()) > MOST_BITS:
            raise InputError(
                f"{what}: got {shortened(value)}, expected a number of at most 1000 digits"
            )
    return number, unit


def _evaluated(form: re.Match[str]) -> WithPi:
    """Return a product, or the sum of two of which one has pi: "2024-01-01" is no number."""
    sums = [Fraction(0), Fraction(0)]
    for sign, product in ((form["sign"], form["first"]), (form["operator"], form["second"])):
        value, powers_of_pi = Fraction(-1 if sign == "-" else 1), 0
        for operator, factor in re.findall(r"([*/]?)\s*([^*/\s]+)", product or ""):
            power = -1 if operator == "/" else 1
            if factor == "pi":
                powers_of_pi += power
            else:
                value *= Fraction(factor) ** power
        if product:
            sums[(0, 1).index(powers_of_pi)] += value
    if form["second"] and not sums[1]:
        raise ValueError("a sum of two numbers without pi")
    return WithPi(*sums)


def decimal_of(value: Any) -> Any:
    """Return the shortest decimal of a finite float, as in TOML; anything else unchanged.

    A float is one of Python or NumPy of any width, or a ``Decimal``, also in an array without axes.
    """
    value = scalar(value)
    plain = isinstance(value, float)
    # float32(0.1) is 0.1, not the 0.100000001490116 that its conversion to double would print
    wide = getattr(getattr(value, "dtype", None), "kind", "") == "f" and not plain
    if wide or isinstance(value, decimal.Decimal):
        return str(value)
    return float.__repr__(value) if plain and math.isfinite(value) else value


def scalar(value: Any) -> Any:
    """Return the number in an array without axes; anything else unchanged."""
    return value[()] if getattr(value, "shape", None) == () else value


def within_doubles(value: Fraction, what: str) -> Fraction:
    """Return the value, refused outside the range of doubles.

    Raises ``InputError``: it is beyond ``LARGEST``.
    """
    if abs(value) > LARGEST:
        raise InputError(f"{what}: got more than 1e300, expected a number in the range of double")
    return value


def to_mpmath(value: Fraction, context: Functions) -> Scalar:
    """The exact ``value`` rounded once into an mpmath context."""
    from mpmath.libmp import from_rational  # here, so that a check in double need not import it

    return context.make_mpf(from_rational(value.numerator, value.denominator, context.prec, "n"))


def as_fraction(t: Scalar) -> Fraction:
    """Return the exact value of a time: a string, an int, a fraction, or a float of any kind.

    The number may stand in an array without axes.

    Raises ``InputError``: it is not a finite number within the range of doubles.
    """
    t = scalar(t)
    if hasattr(t, "_mpf_") and t - t == 0:
        sign, mantissa, power, _ = t._mpf_
        return within_doubles(
            Fraction(int(mantissa) * (-1) ** sign) * Fraction(2) ** int(power), "t"
        )
    if isinstance(t, Integral) or not hasattr(t, "as_integer_ratio"):
        return within_doubles(exact(t, "t"), "t")
    try:
        return within_doubles(Fraction(*map(int, t.as_integer_ratio())), "t")
    except (ValueError, OverflowError):
        raise InputError(f"t: got {t}, expected a finite time in s") from None


def shortest_texts(values: Array) -> list[str | None]:
    """The shortest texts that recover doubles (one axis), as ``repr``; None for NaN."""
    import numpy

    return [None if math.isnan(x) else repr(x) for x in numpy.asarray(values, float).tolist()]
