"""Golden tables against their proof, and the proof against itself: every contradiction, named.

Every printed number has to meet its enclosure, Euler columns those that follow from the vectors.
Counts, times of the climb and the bound of the contact force are derived again from tables and
enclosures. This finds what was changed in any of these files, also where all hashes were made to
fit. Whether the enclosures are those of the exact solution only a proof can decide.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

from tt_precise.golden import store
from tt_precise.golden.digits import DIGITS, ZERO, column_digits
from tt_precise.golden.enclosures import ENCLOSURE, EVENTS_ENCLOSURE, LABELS, Enclosures
from tt_precise.golden.hashes import scene_sha256, self_hash
from tt_precise.golden.held import surely_held
from tt_precise.golden.outward import Outward, pi
from tt_precise.golden.proof_record import PROOF, SELF_HASH, Record
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.tails import last_place
from tt_precise.integration.events import catalogue
from tt_precise.integration.inversion import InversionTimes, Marks, Turns, from_marks
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.untyped import Json

FEW = 3  # of many equal complaints so many are listed
FLOAT_SLACK = 1e-9  # of g_n/(m g) in double
NO_TURNS = Turns((), (), ())
FILES = {TRAJECTORY: ENCLOSURE, EVENTS: EVENTS_ENCLOSURE}


def complaints(stored: Stored, record: Record, *, rows: bool = True) -> list[str]:
    """What speaks against the golden tables, or against their proof; [] if nothing.

    Without ``rows`` the single numbers are left out, which takes most of the time.
    """
    found = list(_damage(stored, record))
    if found:
        return found
    again = f"; run `tt-precise golden certify {stored.name}`"
    found = [
        f"{file}: not the table that was proved{again}"
        for file in FILES
        if record.content[file]["sha256"] != stored.table(file).sha256
    ]
    try:
        found += _counts(stored, record)
        if rows:
            enclosures = record.enclosures(stored)
            found += _shapes(stored, record, enclosures)
            for file in FILES:
                found += _excluded(enclosures, file)
            if not found:
                found += _times(stored, record, enclosures)
                found += _contact(stored, record)
    except (ArithmeticError, ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
        found.append(f"{PROOF}: cannot be checked ({type(error).__name__}: {error})")
    return found


def _damage(stored: Stored, record: Record) -> Iterator[str]:
    """Whether the files are still what was written, about this scene."""
    content = record.content
    if content[SELF_HASH] != self_hash(content, SELF_HASH):
        yield f"{PROOF}: edited after it was written"
        return
    if content["scene_sha256"] != scene_sha256(stored.scene_text):
        yield f"{PROOF}: about another scene than {store.SCENE} says"
        return
    for file, table in ((ENCLOSURE, record.enclosure), (EVENTS_ENCLOSURE, record.events)):
        if content[file]["sha256"] != table.sha256:
            before, now = content[file]["row_marks"], table.row_marks
            marks = range(0, len(before), 4)
            at = next((i for i in marks if before[i : i + 4] != now[i : i + 4]), None)
            line = "" if at is None else f", line {at // 4 + 2}"
            yield f"{file}{line}: changed since it was written"


def _counts(stored: Stored, record: Record) -> Iterator[str]:
    """Numbers in proof.json that follow from the tables."""
    content, columns = record.content, []
    scales = record.enclosures(stored).scales
    for file in FILES:
        table, described = stored.table(file), content[file]["columns"]
        names = [name for name in table.columns if name not in LABELS]
        names = names if file == EVENTS else names[1:]
        if list(described) != names:
            yield f"{PROOF}: its columns are not those of {file}"
            return
        for name in names:
            cells, one = table.column(name), described[name]
            columns.append(one)
            scale = scales[name] if name != "t" else Decimal(0)
            most = column_digits(cells, scale).digits
            if one["wrong"]:
                yield f"{file}: {one['wrong']} entries of {name} are proved wrong"
            if one["entries"] != sum(map(bool, cells)) or not 0 <= one["rounded"] <= one["entries"]:
                yield f"{PROOF}: counts other entries of {name} than {file} has"
            elif one["digits"] is not None and (most is None or one["digits"] > most):
                yield f"{PROOF}: {one['digits']} digits of {name}, where {most} are printed"
    for key in ("entries", "rounded"):
        if content[key] != sum(one[key] for one in columns):
            yield f"{PROOF}: {key} is not the sum over the columns"
    digits = [one["digits"] for one in columns if one["digits"] is not None]
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


def _shapes(stored: Stored, record: Record, enclosures: Enclosures) -> Iterator[str]:
    """Whether there is an enclosure for each row and column."""
    for file, name in FILES.items():
        printed, table = stored.table(file), enclosures.table(file)
        key = "t" if file == TRAJECTORY else "name"
        there, expected = table.column(key), printed.column(key)
        if there != expected[: len(there)]:
            what = "times" if file == TRAJECTORY else "events"
            yield f"{name}: its {what} are not those of {file}"
        elif record.complete and len(there) != len(expected):
            yield f"{name}: {len(there)} rows, where {file} has {len(expected)}"


def _excluded(enclosures: Enclosures, file: str) -> Iterator[str]:
    """Printed entries that their enclosure excludes."""
    printed = enclosures.stored.table(file)
    several, sure = 0, surely_held(enclosures, file)
    rows = zip(printed.rows, enclosures.table(file).rows, sure.tolist(), strict=False)
    for line, (texts, stored, held) in enumerate(rows, start=2):
        if held:
            continue
        cells = enclosures.row(file, texts, stored)
        for name, text in zip(printed.columns, texts, strict=True):
            if name in LABELS or (name == "t" and file == TRAJECTORY):
                continue
            ball = cells[name] if name in cells else Outward.of(0)
            scale = enclosures.scales[name] if name != "t" else Decimal(0)
            if not _holds(text, ball, scale):
                several += 1
                if several <= FEW:
                    yield f"{file}, line {line}, {name}: excluded by its enclosure"


def _holds(text: str, ball: Outward | None, scale: Decimal) -> bool:
    """Whether what rounds to the printed text, and the enclosure, have numbers in common."""
    if not text or ball is None:
        return not text and ball is None
    if text == ZERO:
        return ball.rounds_to(text, scale.scaleb(-DIGITS))
    return ball.rounds_to(text, Decimal(5).scaleb(last_place(text, scale) - 1))


def _times(stored: Stored, record: Record, enclosures: Enclosures) -> Iterator[str]:
    """Times of the climb that are not those which the events give."""
    stated = record.content["inversion"]
    if "failure" in stated or record.content["failure"]:
        return
    found = inversion(stored, enclosures)
    moments = {"equator": (stated.get("equator"), found.equator)}
    for name in "ABC":
        for which in ("t_init", "t_end"):
            own = getattr(getattr(found, name), which)
            moments[f"{name}, {which}"] = stated.get(name, {}).get(which), own
    for name, (ball, derived) in moments.items():
        if (ball is None) != (derived is None):
            yield f"{PROOF}: {name} is {'none' if ball is None else 'there'}, not so the events say"
        elif ball is not None and not Outward.around(**ball).meets(Outward.of(derived)):
            yield f"{PROOF}: {name} is not where the events put it"


def inversion(stored: Stored, enclosures: Enclosures) -> InversionTimes:
    """The times of the climb, from the enclosed events."""
    rows: dict[str, list[dict[str, Json]]] = {}
    for row, cells in zip(stored.events.rows, enclosures.of(EVENTS), strict=True):
        rows.setdefault(row[0], []).append({**cells, "direction": int(row[2])})
    rising = [row for row in rows.get("equator", []) if row["direction"] < 0]
    if not rising:
        return from_marks(Marks([], NO_TURNS, NO_TURNS, [], [], []), pi())
    first = next(enclosures.of(TRAJECTORY))
    state = NewtonState(*(first.get(name, Outward.of(0)) for name in NewtonState._fields))
    motion = Motion(stored.scene.body.numbers(Outward.of), state, None)
    sign = -1 if QUANTITIES["lambda"].evaluate(motion) < 0 else 1

    def times(name: str) -> list[Decimal]:
        return [row["t"] for row in rows.get(name, [])]

    def turns(name: str) -> Turns:
        found = rows.get(name, [])
        return Turns(
            times(name), [row["theta"] for row in found], [sign * row["phi_dot"] for row in found]
        )

    marks = Marks(
        equator=[row["t"] for row in rising],
        minima=turns("theta_min"),
        maxima=turns("theta_max"),
        phi_dot_zero=times("phi_dot_zero"),
        aligned=times("Lk_equals_Lz"),
        opposed=times("Lk_equals_minus_Lz"),
        backwards=sign * rising[0]["phi_dot"] < 0,
    )
    return from_marks(marks, pi())


def _contact(stored: Stored, record: Record) -> Iterator[str]:
    """What is said of the contact force, against the printed states and events."""
    import numpy

    contact = record.content["contact"]
    lost = [row for row in stored.events.rows if row[0] == "contact_lost"]
    if "lost_at_s" in contact:
        if len(lost) != 1 or not Outward.around(**contact["lost_at_s"]).rounds_to(
            lost[0][1], Decimal(5).scaleb(last_place(lost[0][1], Decimal(0)) - 1)
        ):
            yield f"{PROOF}: contact is lost at another time than {EVENTS} says"
        return
    if lost:
        yield f"{PROOF}: contact is not lost, but {EVENTS} says so"
    if not contact["g_n_positive"]:
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
