"""Proved statements about golden tables, read without proving them again.

``golden certify`` proves that every printed number is correctly rounded, and that every event
exists and is the only one. So a table encloses itself: the exact number of a cell is within half a
unit of its last digit. ``proof.json`` has the other statements, and the hashes of the proved scene
and tables; ``complaints`` compares the hashes. Only a proof can decide whether the statements are
true: ``golden certify --check`` proves them again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.documents import ProofRecord
from tt_precise.golden.store import EVENTS, PROOF, SCENE, TRAJECTORY, Stored
from tt_precise.golden.table import DIGITS, LABELS, ZERO, last_digit_exponent, malformed_cells
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime import records
from tt_precise.runtime.values import InputError, Json, Scalar
from tt_precise.scene.scene import Scene


class Interval:
    """A closed interval with exact ends that contains an exact value.

    A comparison is true if it is true for all numbers of the interval.
    """

    __slots__ = ("high", "low")

    def __init__(self, low: Fraction, high: Fraction):
        self.low, self.high = low, high

    @classmethod
    def of(cls, number: Scalar) -> Interval:
        """The interval of a rational number, or the interval itself."""
        return number if isinstance(number, Interval) else cls(Fraction(number), Fraction(number))

    @classmethod
    def around(cls, middle: str, radius: str) -> Interval:
        """The interval of a ball, from decimals.

        Raises ``ArithmeticError``: a decimal is not a finite number.
        """
        centre, bound = Decimal(middle), Decimal(radius)
        if not (centre.is_finite() and bound.is_finite() and bound >= 0):
            raise ArithmeticError(f"got {middle} and {radius}, expected a middle and a radius")
        return cls(Fraction(centre) - Fraction(bound), Fraction(centre) + Fraction(bound))

    @classmethod
    def of_printed(cls, text: str, scale: Decimal) -> Interval:
        """The interval of the numbers that are printed as ``text`` in a column with this ``scale``.

        Its radius is half a unit of the last digit; for "0" 1e-34 of the scale.
        """
        number = Fraction(Decimal(text))
        if text == ZERO:
            half = Fraction(scale.scaleb(-DIGITS))
        else:
            half = Fraction(10) ** last_digit_exponent(text) / 2
        return cls(number - half, number + half)

    def __iter__(self) -> Iterator[Fraction]:
        yield self.low
        yield self.high

    def __repr__(self) -> str:
        return f"Interval({float(self.low):.17g}, {float(self.high):.17g})"

    def __lt__(self, other: Scalar) -> bool:
        return self.high < Interval.of(other).low

    def __gt__(self, other: Scalar) -> bool:
        return self.low > Interval.of(other).high

    def __add__(self, other: Scalar) -> Interval:
        y = Interval.of(other)
        return Interval(self.low + y.low, self.high + y.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Scalar) -> Interval:
        return self + -Interval.of(other)

    def __mul__(self, other: Scalar) -> Interval:
        y = Interval.of(other)
        corners = [a * b for a in self for b in y]
        return Interval(min(corners), max(corners))

    def __truediv__(self, other: Scalar) -> Interval:
        y = Interval.of(other)
        if y.low <= 0 <= y.high:
            raise ZeroDivisionError("an interval that contains zero")
        return self * Interval(1 / y.high, 1 / y.low)

    __radd__ = __add__
    __rmul__ = __mul__


Event = dict[str, Interval]  # time and columns of the state there; and ``direction``, +1 or -1


@dataclass(frozen=True)
class TableProof:
    """The proof of one scene's golden tables, valid if ``complaints`` is empty."""

    content: dict[str, Json]
    digits: int

    @property
    def summary(self) -> dict[str, Json]:
        """The proved digits and the count of proved numbers, for a list of scenes."""
        return {"digits": self.digits, **{n: self.content[n] for n in ("rounded", "entries")}}


def read_proof(name: str, folder: Path | None = None) -> TableProof | None:
    """The proof of the golden tables ``name``; None if there is none.

    Raises ``InputError``: the file cannot be used.
    """
    path = (folder or store.home()) / name
    if not (path / PROOF).is_file():
        return None
    try:
        content = records.read_as_record(path / PROOF, ProofRecord, "a proof")
    except (InputError, OSError, ValueError) as error:
        again = f"run `tt-precise golden certify {name}`"
        raise InputError(f"{name}: the proof cannot be used ({error}); {again}") from None
    return TableProof(content, store.read_files(name, path.parent).manifest["digits"])


def complaints(stored: Stored, record: TableProof) -> list[str]:
    """Contradictions between golden tables and their proof; [] if none."""
    content, again = record.content, f"; run `tt-precise golden certify {stored.name}`"
    problems = []
    if content["scene_sha256"] != store.scene_sha256(stored.scene_text):
        problems.append(f"{PROOF}: about another scene than {SCENE} says{again}")
    problems += [
        f"{file}: not the table that was proved{again}"
        for file, table in stored.tables.items()
        if content[file]["sha256"] != table.sha256
    ]
    if content["rounded"] != content["entries"]:
        problems.append(f"{PROOF}: not every number is proved{again}")
    return problems or [line for line in store.changes(stored) if line.startswith(PROOF)]


def summary(stored: Stored) -> dict[str, Json] | None:
    """The proved digits and numbers, or the ``problem`` of the proof; None without a proof."""
    try:
        record = read_proof(stored.name, stored.path.parent)
    except InputError as error:
        return {"problem": str(error)}
    if record is None:
        return None
    malformed = [x for file, table in stored.tables.items() for x in malformed_cells(file, table)]
    for problem in (*malformed, *complaints(stored, record)):
        return {"problem": problem}
    return record.summary


