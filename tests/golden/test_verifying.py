"""Every damage to golden data is found and named, with and without a fresh computation."""

import json
import random
import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import Patch
from tests.golden.conftest import Small, rehash, with_table
from tests.golden.tables import edit_cell, edit_json, other_digit
from tt_precise.golden import store, verifying
from tt_precise.golden.building import derive
from tt_precise.golden.runs import GoldenRun, perform
from tt_precise.golden.store import EVENTS, FILES, MANIFEST, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import inspect, judge, verify
from tt_precise.runtime.values import InputError

Lines = list[list[str]]


@pytest.fixture(scope="module")
def fresh(small_built: Small) -> GoldenRun:
    """A fresh computation of the small scene, in quad."""
    return perform(small_built.scene, "quad")


def problems(small: Small) -> str:
    return "\n".join(inspect(small.scene.name, small.folder)[1])


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        (TRAJECTORY, lambda lines: lines.pop(4), "got a row of t = 0.04, expected t = 0.03"),
        (TRAJECTORY, lambda lines: lines.pop(), "got a row of t = nothing, expected t = 0.06"),
        (TRAJECTORY, lambda lines: lines.__delitem__(slice(1, None)), "no row, expected one"),
        (TRAJECTORY, lambda lines: lines[0].reverse(), "columns are nu_y,nu_x"),
        (EVENTS, lambda lines: lines.pop(), "changed since it was written"),
    ],
)
def test_a_changed_table_is_found_and_named(
    small: Small, file: str, change: Callable[[Lines], object], words: str
) -> None:
    lines = [line.split(",") for line in (small.path / file).read_text().splitlines()]
    change(lines)
    (small.path / file).write_text("".join(",".join(line) + "\n" for line in lines))
    assert f"{file}: {words}" in problems(small)


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("digits", 33, "manifest.json: digits is '33', the data say '34'"),
        ("files/trajectory.csv/columns/kx/digits", 30, "kx: digits is '30', the data say '34'"),
        ("files/events.csv/rows", 1, "events.csv: rows is '1'"),
        ("scene", "other", "manifest.json: scene is 'other'"),
        ("schema", "tt_precise.golden/0", "expected 'tt_precise.golden/2'"),
        ("evidence", None, "`$.evidence`"),
        ("evidence/constant_over_printed_rows/jellett", 20.0, "jellett is '20.0', the data say '3"),
    ],
)
def test_an_edited_manifest_is_found_and_named(
    small: Small, place: str, value: Any, words: str
) -> None:
    def change(manifest: dict[str, Any]) -> None:
        *path, last = place.split("/")
        for key in path:
            manifest = manifest[key]
        manifest[last] = value

    edit_json(small.path / MANIFEST, change, json.dumps)
    assert words in problems(small)


def test_another_scene_is_found_and_another_comment_is_none(small: Small) -> None:
    path = small.path / "scene.toml"
    path.write_text(path.read_text().replace('mu = "0.3"', 'mu = "0.31"'))
    assert "scene.toml: changed since it was written" in problems(small)
    path.write_text(path.read_text().replace('mu = "0.31"', 'mu = "0.3" # as it was'))
    assert problems(small) == ""


@pytest.mark.parametrize(("size", "empty"), [("9e-29", True), ("1e-28", False), ("1e-3", False)])
def test_only_a_vertical_axis_leaves_its_azimuth_open(
    small: Small, fresh: GoldenRun, size: str, empty: bool
) -> None:
    """A tilt below 28 digits may have no Euler angles; any other tilt has them."""
    edit_cell(small.path / TRAJECTORY, 4, "kx", lambda _: size)
    edit_cell(small.path / TRAJECTORY, 4, "ky", lambda _: "0")
    edit_cell(small.path / TRAJECTORY, 4, "phi_dot", lambda _: "")
    rehash(small.path)
    stored = store.read_files(small.scene.name, small.folder)
    line = f"{TRAJECTORY}, line 4, phi_dot: got nothing, a fresh computation has"
    assert (line not in "".join(judge(stored, fresh)[1])) is empty


def test_another_end_of_the_motion_is_found(small: Small, fresh: GoldenRun) -> None:
    stored = store.read_files(small.scene.name, small.folder)
    assert judge(stored, fresh)[1] == []
    for status in ("contact_lost", "pole", "failed"):
        (complaint,) = judge(stored, replace(fresh, status=status))[1]
        assert complaint == f"status: newton quad ends {status}, the manifest says complete"


def test_a_scene_that_cannot_be_computed_fails_beside_the_others(small: Small) -> None:
    shutil.copytree(small.path, small.folder / "lifted")
    path = small.folder / "lifted" / "scene.toml"
    text = path.read_text().replace('"0.1"', '"1.5"').replace('"155"', '"-1500"')
    path.write_text(text.replace('phi_dot = "0"', 'phi_dot = "-30"'))
    (small.folder / "vectors").mkdir()  # a folder of something else
    lifted, whole = verify(folder=small.folder, workers=1)
    assert "no fresh computation: lifted: g_n is -" in lifted.problems[-1]
    assert (lifted.verdict, whole.verdict) == ("fail", "pass")
    assert (whole.digits_claimed, whole.digits_found) == (34, 34)
    assert whole.fresh == "newton 160"


def test_every_digit_without_a_proof_is_confirmed(small: Small) -> None:
    """The 33rd digit is beyond the 28 that suffice beside a proof."""
    edit_cell(small.path / TRAJECTORY, 4, "theta", lambda cell: other_digit(cell, 33))
    rehash(small.path)
    verification = verifying.verify_scene(small.path)
    assert f"{TRAJECTORY}, line 4, theta: got 9." in verification.problems[0]
    assert 30 < (verification.digits_found or 0) < 34


