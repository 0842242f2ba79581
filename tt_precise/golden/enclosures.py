"""Intervals around every number of the golden tables, from the two files that prove them.

They have the last digits (``tails``) of vector columns and recorded quadratures: ``enclosure.csv``
at the sampled rows, ``events-enclosure.csv`` at events, with their times. Euler columns are derived
from the vectors, by the formulas of the mechanics.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property

from tt_precise.golden.digits import scale_of
from tt_precise.golden.outward import IntervalFunctions, Outward, pi
from tt_precise.golden.store import TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.tails import enclosed
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import dot
from tt_precise.scene.body import Parameters

ENCLOSURE, EVENTS_ENCLOSURE = "enclosure.csv", "events-enclosure.csv"
LABELS = ("name", "direction")
Cells = dict[str, Outward | None]


@dataclass(frozen=True)
class Enclosures:
    """Intervals of the exact numbers behind the golden tables of ``stored``."""

    stored: Stored
    rows: Table
    events: Table

    def table(self, file: str) -> Table:
        """What is stored of the numbers in a golden file."""
        return self.rows if file == TRAJECTORY else self.events

    @cached_property
    def scales(self) -> dict[str, Decimal]:
        """For each column its largest printed entry."""
        table = self.stored.trajectory
        return {name: scale_of(table.column(name)) for name in table.columns}

    def of(self, file: str) -> Iterator[Cells]:
        """Row by row the intervals of all columns; None where a number does not exist.

        Raises
        ------
        ArithmeticError, ValueError
            A cell is no number, or encloses nothing from which the others could be derived.
        """
        printed = self.stored.table(file)
        # events are asked for twice, for their numbers and for the times of the climb
        known = self._events if file != TRAJECTORY else []
        rows = zip(printed.rows, self.table(file).rows, strict=False)
        for number, (texts, cells) in enumerate(rows):
            if number < len(known):
                yield known[number]
                continue
            row = self.row(file, texts, cells)
            if file != TRAJECTORY:
                known.append(row)
            yield row

    def row(self, file: str, texts: Sequence[str], cells: Sequence[str]) -> Cells:
        """The intervals of one row, from what is printed and what is stored."""
        known = self.proved(file, texts, cells)
        return {**known, **self.euler(known)}

    def proved(self, file: str, texts: Sequence[str], cells: Sequence[str]) -> dict[str, Outward]:
        """Those of them that are stored themselves."""
        printed = dict(zip(self.stored.table(file).columns, texts, strict=True))
        _, *names = self.table(file).columns
        return {
            name: enclosed(printed[name], cell, self.scales[name])
            for name, cell in zip(names, cells[1:], strict=True)
        }

    def euler(self, known: dict[str, Outward]) -> Cells:
        """The Euler columns that belong to enclosed vectors."""
        # a rolling top has no gliding velocity
        nothing = Outward.of(0)
        state = NewtonState(*(known.get(name, nothing) for name in NewtonState._fields))
        body = self._body
        horizontal = (state.kx * state.kx + state.ky * state.ky).sqrt()
        if not horizontal > 0:
            # the axis is vertical, or not known not to be; an angle is at most twice its sine here
            tilt = Outward(nothing.low, (2 * horizontal).high)
            there: Cells = dict.fromkeys(EulerState._fields)
            theta = tilt if state.kz > 0 else pi() - tilt
            return {**there, "theta": theta, "omega_3": dot(state.L, state.k) / body.I3}
        return dict(euler_from_vectors(body, state, IntervalFunctions)._asdict())

    @cached_property
    def _events(self) -> list[Cells]:
        """The rows of the events, as far as they have been asked for."""
        return []

    @cached_property
    def _body(self) -> Parameters:
        return self.stored.scene.body.numbers(Outward.of)