def row_intervals(stored: Stored, file: str, row: int) -> dict[str, Interval]:
    """The exact numbers of a row of proved tables, by column, without undefined numbers.

    The times of samples are no numbers to prove.
    """
    table = stored.tables[file]
    return {
        name: Interval.of_printed(text, stored.scales[name])
        for name, text in zip(table.columns, table.rows[row], strict=True)
        if text and name not in LABELS and (file, name) != (TRAJECTORY, "t")
    }


def proved_events(stored: Stored) -> dict[str, list[Event]]:
    """The exact events of proved tables by name, in order of time."""
    events: dict[str, list[Event]] = {}
    for position, row in enumerate(stored.events.rows):
        event = row_intervals(stored, EVENTS, position)
        event["direction"] = Interval.of(int(row[2]))
        events.setdefault(row[0], []).append(event)
    return events


NOTHING: dict[str, Json] = {"contact": {}, "inversion": {}, "forever": {}, "proved_events": {}}


@dataclass(frozen=True)
class Established:
    """Statements of a valid, complete proof of a scene, in SI; without one nothing, and ``why``."""

    stored: Stored | None = None
    record: TableProof | None = None
    why: str = ""

    @property
    def _content(self) -> dict[str, Json]:
        return self.record.content if self.record else NOTHING

    @cached_property
    def _rows(self) -> dict[str, int]:
        times = self.stored.trajectory.column("t") if self.stored else ()
        return {t: row for row, t in enumerate(times)}

    @cached_property
    def _events(self) -> dict[str, list[Event]]:
        return proved_events(self.stored) if self.stored else {}

    @property
    def g_n_positive(self) -> bool:
        """True if g_n > 0 is proved at all times from 0 to the horizon, both included."""
        return self._content["contact"].get("g_n_positive") is True

    @property
    def contact_lost(self) -> Interval | None:
        """The time of the first zero of g_n, a simple zero; None if that is not proved."""
        ball = self._content["contact"].get("lost_at_s")
        return Interval.around(**ball) if ball else None

    @property
    def energy_falls(self) -> bool:
        """True if E falls throughout: E' = -mu g_n v_A^2 (EQ-05) is negative except at instants.

        Proof: an analytic v_A that is not identically zero vanishes only at isolated instants.
        """
        if self.stored is None or not self.g_n_positive or not self.stored.scene.body.mu:
            return False
        speeds = (self.at(name, t) for t in self._rows for name in ("vx", "vy"))
        return any(speed is not None and not speed.low <= 0 <= speed.high for speed in speeds)

    @property
    def for_ever(self) -> dict[str, Json] | None:
        """The statement for all later times (``certify.well``), or None.

        The statement has the keys ``theta_tends_to``, ``limits`` and ``g_n_at_least_mg``.
        """
        forever = self._content["forever"]
        return forever.get("at_the_end", forever.get("held"))

    @property
    def inverts(self) -> bool:
        """True if the inverted spin is proved to be the limit of the motion, for t -> infinity."""
        return bool(self.for_ever and self.for_ever["theta_tends_to"] == "pi")

    def at(self, column: str, t: str) -> Interval | None:
        """A column at the sampled time ``t`` (s, as printed); None where nothing is proved."""
        if self.stored is None or t not in self._rows:
            return None
        return row_intervals(self.stored, TRAJECTORY, self._rows[t]).get(column)

    def potential_energy(self, t: str) -> Interval | None:
        """E_pot in J at the sampled time ``t``; linear in cos theta."""
        height = self.at("kz", t)
        if self.stored is None or height is None:
            return None
        body, still = self.stored.scene.body.numbers(Fraction), NewtonState(*(0,) * 8)
        ends = (
            QUANTITIES["E_pot"].evaluate(Motion(body, still._replace(kz=kz), None)) for kz in height
        )
        return Interval(*sorted(ends))

    def moment(self, definition: str, which: str) -> Interval | None:
        """``t_init``, ``t_end`` or ``duration`` in s by a definition; None if not proved."""
        if which == "duration":
            begin, end = (self.moment(definition, name) for name in ("t_init", "t_end"))
            return end - begin if begin and end else None
        ball = self._content["inversion"].get(definition, {}).get(which)
        return Interval.around(**ball) if ball else None

    def events(self, *names: str) -> list[Event] | None:
        """Time, state and direction at all events with one of these names, in order of time.

        None if nothing is proved. A zero of the event's function at t = 0 is no event.
        """
        if any(name not in self._content["proved_events"] for name in names):
            return None
        happened = [event for name in names for event in self._events.get(name, [])]
        return sorted(happened, key=lambda event: event["t"])


def established(scene: Scene, folder: Path | None = None) -> Established:
    """Return the statements of the complete, valid proof for exactly this scene, or why not."""
    if scene.name not in store.scenes(folder):
        return Established(why=f"{scene.name}: no golden data")
    stored = store.read_files(scene.name, folder)
    if stored.scene != scene:
        why = f"{scene.name}: the golden data are those of another start, body or horizon"
        return Established(why=why)
    try:
        record = read_proof(scene.name, folder)
    except InputError as error:
        return Established(why=str(error))
    if record is None:
        again = f"`tt-precise golden certify {scene.name}` makes it"
        return Established(why=f"{scene.name}: no {PROOF}; {again}")
    if spoiled := complaints(stored, record):
        return Established(why=spoiled[0])
    return Established(stored, record)
