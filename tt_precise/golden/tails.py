"""Enclosures of printed numbers by their last digits.

Numbers are proved to more digits than are printed. Of these the last sixteen are stored, thirteen
that are printed and three beyond: with the printed number they say where the exact one lies, to a
unit of the sixteenth. A printed number that is changed by less than 5e12 units in its last place
does not fit them; a larger change is one in the first 22 digits, which ``verify`` computes again.
"""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction

from tt_precise.golden.digits import DIGITS, ZERO
from tt_precise.golden.outward import Outward

BEYOND = 3  # digits behind the last printed one
STORED = 16
_MODULUS = 10**STORED
_WIDE = Context(prec=200)


def last_place(text: str, scale: Decimal) -> int:
    """The power of ten of the last printed digit; "0" is printed to 34 digits of the scale."""
    if text == ZERO:
        return scale.adjusted() - DIGITS
    exponent = Decimal(text).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(f"got {text}, expected a number")
    return exponent


def tail(text: str, low: Fraction, high: Fraction, scale: Decimal) -> str:
    """The last digits of a number between ``low`` and ``high`` that is printed as ``text``.

    Empty if the interval is wider than the last of them.
    """
    unit = Fraction(10) ** (last_place(text, scale) - BEYOND)
    whole = round((low + high) / 2 / unit)
    if not (whole - 1) * unit <= low <= high <= (whole + 1) * unit:
        return ""
    return f"{whole % _MODULUS:0{STORED}d}"


def enclosed(text: str, digits: str, scale: Decimal) -> Outward:
    """Where the number printed as ``text`` lies that has these last digits.

    Raises
    ------
    ValueError
        Either is no number.
    """
    place = last_place(text, scale) - BEYOND
    near = int(Decimal(text).scaleb(-place, _WIDE))
    whole = int(digits)
    whole += _MODULUS * ((near - whole + _MODULUS // 2) // _MODULUS)
    return Outward(Decimal(whole - 1).scaleb(place, _WIDE), Decimal(whole + 1).scaleb(place, _WIDE))
