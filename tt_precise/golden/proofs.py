"""The proofs of golden tables by ``golden certify``, read without python-flint.

The folder of the tables also has ``proof.json`` (the statements, the tables, the prover) and two
tables of balls, ``enclosure.csv`` and ``events-enclosure.csv``: the last digits of the exact number
in each cell of ``trajectory.csv`` and ``events.csv``. These are the last six that are printed and
three more, to one unit; the digits before them are the printed digits. (62202699 with
9.983341664682815230681419841062203e-2 means 9.983341664682815230681419841062202699e-2.)

``complaints`` compares all of these with each other. Every printed number must meet its ball;
counts, times of the climb and the bound of the contact force are derived again. This detects every
change of these files, even with adapted hashes, except a change by a multiple of 1e6 units of the
last place; for that ``verify`` recomputes 28 digits. Only a proof can decide whether the balls
contain the exact solution.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.digits import DIGITS, ZERO, column_digits, last_place, misprinted
from tt_precise.golden.documents import Proof
from tt_precise.golden.store import EVENTS, PROOF, PROOF_HASH, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.integration.events import catalogue
from tt_precise.integration.inversion import (
    InversionEvents,
    InversionTimes,
    Turns,
    from_inversion_events,
)
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime import records
from tt_precise.runtime.values import InputError, Json, Scalar
from tt_precise.scene.scene import Scene

SCHEMA = Proof.__struct_config__.tag
# The version of the prover increases with each change that affects soundness; a proof by a version
# before ``SOUND_SINCE`` is refused.
PROVER = SOUND_SINCE = 1
ENCLOSURE, EVENTS_ENCLOSURE = "enclosure.csv", "events-enclosure.csv"
ENCLOSURES = {TRAJECTORY: ENCLOSURE, EVENTS: EVENTS_ENCLOSURE}
LABELS = {TRAJECTORY: ("t",), EVENTS: ("name", "direction")}  # columns without a ball
LONGEST_EXPONENT = 5  # its sign included
KEPT, BEYOND = 6, 3  # digits of a ball: printed ones, and those after them
FEW = 3  # of many equal complaints so many are listed
FLOAT_SLACK = 1e-9  # of g_n/(m g) in double
NO_TURNS = Turns((), (), ())
_WIDE = Context(prec=400)


def _digits_of(text: str) -> tuple[int, int]:
    """A decimal as a whole number and the power of ten of its last digit.

    Raises ``ValueError``: it is no decimal.
    """
    mantissa, _, exponent = text.partition("e")
    front, _, decimals = mantissa.partition(".")
    if len(exponent) > LONGEST_EXPONENT:
        raise ValueError(f"got {text[:50]!r}, expected a number")
    return int(front + decimals), int(exponent or 0) - len(decimals)


class Interval:
    """Exact numbers that an exact value lies between, ends included.

    A comparison is true if it is true for all of them.
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
        """From the decimals of a ball.

        Raises ``ArithmeticError``: one of them is not a finite number.
        """
        centre, reach = Decimal(middle), Decimal(radius)
        if not (centre.is_finite() and reach.is_finite() and reach >= 0):
            raise ArithmeticError(f"got {middle} and {radius}, expected a middle and a radius")
        return cls(Fraction(centre) - Fraction(reach), Fraction(centre) + Fraction(reach))

    @classmethod
    def of_ball(cls, text: str, ball: str, scale: Decimal) -> Interval:
        """The interval of a number printed as ``text`` in a column of this ``scale``."""
        sign, number, place = _printed(text, scale)
        middle, radius = _ball(ball)
        middle += number // 10**KEPT * 10 ** (KEPT + BEYOND)
        unit = Fraction(10) ** (place - BEYOND)
        return cls(*sorted(sign * end * unit for end in (middle - radius, middle + radius)))

    def __iter__(self) -> Iterator[Fraction]:
        yield self.low
        yield self.high

    def __repr__(self) -> str:
        return f"Interval({float(self.low):.17g}, {float(self.high):.17g})"

    def meets(self, other: Interval) -> bool:
        return self.low <= other.high and other.low <= self.high

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


