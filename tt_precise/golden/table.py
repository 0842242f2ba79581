"""Tables of printed decimals: reading, writing, and the rule of printed digits.

A cell has the most significant digits, 34 at most, to which all computed values round alike;
``RULE`` says so in every manifest. Computed values are ``Decimal``, exact images of their text.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, InvalidOperation, localcontext
from functools import cached_property

from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import InputError, Json, Scalar
from tt_precise.scene.numerals import as_fraction

FORMAT = "tt_precise.golden/2"  # The form of golden tables and their manifest.
DIGITS = 34  # Most digits of a cell; IEEE decimal128 and Fortran's real(16) hold as many.
RULE = (
    "An entry is printed with the most significant digits, 34 at most, to which all runs round "
    "alike; so every printed digit is the correctly rounded one, as far as they agree. Digits "
    "count relative to the entry itself. Near a zero of a component they count relative to its "
    "scale, its largest entry in trajectory.csv: an entry with fewer than 34 digits whose last "
    "one still lies below 1e-33 of the scale is near_zero, and 0 stands for less than 1e-34 of "
    "the scale. An empty cell is undefined (Euler angles at a pole)."
)
EXACTLY = Context(prec=400)  # Digits with which differences of computed values are exact.
ZERO = "0"
LABELS = ("name", "direction")  # Columns of events without computed numbers.
PRINTED = re.compile(r"-?(?:0|\d(?:\.\d+)?e[+-]\d+)", re.ASCII)
FORMS = {
    "name": re.compile(r"\w+", re.ASCII),
    "t": re.compile(rf"{PRINTED.pattern}|\d+(?:\.\d+)?", re.ASCII),
    "direction": re.compile(r"[+-]?1|0", re.ASCII),
}
NEVER_EMPTY = {*FORMS, *NewtonState._fields}  # Euler columns are undefined at the poles.


@dataclass(frozen=True)
class Table:
    """Rows of text under named columns; "" where a value is undefined."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        for line, row in enumerate(self.rows, start=2):
            if len(row) != len(self.columns):
                raise InputError(f"line {line}: got {len(row)} cells, expected {len(self.columns)}")

    @classmethod
    def of_columns(cls, columns: Mapping[str, Sequence[str]]) -> Table:
        return cls(tuple(columns), tuple(zip(*columns.values(), strict=True)))

    @classmethod
    def parse(cls, text: str) -> Table:
        """Read CSV text with one header line; quotes around cells are ignored.

        Raises ``InputError``: no header, a name twice, or a row of another length.
        """
        lines = text.replace('"', "").splitlines()
        rows = [tuple(map(str.strip, line.split(","))) for line in lines if line]
        if not rows or len(set(rows[0])) != len(rows[0]):
            raise InputError("line 1: expected a header line with different names")
        return cls(rows[0], tuple(rows[1:]))

    def csv(self) -> str:
        return "".join(",".join(row) + "\n" for row in (self.columns, *self.rows))

    def column(self, name: str) -> tuple[str, ...]:
        return self._cells[self.columns.index(name)]

    def cells(self, row: int, names: Sequence[str]) -> list[str]:
        return [self.column(name)[row] for name in names]

    def floats(self, name: str) -> tuple[float, ...]:
        """The numbers under ``name``, rounded to double; NaN where a cell is empty."""
        return tuple(float(cell) if cell else math.nan for cell in self.column(name))

    @property
    def numbers(self) -> tuple[str, ...]:
        """The names of the columns of numbers, t first."""
        return tuple(name for name in self.columns if name not in LABELS)

    @cached_property
    def scales(self) -> dict[str, Decimal]:
        """The largest magnitude in each column of numbers, rounded to three digits."""
        with localcontext(prec=3):
            return {
                name: max((abs(Decimal(x)) for x in self.column(name) if x), default=Decimal(0))
                for name in self.numbers
            }

    @cached_property
    def _cells(self) -> tuple[tuple[str, ...], ...]:
        return tuple(zip(*self.rows, strict=True)) if self.rows else ((),) * len(self.columns)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the content, independent of line ends and spaces in a file."""
        return hashlib.sha256(self.csv().encode()).hexdigest()


def malformed_cells(file: str, table: Table) -> list[str]:
    """A line for each cell that is not a number in the form of golden data."""
    return [
        f"{file}, line {line}, {name}: got {cell[:50]!r}, expected a printed number"
        for line, row in enumerate(table.rows, start=2)
        for name, cell in zip(table.columns, row, strict=True)
        if not FORMS.get(name, PRINTED).fullmatch(cell) and (cell or name in NEVER_EMPTY)
    ]


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
    if not (first and difference.is_finite()):
        return -math.inf
    ratio = Context(prec=9).divide(difference, abs(first))
    return -(ratio.adjusted() + math.log10(ratio.scaleb(-ratio.adjusted())))


def digits_of(text: str) -> int:
    """Significant digits of a printed cell that is not zero."""
    return len(text.lstrip("-").partition("e")[0].replace(".", ""))


def last_digit_exponent(text: str) -> int:
    """The power of ten of the last printed digit."""
    mantissa, _, exponent = text.partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])


def is_near_zero(text: str, scale: Decimal) -> bool:
    """Test if a printed cell may have fewer digits because it is small relative to its scale."""
    if text == ZERO:
        return True
    if digits_of(text) >= DIGITS:
        return False
    return Decimal(1).scaleb(last_digit_exponent(text)) <= scale.scaleb(1 - DIGITS)


def claims(cells: Sequence[str], scale: Decimal) -> dict[str, Json]:
    """The claims for a column, which follow from its printed cells.

    ``digits`` are the fewest of a cell that is not near zero, None if there is none; ``near_zero``
    and ``undefined`` count cells; ``scale`` has three digits.
    """
    present = [cell for cell in cells if cell]
    counted = [digits_of(cell) for cell in present if not is_near_zero(cell, scale)]
    return {
        "digits": min(counted, default=None),
        "scale": f"{scale:.2e}",
        "near_zero": len(present) - len(counted),
        "undefined": len(cells) - len(present),
    }


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
