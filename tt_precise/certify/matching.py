"""Golden tables against what is proved to be there: columns, times, rows and events, all of them.

What does not match is named, and belongs to no number that could be called proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from itertools import pairwise

from flint import arb

from tt_precise.certify.balls import ball
from tt_precise.certify.printed import compare
from tt_precise.certify.proof import Proof
from tt_precise.certify.tables import State
from tt_precise.golden.runs import ORDER, SAME_TIME, columns, exact_decimal
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.integration.events import catalogue

LOST = "contact_lost"


@dataclass(frozen=True)
class Match:
    """For each row of a table the state that is proved to belong to it; {} where none is.

    ``mismatches`` say where table and proof differ in anything but the digits of numbers.
    """

    states: list[State]
    mismatches: list[str]


def match_rows(stored: Stored, proof: Proof) -> Match:
    """The states of trajectory.csv: at each sample, and at the loss of contact."""
    table, expected = stored.trajectory, columns(stored.scene)
    found = _columns(TRAJECTORY, table, expected)
    if found:
        return Match([{} for _ in table.rows], found)
    proved: list[tuple[str | None, State]] = [
        (exact_decimal(seconds), {"t": ball(seconds), **state}) for seconds, state in proof.rows()
    ]
    if proof.lost:
        time, state = proof.event_state(proof.lost)
        proved.append((None, {"t": time, **state}))
    ended = proof.complete
    if len(table.rows) < len(proved) or (ended and len(table.rows) > len(proved)):
        found.append(f"{TRAJECTORY}: {len(table.rows)} rows, expected {len(proved)}")
    states: list[State] = []
    for line, (row, (printed, state)) in enumerate(zip(table.rows, proved, strict=False), start=2):
        # an instant without a finite decimal, such as that of the loss, is printed rounded
        same = row[0] == printed if printed else _is_rounded(row[0], state["t"])
        if not same:
            found.append(
                f"{TRAJECTORY}, line {line}: got t = {row[0][:50]}, expected {printed or 'another'}"
            )
        found += _emptiness(f"{TRAJECTORY}, line {line}", table.columns, row, state)
        states.append(state if same else {})
    states += [{} for _ in range(len(table.rows) - len(states))]
    return Match(states, found)


def match_events(stored: Stored, proof: Proof) -> Match:
    """The states of events.csv, event by event of each kind in order of time."""
    table = stored.events
    names = ("name", "t", "direction", *columns(stored.scene)[1:])
    found = _columns(EVENTS, table, names)
    states: list[State] = [{} for _ in table.rows]
    if found:
        return Match(states, found)
    proved = {name: one.zeros for name, one in proof.all_events.items() if not one.failure}
    if proof.lost:
        proved[LOST] = (proof.lost,)
    lines: dict[str, list[int]] = {}
    for position, row in enumerate(table.rows):
        lines.setdefault(row[0], []).append(position)
    known = {*catalogue(stored.scene.model), LOST}
    found += [
        f"{EVENTS}: an event {name[:50]}, which does not exist"
        for name in sorted(lines.keys() - known)
    ]
    if LOST in lines and not proof.lost and proof.complete:
        found.append(f"{EVENTS}: {LOST}, which is proved not to happen")
    for name, zeros in proved.items():
        there = lines.get(name, [])
        if len(there) < len(zeros) or (proof.complete and len(there) > len(zeros)):
            found.append(f"{EVENTS}: {len(there)} events {name}, expected {len(zeros)}")
        for position, zero in zip(there, zeros, strict=False):
            row, (time, state) = table.rows[position], proof.event_state(zero)
            where = f"{EVENTS}, line {position + 2}"
            if row[2] != str(zero.direction):
                found.append(f"{where}: direction {row[2][:50]}, expected {zero.direction}")
            else:
                states[position] = {"t": time, **state}
                found += _emptiness(where, table.columns, row, state)
    return Match(states, [*found, *_disorder(table)])


def _columns(file: str, table: Table, expected: Sequence[str]) -> list[str]:
    if table.columns == tuple(expected):
        return []
    return [f"{file}: columns {','.join(table.columns)[:80]}, expected {','.join(expected)[:80]}"]


def _emptiness(where: str, names: Sequence[str], row: Sequence[str], state: State) -> list[str]:
    """Cells that are empty where a number is proved to exist."""
    return [
        f"{where}, {name}: empty, where there is a number"
        for name, cell in zip(names, row, strict=True)
        if not cell and state.get(name) is not None
    ]


def _is_rounded(text: str, exact: arb | None) -> bool:
    try:
        return exact is not None and compare(text, exact).rounded
    except InvalidOperation:
        return False


def _disorder(table: Table) -> list[str]:
    """Rows that are not in order of time, those of one instant in the catalogue's order."""
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
