"""Comparison of golden tables with an enclosure of the exact solution.

Every cell of the tables is compared with the ball around its number. A cell must have the form of
golden data, with all 34 digits (0 stands for at most 1e-34 of the column's largest number), and
must be the correctly rounded number; rows, events, directions and their order must be those of the
motion. Every difference is named and counts as unproved.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_HALF_EVEN, Decimal, InvalidOperation, localcontext
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from flint import arb

from tt_precise.certify.balls import ball, bounds, round_to
from tt_precise.golden.runs import ORDER, SAME_TIME, columns, exact_decimal
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import DIGITS, LABELS, PRINTED, ZERO, Table, digits_of
from tt_precise.integration.events import JOINING, TERMINAL, catalogue

MOST_EXPONENT = 4  # Most digits of an exponent, its sign included.

State = Mapping[str, arb | None]  # of one row or event, by column, SI; None where undefined


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


class Tally(NamedTuple):
    """Counts of printed numbers: all, proved correctly rounded, proved wrong."""

    numbers: int = 0
    rounded: int = 0
    wrong: int = 0

    def __add__(self, other: Tally) -> Tally:  # type: ignore[override]
        return Tally(*(a + b for a, b in zip(self, other, strict=True)))


class TableComparison(NamedTuple):
    """The comparison of tables and enclosure.

    ``tallies`` has each column of each file. ``mismatches`` are differences of the tables other
    than digits of numbers.
    """

    tallies: Mapping[str, Mapping[str, Tally]]
    mismatches: Sequence[str]

    @property
    def total(self) -> Tally:
        """The tally of all columns."""
        columns = (tally for columns in self.tallies.values() for tally in columns.values())
        return sum(columns, Tally())

    @property
    def undecided(self) -> bool:
        """True where narrower balls may prove more."""
        return self.total.rounded + self.total.wrong < self.total.numbers and not self.mismatches

    @property
    def objection(self) -> str:
        """The reason why not every printed number and event is proved; "" if all are proved."""
        if self.mismatches:
            return self.mismatches[0]
        for file, tallies in self.tallies.items():
            for name, tally in tallies.items():
                if tally.wrong:
                    return f"{file}: {tally.wrong} entries of {name} are proved wrong"
                if tally.rounded != tally.numbers:
                    missing = tally.numbers - tally.rounded
                    return f"{file}: {missing} entries of {name} are not proved"
        return ""


def compare(stored: Stored, enclosed: Enclosed) -> TableComparison:
    """Compare the golden tables ``stored`` with balls around their numbers."""
    trajectory = stored.trajectory
    scales = {name: _scale(trajectory.column(name)) for name in trajectory.columns}
    rows, problems = _rows(stored, enclosed)
    events, more = _events(stored, enclosed)
    states = {TRAJECTORY: rows, EVENTS: events}
    misprints = [misprint for file in states for misprint in _misprints(file, stored.tables[file])]
    tallies = {
        file: _tallies(stored.tables[file], states[file], scales) for file in (TRAJECTORY, EVENTS)
    }
    return TableComparison(tallies, [*misprints, *problems, *more])


def _rows(stored: Stored, enclosed: Enclosed) -> tuple[list[State], list[str]]:
    """The states of trajectory.csv: at each sample, and at the loss of contact."""
    table, expected = stored.trajectory, columns(stored.scene)
    nothing: list[State] = [{} for _ in table.rows]
    problems = _columns(TRAJECTORY, table, expected)
    if problems:
        return nothing, problems
    proved: list[tuple[str | None, State]] = [
        (
            exact_decimal(seconds) or round_to(seconds, ROUND_HALF_EVEN, DIGITS),
            {"t": ball(seconds), **state},
        )
        for seconds, state in enclosed.rows
    ]
    if enclosed.end:
        proved.append((None, {"t": enclosed.end.time, **enclosed.end.state}))
    if len(table.rows) != len(proved):
        problems.append(f"{TRAJECTORY}: {len(table.rows)} rows, expected {len(proved)}")
    states: list[State] = []
    for line, (row, (printed, state)) in enumerate(zip(table.rows, proved, strict=False), start=2):
        same = row[0] == printed if printed else _is_rounded(row[0], state["t"])
        if not same:
            problems.append(
                f"{TRAJECTORY}, line {line}: got t = {row[0][:50]}, expected {printed or 'the end'}"
            )
        problems += _emptiness(f"{TRAJECTORY}, line {line}", table.columns, row, state)
        states.append(state if same else {})
    return [*states, *nothing[len(states) :]], problems


def _events(stored: Stored, enclosed: Enclosed) -> tuple[list[State], list[str]]:
    """The states of events.csv, event by event of each kind in order of time."""
    table, proved = stored.events, enclosed.events
    states: list[State] = [{} for _ in table.rows]
    problems = _columns(EVENTS, table, ("name", "t", "direction", *columns(stored.scene)[1:]))
    if problems:
        return states, problems
    lines: dict[str, list[int]] = {}
    for position, row in enumerate(table.rows):
        lines.setdefault(row[0], []).append(position)
    ends = {*TERMINAL, *JOINING}
    unknown = sorted(lines.keys() - {*catalogue(stored.scene.model), *ends})
    problems += [f"{EVENTS}: an event {name[:50]}, which does not exist" for name in unknown]
    unproved = sorted((lines.keys() & ends) - proved.keys())
    problems += [f"{EVENTS}: {name}, which is not proved to happen" for name in unproved]
    for name, happenings in proved.items():
        there = lines.get(name, [])
        if len(there) != len(happenings):
            problems.append(f"{EVENTS}: {len(there)} events {name}, expected {len(happenings)}")
        for position, happening in zip(there, happenings, strict=False):
            row, where = table.rows[position], f"{EVENTS}, line {position + 2}"
            if row[2] != str(happening.direction):
                problems.append(f"{where}: direction {row[2][:50]}, expected {happening.direction}")
            else:
                states[position] = {"t": happening.time, **happening.state}
                problems += _emptiness(where, table.columns, row, states[position])
    return states, [*problems, *_disorder(table)]


def _columns(file: str, table: Table, expected: Sequence[str]) -> list[str]:
    if table.columns == tuple(expected):
        return []
    return [f"{file}: columns {','.join(table.columns)[:80]}, expected {','.join(expected)[:80]}"]


def _emptiness(where: str, names: Sequence[str], row: Sequence[str], state: State) -> list[str]:
    """Cells that are empty where a number is proved to exist, and numbers where none does."""
    return [
        f"{where}, {name}: {cell[:50] or 'empty'}, where there is {'no' if cell else 'a'} number"
        for name, cell in zip(names, row, strict=True)
        if name not in LABELS and bool(cell) != (state.get(name) is not None)
    ]


def _misprints(file: str, table: Table) -> list[str]:
    """Cells without the form of golden data, except times of samples."""
    return [
        f"{file}, line {line}, {name}: got {cell[:50]!r}, expected 0 or {DIGITS} digits"
        for line, row in enumerate(table.rows, start=2)
        for name, cell in zip(table.columns, row, strict=True)
        if cell and name not in LABELS and not is_whole(cell)
        if name != "t" or file == EVENTS
    ]


def is_whole(cell: str) -> bool:
    """True for the cell 0, or a number in the form of golden data with all digits."""
    if cell == ZERO:
        return True
    _, _, exponent = cell.partition("e")
    if not PRINTED.fullmatch(cell) or len(exponent) > MOST_EXPONENT or digits_of(cell) != DIGITS:
        return False
    return cell == f"{Decimal(cell):.{DIGITS - 1}e}" and bool(Decimal(cell))


def _scale(cells: Sequence[str]) -> Decimal:
    """The largest magnitude of the cells that are numbers, rounded to three digits."""
    with localcontext(prec=3):
        return max((abs(Decimal(cell)) for cell in cells if is_whole(cell)), default=Decimal(0))


def _disorder(table: Table) -> list[str]:
    """Rows that are not in order of time, or at one instant not in the catalogue's order."""
    for line, (row, after) in enumerate(pairwise(table.rows), start=3):
        try:
            time, later = Decimal(row[1]), Decimal(after[1])
            at_once = abs(later - time) <= SAME_TIME * time
            named = ORDER.index(row[0]) < ORDER.index(after[0])
        except (InvalidOperation, ValueError):
            return [f"{EVENTS}, line {line}: no time, or no event"]
        if not (named if at_once else time < later):
            return [f"{EVENTS}, line {line}: not in order of time"]
    return []


def _tallies(
    table: Table, states: Sequence[State], scales: Mapping[str, Decimal]
) -> dict[str, Tally]:
    """A tally for each column of numbers; a trajectory's times are exact."""
    skipped = LABELS if "name" in table.columns else ("t",)
    return {
        name: tally(
            zip(table.column(name), (state.get(name) for state in states), strict=True),
            Fraction(scales.get(name, Decimal(0)).scaleb(-DIGITS)) if name != "t" else Fraction(0),
        )
        for name in table.columns
        if name not in skipped
    }


def tally(cells: Iterable[tuple[str, arb | None]], zero: Fraction) -> Tally:
    """Return the tally of a column of printed numbers; see ``rounding_of`` for ``zero``."""
    numbers = rounded = wrong = 0
    for text, exact in cells:
        numbers += bool(text)
        if is_whole(text) and exact is not None:
            verdict = rounding_of(text, exact, zero)
            rounded += verdict is True
            wrong += verdict is False
    return Tally(numbers, rounded, wrong)


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


def _is_rounded(text: str, exact: arb | None) -> bool:
    return exact is not None and is_whole(text) and rounding_of(text, exact) is True
