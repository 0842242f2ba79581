"""What ``golden certify`` proved about a scene's golden tables, read without python-flint.

Beside the tables lie ``proof.json`` (what is proved, and about which tables) and
``enclosure.csv`` (at each row the middle and the radius of balls that contain the exact solution).
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Context, Decimal, Inexact, InvalidOperation
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from tt_precise.errors import InputError
from tt_precise.golden import store
from tt_precise.golden.digits import scale_of
from tt_precise.golden.manifest import scene_sha256, self_hash
from tt_precise.golden.runs import DIGITS
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.scene import Scene

SCHEMA = "tt_precise.proof/1"
PROOF, ENCLOSURE = "proof.json", "enclosure.csv"
SELF_HASH = "sha256_of_proof"
FEW = 3  # of many equal complaints so many are told
_NEEDED = {
    "bits", "conserved_within", "contact", "digits", "entries", "failure", "inversion",
    "proved_events", "proved_until_s", "rounded", "same_events", "scene", "scene_sha256",
    "undecided_events", ENCLOSURE, EVENTS, TRAJECTORY, SELF_HASH,
}  # fmt: skip


# 34 digits beside a radius of any size; numbers too far apart for it are no proof's
_WIDE = Context(prec=2000, traps=[InvalidOperation, Inexact])


class Interval(NamedTuple):
    """Exact numbers that the exact value lies between, ends included."""

    low: Fraction
    high: Fraction

    @classmethod
    def around(cls, middle: str, radius: str) -> Interval:
        """From the decimals of a ball."""
        centre, reach = Fraction(Decimal(middle)), Fraction(Decimal(radius))
        return cls(centre - reach, centre + reach)


@dataclass(frozen=True)
class Record:
    """proof.json and enclosure.csv of one scene. What it says counts if ``complaints`` has none."""

    content: dict[str, Any]
    enclosure: Table

    @property
    def digits(self) -> int | None:
        """Fewest proved digits of any column; None if nothing but zeros is printed."""
        return self.content["digits"]

    @property
    def complete(self) -> bool:
        """Whether every row is enclosed and events.csv lists what is proved to happen."""
        return self.content["failure"] is None and bool(self.content["same_events"])

    @property
    def until_s(self) -> str:
        """The time in s up to which every row is enclosed."""
        return str(self.content["proved_until_s"]["middle"])

    @property
    def summary(self) -> dict[str, Any]:
        """What a list of scenes tells: digits proved, and of how many numbers the rounding."""
        told = {name: self.content[name] for name in ("digits", "rounded", "entries")}
        return {**told, "complete": self.complete, "until_s": self.until_s}


@dataclass(frozen=True)
class Established:
    """What an unspoiled, complete proof establishes about its scene; all numbers in SI."""

    stored: Stored
    record: Record

    @property
    def contact(self) -> dict[str, Any]:
        """What is proved of the contact force, as in proof.json."""
        return self.record.content["contact"]

    @cached_property
    def _rows(self) -> dict[str, dict[str, str]]:
        table = self.record.enclosure
        return {row[0]: dict(zip(table.columns, row, strict=True)) for row in table.rows}

    def at(self, column: str, t: str) -> Interval | None:
        """A column at the sampled time ``t`` (s, as printed); None where nothing is proved.

        Vector columns as they are enclosed, others (Euler columns) from what is printed.
        """
        row = self._rows.get(t)
        if row is None or column in row:
            return Interval.around(row[column], row[f"{column}_radius"]) if row else None
        table, told = self.stored.trajectory, self.record.content[TRAJECTORY]["columns"]
        cell = table.column(column)[table.column("t").index(t)]
        return Interval.around(cell, told[column]["within"]) if cell else None

    def moment(self, definition: str, which: str) -> Interval | None:
        """Initiation or ending time (``t_init``, ``t_end``) in a definition (A, B or C)."""
        ball = self.record.content["inversion"].get(definition, {}).get(which)
        return Interval.around(ball["middle"], ball["radius"]) if ball else None

    def happened(self, name: str) -> list[dict[str, Interval]] | None:
        """Time, state and direction at all events of that name, in order; None if undecided.

        An event whose function starts at zero is searched from shortly after the start on.
        """
        if name not in self.record.content["proved_events"]:
            return None
        table, columns = self.stored.events, self.record.content[EVENTS]["columns"]
        return [
            {
                column: Interval.around(cell, columns.get(column, {"within": "0"})["within"])
                for column, cell in zip(table.columns, row, strict=True)
                if cell and column != "name"
            }
            for row in table.rows
            if row[0] == name
        ]


def read(name: str, folder: Path | None = None) -> Record | None:
    """The proof that lies beside the golden tables ``name``; None if there is none.

    Raises
    ------
    InputError
        A file cannot be used.
    """
    place = (folder or store.home()) / name
    if not (place / PROOF).is_file() and not (place / ENCLOSURE).is_file():
        return None
    try:
        content = json.loads((place / PROOF).read_text("utf-8"))
        table = Table.parse((place / ENCLOSURE).read_text("utf-8"))
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            f"{name}: {PROOF} and {ENCLOSURE} cannot be used ({reason}), expected what "
            f"`tt-precise golden certify {name}` writes"
        ) from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise InputError(f"{place / PROOF}: got another schema, expected {SCHEMA}")
    missing = sorted(_NEEDED - content.keys())
    if missing:
        raise InputError(f"{place / PROOF}: {', '.join(missing)} missing, expected to be there")
    return Record(content, table)


def text(content: dict[str, Any]) -> str:
    """The text of proof.json, with the proof's own hash added."""
    sealed = {**content, SELF_HASH: self_hash(content, SELF_HASH)}
    return json.dumps(sealed, indent=1, ensure_ascii=False) + "\n"


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
        reason = record.content["failure"] or "its events are not those that are proved to happen"
        return None, f"{scene.name}: {reason}"
    return Established(stored, record), ""


