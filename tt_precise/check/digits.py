"""Correct digits of columns, counted as in ``golden.compare``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from typing import Any

from tt_precise.golden.digits import scale_of
from tt_precise.golden.runs import DIGITS

NEAR_ZERO = Decimal("1e-3")  # of a column's scale: what smaller entries are measured against


@dataclass
class Digits:
    """The fewest correct digits of every column so far, and where the fewest of all were.

    Digits are relative to the true entry, or to 1e-3 of the largest one of its column
    (``scales``) where it is smaller than that; at most 34.
    """

    scales: Mapping[str, Decimal]
    fewest: dict[str, float] = field(default_factory=dict)
    worst: float = math.inf
    at: float | None = None
    rows: int = 0

    @classmethod
    def of_columns(cls, cells: Mapping[str, Sequence[str]]) -> Digits:
        """Nothing compared yet; scales from the true entries of each column ("" undefined)."""
        return cls({name: scale_of(column) for name, column in cells.items()})

    def add(self, t: float, name: str, error: Decimal, true: Decimal) -> None:
        """One entry with its error, at time ``t`` (s)."""
        size = max(abs(true), self.scales[name] * NEAR_ZERO)
        found = float(DIGITS)
        if error:
            found = min(found, max(0.0, log10(size / abs(error)))) if size else 0.0
        self.fewest[name] = min(self.fewest.get(name, math.inf), found)
        if found < self.worst:
            self.worst, self.at = found, t


def log10(number: Decimal) -> float:
    """Decimal logarithm of a positive number of any size, to the precision of a float."""
    # Decimal.log10 works out all 28 digits, which took half the time of a check
    exponent = number.adjusted()
    return exponent + math.log10(number.scaleb(-exponent))


def as_decimal(value: Any) -> Decimal | None:
    """The exact value of a cell (text or number of any arithmetic); None if there is none."""
    if value is None or value == "":
        return None
    try:
        number = Decimal(value) if isinstance(value, str | int) else Decimal(float(value))
        if hasattr(value, "_mpf_"):
            number = Decimal(str(value))
    except (InvalidOperation, TypeError, ValueError):
        return None
    return number if number.is_finite() else None