PI = Interval.around("3.14159265358979323846264338327950288419716939937510582097494", "1e-59")


def _printed(text: str, scale: Decimal) -> tuple[int, int, int]:
    """Sign and digits of a printed number, and the place of the last; 0 is one of 34 digits."""
    if text == ZERO:
        return 1, 0, scale.adjusted() - DIGITS
    number, place = _digits_of(text)
    return (-1 if number < 0 else 1), abs(number), place


def _ball(text: str) -> tuple[int, int]:
    """Middle and radius of a cell, in units of the last digit that it may have."""
    number, power = _digits_of(text)
    if power < 0:
        raise ValueError(f"got {text[:50]!r}, expected a whole number")
    return number * 10**power, 10**power


def ball_text(text: str, low: Fraction, high: Fraction, scale: Decimal) -> str:
    """The cell for a number between ``low`` and ``high`` that is printed as ``text``.

    If the interval is too wide for one unit of the last digit, the unit is a higher power of ten.
    """
    sign, number, place = _printed(text, scale)
    before = number // 10**KEPT * 10 ** (KEPT + BEYOND)
    ends = [sign * end / Fraction(10) ** (place - BEYOND) - before for end in (low, high)]
    power = 0
    while True:
        unit = 10**power
        whole = round(sum(ends) / 2 / unit)
        if (whole - 1) * unit <= min(ends) and max(ends) <= (whole + 1) * unit:
            return f"{whole}e{power}" if power else str(whole)
        power += 1


Event = dict[str, Interval]  # time and columns of the state there; and ``direction``, +1 or -1


@dataclass(frozen=True)
class Record:
    """proof.json and the enclosures of one scene.

    It is valid if ``complaints`` is empty.
    """

    content: dict[str, Json]
    enclosure: Table
    events: Table

    @property
    def digits(self) -> int | None:
        """Fewest proved digits of a column; None if only zeros are printed."""
        return self.content["digits"]

    @property
    def incomplete(self) -> str:
        """The unproved part in words; "" if every printed number, event and time is proved."""
        content = self.content
        if content["failure"]:
            return str(content["failure"])
        if content["mismatches"]:
            return str(content["mismatches"][0])
        if content["undecided_events"]:
            name, why = next(iter(content["undecided_events"].items()))
            return f"{name}: {why}"
        if content["unproved"]:
            return f"{content['unproved']} numbers have no enclosure"
        if "failure" in content["inversion"]:
            return f"times of the climb: {content['inversion']['failure']}"
        return "" if content["contact"]["g_n_positive"] else "the contact force may reach zero"

    @property
    def complete(self) -> bool:
        return not self.incomplete

    @property
    def until_s(self) -> str:
        """The time in s up to which every row is enclosed."""
        return str(self.content["proved_until_s"]["middle"])

    @property
    def summary(self) -> dict[str, Json]:
        """For a list of scenes: proved digits, and the count of numbers with proved rounding."""
        facts = {name: self.content[name] for name in ("digits", "rounded", "entries")}
        return {**facts, "complete": self.complete, "until_s": self.until_s}

    def balls(self, file: str) -> Table:
        """The enclosures of the numbers in a golden file."""
        return self.enclosure if file == TRAJECTORY else self.events


