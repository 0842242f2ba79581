"""``Table``: named columns of decimal strings, as in a CSV file, and its hash."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from tt_precise.runtime.values import InputError

FORMAT = "tt_precise.golden/2"  # The form of golden tables and their manifest.


@dataclass(frozen=True)
class Table:
    """Rows of text under named columns; "" where a value is undefined."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows, start=2):
            if len(row) != len(self.columns):
                raise InputError(
                    f"line {number}: got {len(row)} cells, expected {len(self.columns)}, "
                    "one for each name in the header"
                )

    @classmethod
    def of_columns(cls, columns: Mapping[str, Sequence[str]]) -> Table:
        return cls(tuple(columns), tuple(zip(*columns.values(), strict=True)))

    @classmethod
    def parse(cls, text: str) -> Table:
        """Read CSV text with one header line; quotes around cells are ignored.

        Raises ``InputError``: no header, a name twice, or a row of another length; the line is
        named.
        """
        lines = text.replace('"', "").splitlines()
        rows = [tuple(map(str.strip, line.split(","))) for line in lines if line]
        if not rows:
            raise InputError("an empty file, expected a header line")
        if len(set(rows[0])) != len(rows[0]):
            raise InputError("line 1: got a column name twice, expected each once")
        return cls(rows[0], tuple(rows[1:]))

    def csv(self) -> str:
        return "".join(",".join(row) + "\n" for row in (self.columns, *self.rows))

    def column(self, name: str) -> tuple[str, ...]:
        return self._cells[self.columns.index(name)]

    def floats(self, name: str) -> tuple[float, ...]:
        """The numbers under ``name``, rounded to double; NaN where a cell is empty."""
        return tuple(float(cell) if cell else math.nan for cell in self.column(name))

    @cached_property
    def _cells(self) -> tuple[tuple[str, ...], ...]:
        return tuple(zip(*self.rows, strict=True)) if self.rows else ((),) * len(self.columns)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the content, independent of line ends and spaces in a file."""
        return hashlib.sha256(self.csv().encode()).hexdigest()
