"""Exact numbers: decimal or fraction strings in, ``Fraction`` inside, any arithmetic out."""

from __future__ import annotations

import decimal
import math
import re
from fractions import Fraction
from numbers import Integral
from typing import Any, NamedTuple

from tt_precise.runtime.values import Array, Functions, InputError, Scalar

_DECIMAL = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = rf"(?:{_DECIMAL}|pi)"
_PRODUCT = rf"{_FACTOR}(?:\s*[*/]\s*{_FACTOR}){{0,3}}"
_EXPRESSION = re.compile(
    rf"(?P<sign>[+-]?)\s*(?P<first>{_PRODUCT})"
    rf"(?:\s*(?P<operator>[+-])\s*(?P<second>{_PRODUCT}))?(?:\s+(?P<unit>deg(?:/s)?))?",
    re.ASCII,
)
# Characters. With three digits of exponent an integer stays below the 4300 digits that Python
# prints, and a hostile file cannot build a huge integer.
LONGEST = 2000
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

    @property
    def rational(self) -> Fraction:
        """The number itself, or the decimal of ``IRRATIONAL_DIGITS`` digits nearest to it."""
        if not self.of_pi:
            return self.plain
        value = self.plain + self.of_pi * PI
        with decimal.localcontext(prec=IRRATIONAL_DIGITS):
            return Fraction(decimal.Decimal(value.numerator) / decimal.Decimal(value.denominator))


def whole(value: Any) -> int | None:
    """A whole number of Python or NumPy as an int; None for anything else."""
    return None if isinstance(value, bool) or not isinstance(value, Integral) else int(value)


def exact(value: str | int | Fraction, what: str = "number") -> Fraction:
    """The exact value of a decimal ("0.02", "1e-9"), a fraction, or a quotient or product of these.

    A value with pi ("pi/18") is rounded to ``IRRATIONAL_DIGITS`` digits.

    Raises ``InputError`` for anything else: a float is already rounded; NaN and infinity are
    refused.
    """
    return read(value, what).rational


def read(value: str | int | Fraction, what: str = "number", unit: str = "") -> WithPi:
    """As ``exact``, with pi kept apart; ``unit`` is "deg" or "deg/s" if that unit is allowed.

    Raises ``InputError``: as ``exact``.
    """
    if isinstance(value, Fraction):
        return WithPi(value)
    if (number := whole(value)) is not None:
        return WithPi(Fraction(number))
    if isinstance(value, str) and len(value) <= LONGEST:
        text = value.strip()
        try:
            form = _EXPRESSION.fullmatch(text)
            if form and (form["unit"] or unit) == unit:
                return _evaluated(form)
        except ArithmeticError:
            pass
    shown = repr(value) if len(repr(value)) <= 60 else repr(value)[:57] + "..."
    raise InputError(
        f"{what}: got {shown}, expected an exact number as a string, "
        'such as "0.02", "1e-9", "131/350" or "0.004/0.017"' + (f', or "10 {unit}"' if unit else "")
    )


def _evaluated(form: re.Match[str]) -> WithPi:
    parts = _product(form["first"])
    sign = -1 if form["sign"] == "-" else 1
    plain, of_pi = sign * parts.plain, sign * parts.of_pi
    if form["second"]:
        more = _product(form["second"])
        if not (of_pi or more.of_pi):  # "2024-01-01" is not a number
            raise ArithmeticError
        sign = -1 if form["operator"] == "-" else 1
        plain, of_pi = plain + sign * more.plain, of_pi + sign * more.of_pi
    if form["unit"]:
        if of_pi:
            raise ArithmeticError
        return WithPi(Fraction(0), plain / 180)
    return WithPi(plain, of_pi)


def _product(text: str) -> WithPi:
    first, *rest = re.split(r"\s*([*/])\s*", text)
    value, powers = Fraction(1), 0
    for operator, factor in zip(("*", *rest[::2]), (first, *rest[1::2]), strict=True):
        power = 1 if operator == "*" else -1
        if factor == "pi":
            powers += power
        else:
            value *= Fraction(factor) ** power
    if powers not in (0, 1):
        raise ArithmeticError
    return WithPi(Fraction(0), value) if powers else WithPi(value)


def written(value: str | float | Fraction, what: str = "number", unit: str = "") -> Fraction:
    """``exact`` for numbers in files and code: a float stands for its shortest decimal, as in TOML.

    Raises ``InputError``: as ``exact``; NaN and infinity too.
    """
    return read(decimal_of(value), what, unit).rational


def decimal_of(value: Any) -> Any:
    """The shortest decimal of a finite float; anything else as it is."""
    if isinstance(value, float) and math.isfinite(value):
        return float.__repr__(value)
    return value


def within_doubles(value: Fraction, what: str) -> Fraction:
    """The value, if it is within the range of doubles.

    Raises ``InputError``: it is beyond ``LARGEST``.
    """
    if abs(value) > LARGEST:
        digits = len(str(abs(value.numerator) // value.denominator))
        raise InputError(
            f"{what}: got a number of {digits} digits before the point, expected at most 1e300 "
            "in size (the range of double)"
        )
    return value


def to_mpmath(value: Fraction, context: Functions) -> Scalar:
    """The exact ``value`` rounded once into an mpmath context."""
    from mpmath.libmp import from_rational  # here, so that a check in double need not import it

    return context.make_mpf(from_rational(value.numerator, value.denominator, context.prec, "n"))


def as_fraction(t: Scalar) -> Fraction:
    """The exact value of a time: a string, an int, a fraction, or a float of any kind.

    Raises ``InputError``: it is not a finite number.
    """
    if hasattr(t, "_mpf_"):
        sign, mantissa, power, _ = t._mpf_
        if t - t != 0:
            raise InputError(f"t: got {t}, expected a finite time in s")
        value = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        return -value if sign else value
    if isinstance(t, bool):
        return exact(t, "t")
    if isinstance(t, Integral):  # NumPy's integers too
        return Fraction(int(t))
    if not hasattr(t, "as_integer_ratio"):
        return exact(t, "t")
    try:
        return Fraction(*map(int, t.as_integer_ratio()))
    except (ValueError, OverflowError):
        raise InputError(f"t: got {t}, expected a finite time in s") from None


def shortest_texts(values: Array) -> list[str | None]:
    """The shortest texts that recover doubles (one axis), as ``repr``; None for NaN."""
    import numpy

    return [None if math.isnan(x) else repr(x) for x in numpy.asarray(values, float).tolist()]
