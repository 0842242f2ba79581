"""How the numbers of a finding are looked up: a cost on a curve, an entry, or a statistic."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from tt_precise.tradeoff.tables import TradeoffTables, chosen, costs


class Amount(NamedTuple):
    """A number from the tables (None: they do not hold it), and what the definition says of it.

    ``which`` names where it comes from, ``error`` is the error of the state that goes with it.
    """

    value: float | None
    which: str = "none"
    error: float = float("nan")


MISSING = Amount(None)


class Evaluator(Protocol):
    """What finds an amount in a table; ``table`` is the name of a field of ``TradeoffTables``."""

    @property
    def table(self) -> str:
        """Which table."""

    def amount(self, tables: TradeoffTables) -> Amount:
        """The number, where the tables hold it."""


@dataclass(frozen=True)
class CostTo:
    """What an accuracy costs the fastest of some methods, interpolated on their curves.

    ``methods`` are prefixes of names (all peers if there are none) without those that begin with
    ``but``; ``cost`` is "ratio" (to the bare heyoka loop) or "seconds".
    """

    error: float
    methods: tuple[str, ...] = ()
    formulation: str = "newton"
    precision: str = "double"
    cost: str = "ratio"
    but: str | None = None
    table: str = "rows"

    def amount(self, tables: TradeoffTables) -> Amount:
        """Its ``which`` is the fastest method."""
        rows = tables.rows
        if rows is None:
            return MISSING
        if self.methods:
            rows = rows[rows["method"].isin(_beginning(rows["method"], self.methods))]
        else:
            rows = rows[rows["peer"].astype(str) == "True"]
        prices = {
            method: known[self.error]
            for method, known in costs(
                rows, self.formulation, self.cost, [self.error], self.precision
            ).items()
            if self.error in known and not (self.but and method.startswith(self.but))
        }
        fastest = min(prices, key=lambda method: prices[method], default=None)
        return MISSING if fastest is None else Amount(prices[fastest], fastest, self.error)


def _beginning(names: Iterable[str], prefixes: tuple[str, ...]) -> Collection[str]:
    # a name is a prefix of itself: "heyoka" is the bare loop, not "heyoka, 8 lanes"
    exact = {name for name in names if name in prefixes}
    return exact or {str(name) for name in names if str(name).startswith(prefixes)}


@dataclass(frozen=True)
class TableEntry:
    """The smallest number in a column of the rows that have the given values.

    ``among`` are several values of one column, such as settings of which the fastest counts.
    """

    column: str
    row: Mapping[str, object]
    among: Mapping[str, tuple[object, ...]] = field(default_factory=dict)
    table: str = "rows"

    def amount(self, tables: TradeoffTables) -> Amount:
        """Its ``which`` is the value that ``among`` left open."""
        rows = tables.rows
        if rows is None:
            return MISSING
        rows = chosen(rows, **self.row)
        for column, values in self.among.items():
            rows = rows[rows[column].isin(values)]
        if rows.empty:
            return MISSING
        least = rows.sort_values(self.column).iloc[0]
        which = ", ".join(str(least[column]) for column in self.among)
        return Amount(float(least[self.column]), which, float(least.get("error", float("nan"))))


@dataclass(frozen=True)
class Statistic:
    """A function of a whole table."""

    table: str
    function: Callable[[Any], Amount]

    def amount(self, tables: TradeoffTables) -> Amount:
        """What the function makes of the table."""
        known = getattr(tables, self.table)
        return MISSING if known is None else self.function(known)