def read(name: str, folder: Path | None = None) -> Record | None:
    """The proof of the golden tables ``name``; None if there is none.

    Raises ``InputError``: a file cannot be used, or its prover is not sound.
    """
    place = (folder or store.home()) / name
    files = (PROOF, ENCLOSURE, EVENTS_ENCLOSURE)
    if not any((place / file).is_file() for file in files):
        return None
    again = f"run `tt-precise golden certify {name}`"
    try:
        content = records.read_as_record(place / PROOF, Proof, "a proof")
        enclosure, events = (Table.parse((place / file).read_text("utf-8")) for file in files[1:])
    except (InputError, OSError, ValueError) as error:
        raise InputError(f"{name}: the proof cannot be used ({error}); {again}") from None
    version = content["prover"]["version"]
    if not SOUND_SINCE <= version <= PROVER:
        raise InputError(
            f"{place / PROOF}: got a proof by version {version} of the prover, expected "
            f"{SOUND_SINCE} to {PROVER}; {again}"
        )
    return Record(content, enclosure, events)


def complaints(stored: Stored, record: Record, *, rows: bool = True) -> list[str]:
    """Contradictions in the golden tables or their proof; [] if none.

    Without ``rows`` the single numbers are not compared, which takes most of the time.
    """
    problems = list(_damage(stored, record))
    if problems:
        return problems
    again = f"; run `tt-precise golden certify {stored.name}`"
    problems = [
        f"{file}: not the table that was proved{again}"
        for file in ENCLOSURES
        if record.content[file]["sha256"] != stored.table(file).sha256
    ]
    try:
        problems += _counts(stored, record)
        if rows:
            problems += _shapes(stored, record)
            for file in ENCLOSURES:
                problems += _excluded(stored, record, file)
            if not problems:
                problems += _times(stored, record)
                problems += _contact(stored, record)
    except (ArithmeticError, ValueError, KeyError, IndexError) as error:
        problems.append(f"{PROOF}: cannot be checked ({type(error).__name__}: {error})")
    return problems


def _damage(stored: Stored, record: Record) -> Iterator[str]:
    """Changes of the files since they were written, and a different scene."""
    content = record.content
    if content[PROOF_HASH] != store.self_hash(content, PROOF_HASH):
        yield f"{PROOF}: edited after it was written"
        return
    if content["scene_sha256"] != store.scene_sha256(stored.scene_text):
        yield f"{PROOF}: about another scene than {store.SCENE} says"
        return
    for file, name in ENCLOSURES.items():
        if content[name]["sha256"] != record.balls(file).sha256:
            yield f"{name}: changed since it was written"


def _counts(stored: Stored, record: Record) -> Iterator[str]:
    """Numbers in proof.json that follow from the tables."""
    content, columns = record.content, []
    for file in ENCLOSURES:
        table, described = stored.table(file), content[file]["columns"]
        names = [name for name in table.columns if name not in LABELS[file]]
        if list(described) != names:
            yield f"{PROOF}: its columns are not those of {file}"
            return
        for name in names:
            cells, entry = table.column(name), described[name]
            columns.append(entry)
            most = column_digits(cells, stored.scales[name]).digits
            if entry["wrong"]:
                yield f"{file}: {entry['wrong']} entries of {name} are proved wrong"
            if (
                entry["entries"] != sum(map(bool, cells))
                or not 0 <= entry["rounded"] <= entry["entries"]
            ):
                yield f"{PROOF}: counts other entries of {name} than {file} has"
            elif entry["digits"] is not None and (most is None or entry["digits"] > most):
                yield f"{PROOF}: {entry['digits']} digits of {name}, where {most} are printed"
    for key in ("entries", "rounded"):
        if content[key] != sum(entry[key] for entry in columns):
            yield f"{PROOF}: {key} is not the sum over the columns"
    digits = [entry["digits"] for entry in columns if entry["digits"] is not None]
    if content["digits"] != min(digits, default=None):
        yield f"{PROOF}: digits is not the least over the columns"
    yield from _event_counts(stored, content)


def _event_counts(stored: Stored, content: dict[str, Json]) -> Iterator[str]:
    proved, undecided = content["proved_events"], content["undecided_events"]
    names = catalogue(stored.scene.model)
    if sorted([*proved, *undecided]) != sorted(names):
        yield f"{PROOF}: its kinds of events are not those of the catalogue"
    counts = Counter(stored.events.column("name"))
    for name, count in proved.items():
        if count != counts[name] and content["failure"] is None:
            yield f"{PROOF}: {count} events {name}, where {EVENTS} lists {counts[name]}"


