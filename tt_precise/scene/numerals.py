"""Exact numbers: decimals and fractions, stored as ``Fraction``, converted to any arithmetic."""

from __future__ import annotations

import decimal
import math
import re
import string
from contextlib import suppress
from fractions import Fraction
from numbers import Integral
from typing import Any, NamedTuple

from tt_precise.runtime.values import (
    Array,
    Functions,
    InputError,
    Scalar,
    shortened,
    whole,
)

_DECIMAL = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?"
_FACTOR = rf"(?:{_DECIMAL}|pi)"
_PRODUCT = rf"{_FACTOR}(?:\s*[*/]\s*{_FACTOR}){{0,3}}"
_EXPRESSION = re.compile(
    rf"(?P<sign>[+-]?)\s*(?P<first>{_PRODUCT})"
    rf"(?:\s*(?P<operator>[+-])\s*(?P<second>{_PRODUCT}))?(?:\s*(?P<unit>[a-z]+(?:/[a-z]+)?(?:\^2)?))?",
    re.ASCII,
)
_LETTERS = string.ascii_letters + "/^2 "  # of units
LONGEST = 2000  # Characters of a numeral: a hostile file cannot build a huge integer.
# Bits of a numerator or denominator, about 1,000 digits: a moment of inertia, a product of four
# such numbers, stays below the 4,300 digits that Python prints.
MOST_BITS = 3400
LARGEST = 10**300
SURELY_WITHIN = 990  # Bits of a whole part that ``LARGEST`` exceeds, compared without dividing.
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
            raise ArithmeticError
        mixed = self.plain * other.of_pi + self.of_pi * other.plain
        return WithPi(self.plain * other.plain, mixed)

    @property
    def rational(self) -> Fraction:
        """The number itself, or the decimal of ``IRRATIONAL_DIGITS`` digits nearest to it."""
        if not self.of_pi:
            return self.plain
        value = self.plain + self.of_pi * PI
        with decimal.localcontext(prec=IRRATIONAL_DIGITS):
            return Fraction(decimal.Decimal(value.numerator) / decimal.Decimal(value.denominator))


ONE = WithPi(Fraction(1))
# The units that may follow a number, by the unit of the entry, and their values in that unit.
UNITS = {
    "kg": {"kg": ONE, "g": WithPi(Fraction(1, 1000))},
    "m": {"m": ONE, "cm": WithPi(Fraction(1, 100)), "mm": WithPi(Fraction(1, 1000))},
    "g": {"g": ONE, "kg": WithPi(Fraction(1000))},
    "mm": {"mm": ONE, "cm": WithPi(Fraction(10)), "m": WithPi(Fraction(1000))},
    "s": {"s": ONE},
    "m/s": {"m/s": ONE, "cm/s": WithPi(Fraction(1, 100)), "mm/s": WithPi(Fraction(1, 1000))},
    "m/s^2": {"m/s^2": ONE},
    "rad": {"rad": ONE, "deg": WithPi(Fraction(0), Fraction(1, 180))},
    "rad/s": {
        "rad/s": ONE, "deg/s": WithPi(Fraction(0), Fraction(1, 180)),
        "rev/s": WithPi(Fraction(0), Fraction(2)), "rpm": WithPi(Fraction(0), Fraction(1, 30)),
    },
}  # fmt: skip
# The entries of a scene that have a unit of ``UNITS``.
UNIT_OF = {
    "m": "kg", "R": "m", "g": "m/s^2", "until": "s", "sample_every": "s", "theta": "rad",
    "theta_dot": "rad/s", "phi_dot": "rad/s", "omega_3": "rad/s", "psi_dot": "rad/s",
    "nu_x": "m/s", "nu_y": "m/s", "height": "m", "rise": "m/s", "v_s": "m/s", "epsilon": "m/s",
}  # fmt: skip
# The keys that end in their unit, but for those of moments.
KEY_UNITS = {"m_g": "g", "R_mm": "mm", "centre_mm": "mm", "centre_m": "m"}
# The entries that are ratios: their units, and the keys that take a size.
RATIO_OF = {"alpha": "R", "I1": "m R^2", "I3": "m R^2"}
SIZE_KEYS = {"R": "centre_mm or centre_m", "m R^2": "I1_g_mm2 or I1_kg_m2 (so for I3)"}


def exact(value: str | int | Fraction, what: str = "number") -> Fraction:
    """The exact value of a decimal ("0.02", "1e-9"), a fraction, or a quotient or product of these.

    A value with pi ("pi/18") is rounded to ``IRRATIONAL_DIGITS`` digits.

    Raises ``InputError`` for anything else: a float is already rounded; NaN and infinity are
    refused.
    """
    return parse(value, what).rational


