"""Comparison of golden tables with an enclosure of the exact solution.

The enclosure writes tables of its own: texts (names, directions, exact times), balls, and None
where a value is undefined. The printed tables must have the same columns and rows, and in each cell
the same text; or for a ball a number in the form of golden data, with all 34 digits (0 stands for
at most 1e-34 of the column's largest number), that is proved to be correctly rounded; or nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import ROUND_HALF_EVEN, Decimal, localcontext
from fractions import Fraction
from functools import cmp_to_key
from typing import Any, NamedTuple

from flint import arb

from tt_precise.certify.balls import bounds, round_to
from tt_precise.golden.runs import ORDER, SAME_TIME, columns, exact_decimal
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import DIGITS, Table
from tt_precise.integration.events import TERMINAL
from tt_precise.scene.scene import Scene

# The cell 0, or a number in the form of golden data with all digits.
WHOLE = re.compile(rf"0|-?[1-9]\.\d{{{DIGITS - 1}}}e(?:\+0|[+-][1-9]\d{{0,2}})", re.ASCII)

State = Mapping[str, arb | None]  # of one row or event, by column, SI; None where undefined
Cell = Any  # Of an exact table: a text, a ball, or None.


class TableEvent(NamedTuple):
    """An event: direction, time in s, and state."""

    direction: int
    time: arb
    state: State


class Enclosed(NamedTuple):
    """Balls around the exact solution of a scene.

    ``rows`` has time (s) and state at each sample. ``events`` has all events by kind, in order of
    time, including the events that end the motion or its equations.
    """

    rows: Sequence[tuple[Fraction, State]]
    events: Mapping[str, Sequence[TableEvent]]

    @property
    def end(self) -> TableEvent | None:
        """The event that ends the motion, such as the loss of contact."""
        return next((self.events[name][0] for name in TERMINAL if name in self.events), None)

    def tables(self, scene: Scene) -> dict[str, Table]:
        """Return the tables by file: samples with the end of the motion, and events in order."""
        names = columns(scene)[1:]

        def cells(state: State) -> list[Cell]:
            return [state.get(name) for name in names]

        samples = [
            [exact_decimal(t) or round_to(t, ROUND_HALF_EVEN, DIGITS), *cells(state)]
            for t, state in self.rows
        ]
        if self.end:
            samples.append([self.end.time, *cells(self.end.state)])
        happened = [(name, event) for name, kind in self.events.items() for event in kind]
        happened.sort(key=cmp_to_key(_order))
        events = [
            [name, event.time, str(event.direction), *cells(event.state)]
            for name, event in happened
        ]
        return {
            TRAJECTORY: Table(("t", *names), tuple(map(tuple, samples))),
            EVENTS: Table(("name", "t", "direction", *names), tuple(map(tuple, events))),
        }


def _order(event: tuple[str, TableEvent], other: tuple[str, TableEvent]) -> int:
    """Order events by time; those at one instant by their names in the catalogue."""
    time, later = event[1].time.mid(), other[1].time.mid()
    if abs(later - time) <= arb(str(SAME_TIME)) * time:
        return ORDER.index(event[0]) - ORDER.index(other[0])
    return -1 if time < later else 1


class TableComparison(NamedTuple):
    """The comparison of printed tables with exact ones.

    ``numbers`` counts the numbers other than times of samples, ``rounded`` the correctly rounded
    ones. ``wrong`` names numbers that are proved to be wrong, ``mismatches`` all other differences.
    """

    numbers: int
    rounded: int
    wrong: Sequence[str]
    mismatches: Sequence[str]

    @property
    def undecided(self) -> bool:
        """True where narrower balls may prove more."""
        return self.rounded + len(self.wrong) < self.numbers and not self.mismatches

    @property
    def objection(self) -> str:
        """The reason why not every printed number and event is proved; "" if all are proved."""
        missing = self.numbers - self.rounded
        open_ = [f"{missing} of {self.numbers} numbers are not proved"] if missing else []
        return next(iter([*self.mismatches, *self.wrong, *open_]), "")


def compare(stored: Stored, enclosed: Enclosed) -> TableComparison:
    """Compare the golden tables ``stored`` with balls around their numbers."""
    verdicts, wrong, mismatches = list[bool | None](), list[str](), list[str]()
    zeros = _zeros(stored.trajectory)
    for file, exact in enclosed.tables(stored.scene).items():
        table = stored.tables[file]
        if table.columns != exact.columns:
            names, expected = ",".join(table.columns), ",".join(exact.columns)
            mismatches.append(f"{file}: columns {names}, expected {expected}")
            continue
        if len(table.rows) != len(exact.rows):
            mismatches.append(f"{file}: {len(table.rows)} rows, expected {len(exact.rows)}")
        for place, name, text, cell in _cells(file, table, exact):
            if not isinstance(cell, arb):
                if text != (cell or ""):
                    expected = cell or "an empty cell"
                    mismatches.append(f"{place}: got {text[:50]!r}, expected {expected}")
                continue
            verdict = None
            if WHOLE.fullmatch(text):
                verdict = rounding_of(text, cell, zeros.get(name, Fraction(0)))
            else:
                mismatches.append(f"{place}: got {text[:50]!r}, expected 0 or {DIGITS} digits")
            if verdict is False:
                wrong.append(f"{place}: {text} is proved wrong")
            # the end of the motion stands in both tables, and is counted among the events
            if file == EVENTS or name != "t":
                verdicts.append(verdict)
    return TableComparison(len(verdicts), verdicts.count(True), wrong, mismatches)


def _cells(file: str, table: Table, exact: Table) -> Iterator[tuple[str, str, str, Cell]]:
    """Each printed cell with its place, its column and its exact value."""
    for line, (printed, row) in enumerate(zip(table.rows, exact.rows, strict=False), start=2):
        for name, text, cell in zip(table.columns, printed, row, strict=True):
            yield f"{file}, line {line}, {name}", name, text, cell


def _zeros(table: Table) -> dict[str, Fraction]:
    """Return the largest size of a number that is printed as "0", by column."""
    numbers = {
        name: [Decimal(text) for text in table.column(name) if WHOLE.fullmatch(text)]
        for name in table.columns
        if name != "t"
    }
    with localcontext(prec=3):  # as ``golden.proofs`` reads it
        sizes = {
            name: max(map(abs, column), default=Decimal(0)) for name, column in numbers.items()
        }
    return {name: Fraction(size.scaleb(-DIGITS)) for name, size in sizes.items()}


def rounding_of(text: str, exact: arb, zero: Fraction = Fraction(0)) -> bool | None:
    """True if a printed decimal is proved to be the correctly rounded number in a ball.

    None if neither that nor the contrary is proved. ``zero`` is the largest size of a number that
    is printed as "0".
    """
    low, high = bounds(exact)
    number = Decimal(text)
    value = Fraction(number)
    if not value:
        return True if max(high, -low) <= zero else False if max(low, -high) > zero else None
    _, figures, exponent = number.as_tuple()
    assert isinstance(exponent, int)  # a number, neither NaN nor infinite
    last = Fraction(10) ** exponent / 2
    # towards zero the numbers with as many digits lie ten times closer below a power of ten
    inner = last / 10 if figures[0] == 1 and not any(figures[1:]) else last
    sign = 1 if value > 0 else -1
    ends = sorted((sign * (low - value), sign * (high - value)))
    if -inner <= ends[0] and ends[1] <= last:
        return True
    return False if ends[1] < -inner or ends[0] > last else None
