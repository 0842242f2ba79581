"""Exact numbers: decimal or fraction strings in, ``Fraction`` inside, any arithmetic out."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

from tt_precise.errors import InputError

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?|[+-]?\d+/\d+", re.ASCII)
# Characters. With three digits of exponent an integer stays below the 4300 digits that Python is
# willing to print, and a hostile file cannot build an astronomically large one.
LONGEST = 2000


def exact(value: str | int | Fraction, what: str = "number") -> Fraction:
    """The exact value of a decimal ("0.02", "1e-9") or fraction ("131/350") string.

    Raises
    ------
    InputError
        For anything else: a float has already been rounded, NaN and infinity are no numbers here.
    """
    if isinstance(value, Fraction):
        return value
    if isinstance(value, int) and not isinstance(value, bool):
        return Fraction(value)
    if isinstance(value, str):
        text = value.strip()
        if len(text) <= LONGEST and NUMBER.fullmatch(text):
            try:
                return Fraction(text)
            except ZeroDivisionError:
                pass
    shown = repr(value) if len(repr(value)) <= 60 else repr(value)[:57] + "..."
    raise InputError(
        f"{what}: got {shown}, expected an exact number as a string, "
        'such as "0.02", "1e-9" or "131/350"'
    )


def to_mpmath(value: Fraction, context: Any) -> Any:
    """The exact ``value`` rounded once into an mpmath context (``mpmath.mp`` or an own one)."""
    from mpmath.libmp import from_rational  # here, so that a check in double need not import it

    return context.make_mpf(from_rational(value.numerator, value.denominator, context.prec, "n"))
