"""Seeded corruptions of a right trajectory never pass a gate; without one it passes."""

import random
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.check.checks import DEFAULT_LIMITS
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState

# Hundreds of wrong files: what explains them is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

DIGITS = 8
NOTICEABLE = 1e-6  # Relative error that eight digits must notice.
TRACK = ("phi", "psi", "x", "y")
RADIUS = float(tt.load_scene("track").body.R)  # m

Table = dict[str, numpy.ndarray]


class Right(NamedTuple):
    """A right trajectory: its scene, the time (s) up to which it is, and its columns."""

    scene: str
    until: float | None
    table: Table
    sizes: Table


TABLES = {
    "vectors": ("contact-lost", NewtonState._fields, None),
    "off the golden times": ("contact-lost", NewtonState._fields, None),
    "track": ("track", (*EulerState._fields, *TRACK), 1.0),
}


@cache
def right(which: str) -> Right:
    scene, kept, until = TABLES[which]
    golden = pandas.DataFrame(tt.golden.load(scene))
    if which.startswith("off"):
        times = [0.0, *(0.0043 + 0.01 * i for i in range(134))]
        golden = tt.integrate(scene, digits=12).frame(times=times, numbers="float")
    rows = golden["t"].to_numpy() <= (until or 9)
    every = {name: golden[name].to_numpy(dtype=float)[rows] for name in golden}
    known = [*NewtonState._fields, *EulerState._fields, *(n for n in TRACK if n in every)]
    body = tt.load_scene(scene).body.numbers(float)
    beside = sizes(body, {name: every[name] for name in known}, numpy)
    return Right(scene, until, {n: every[n] for n in ("t", *kept)}, {n: beside[n] for n in kept})


def corrupt(
    kind: str, table: Table, name: str, other: str, part: slice, rng: random.Random
) -> None:
    """One thing done to the column ``name`` or to the time, mostly in a part of the rows."""
    column, rows = table[name], numpy.arange(len(table["t"]))
    match kind:
        case "unit":
            column[part] *= rng.choice([1e-3, 1e3, 180 / numpy.pi, 1 + 1e-4])
        case "nan" | "-inf" | "0":
            table[rng.choice([name, "t"])][part] = float(kind)
        case "sign":
            column[part] *= -1
        case "shift":
            column[part] = numpy.roll(column[part], rng.choice([-2, -1, 1, 2]))
        case "later":
            table["t"][part] += rng.choice([1e-5, -1e-5, 0.0037, 0.01])
        case "swap":
            column[part], table[other][part] = table[other][part].copy(), column[part].copy()
        case "permute":
            order = list(range(part.stop - part.start))
            rng.shuffle(order)
            for each in list(table)[1:] if rng.random() < 0.5 else (name,):
                table[each][part] = table[each][part][order]
        case "noise":
            size = 10.0 ** rng.uniform(-5, 0) * abs(column).max()
            column[part] += size * numpy.array([rng.gauss(0, 1) for _ in column[part]])
        case "one cell":
            row = rng.randrange(len(rows))
            column[row] += 10.0 ** rng.uniform(-5, 0) * (abs(column).max() or 1.0)
        case "beyond":
            for each in table:
                table[each] = numpy.append(table[each], table[each][-1])
            table["t"][-1] += 0.01
            table[name][-1] = 5.0
        case "drop column":
            del table["t"]
        case _:
            kept = {
                "truncate": rows[: part.start],
                "drop rows": numpy.delete(rows, part),
                "duplicate": numpy.insert(rows, part.stop, rows[part]),
            }[kind]
            for each in table:
                table[each] = table[each][kept]


# what is left of the rows is right: ``compare`` and the conservation laws see the rows there are
ROWS = ("truncate", "drop rows", "duplicate")
KINDS = (
    "unit", "nan", "-inf", "0", "sign", "shift", "later", "swap", "permute", "noise", "one cell",
    "beyond", "drop column", *ROWS,
)  # fmt: skip


def compares(given: Right, table: Table) -> None:
    found = tt.golden.compare(pandas.DataFrame(table), given.scene)
    assert found.worst >= DIGITS
    assert not found.unmatched


def asserts(check: Callable[..., object], **words: Any) -> Callable[[Right, Table], object]:
    return lambda given, table: check(
        pandas.DataFrame(table), given.scene, digits=DIGITS, until=given.until, **words
    )


