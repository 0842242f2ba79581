"""A finding of the trade-off: a number computed from the table, with its definition and its bar."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tt_precise.bench.plan import SCENE
from tt_precise.bench.work_precision import Point

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Finding:
    """One number and what it means; ``bar`` is what was aimed at, ("at least" or "below", value).

    ``value`` is None where the table does not hold what it takes.
    """

    name: str
    value: float | None
    unit: str
    definition: str
    bar: tuple[str, float] | None = None

    def __post_init__(self) -> None:
        if self.bar and self.bar[0] not in ("at least", "below"):
            raise ValueError(f"bar: got {self.bar[0]!r}, expected 'at least' or 'below'")

    @property
    def met(self) -> bool | None:
        """Whether the bar is met; None without a bar or a value."""
        if self.bar is None or self.value is None:
            return None
        kind, limit = self.bar
        return self.value >= limit if kind == "at least" else self.value < limit


def chosen(rows: pandas.DataFrame, **wanted: object) -> pandas.DataFrame:
    """Rows of the reference scene (unless another is wanted) with these values."""
    for column, value in {"scene": SCENE, **wanted}.items():
        rows = rows[rows[column] == value]
    return rows


def points(rows: pandas.DataFrame, cost: str) -> list[Point]:
    """Points (error at the end, cost) of the rows that have both."""
    kept = rows[["error", cost]].dropna()
    return [Point(float(error), float(value)) for error, value in kept.to_numpy() if error > 0]


def first(rows: pandas.DataFrame, column: str) -> float | None:
    """The value in the first row, None if there is no row."""
    return None if rows.empty else float(rows[column].iloc[0])


def quotient(above: float | None, below: float | None) -> float | None:
    """``above/below``, None if one is missing."""
    return None if above is None or not below else above / below


def least(values: Iterable[float | None]) -> float | None:
    """The smallest of those that are there."""
    there = [value for value in values if value is not None]
    return min(there, default=None)


Source = Callable[["pandas.DataFrame"], list[Finding]]
