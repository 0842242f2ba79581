"""The tables that the trade-off leaves in the report's folder, and how they are read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.tradeoff.plan import SCENE
from tt_precise.tradeoff.work_precision import Point, cost_of

if TYPE_CHECKING:
    import pandas

TABLE, GROWTH, ESTIMATES = "tradeoff.csv", "tradeoff-growth.csv", "estimates.csv"
ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
WHOLE_S = 8.0  # the horizon of the reference scene


class TradeoffTables(NamedTuple):
    """What was measured; None where it was not."""

    rows: pandas.DataFrame | None
    long_runs: pandas.DataFrame | None = None
    estimates: pandas.DataFrame | None = None


def read(folder: Path) -> TradeoffTables:
    """The tables that lie in a folder."""
    import pandas

    files = [folder / name for name in (TABLE, GROWTH, ESTIMATES)]
    return TradeoffTables(*(pandas.read_csv(file) if file.is_file() else None for file in files))


def chosen(rows: pandas.DataFrame, **wanted: object) -> pandas.DataFrame:
    """Rows of the reference scene (unless another is wanted) with these values (None: without)."""
    for column, value in {"scene": SCENE, **wanted}.items():
        rows = rows[rows[column].isna() if value is None else rows[column] == value]
    return rows


def points(rows: pandas.DataFrame, cost: str) -> list[Point]:
    """Points (error at the end, cost) of the rows that have both."""
    both = rows[["error", cost]].dropna()
    return [Point(float(error), float(value)) for error, value in both.to_numpy() if error > 0]


def costs(
    rows: pandas.DataFrame,
    formulation: str,
    cost: str,
    accuracies: Iterable[float] = ACCURACIES,
    precision: str = "double",
) -> dict[str, dict[float, float]]:
    """For each method what each accuracy costs over the whole horizon, where it reaches it.

    The accuracy is the largest absolute error of k, L, v at the end, dimensionless; a cost is
    interpolated on the curve of the method.
    """
    mine = chosen(rows, precision=precision, formulation=formulation, horizon_s=WHOLE_S)
    wanted, found = tuple(accuracies), {}
    for method, group in mine.groupby("method", sort=False):
        prices = {accuracy: cost_of(points(group, cost), accuracy) for accuracy in wanted}
        found[str(method)] = {a: price for a, price in prices.items() if price is not None}
    return found
