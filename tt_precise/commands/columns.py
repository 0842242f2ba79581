"""``tt-precise columns``: the columns of a trajectory, with units, frames and conventions."""

from __future__ import annotations

from pathlib import Path

import click

from tt_precise.commands.options import JSON, emit
from tt_precise.mechanics.digits import RULE
from tt_precise.mechanics.quantities import QUANTITIES, described
from tt_precise.runtime.values import Json

SCHEMA = "tt_precise.columns/1"
_TEXT = (Path(__file__).parent / "conventions.txt").read_text("utf-8")
CONVENTIONS = (*_TEXT.splitlines(), f"Digits: {RULE}")
Columns = dict[str, dict[str, Json]]


@click.command("columns")
@JSON
def command(as_json: bool) -> int:
    """List the columns that `check` reads and `run` writes, and all quantities along a motion.

    Each line has name, unit, frame and meaning. `run --columns`, `events --columns` and `frame`
    take the quantities too; `extremum:NAME` and `zero:NAME` are their events.
    """
    sets, table = column_sets(), quantities()
    headed = {**sets, "quantities of `run --columns`, `events --columns` and `frame`": table}
    lines = ["A trajectory has one of these sets of columns; others are ignored."]
    for heading, columns in headed.items():
        lines += ["", heading]
        lines += [f"  {name:<20} {row['unit']:<9} {meaning(row)}" for name, row in columns.items()]
    lines += ["", *(f"- {sentence}" for sentence in CONVENTIONS)]
    content = {"schema": SCHEMA, "sets": sets, "quantities": table, "conventions": CONVENTIONS}
    emit(as_json, content, lines)
    return 0


def column_sets() -> dict[str, Columns]:
    """Return the columns of each set, in order: unit, meaning and whether each is required."""
    from tt_precise.check.columns import COLUMN_SETS

    return {
        name: {
            column: {**described(column)._asdict(), "required": column in ("t", *columns.required)}
            for column in ("t", *columns.names, *columns.height)
        }
        for name, columns in COLUMN_SETS.items()
    }


def quantities() -> Columns:
    """Return the unit and the meaning of each quantity along a motion."""
    return {
        name: {
            "unit": quantity.unit,
            "meaning": quantity.meaning + ("" if quantity.pole else " Undefined at the poles."),
        }
        for name, quantity in QUANTITIES.items()
    }


def meaning(column: dict[str, Json]) -> str:
    """Return the meaning of a column of ``column_sets`` or ``quantities``."""
    note = "" if column.get("required", True) else " (if known)"
    return str(column["meaning"]).rstrip(".") + note