def _shapes(stored: Stored, record: Record) -> Iterator[str]:
    """Whether there is an enclosure for each row and column."""
    for file, name in ENCLOSURES.items():
        printed, balls = stored.table(file), record.balls(file)
        if balls.columns != tuple(
            column for column in printed.columns if column not in LABELS[file]
        ):
            yield f"{name}: its columns are not those of {file}"
        there, expected = len(balls.rows), len(printed.rows)
        if there > expected or (record.complete and there < expected):
            yield f"{name}: {there} rows, where {file} has {expected}"


def _excluded(stored: Stored, record: Record, file: str) -> Iterator[str]:
    """Printed entries that their enclosure excludes."""
    printed, balls, problems = stored.table(file), record.balls(file), []
    for name in balls.columns:
        pairs = zip(printed.column(name), balls.column(name), strict=False)
        problems += [
            (line, f"{file}, line {line}, {name}: excluded by its enclosure")
            for line, pair in enumerate(pairs, start=2)
            if excludes(*pair, stored.scales[name])
        ]
    yield from (said for _, said in sorted(problems)[:FEW])


def excludes(text: str, ball: str, scale: Decimal) -> bool:
    """Whether no number in a ball rounds to the printed ``text``.

    "0" stands for what is at most 1e-34 of the column's ``scale``.
    """
    if not text or not ball:
        return bool(text) != bool(ball)
    middle, radius = _ball(ball)
    _, number, place = _printed(text, scale)
    if text == ZERO:
        least = Decimal(max(abs(middle) - radius, 0))
        return least.scaleb(place - BEYOND, _WIDE) > scale.scaleb(-DIGITS)
    return abs(middle - number % 10**KEPT * 10**BEYOND) > 10**BEYOND // 2 + radius


def enclosed(stored: Stored, record: Record, file: str, row: int) -> dict[str, Interval]:
    """The exact numbers of a row of golden data, by column; without those that are undefined."""
    balls, texts = record.balls(file), stored.table(file)
    printed = dict(zip(texts.columns, texts.rows[row], strict=True))
    return {
        name: Interval.of_ball(printed[name], ball, stored.scales[name])
        for name, ball in zip(balls.columns, balls.rows[row], strict=True)
        if ball
    }


def _times(stored: Stored, record: Record) -> Iterator[str]:
    """Times of the climb that differ from those of the events."""
    stated = record.content["inversion"]
    if "failure" in stated:
        return
    if record.content["failure"]:
        # null means that it never happens
        if stated.get("equator") is None:
            yield f"{PROOF}: no climb, by a proof that ends early"
        return
    climb = inversion(stored, record)
    moments = {"equator": (stated.get("equator"), climb.equator)}
    for name in "ABC":
        for which in ("t_init", "t_end"):
            own = getattr(getattr(climb, name), which)
            moments[f"{name}, {which}"] = stated.get(name, {}).get(which), own
    for name, (ball, derived) in moments.items():
        if (ball is None) != (derived is None):
            yield f"{PROOF}: {name} is {'none' if ball is None else 'there'}, not so the events say"
        elif ball is not None and not Interval.around(**ball).meets(Interval.of(derived)):
            yield f"{PROOF}: {name} is not where the events put it"


