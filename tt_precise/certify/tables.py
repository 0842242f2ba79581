"""The enclosures of printed numbers as the tables that lie beside golden data."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.golden.store import TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.tails import tail
from tt_precise.mechanics.formulations import formulation

State = dict[str, arb | None]  # of one row or event, by column, SI; None where undefined


def tails_table(
    stored: Stored, file: str, states: Sequence[State], scales: dict[str, Decimal]
) -> tuple[Table, int]:
    """The last digits of vectors, quadratures and events' times, and how many numbers lack them.

    ``states`` belong to the rows of ``file``; {} where nothing is proved. The table ends before
    the first row in which a number has no enclosure, or one wider than its last digits.
    """
    printed, scene = stored.table(file), stored.scene
    label, *times = ("t",) if file == TRAJECTORY else ("name", "t")
    names = (*times, *formulation(scene.model, "newton").columns, *scene.record)
    rows: list[tuple[str, ...]] = []
    short, whole = 0, True
    for cells, state in zip(printed.rows, states, strict=True):
        texts = dict(zip(printed.columns, cells, strict=True))
        found = [_tail(texts.get(name, ""), state.get(name), scales[name]) for name in names]
        short += sum(
            state.get(name) is not None and not digits
            for name, digits in zip(names, found, strict=True)
        )
        whole = whole and all(found)
        if whole:
            rows.append((cells[0], *found))
    return Table((label, *names), tuple(rows)), short


def _tail(text: str, ball: arb | None, scale: Decimal) -> str:
    if not text or ball is None:
        return ""
    return tail(text, *bounds(ball), scale)
