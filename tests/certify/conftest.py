"""Golden tables as they would be, for any scene that is proved."""

from decimal import Decimal, localcontext
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

from dataclasses import replace

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.certify.compare import Enclosed, State
from tt_precise.golden.runs import ORDER, columns, exact_decimal
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.scene.scene import Scene


def printed(number: arb | None) -> str:
    """A ball as golden data would have it."""
    if number is None:
        return ""
    if abs(number) < 1e-40:
        return "0"
    low, high = bounds(number)
    middle = (low + high) / 2
    with localcontext(prec=60):
        return f"{Decimal(middle.numerator) / Decimal(middle.denominator):.33e}"


def seeds(quick: int, many: int) -> list[Any]:
    """The first ``quick`` seeds, and the others up to ``many`` for the long proofs."""
    return [*range(quick), *(pytest.param(n, marks=pytest.mark.proofs) for n in range(quick, many))]


def altered(stored: Stored, file: str, table: Table) -> Stored:
    """The golden data with another table."""
    return replace(stored, tables={**stored.tables, file: table})


def without(table: Table, row: int) -> Table:
    return Table(table.columns, (*table.rows[:row], *table.rows[row + 1 :]))


def stored_of(scene: Scene, enclosed: Enclosed) -> Stored:
    """Tables with the correctly rounded numbers of what is enclosed."""
    names = columns(scene)[1:]

    def cells(state: State) -> list[str]:
        return [printed(state[name]) for name in names]

    rows = [(str(exact_decimal(t)), *cells(state)) for t, state in enclosed.rows]
    if enclosed.end:
        rows.append((printed(enclosed.end.time), *cells(enclosed.end.state)))
    happened = sorted(
        (
            float(one.time),
            ORDER.index(name),
            (name, printed(one.time), str(one.direction), *cells(one.state)),
        )
        for name, kind in enclosed.events.items()
        for one in kind
    )
    events = Table(("name", "t", "direction", *names), tuple(row for *_, row in happened))
    tables = {TRAJECTORY: Table(("t", *names), tuple(rows)), EVENTS: events}
    return Stored(Path(scene.name), scene.text, tables, {})