def inversion(stored: Stored, record: Record) -> InversionTimes:
    """The times of the climb, from the enclosed events."""
    events = proved_events(stored, record)
    rising = [event for event in events.get("equator", []) if event["direction"] < 0]
    if not rising:
        return from_inversion_events(InversionEvents([], NO_TURNS, NO_TURNS, [], [], []), PI)
    first = enclosed(stored, record, TRAJECTORY, 0)
    state = NewtonState(*(first[name] for name in NewtonState._fields))
    motion = Motion(stored.scene.body.numbers(Fraction), state, None)
    sign = -1 if QUANTITIES["lambda"].evaluate(motion) < 0 else 1

    def times(name: str) -> list[Interval]:
        return [event["t"] for event in events.get(name, [])]

    def turns(name: str) -> Turns:
        turning = events.get(name, [])
        return Turns(
            times(name),
            [event["theta"] for event in turning],
            [sign * event["phi_dot"] for event in turning],
        )

    marks = InversionEvents(
        equator=[event["t"] for event in rising],
        minima=turns("theta_min"),
        maxima=turns("theta_max"),
        phi_dot_zero=times("phi_dot_zero"),
        aligned=times("Lk_equals_Lz"),
        opposed=times("Lk_equals_minus_Lz"),
        backwards=sign * rising[0]["phi_dot"] < 0,
    )
    return from_inversion_events(marks, PI)


def proved_events(stored: Stored, record: Record) -> dict[str, list[Event]]:
    """The enclosed events by name, in order of time."""
    events: dict[str, list[Event]] = {}
    for position, row in enumerate(stored.events.rows):
        event = enclosed(stored, record, EVENTS, position)
        event["direction"] = Interval.of(int(row[2]))
        events.setdefault(row[0], []).append(event)
    return events


def _contact(stored: Stored, record: Record) -> Iterator[str]:
    """Contradictions between the statement on the contact force and the printed tables."""
    import numpy

    contact = record.content["contact"]
    lost = [row for row in stored.events.rows if row[0] == "contact_lost"]
    if "lost_at_s" in contact:
        ball = Interval.around(**contact["lost_at_s"])
        half = f"5e{last_place(lost[0][1]) - 1}" if lost else "0"
        if len(lost) != 1 or not ball.meets(Interval.around(lost[0][1], half)):
            yield f"{PROOF}: contact is lost at another time than {EVENTS} says"
        return
    if lost:
        yield f"{PROOF}: contact is not lost, but {EVENTS} says so"
    if stored.scene.lifts or not contact["g_n_positive"]:
        return
    scene, table = stored.scene, stored.trajectory
    state = NewtonState(*(numpy.array(table.column(name), float) for name in NewtonState._fields))
    body = scene.body.numbers(float)
    force = QUANTITIES["g_n"].evaluate(Motion(body, state, numpy, scene.model))
    bound = Fraction(Decimal(contact["g_n_at_least_mg"]))
    if not 0 < bound <= numpy.min(force) / (body.m * body.g) + FLOAT_SLACK:
        yield f"{PROOF}: a bound of the contact force that {TRAJECTORY} breaks"
    if not contact["energy_never_grows"]:
        yield f"{PROOF}: the energy may grow, although the contact force is positive"


NOTHING: dict[str, Json] = {"contact": {}, "inversion": {}, "forever": {}, "proved_events": {}}


