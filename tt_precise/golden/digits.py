"""Correct digits of a cell: agreement of computed values, and the printed decimal.

The rule, which every manifest repeats (``RULE``): a cell has the most significant digits, 34 at
most, to which all computed values round alike. Numbers here are ``Decimal``, exact images of the
computed text.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from decimal import Context, Decimal, InvalidOperation, localcontext
from typing import NamedTuple

from tt_precise.golden.table import Table
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.numerals import as_fraction

DIGITS = 34  # published at most; IEEE decimal128 and Fortran's real(16) hold as many
RULE = (
    "An entry is printed with the most significant digits, 34 at most, to which all runs round "
    "alike; so every printed digit is the correctly rounded one, as far as they agree. Digits "
    "count relative to the entry itself. Near a zero of a component they count relative to its "
    "scale, its largest entry in trajectory.csv: an entry with fewer than 34 digits whose last "
    "one still lies below 1e-33 of the scale is near_zero, and 0 stands for less than 1e-34 of "
    "the scale. An empty cell is undefined (Euler angles at a pole)."
)
EXACTLY = Context(prec=400)  # enough bits that no difference of computed values is rounded
COUNTING_CONTEXT = Context(prec=9)  # for a count of digits
PRINTED = re.compile(r"-?(?:0|\d(?:\.\d+)?e[+-]\d+)", re.ASCII)
ZERO = "0"
_FORMS = {
    "name": re.compile(r"\w+", re.ASCII),
    "t": re.compile(rf"{PRINTED.pattern}|\d+(?:\.\d+)?", re.ASCII),
    "direction": re.compile(r"[+-]?1|0", re.ASCII),
}
# Euler columns are undefined at the poles, others nowhere
NEVER_EMPTY = {*_FORMS, *NewtonState._fields}


class ColumnDigits(NamedTuple):
    """The claims for one column of a table.

    digits
        Fewest significant digits printed, apart from cells near zero; None if all are zero or
        undefined.
    scale
        Largest cell of the trajectory's column, three digits.
    near_zero, undefined
        Number of cells near zero, and of empty ones.
    """

    digits: int | None
    scale: str
    near_zero: int
    undefined: int


def common_text(values: Sequence[Decimal], scale: Decimal) -> str:
    """The printed text of a cell with these computed values; "" without a common digit."""
    if all(abs(value) <= scale.scaleb(-DIGITS) for value in values):
        return ZERO
    for digits in range(DIGITS, 0, -1):
        texts = {f"{value:.{digits - 1}e}" for value in values}
        if len(texts) == 1:
            return texts.pop()
    return ""


def prints(text: str, value: Decimal, scale: Decimal) -> bool:
    """Test if a computed value is printed as ``text``, with as many digits."""
    if text == ZERO:
        return abs(value) <= scale.scaleb(-DIGITS)
    return f"{value:.{digits_of(text) - 1}e}" == text


def agreement(first: Decimal, other: Decimal) -> float:
    """Digits on which ``other`` agrees with ``first``, relative to ``first``; infinite if equal."""
    difference = abs(EXACTLY.subtract(first, other))
    if not difference:
        return math.inf
    if not first:
        return -math.inf
    return digits_left(COUNTING_CONTEXT.divide(difference, abs(first)))


def digits_left(relative_error: Decimal) -> float:
    """Correct digits with this nonzero relative error."""
    if not relative_error.is_finite():
        return -math.inf
    # Decimal.log10 works out all its digits, which took half the time of a check
    exponent = relative_error.adjusted()
    return -(exponent + math.log10(relative_error.scaleb(-exponent)))


def digits_of(text: str) -> int:
    """Significant digits of a printed cell that is not zero."""
    mantissa, _, _ = text.lstrip("-").partition("e")
    return len(mantissa.replace(".", ""))


def last_digit_exponent(text: str) -> int:
    """The power of ten of the last printed digit."""
    mantissa, _, exponent = text.partition("e")
    _, _, decimals = mantissa.partition(".")
    return int(exponent or 0) - len(decimals)


def is_near_zero(text: str, scale: Decimal) -> bool:
    """Test if a printed cell may have fewer digits because it is small relative to its scale."""
    if text == ZERO:
        return True
    if digits_of(text) >= DIGITS:
        return False
    return Decimal(1).scaleb(last_digit_exponent(text)) <= scale.scaleb(1 - DIGITS)


def scale_of(cells: Sequence[str]) -> Decimal:
    """Largest magnitude among printed or computed cells, rounded to three digits."""
    with localcontext(prec=3):
        return max((abs(Decimal(cell)) for cell in cells if cell), default=Decimal(0))


def scales_of(table: Table) -> dict[str, Decimal]:
    """``scale_of`` each column."""
    return {name: scale_of(table.column(name)) for name in table.columns}


def column_digits(cells: Sequence[str], scale: Decimal) -> ColumnDigits:
    """The claims of the printed ``cells`` of a column, derived from the text alone."""
    present = [cell for cell in cells if cell]
    claimed = [digits_of(cell) for cell in present if not is_near_zero(cell, scale)]
    return ColumnDigits(
        digits=min(claimed, default=None),
        scale=f"{scale:.2e}",
        near_zero=len(present) - len(claimed),
        undefined=len(cells) - len(present),
    )


def malformed_cells(file: str, table: Table, *, empty: bool = True) -> list[str]:
    """A line for each cell that is not a number in the form of golden data; ``empty`` cells too."""
    return [
        f"{file}, line {line}, {name}: got {cell[:50]!r}, expected a printed number"
        for line, row in enumerate(table.rows, start=2)
        for name, cell in zip(table.columns, row, strict=True)
        if not _FORMS.get(name, PRINTED).fullmatch(cell)
        and (cell or (empty and name in NEVER_EMPTY))
    ]


def correct_digits(error: float) -> float:
    """Correct digits with a relative error, between 0 and 34."""
    return min(float(DIGITS), max(0.0, -math.log10(error))) if error else float(DIGITS)


def as_decimal(value: Scalar) -> Decimal | None:
    """The exact value of a float, a decimal string or an mpmath number.

    None for a missing cell, NaN and infinity.

    Raises ``InputError``: it is not a number.
    """
    if value is None or value == "":
        return None
    if hasattr(value, "_mpf_"):
        if value - value != 0:
            return None
        exact = as_fraction(value)
        return EXACTLY.divide(Decimal(exact.numerator), Decimal(exact.denominator))
    try:
        if isinstance(value, str) and "_" in value:
            raise ValueError
        number = Decimal(value) if isinstance(value, str | int | Decimal) else Decimal(float(value))
    except (InvalidOperation, TypeError, ValueError, OverflowError):
        raise InputError(f"trajectory: got {str(value)[:60]!r}, expected a number") from None
    return number if number.is_finite() else None
