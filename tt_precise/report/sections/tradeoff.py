"""Speed against accuracy: findings computed from the tables of ``tt-precise tradeoff``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise.report.document import Block, Figure, PageTable, Section, Text
from tt_precise.report.figures.measured import (
    growth_of_errors,
    hidden_by_conservation,
    work_and_digits,
    work_precision,
)
from tt_precise.report.text import short
from tt_precise.runtime.records import of_its_form
from tt_precise.tradeoff.findings import (
    ACCURACIES,
    TABLE,
    Finding,
    TradeoffTables,
    costs,
    findings,
    read,
)  # fmt: skip

if TYPE_CHECKING:
    import pandas

KEY, TITLE = "tradeoff", "Speed against accuracy"
COMMAND = "tt-precise tradeoff"


def section(folder: Path) -> Section:
    """What the tables in ``folder`` say, or the command that would make them."""
    with of_its_form(folder / TABLE, f"what `{COMMAND}` writes, as its other tables"):
        return _section(read(folder))


def _section(tables: TradeoffTables) -> Section:
    rows = tables.rows
    if rows is None:
        return Section(KEY, TITLE, [Text(f"Not measured yet: `{COMMAND}`.")])
    found = findings(tables)
    blocks: list[Block] = [
        Text(
            f"Measured by `{COMMAND}`; not by the run that wrote this page. Every method "
            "integrates the same equations from the same dimensionless numbers, and is compared "
            "with golden data; "
            f"all settings stand in `{TABLE}`. Times are measured in turn, the fastest of "
            "several; ratios are medians of ratios to a bare heyoka loop timed just before."
        ),
        *figures(rows, tables.long_runs),
        _costs_table(rows, "newton", "Newton form"),
        _costs_table(rows, "euler", "Euler form"),
        _findings_table(found),
    ]
    results = {one.name: {"value": short(one.value, 3)} for one in found if one.value is not None}
    return Section(KEY, TITLE, blocks, results)


def figures(rows: pandas.DataFrame, long_runs: pandas.DataFrame | None) -> list[Figure]:
    """The diagrams."""
    drawn = [work_precision(rows), work_and_digits(rows), hidden_by_conservation(rows)]
    return drawn if long_runs is None else [*drawn, growth_of_errors(long_runs)]


def _costs_table(rows: pandas.DataFrame, coordinates: str, title: str) -> PageTable:
    every = costs(rows, coordinates, "seconds")
    wanted = sorted(every.items(), key=lambda item: (-len(item[1]), *item[1].values()))
    return PageTable(
        ("method", *(f"ms to {accuracy:.0e}" for accuracy in ACCURACIES)),
        [
            (method, *(_milliseconds(prices.get(accuracy)) for accuracy in ACCURACIES))
            for method, prices in wanted
            if prices
        ],
        f"{title}, double: what an error at 8 s costs, interpolated on the curve of the method; "
        "- where it does not get there.",
        name=f"tradeoff-{coordinates}",
    )


def _milliseconds(seconds: float | None) -> str:
    return "-" if seconds is None else short(1e3 * seconds)


def _findings_table(found: list[Finding]) -> PageTable:
    rows = [
        (one.name, f"{short(one.value, 3)} {one.unit}".strip(), one.definition)
        for one in found
        if one.value is not None
    ]
    return PageTable(
        ("finding", "value", "definition"), rows, "Computed from the tables.",
        name="tradeoff-findings",
    )  # fmt: skip
