"""What ``golden certify`` proved about a scene's golden tables, read without python-flint.

Beside the tables lie ``proof.json`` (what is proved, and about which tables) and the enclosures of
their numbers (``enclosures``); ``proof_checks`` holds all of them against each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from tt_precise.golden import store
from tt_precise.golden.enclosures import ENCLOSURE, EVENTS_ENCLOSURE, Cells, Enclosures
from tt_precise.golden.outward import Outward
from tt_precise.golden.printed_cells import misprinted
from tt_precise.golden.proof_checks import complaints
from tt_precise.golden.proof_record import PROOF, SCHEMA, SELF_HASH, Record, read, text
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene

__all__ = [
    "ENCLOSURE", "EVENTS_ENCLOSURE", "PROOF", "SCHEMA", "SELF_HASH", "Established", "Interval",
    "Record", "complaints", "established", "read", "summary", "text",
]  # fmt: skip


class Interval(NamedTuple):
    """Exact numbers that the exact value lies between, ends included."""

    low: Fraction
    high: Fraction

    @classmethod
    def around(cls, middle: str, radius: str) -> Interval:
        """From the decimals of a ball."""
        centre, reach = Fraction(Decimal(middle)), Fraction(Decimal(radius))
        return cls(centre - reach, centre + reach)

    @classmethod
    def of(cls, outward: Outward) -> Interval:
        """From an interval of decimals."""
        return cls(Fraction(outward.low), Fraction(outward.high))


@dataclass(frozen=True)
class Established:
    """What an unspoiled, complete proof establishes about its scene; all numbers in SI."""

    stored: Stored
    record: Record

    @property
    def contact(self) -> dict[str, Json]:
        """What is proved of the contact force, as in proof.json."""
        return self.record.content["contact"]

    @cached_property
    def _enclosures(self) -> Enclosures:
        return self.record.enclosures(self.stored)

    @cached_property
    def _rows(self) -> dict[str, Cells]:
        return dict(
            zip(self.stored.trajectory.column("t"), self._enclosures.of(TRAJECTORY), strict=True)
        )

    @cached_property
    def _events(self) -> list[Cells]:
        return list(self._enclosures.of(EVENTS))

    def at(self, column: str, t: str) -> Interval | None:
        """A column at the sampled time ``t`` (s, as printed); None where nothing is proved.

        Vector columns as they are enclosed, Euler columns as they follow from these.
        """
        ball = self._rows.get(t, {}).get(column)
        return None if ball is None else Interval.of(ball)

    def moment(self, definition: str, which: str) -> Interval | None:
        """Initiation or ending time (``t_init``, ``t_end``) in a definition (A, B or C)."""
        ball = self.record.content["inversion"].get(definition, {}).get(which)
        return Interval.around(ball["middle"], ball["radius"]) if ball else None

    def happened(self, name: str) -> list[dict[str, Interval]] | None:
        """Time, state and direction at all events of that name after t = 0, in order.

        None if undecided. A zero of the event's function at t = 0 itself is not an event.
        """
        if name not in self.record.content["proved_events"]:
            return None
        found = []
        for row, cells in zip(self.stored.events.rows, self._events, strict=True):
            if row[0] == name:
                known = {key: Interval.of(ball) for key, ball in cells.items() if ball is not None}
                direction = Fraction(Decimal(row[2]))
                found.append({**known, "direction": Interval(direction, direction)})
        return found


def summary(stored: Stored, folder: Path | None = None) -> dict[str, Json] | None:
    """What a list of scenes says of the proof, or the ``problem`` with it; None if there is none.

    Counts and hashes are checked, single numbers are not: that is what ``verify`` does.
    """
    try:
        record = read(stored.name, folder)
    except InputError as error:
        return {"problem": str(error)}
    if record is None:
        return None
    found = [
        *misprinted(TRAJECTORY, stored.trajectory),
        *misprinted(EVENTS, stored.events),
    ] or complaints(stored, record, rows=False)
    return {"problem": found[0]} if found else record.summary


def established(scene: Scene, folder: Path | None = None) -> tuple[Established | None, str]:
    """The complete and unspoiled proof about this very scene, to every digit; or None, and why."""
    if scene.name not in store.scenes(folder):
        return None, f"{scene.name}: no golden data"
    stored = store.read(scene.name, folder)
    if stored.scene != scene:
        return None, f"{scene.name}: the golden data are those of another start, body or horizon"
    try:
        record = read(scene.name, folder)
    except InputError as error:
        return None, str(error)
    if record is None:
        return None, f"{scene.name}: no {PROOF}; `tt-precise golden certify {scene.name}` makes it"
    spoiled = complaints(stored, record)
    if spoiled:
        return None, spoiled[0]
    if not record.complete:
        return None, f"{scene.name}: {record.incomplete}"
    return Established(stored, record), ""
