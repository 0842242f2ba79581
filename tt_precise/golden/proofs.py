"""Proved statements about golden tables, read without proving them again.

``golden certify`` proves that every printed number is correctly rounded, and that every event
exists and is the only one. So a table encloses itself: the exact number of a cell is within half a
unit of its last digit. ``proof.json`` has the other statements, and the hashes of the proved scene
and tables, which ``read_proof`` compares; ``golden certify --check`` proves all again. After a
change of the code that made it, ``CODE``, a proof is ``stale`` until it is made again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.store import EVENTS, PROOF, SCENE, TRAJECTORY, ProofRecord, Stored
from tt_precise.golden.table import DIGITS, LABELS, ZERO, last_digit_exponent, malformed_cells
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime import records
from tt_precise.runtime.cache import source_hash
from tt_precise.runtime.values import InputError, Json
from tt_precise.scene.scene import Scene

# what a reader of a proof has to trust; docs/explanation/proof.md says for which statement
CODE = (
    *(f"certify/{name}.py" for name in (
        "kernel", "balls", "models", "motion", "compare", "problem", "statements", "well")),
    "scene", "mechanics", "integration/equations.py", "integration/events.py",
    "integration/inversion.py", "nonsmooth/phases.py", "nonsmooth/lifting.py",
    "golden/table.py", "golden/runs.py", "runtime/values.py",
)  # fmt: skip


@dataclass(frozen=True)
class Interval:
    """A closed interval with exact ends that contains an exact value.

    A comparison is true if it is true for all numbers of the intervals.
    """

    low: Fraction
    high: Fraction

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

    def __lt__(self, other: Interval) -> bool:
        return self.high < other.low

    def __gt__(self, other: Interval) -> bool:
        return self.low > other.high

    def __sub__(self, other: Interval) -> Interval:
        return Interval(self.low - other.high, self.high - other.low)

    def __truediv__(self, other: Interval) -> Interval:
        if other.low <= 0 <= other.high:
            raise ZeroDivisionError("an interval that contains zero")
        corners = [a / b for a in self for b in other]
        return Interval(min(corners), max(corners))


Event = dict[str, Interval]  # time and columns of the state there; and ``direction``, +1 or -1


def read_proof(stored: Stored) -> dict[str, Json] | None:
    """The content of the valid proof of golden tables; None if there is none.

    Raises ``InputError``: the file cannot be used, or contradicts the tables.
    """
    path, again = stored.path / PROOF, f"; run `tt-precise golden certify {stored.name}`"
    if not path.is_file():
        return None
    try:
        content = records.read_as_record(path, ProofRecord, "a proof")
    except (InputError, OSError, ValueError) as error:
        raise InputError(f"{stored.name}: the proof cannot be used ({error}){again}") from None
    for problem in _contradictions(stored, content):
        raise InputError(f"{problem}{again}")
    return content


def _contradictions(stored: Stored, content: dict[str, Json]) -> Iterator[str]:
    if content["scene_sha256"] != store.scene_sha256(stored.scene_text):
        yield f"{PROOF}: about another scene than {SCENE} says"
    for file, table in stored.tables.items():
        if content[file]["sha256"] != table.sha256:
            yield f"{file}: not the table that was proved"
        yield from malformed_cells(file, table)
    if content["rounded"] != content["entries"]:
        yield f"{PROOF}: not every number is proved"
    yield from (line for line in store.changes(stored) if line.startswith(PROOF))


@cache
def trusted() -> dict[str, str]:
    """The hash of each path of ``CODE``."""
    return {path: source_hash(path) for path in CODE}


def stale(proof: dict[str, Json]) -> str:
    """The trusted sources that have changed since a proof was made, in words; "" if none has."""
    if (code := proof.get("code")) is None:
        return ", by earlier code"
    paths = ", ".join(path for path, sha256 in trusted().items() if code.get(path) != sha256)
    return f", before the last change of {paths}" if paths else ""


def summary(stored: Stored) -> dict[str, Json] | None:
    """The proved digits and numbers, and whether the proof is ``stale``; None without a proof.

    Of a proof that cannot be used the ``problem``.
    """
    try:
        proof = read_proof(stored)
    except InputError as error:
        return {"problem": str(error)}
    if proof is None:
        return None
    numbers = {name: proof[name] for name in ("rounded", "entries")}
    return {"digits": stored.manifest["digits"], **numbers, "stale": bool(stale(proof))}


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


NOTHING: dict[str, Json] = {"contact": {}, "inversion": {}, "forever": {}, "proved_events": {}}


@dataclass(frozen=True)
class Established:
    """Statements of a valid, complete proof of a scene, in SI; without one nothing, and ``why``."""

    stored: Stored | None = None
    proof: dict[str, Json] = field(default_factory=NOTHING.copy)
    why: str = ""

    @cached_property
    def _rows(self) -> dict[str, int]:
        times = self.stored.trajectory.column("t") if self.stored else ()
        return {t: row for row, t in enumerate(times)}

    @property
    def g_n_positive(self) -> bool:
        """True if g_n > 0 is proved at all times from 0 to the horizon, both included."""
        return self.proof["contact"].get("g_n_positive") is True

    @property
    def contact_lost(self) -> Interval | None:
        """The time of the first zero of g_n, a simple zero; None if that is not proved."""
        ball = self.proof["contact"].get("lost_at_s")
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
        forever = self.proof["forever"]
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
        ball = self.proof["inversion"].get(definition, {}).get(which)
        return Interval.around(**ball) if ball else None

    def events(self, *names: str) -> list[Event] | None:
        """Time, state and direction at all events with one of these names, in order of time.

        None if nothing is proved. A zero of the event's function at t = 0 is no event.
        """
        if self.stored is None or not {*names} <= {*self.proof["proved_events"]}:
            return None
        happened = []
        for position, (name, _, way, *_) in enumerate(self.stored.events.rows):
            if name in names:
                event = row_intervals(self.stored, EVENTS, position)
                happened.append({**event, "direction": Interval(Fraction(way), Fraction(way))})
        return happened


def established(scene: Scene, folder: Path | None = None) -> Established:
    """Return the statements of the complete, valid proof for exactly this scene, or why not."""
    if scene.name not in store.scenes(folder):
        return Established(why=f"{scene.name}: no golden data")
    stored = store.read_files(scene.name, folder)
    if stored.scene != scene:
        why = f"{scene.name}: the golden data are those of another start, body or horizon"
        return Established(why=why)
    try:
        proof = read_proof(stored)
    except InputError as error:
        return Established(why=str(error))
    if proof is None:
        again = f"`tt-precise golden certify {scene.name}` makes it"
        return Established(why=f"{scene.name}: no {PROOF}; {again}")
    return Established(stored, proof)
