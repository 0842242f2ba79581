"""The enclosures of printed numbers as the tables that lie beside golden data."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.certify.printed import outward
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table
from tt_precise.golden.tails import tail
from tt_precise.mechanics.formulations import formulation
from tt_precise.scene import Scene

State = dict[str, arb | None]  # of one row or event, by column, SI; None where undefined


def stored_columns(scene: Scene) -> tuple[str, ...]:
    """The columns that are stored: vectors and quadratures; Euler columns follow from these."""
    return (*formulation(scene.model, "newton").columns, *scene.record)


def enclosure_table(scene: Scene, times: Sequence[str], states: Sequence[State]) -> Table:
    """Middle and radius at each row that has a state; ``times`` as they are printed."""
    names = stored_columns(scene)
    header = ("t", *(text for name in names for text in (name, f"{name}_radius")))
    rows = []
    for printed, state in zip(times, states, strict=False):
        balls = [state.get(name) for name in names]
        if None in balls:
            break
        rows.append((printed, *(text for one in balls if one is not None for text in outward(one))))
    return Table(header, tuple(rows))


def events_table(
    stored: Stored, states: Sequence[State], scales: dict[str, Decimal]
) -> tuple[Table, int]:
    """The last digits at each event up to the first that has none, and how many numbers lack them.

    ``states`` belong to the rows of events.csv, "t" included; {} where nothing is proved.
    """
    names = ("t", *stored_columns(stored.scene))
    rows: list[tuple[str, ...]] = []
    missing = 0
    for printed, state in zip(stored.events.rows, states, strict=True):
        texts = dict(zip(stored.events.columns, printed, strict=True))
        cells = [_tail(texts.get(name, ""), state.get(name), scales.get(name)) for name in names]
        missing += cells.count("")
        if not missing:
            rows.append((printed[0], *cells))
    return Table(("name", *names), tuple(rows)), missing


def _tail(text: str, ball: arb | None, scale: Decimal | None) -> str:
    if not text or ball is None:
        return ""
    return tail(text, *bounds(ball), scale or Decimal(0))