def parse(value: str | int | Fraction, what: str = "number", unit: str = "") -> WithPi:
    """Read a number as ``exact``, with pi apart, in ``unit``, a key of ``UNITS`` where it has one.

    Raises ``InputError``: as ``exact``.
    """
    number = _parse(value, unit)
    if number is None:
        with_unit = isinstance(value, str) and _parse(value.rstrip(_LETTERS), "") is not None
        alone = " without a unit" if with_unit else ""
        if unit in SIZE_KEYS:
            alone = f" in units of {unit} (a size has the key {SIZE_KEYS[unit]})"
        units = ", ".join(f'"10 {one}"' for one in UNITS.get(unit, ()))
        raise InputError(
            f"{what}: got {shortened(value)}, expected an exact number as a string"
            f'{"" if units else alone}, such as "0.02", "1e-9", "131/350" or "0.004/0.017"'
            + (f" or, with a unit, {units}" if units else "")
        )
    for part in number:
        if max(part.numerator.bit_length(), part.denominator.bit_length()) > MOST_BITS:
            raise InputError(
                f"{what}: got {shortened(value)}, expected a number of at most 1000 digits"
            )
    return number


def _parse(value: Any, unit: str) -> WithPi | None:
    """The number of a fraction, an integer or a text; None for anything else."""
    if isinstance(value, Fraction):
        return WithPi(value)
    if (number := whole(value)) is not None:
        return WithPi(Fraction(number))
    if isinstance(value, str) and len(value) <= LONGEST:
        form = _EXPRESSION.fullmatch(value.strip())
        with suppress(ArithmeticError):
            factor = UNITS.get(unit, {}).get(form["unit"]) if form and form["unit"] else ONE
            return _evaluated(form) * factor if form and factor else None
    return None


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


def written(value: Scalar, name: str = "number", what: str = "") -> Fraction:
    """``exact`` for the numbers of files and users, of every type that ``decimal_of`` knows.

    A number may have a unit if ``name`` is in ``UNIT_OF`` or ``KEY_UNITS``. Errors say ``what`` it
    is.

    Raises ``InputError``: as ``exact``; NaN and infinity too.
    """
    unit = (UNIT_OF | KEY_UNITS | RATIO_OF).get(name, "")
    return parse(decimal_of(value), what or name, unit).rational


def has_unit(value: Any) -> bool:
    """True for a text that ends in a unit."""
    form = _EXPRESSION.fullmatch(str(value).strip())
    return bool(form and form["unit"])


def decimal_of(value: Any) -> Any:
    """The shortest decimal of a finite float, as in TOML; anything else unchanged.

    A float is one of Python or NumPy of any width, or a ``Decimal``, also in an array without axes.
    """
    value = scalar(value)
    # float32(0.1) is 0.1, not the 0.100000001490116 that its conversion to double would print
    if isinstance(value, decimal.Decimal) or _is_wide_float(value):
        return str(value)
    return float.__repr__(value) if isinstance(value, float) and math.isfinite(value) else value


def scalar(value: Any) -> Any:
    """The number in an array without axes; anything else unchanged."""
    return value[()] if getattr(value, "shape", None) == () else value


def _is_wide_float(value: Any) -> bool:
    """True for a NumPy float that is no Python float: float16, float32, longdouble."""
    return hasattr(value, "dtype") and value.dtype.kind == "f" and not isinstance(value, float)


def within_doubles(value: Fraction, what: str) -> Fraction:
    """Return the value, refused outside the range of doubles.

    Raises ``InputError``: it is beyond ``LARGEST``.
    """
    size = value.numerator.bit_length() - value.denominator.bit_length()
    if size > SURELY_WITHIN and abs(value) > LARGEST:
        digits = math.floor((abs(value) // 1).bit_length() * math.log10(2)) + 1
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

    The number may stand in an array without axes.

    Raises ``InputError``: it is not a finite number within the range of doubles.
    """
    return within_doubles(_as_fraction(scalar(t)), "t")


def _as_fraction(t: Scalar) -> Fraction:
    if hasattr(t, "_mpf_"):
        sign, mantissa, power, _ = t._mpf_
        if t - t != 0:
            raise InputError(f"t: got {t}, expected a finite time in s")
        value = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        return -value if sign else value
    if not isinstance(t, Integral) and hasattr(t, "as_integer_ratio"):
        try:
            return Fraction(*map(int, t.as_integer_ratio()))
        except (ValueError, OverflowError):
            raise InputError(f"t: got {t}, expected a finite time in s") from None
    return parse(t, "t", "s").rational


def shortest_texts(values: Array) -> list[str | None]:
    """The shortest texts that recover doubles (one axis), as ``repr``; None for NaN."""
    import numpy

    return [None if math.isnan(x) else repr(x) for x in numpy.asarray(values, float).tolist()]
