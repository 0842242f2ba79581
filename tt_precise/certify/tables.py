"""The enclosures of printed numbers as the tables that lie beside golden data."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.golden.proofs import ball_place, ball_text
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table

State = dict[str, arb | None]  # of one row or event, by column, SI; None where undefined


def balls_table(
    stored: Stored, file: str, states: Sequence[State], scales: dict[str, Decimal]
) -> Table:
    """A ball for every number of ``file`` as ``golden.proofs`` reads it.

    ``states`` belong to its rows; {} where nothing is proved. The table ends before the first row
    in which a printed number has no enclosure.
    """
    printed = stored.table(file)
    label, *names = (name for name in printed.columns if name != "direction")
    rows: list[tuple[str, ...]] = []
    for cells, state in zip(printed.rows, states, strict=True):
        texts = dict(zip(printed.columns, cells, strict=True))
        found = [
            _ball(texts[name], state.get(name), scales.get(name, Decimal(0))) for name in names
        ]
        if any(texts[name] and not ball for name, ball in zip(names, found, strict=True)):
            break
        rows.append((texts[label], *found))
    return Table((label, *names), tuple(rows))


def _ball(text: str, exact: arb | None, scale: Decimal) -> str:
    if not text or exact is None:
        return ""
    return ball_text(*bounds(exact), ball_place(text, scale))