def test_a_fresh_computation_that_is_too_coarse_takes_the_bits_of_the_data(
    small: Small, monkeypatch: Patch
) -> None:
    monkeypatch.setattr(verifying, "FRESH_DIGITS", 33)
    monkeypatch.setattr(verifying, "FINE", "quad")
    monkeypatch.setattr(verifying.proofs, "summary", lambda stored: {"digits": 34})
    verification = verifying.verify_scene(small.path)
    assert (verification.verdict, verification.fresh) == ("pass", "newton 160")


def test_data_that_ship_are_of_the_scene_that_ships(small: Small, monkeypatch: Patch) -> None:
    """Everything else may fit: those of a shorter run are others under the same name."""
    assert problems(small) == ""
    monkeypatch.setattr(store, "home", lambda: small.folder)
    assert "scene.toml: another scene than the reference that ships" in problems(small)


def test_tables_that_cannot_be_compared_do_not_pass(small: Small, fresh: GoldenRun) -> None:
    """Without ``inspect``, which finds other columns too."""
    stored = store.read_files(small.scene.name, small.folder)
    empty = {file: Table(table.columns, ()) for file, table in stored.tables.items()}
    digits, lines = judge(replace(stored, tables=empty), fresh)
    assert digits is None
    assert "newton quad: no entry could be compared, expected all of them" in lines
    *others, last = stored.trajectory.columns
    rows = [("0.01", *("" for _ in others[1:]), "1")] * len(stored.trajectory.rows)
    blank = stored.tables | {TRAJECTORY: Table(stored.trajectory.columns, tuple(rows))}
    assert f"{last}: newton quad agrees" in judge(replace(stored, tables=blank), fresh)[1][-1]
    assert judge(stored, with_table(fresh, TRAJECTORY, Table(("x",), ())))[0] is not None


def test_rows_before_an_early_end_are_at_the_times_of_samples(small: Small) -> None:
    edit_json(small.path / MANIFEST, lambda manifest: manifest.update(status="pole"), json.dumps)
    assert TRAJECTORY not in problems(small)
    edit_cell(small.path / TRAJECTORY, 7, "t", lambda _: "0.055")
    assert "got a row of t = 0.055, expected t = 0.05" in problems(small)


def damaged(place: Path, rng: random.Random) -> str:
    """Do one thing to the files; what it was."""
    kind = rng.choice(["byte", "byte", "byte", "delete", "cut", "digit", "digit", "rearranged"])
    file = place / rng.choice(FILES)
    data = bytearray(file.read_bytes())
    match kind:
        case "delete":
            file.unlink()
        case "cut":
            file.write_bytes(data[: rng.choice([0, rng.randrange(len(data))])])
        case "byte":
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
            file.write_bytes(data)
        case _:
            file = place / rng.choice([TRAJECTORY, EVENTS])
            lines = [line.split(",") for line in file.read_text().splitlines()]
            kind = (changed_digit if kind == "digit" else rearranged)(lines, rng)
            file.write_text("\n".join(map(",".join, lines)) + "\n")
            with suppress(InputError, ArithmeticError, KeyError, ValueError):
                rehash(place)
    return f"{kind} of {file.name}"


def changed_digit(lines: Lines, rng: random.Random) -> str:
    """Change one of the first 26 digits of a number that is not near zero."""
    first = 3 if "name" in lines[0] else 1
    long = [
        (r, c) for r, row in enumerate(lines) for c in range(first, len(row)) if len(row[c]) > 36
    ]
    row, column = rng.choice(long)
    cell = lines[row][column]
    at = rng.choice([i for i, c in enumerate(cell[:26]) if c.isdigit() and i > 2])
    other = (int(cell[at]) + rng.randrange(1, 10)) % 10
    lines[row][column] = f"{cell[:at]}{other}{cell[at + 1 :]}"
    return f"digit {at} of {lines[0][column]}, rehashed,"


def rearranged(lines: Lines, rng: random.Random) -> str:
    """Blank cells, or leave out, double or exchange rows, or cells of a row."""
    header, *rows = lines
    first = 3 if "name" in header else 1
    at, other = rng.sample(range(1, len(lines)), 2)
    column, beside = rng.sample(range(first, len(header)), 2)
    kind = rng.choice(["blank", "blank column", "drop", "double", "rows", "cells"])
    if kind == "drop":
        del lines[at]
    elif kind == "double":
        lines.insert(at, lines[at])
    elif kind == "rows":
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == "cells":
        row = lines[at]
        row[column], row[beside] = row[beside], row[column]
    else:
        for row in [lines[at]] if kind == "blank" else rows:
            row[column] = ""
    return f"{kind} {header[column]}, row {at}, rehashed,"


def content(stored: Stored) -> Sequence[object]:
    """Return the content of a folder without comments, layout and the evidence of a build."""
    derived = derive(stored.scene, stored.scene_text, stored.tables)
    return stored.scene, stored.tables, derived


@pytest.mark.parametrize(
    "seeds",
    [
        range(300),
        pytest.param(range(1000, 11_000), marks=pytest.mark.fuzz),
    ],
    ids=len,
)
def test_damage_is_found(small: Small, fresh: GoldenRun, tmp_path: Path, seeds: range) -> None:
    whole, place = content(store.read_files("reference", small.folder)), tmp_path / "spoiled"
    for seed in seeds:
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(small.folder, place)
        done = damaged(place / "reference", random.Random(seed))
        stored, lines = inspect("reference", place)
        if stored is not None and not lines and not judge(stored, fresh)[1]:
            assert content(stored) == whole, f"seed {seed}: {done}"
