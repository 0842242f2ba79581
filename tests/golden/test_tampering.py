"""Seeded damage to a scene's folder never verifies, unless the content is still the same."""

from __future__ import annotations

import random
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.golden.test_seal import reseal
from tt_precise.golden import store
from tt_precise.golden.integrity import inspect
from tt_precise.golden.runs import Run, Task, perform
from tt_precise.golden.store import EVENTS, FILES, TRAJECTORY, Stored
from tt_precise.golden.verifying import judge
from tt_precise.runtime.errors import InputError

if TYPE_CHECKING:
    from tests.golden.conftest import Small


@pytest.fixture(scope="module")
def fresh(small_built: Small) -> list[Run]:
    """The fresh computations of the small scene, in quad and in double."""
    name, text = small_built.scene.name, small_built.scene.text
    return [
        perform(Task(name, text, "quad", None, "newton")),
        perform(Task(name, text, "double", None, "newton", events=False)),
    ]


def damaged(place: Path, rng: random.Random) -> str:
    """Do one thing to the files; what it was."""
    kind = rng.choice(["byte", "byte", "byte", "delete", "cut", "digit", "digit", "resealed"])
    file = place / rng.choice(FILES)
    data = bytearray(file.read_bytes())
    if kind == "delete":
        file.unlink()
    elif kind == "cut":
        file.write_bytes(data[: rng.randrange(len(data))])
    elif kind == "byte":
        at = rng.randrange(len(data))
        data[at] ^= 1 << rng.randrange(8)
        file.write_bytes(data)
    else:
        file = place / rng.choice([TRAJECTORY, EVENTS])
        kind = changed_digit(file, rng) if kind == "digit" else rearranged(file, rng)
        try:
            reseal(place)
        except (InputError, ArithmeticError, KeyError, ValueError):
            return kind
    return f"{kind} of {file.name}"


def changed_digit(file: Path, rng: random.Random) -> str:
    """Change one of the first 26 digits of a number that is not near zero."""
    lines = file.read_text().splitlines()
    while True:
        row = rng.randrange(1, len(lines))
        cells = lines[row].split(",")
        column = rng.randrange(1 if "name" not in lines[0] else 3, len(cells))
        if len(cells[column]) > 36:
            break
    mantissa, exponent = cells[column].split("e")
    at = rng.choice([i for i, c in enumerate(mantissa[:26]) if c.isdigit() and i > 2])
    digit = str((int(mantissa[at]) + rng.randrange(1, 10)) % 10)
    cells[column] = f"{mantissa[:at]}{digit}{mantissa[at + 1 :]}e{exponent}"
    lines[row] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")
    return f"digit {at} of {lines[0].split(',')[column]}, resealed,"


def rearranged(file: Path, rng: random.Random) -> str:
    """Blank cells, or leave out, double or exchange rows, or cells of a row."""
    header, *rows = (line.split(",") for line in file.read_text().splitlines())
    first = 3 if "name" in header else 1
    at, other = rng.sample(range(len(rows)), 2)
    column, beside = rng.sample(range(first, len(header)), 2)
    kind = rng.choice(["blank", "blank column", "drop", "double", "rows", "cells"])
    if kind == "drop":
        del rows[at]
    elif kind == "double":
        rows.insert(at, rows[at])
    elif kind == "rows":
        rows[at], rows[other] = rows[other], rows[at]
    elif kind == "cells":
        rows[at][column], rows[at][beside] = rows[at][beside], rows[at][column]
    else:
        for row in [rows[at]] if kind == "blank" else rows:
            row[column] = ""
    file.write_text("\n".join(map(",".join, [header, *rows])) + "\n")
    return f"{kind} {header[column]}, row {at}, resealed,"


def same(one: Stored, other: Stored) -> bool:
    """Whether two folders say the same, comments and layout apart."""
    return (one.scene, one.trajectory, one.events, one.manifest) == (
        other.scene, other.trajectory, other.events, other.manifest,
    )  # fmt: skip


def spoil_and_verify(small: Small, fresh: list[Run], place: Path, seed: int) -> None:
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(small.folder, place)
    done = damaged(place / "reference", random.Random(seed))
    stored, problems = inspect("reference", place)
    if stored is None or problems:
        return
    verdict = judge(stored, problems, fresh).verdict
    if verdict == "pass":
        assert same(stored, store.read("reference", small.folder)), f"seed {seed}: {done}"


def test_what_is_whole_verifies(small: Small, fresh: list[Run]) -> None:
    """The control: without damage there is nothing to find."""
    stored, problems = inspect("reference", small.folder)
    assert stored is not None
    assert judge(stored, problems, fresh).verdict == "pass"


def test_damage_is_found(small: Small, fresh: list[Run], tmp_path: Path) -> None:
    for seed in range(300):
        spoil_and_verify(small, fresh, tmp_path / "spoiled", seed)


@pytest.mark.fuzz
def test_damage_is_found_long(small: Small, fresh: list[Run], tmp_path: Path) -> None:
    for seed in range(1000, 11_000):
        spoil_and_verify(small, fresh, tmp_path / "spoiled", seed)