@dataclass(frozen=True)
class Established:
    """What a valid, complete proof says of its scene, in SI; without one nothing, and ``why``."""

    stored: Stored | None = None
    record: Record | None = None
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
        return proved_events(self.stored, self.record) if self.stored and self.record else {}

    @property
    def g_n_positive(self) -> bool:
        """Whether g_n > 0 at all times from 0 to the horizon, both included."""
        return self._content["contact"].get("g_n_positive") is True

    @property
    def contact_lost(self) -> Interval | None:
        """The time of the first zero of g_n, a simple zero; None if that is not proved."""
        ball = self._content["contact"].get("lost_at_s")
        return Interval.around(**ball) if ball else None

    @property
    def energy_falls(self) -> bool:
        """Whether E falls throughout: E' = -mu g_n v_A^2 (EQ-05) is negative except at instants.

        An analytic v_A that is not identically zero vanishes only at isolated instants.
        """
        if self.stored is None or not self.g_n_positive or not self.stored.scene.body.mu:
            return False
        speeds = (self.at(name, t) for t in self._rows for name in ("vx", "vy"))
        return any(speed is not None and not speed.low <= 0 <= speed.high for speed in speeds)

    @property
    def for_ever(self) -> dict[str, Json] | None:
        """The statement for all later times (``certify.energy_well``); None if there is none.

        With ``theta_tends_to``, ``limits`` and ``g_n_at_least_mg``.
        """
        forever = self._content["forever"]
        return forever.get("at_the_end", forever.get("held"))

    @property
    def inverts(self) -> bool:
        """Whether the inverted spin is proved to be the limit of the motion, for t -> infinity."""
        return bool(self.for_ever and self.for_ever["theta_tends_to"] == "pi")

    @property
    def span(self) -> str:
        """In words, the times for which ``g_n_positive`` and ``least_g_n`` hold."""
        if self.record is None or self.for_ever is not None:
            return "at all times t >= 0"
        return f"at all times from 0 to {Decimal(self.record.until_s):.3g} s"

    @property
    def least_g_n(self) -> str:
        """A proved lower bound of g_n in units of m g, rounded down; "0" if none is proved."""
        bound, later = self._content["contact"].get("g_n_at_least_mg"), self.for_ever
        if not bound:
            return "0"
        least = min(Decimal(bound), Decimal(later["g_n_at_least_mg"] if later else bound))
        return f"{least:f}"

    def at(self, column: str, t: str) -> Interval | None:
        """A column at the sampled time ``t`` (s, as printed); None where nothing is proved."""
        if self.stored is None or self.record is None or t not in self._rows:
            return None
        return enclosed(self.stored, self.record, TRAJECTORY, self._rows[t]).get(column)

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
        """``t_init``, ``t_end`` or ``duration`` in s in a definition; None if not proved."""
        if which == "duration":
            begin, end = (self.moment(definition, name) for name in ("t_init", "t_end"))
            return end - begin if begin and end else None
        ball = self._content["inversion"].get(definition, {}).get(which)
        return Interval.around(**ball) if ball else None

    def events(self, *names: str) -> list[Event] | None:
        """Time, state and direction at all events with one of these names, in order of time.

        None if any is undecided. A zero of the event's function at t = 0 itself is not an event.
        """
        if any(name not in self._content["proved_events"] for name in names):
            return None
        happened = [event for name in names for event in self._events.get(name, [])]
        return sorted(happened, key=lambda event: event["t"])


def summary(stored: Stored, folder: Path | None = None) -> dict[str, Json] | None:
    """The entry of a proof in a list of scenes, or its ``problem``; None without a proof.

    Counts and hashes are checked; ``verify`` also checks single numbers.
    """
    try:
        record = read(stored.name, folder)
    except InputError as error:
        return {"problem": str(error)}
    if record is None:
        return None
    problems = [
        *misprinted(TRAJECTORY, stored.trajectory),
        *misprinted(EVENTS, stored.events),
    ] or complaints(stored, record, rows=False)
    return {"problem": problems[0]} if problems else record.summary


def established(scene: Scene, folder: Path | None = None) -> Established:
    """What the complete and valid proof for exactly this scene says; or why there is none."""
    if scene.name not in store.scenes(folder):
        return Established(why=f"{scene.name}: no golden data")
    stored = store.read(scene.name, folder)
    if stored.scene != scene:
        why = f"{scene.name}: the golden data are those of another start, body or horizon"
        return Established(why=why)
    try:
        record = read(scene.name, folder)
    except InputError as error:
        return Established(why=str(error))
    if record is None:
        again = f"`tt-precise golden certify {scene.name}` makes it"
        return Established(why=f"{scene.name}: no {PROOF}; {again}")
    if spoiled := complaints(stored, record):
        return Established(why=spoiled[0])
    if not record.complete:
        return Established(why=f"{scene.name}: {record.incomplete}")
    return Established(stored, record)
