"""Rows that surely meet their enclosures, against intervals; and no damage is among them."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import numpy
import pytest

from tt_precise.golden import proof_checks, proofs, store
from tt_precise.golden.enclosures import LABELS, Enclosures
from tt_precise.golden.held import surely_held
from tt_precise.golden.proof_checks import _excluded, _holds
from tt_precise.golden.store import EVENTS, TRAJECTORY
from tt_precise.golden.table import Table

SCENES = ["coulomb-gliding", "rocking", "contact-lost", "rolling"]
ROWS = 24


def enclosures_of(scene: str) -> Enclosures:
    """Those of the first rows of a scene, and of its last ones."""
    stored = store.read(scene)
    record = proofs.read(scene)
    assert record is not None

    def few(table: Table) -> Table:
        return Table(table.columns, (*table.rows[:ROWS], *table.rows[-2:]))

    short = replace(stored, trajectory=few(stored.trajectory), events=few(stored.events))
    return Enclosures(short, few(record.enclosure), few(record.events))


def with_cell(table: Table, row: int, place: int, cell: str) -> Table:
    """The table with another text in one cell."""
    rows = [list(cells) for cells in table.rows]
    rows[row][place] = cell
    return Table(table.columns, tuple(map(tuple, rows)))


def with_printed(enclosures: Enclosures, file: str, table: Table) -> Enclosures:
    """The same beside another golden table."""
    stored = enclosures.stored
    trajectory, events = (
        (table, stored.events) if file == TRAJECTORY else (stored.trajectory, table)
    )
    spoiled = replace(stored, trajectory=trajectory, events=events)
    return replace(enclosures, stored=spoiled)


def in_intervals(enclosures: Enclosures, file: str) -> list[str]:
    """What intervals alone say."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            proof_checks,
            "surely_held",
            lambda enclosures, file: numpy.zeros(len(enclosures.table(file).rows), bool),
        )
        return said(enclosures, file)


def said(enclosures: Enclosures, file: str) -> list[str]:
    try:
        return list(_excluded(enclosures, file))
    except (ArithmeticError, ValueError, KeyError, TypeError, IndexError) as error:
        return [type(error).__name__]


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
@pytest.mark.parametrize("scene", SCENES)
def test_intervals_hold_them_too(scene: str, file: str) -> None:
    enclosures = enclosures_of(scene)
    printed, sure = enclosures.stored.table(file), surely_held(enclosures, file)
    for texts, cells, held in zip(printed.rows, enclosures.of(file), sure, strict=True):
        for name, text in zip(printed.columns, texts, strict=True):
            if not held or name in LABELS or (name == "t" and file == TRAJECTORY):
                continue
            ball: Any = cells.get(name, proof_checks.Outward.of(0))
            assert _holds(text, ball, enclosures.scales[name])
    assert sure.mean() > 0.4  # or nothing is saved


@pytest.mark.parametrize("scene", SCENES)
def test_seeded_damage_is_what_intervals_say_it_is(scene: str) -> None:
    rng, whole = random.Random(scene), enclosures_of(scene)
    excluded = 0
    for _ in range(50):
        file = rng.choice([TRAJECTORY, EVENTS])
        printed, stored = whole.stored.table(file), whole.table(file)
        row = rng.randrange(len(printed.rows))
        if rng.random() < 0.7:
            place = rng.randrange(3 if file == EVENTS else 1, len(printed.columns))
            cell = damaged(printed.rows[row][place], rng)
            spoiled = with_printed(whole, file, with_cell(printed, row, place, cell))
        else:
            place = rng.randrange(1, len(stored.columns))
            cell = damaged(stored.rows[row][place], rng)
            table = with_cell(stored, row, place, cell)
            rows, events = (table, whole.events) if file == TRAJECTORY else (whole.rows, table)
            spoiled = replace(whole, rows=rows, events=events)
        expected = in_intervals(spoiled, file)
        assert said(spoiled, file) == expected, (file, row, place, cell)
        excluded += bool(expected)
    assert excluded >= 25  # damage, and no trifles


def damaged(cell: str, rng: random.Random) -> str:
    """The text with another sign, another digit, or one digit less, or no number."""
    kind = rng.choice(["last", "last", "any", "sign", "cut", "empty", "word", "zero"])
    mantissa, mark, exponent = cell.partition("e")
    if kind == "empty":
        return ""
    if kind == "word":
        return "nan"
    if kind == "zero":
        return "0"
    if kind == "sign":
        return cell[1:] if cell.startswith("-") else f"-{cell}"
    if kind == "cut":
        return mantissa[:-1] + mark + exponent
    places = [at for at, sign in enumerate(mantissa) if sign.isdigit()]
    if not places:
        return "1"
    at = places[-1] if kind == "last" else rng.choice(places)
    digit = str((int(mantissa[at]) + rng.choice([1, 9])) % 10)
    return mantissa[:at] + digit + mantissa[at + 1 :] + mark + exponent


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_unit_in_the_last_place_of_a_derived_column_is_not_held(file: str) -> None:
    whole = enclosures_of("contact-lost")
    printed = whole.stored.table(file)
    sure = surely_held(whole, file)
    row = int(numpy.flatnonzero(sure)[10])
    for name in ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"):
        place = printed.columns.index(name)
        mantissa, mark, exponent = printed.rows[row][place].partition("e")
        cell = mantissa[:-1] + str((int(mantissa[-1]) + 5) % 10) + mark + exponent
        spoiled = with_printed(whole, file, with_cell(printed, row, place, cell))
        assert not surely_held(spoiled, file)[row]
        assert said(spoiled, file) == [f"{file}, line {row + 2}, {name}: excluded by its enclosure"]


def test_an_axis_of_another_length_is_left_to_intervals() -> None:
    # every enclosure fits what is printed, but no angle belongs to such an axis
    whole = enclosures_of("contact-lost")
    longer = whole.stored.trajectory
    for name in ("kx", "ky", "kz"):
        place = longer.columns.index(name)
        for row in range(len(longer.rows)):
            cell = longer.rows[row][place]
            if cell != "0":
                mantissa, mark, exponent = cell.partition("e")
                first = mantissa.lstrip("-")[0]
                mantissa = mantissa.replace(first, str(int(first) % 9 + 1), 1)
                longer = with_cell(longer, row, place, mantissa + mark + exponent)
    spoiled = with_printed(whole, TRAJECTORY, longer)
    assert not surely_held(spoiled, TRAJECTORY).any()
    assert said(spoiled, TRAJECTORY) == in_intervals(spoiled, TRAJECTORY) != []
