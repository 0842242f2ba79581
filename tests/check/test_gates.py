"""Seeded corruptions of a right trajectory never pass as golden; without one it passes."""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.check import run

SCENE = "contact-lost"  # few rows
COLUMNS = ("t", "kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
DIGITS = 8
# Errors below this part of a column's largest entry may be within what is asked for.
NOTICEABLE = 1e-6

Table = dict[str, numpy.ndarray]


@pytest.fixture(scope="module")
def right() -> Table:
    golden = tt.golden.load(SCENE)
    return {name: golden[name].to_numpy() for name in COLUMNS}


@pytest.fixture(autouse=True)
def golden_data_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    # what else a check looks at must not be what saves this gate
    monkeypatch.setattr(run, "checks_of", lambda scene: ())
    monkeypatch.setattr(run, "refuse_other_units", lambda *arguments: None)


def stretch(rows: int, rng: random.Random) -> slice:
    first, last = sorted(rng.sample(range(1, rows + 1), 2))
    return slice(first, last)


def corrupted(right: Table, rng: random.Random) -> tuple[str, Table]:
    """What was done, and the table."""
    table = {name: values.copy() for name, values in right.items()}
    rows, name = len(table["t"]), rng.choice(COLUMNS[1:])
    part, other = stretch(rows, rng), rng.choice([one for one in COLUMNS[1:] if one != name])
    kind = rng.choice(list(KINDS))
    KINDS[kind](table, name, other, part, rng)
    return f"{kind} {name} {other} {part}", table


def _scale(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    table[name][part] *= rng.choice([1e-3, 1e3, 180 / numpy.pi, 1 + 1e-5])


def _set(value: float) -> Callable[..., None]:
    def change(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
        table[rng.choice([name, "t"])][part] = value

    return change


def _shift(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    table[name][part] = numpy.roll(table[name][part], rng.choice([-2, -1, 1, 2]))


def _later(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    table["t"][part] += rng.choice([1e-5, -1e-5, 0.0037, 0.01])


def _swap(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    table[name][part], table[other][part] = table[other][part].copy(), table[name][part].copy()


def _permute(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    order = list(range(part.stop - part.start))
    rng.shuffle(order)
    for each in COLUMNS[1:] if rng.random() < 0.5 else (name,):
        table[each][part] = table[each][part][order]


def _rows(keep: Callable[[numpy.ndarray, slice], numpy.ndarray]) -> Callable[..., None]:
    def change(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
        rows = keep(numpy.arange(len(table["t"])), part)
        for each in table:
            table[each] = table[each][rows]

    return change


def _noise(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    size = 10.0 ** rng.uniform(-5, 0) * abs(table[name]).max()
    table[name][part] += size * numpy.array([rng.gauss(0, 1) for _ in table[name][part]])


def _drop_column(table: Table, name: str, other: str, part: slice, rng: random.Random) -> None:
    del table[rng.choice([name, "t"])]


KINDS: dict[str, Callable[[Table, str, str, slice, random.Random], None]] = {
    "unit": _scale,
    "nan": _set(numpy.nan),
    "inf": _set(-numpy.inf),
    "zero": _set(0.0),
    "sign": lambda table, name, other, part, rng: _negate(table, name, part),
    "shift": _shift,
    "later": _later,
    "swap": _swap,
    "permute": _permute,
    "noise": _noise,
    "truncate": _rows(lambda rows, part: rows[: part.start]),
    "drop rows": _rows(lambda rows, part: numpy.delete(rows, part)),
    "duplicate": _rows(lambda rows, part: numpy.insert(rows, part.stop, rows[part])),
    "drop column": _drop_column,
}


def _negate(table: Table, name: str, part: slice) -> None:
    table[name][part] *= -1


def changed(right: Table, table: Table) -> bool:
    """Whether anything was done that eight digits must notice."""
    if table.keys() != right.keys() or len(table["t"]) < len(right["t"]) - 1:
        return True
    if numpy.array_equal(table["t"], right["t"][:-1]):
        return False  # whoever stops at the last sample before contact is lost is right
    if len(table["t"]) != len(right["t"]):
        return True
    return any(
        not numpy.isfinite(table[name]).all()
        or (abs(table[name] - right[name]) > NOTICEABLE * abs(right[name]).max()).any()
        for name in COLUMNS
    )


def passes(table: Table) -> bool:
    try:
        tt.check.assert_matches_golden(pandas.DataFrame(table), SCENE, digits=DIGITS)
    except (AssertionError, tt.InputError):
        return False
    return True


def let_through(right: Table, seeds: range) -> list[str]:
    found = []
    for seed in seeds:
        what, table = corrupted(right, random.Random(seed))
        if changed(right, table) and passes(table):
            found.append(f"seed {seed}: {what}")
    return found


def test_nothing_but_golden_data_is_looked_at(right: Table) -> None:
    findings = tt.check.conservation(pandas.DataFrame(right), SCENE)
    assert {finding.name for finding in findings.checks} == {"finite", "golden"}


def test_what_is_right_passes(right: Table) -> None:
    """The control."""
    assert passes(right)
    assert passes(
        {name: values * (1 + 1e-12) for name, values in right.items()} | {"t": right["t"]}
    )


def test_corruptions_do_not_pass(right: Table) -> None:
    assert let_through(right, range(300)) == []


@pytest.mark.fuzz
def test_corruptions_do_not_pass_long(right: Table) -> None:
    assert let_through(right, range(1000, 11_000)) == []
