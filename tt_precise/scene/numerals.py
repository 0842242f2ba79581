"""Exact numbers: decimal or fraction strings in, ``Fraction`` inside, any arithmetic out."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from numbers import Integral

from tt_precise.runtime.arithmetic import Array, Functions, Scalar
from tt_precise.runtime.errors import InputError

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?|[+-]?\d+/\d+", re.ASCII)
# Characters. With three digits of exponent an integer stays below the 4300 digits that Python is
# willing to print, and a hostile file cannot build an astronomically large one.
LONGEST = 2000
LARGEST = 10**300
PLAIN = 1e-4, 1e16  # from the first to below the second, ``repr`` writes no power of ten


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


def written(value: str | float | Fraction, what: str = "number") -> Fraction:
    """``exact``, where people write numbers: a float stands for its shortest decimal, as in TOML.

    Raises
    ------
    InputError
        As ``exact``; NaN and infinity too.
    """
    if isinstance(value, float) and math.isfinite(value):
        return exact(float.__repr__(value), what)
    return exact(value, what)  # type: ignore[arg-type]


def within_doubles(value: Fraction, what: str) -> Fraction:
    """The value, if doubles go so far.

    Raises
    ------
    InputError
        It is beyond ``LARGEST``.
    """
    if abs(value) > LARGEST:
        digits = len(str(abs(value.numerator) // value.denominator))
        raise InputError(
            f"{what}: got a number of {digits} digits before the point, expected one of at most "
            "1e300 in size, for which double has a number"
        )
    return value


def to_mpmath(value: Fraction, context: Functions) -> Scalar:
    """The exact ``value`` rounded once into an mpmath context (``mpmath.mp`` or an own one)."""
    from mpmath.libmp import from_rational  # here, so that a check in double need not import it

    return context.make_mpf(from_rational(value.numerator, value.denominator, context.prec, "n"))


def as_fraction(t: Scalar) -> Fraction:
    """The exact value of a time given as a string, or as an int, fraction, float of any kind.

    Raises
    ------
    InputError
        It is no finite number.
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
    """The shortest texts that recover doubles (float64, one axis), as ``repr``; None for NaN.

    Eight times as fast as ``repr``, which still writes infinities, and powers of ten in its way.
    """
    import numpy
    from msgspec import json

    given = numpy.asarray(values, dtype=float)
    if not given.size:
        return []
    listed = json.encode(given.tolist())[1:-1].decode("ascii")
    texts: list[str | None] = listed.split(",")  # type: ignore[assignment]
    size = abs(given)
    other = ~((size >= PLAIN[0]) & (size < PLAIN[1])) & (given != 0)
    for place in numpy.flatnonzero(other).tolist():
        value = float(given[place])
        texts[place] = None if math.isnan(value) else repr(value)
    return texts