def complaints(stored: Stored, record: Record) -> list[str]:
    """What speaks against the golden tables, or against their proof; [] if nothing.

    Every printed vector entry is held against the enclosure of its row, which takes milliseconds.
    """
    spoiled = list(_damage(stored, record))
    if spoiled:
        return spoiled
    content, again = record.content, f"; run `tt-precise golden certify {stored.name}`"
    found = [
        f"{file}: not the table that was proved{again}"
        for file in (TRAJECTORY, EVENTS)
        if content[file]["sha256"] != stored.table(file).sha256
    ]
    found += [
        f"{file}: {column['wrong']} entries of {name} are proved wrong"
        for file in (TRAJECTORY, EVENTS)
        for name, column in content[file]["columns"].items()
        if column["wrong"]
    ]
    return found + list(_excluded(stored.trajectory, record.enclosure))


def _damage(stored: Stored, record: Record) -> Iterator[str]:
    """Whether the two files are still what was written, about this scene."""
    content = record.content
    if content[SELF_HASH] != self_hash(content, SELF_HASH):
        yield f"{PROOF}: edited after it was written"
    elif content["scene_sha256"] != scene_sha256(stored.scene_text):
        yield f"{PROOF}: about another scene than {store.SCENE} says"
    elif content[ENCLOSURE]["sha256"] != record.enclosure.sha256:
        told, there = content[ENCLOSURE]["row_marks"], record.enclosure.row_marks
        at = next((i for i in range(0, len(told), 4) if told[i : i + 4] != there[i : i + 4]), None)
        line = "" if at is None else f", line {at // 4 + 2}"
        yield f"{ENCLOSURE}{line}: changed since it was written"


def _excluded(printed: Table, enclosure: Table) -> Iterator[str]:
    """Printed entries that the enclosure of their row excludes."""
    told = 0
    times = enclosure.column("t")
    if times != printed.column("t")[: len(times)]:
        yield f"{ENCLOSURE}: its times are not those of {TRAJECTORY}"
        return
    for name in enclosure.columns[1::2]:
        column = printed.column(name)
        scale = scale_of(column)
        balls = zip(enclosure.column(name), enclosure.column(f"{name}_radius"), strict=True)
        for line, (cell, (middle, radius)) in enumerate(zip(column, balls, strict=False), start=2):
            if not _meet(cell, middle, radius, scale):
                told += 1
                if told <= FEW:
                    yield f"{TRAJECTORY}, line {line}, {name}: excluded by its enclosure"


def _meet(cell: str, middle: str, radius: str, scale: Decimal) -> bool:
    """Whether what rounds to the printed text, and the enclosure, have numbers in common."""
    try:
        printed, centre, reach = Decimal(cell), Decimal(middle), Decimal(radius)
        exponent = printed.as_tuple().exponent
        if not isinstance(exponent, int):  # NaN or infinite
            return False
        slack = Decimal(5).scaleb(exponent - 1) if printed else scale.scaleb(-DIGITS)
        beyond = _WIDE.subtract(_WIDE.subtract(printed, centre).copy_abs(), slack)
        return _WIDE.compare(beyond, reach) <= 0
    except (InvalidOperation, Inexact, OverflowError, ValueError):
        return False