def is_green(given: Right, table: Table) -> None:
    """By the law of green alone: no digits are asked for.

    Rows this far apart show another law's force to a thousandth of a column or of a step only.
    """
    before = given.table
    small = table is not before and table.keys() == before.keys()
    small = small and len(table["t"]) == len(before["t"])
    step = numpy.diff(before["t"]).max()
    small = small and bool((abs(table["t"] - before["t"]) <= 1.001e-3 * step).all())
    small = small and all(
        (abs(table[name] - before[name]) <= 1e-3 * size).all() for name, size in given.sizes.items()
    )
    laws = ("scene",) if small else ("scene", "other")
    for friction in laws:
        found = tt.check.conservation(
            pandas.DataFrame(table), given.scene, until=given.until, friction=friction
        )
        if found.passed:
            return
    raise AssertionError(found.heading)


GATES: dict[str, Callable[[Right, Table], object]] = {
    "matches": asserts(tt.check.assert_matches_golden),
    "conserves": asserts(tt.check.assert_conserves),
    "green": is_green,
    "compare": compares,
}


def corrupted(given: Right, rng: random.Random) -> tuple[str, str, Table]:
    """The kind of what was done, its particulars, and the table."""
    table = {name: values.copy() for name, values in given.table.items()}
    name, other = rng.sample([name for name in table if name != "t"], 2)
    part = slice(*sorted(rng.sample(range(len(table["t"]) + 1), 2)))
    kind = rng.choice(KINDS)
    corrupt(kind, table, name, other, part, rng)
    return kind, f"{kind} {name} {other} {part}", table


def changed(given: Right, table: Table) -> bool:
    """Test that the table was changed by more than eight digits can miss."""
    before = given.table
    if table.keys() != before.keys():
        return True
    if given.until is not None:
        keep = ~(table["t"] > given.until)
        table = {name: values[keep] for name, values in table.items()}
    if numpy.array_equal(table["t"], before["t"][:-1]) or len(table["t"]) != len(before["t"]):
        # whoever stops at the last sample before contact is lost is right
        return len(table["t"]) != len(before["t"]) - 1 or given.scene != "contact-lost"
    return not numpy.array_equal(table["t"], before["t"]) or any(
        not (abs(table[name] - before[name]) <= NOTICEABLE * size).all()
        for name, size in given.sizes.items()
    )


def within_limits(given: Right, table: Table) -> bool:
    """Test that only positions changed, by a tenth of what ``kinematics`` allows: 1e-2 R."""
    before, allowed = given.table, 0.1 * DEFAULT_LIMITS["kinematics"] * RADIUS
    return table.keys() == before.keys() and all(
        len(values) == len(before[name])
        and (abs(values - before[name]) <= (allowed if name in ("x", "y") else 0.0)).all()
        for name, values in table.items()
    )


def passes(gate: str, given: Right, table: Table) -> bool:
    try:
        GATES[gate](given, table)
    except (AssertionError, tt.InputError):
        return False
    return True


def let_through(seeds: range) -> list[str]:
    found = []
    for seed in seeds:
        rng = random.Random(seed)
        gate = rng.choice(list(GATES))
        given = right(rng.choice(list(TABLES)))
        kind, what, table = corrupted(given, rng)
        if gate in ("compare", "green") and kind in ROWS:
            continue
        if gate == "green" and within_limits(given, table):
            continue
        if changed(given, table) and passes(gate, given, table):
            found.append(f"seed {seed}: {gate} {given.scene}: {what}")
    return found


@pytest.mark.parametrize("which", TABLES)
@pytest.mark.parametrize("gate", GATES)
def test_what_is_right_passes(gate: str, which: str) -> None:
    """The control."""
    given = right(which)
    GATES[gate](given, given.table)
    shaken = {n: v + 1e-12 * given.sizes[n] for n, v in given.table.items() if n != "t"}
    if gate not in ("conserves", "green"):  # the last row has lost contact, to the last digit
        GATES[gate](given, {"t": given.table["t"], **shaken})


@pytest.mark.parametrize(
    "seeds",
    [
        range(15, 30),
        *map(more, (range(15), range(30, 120))),  # every kind, gate and table
        pytest.param(range(1000, 3000), marks=pytest.mark.slow),
        pytest.param(range(10_000, 20_000), marks=pytest.mark.fuzz),
    ],
    ids=lambda seeds: f"{len(seeds)} from {seeds[0]}",
)
def test_corruptions_do_not_pass(seeds: range) -> None:
    assert let_through(seeds) == []
