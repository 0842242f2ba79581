"""Every damage to golden data is found and named, with and without a fresh computation."""

import json
import math
import random
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

from tests.conftest import Patch
from tests.golden.conftest import Small, rehash, shortened
from tests.golden.tables import edit_cell, edit_json, other_digit
from tt_precise.golden import build, store, verifying
from tt_precise.golden.building import CONSTANT_TO, Constancy, derive
from tt_precise.golden.runs import GoldenRun, Task, perform
from tt_precise.golden.store import EVENTS, FILES, MANIFEST, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import (
    FRESH_DIGITS,
    bits_needed,
    cell_errors,
    column_sizes,
    inspect,
    judge,
    verify,
)
from tt_precise.integration.precision import precision_named
from tt_precise.runtime.values import InputError
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import load_scene, parse_scene


@pytest.fixture(scope="module")
def fresh(small_built: Small) -> GoldenRun:
    """A fresh computation of the small scene, in quad."""
    return perform(Task(small_built.scene.name, small_built.scene.text, "quad", None, "newton"))


def path_of(small: Small, file: str) -> Path:
    return small.folder / small.scene.name / file


Lines = list[list[str]]


def edit_table(small: Small, file: str, change: Callable[[Lines], object]) -> None:
    lines = [line.split(",") for line in path_of(small, file).read_text().splitlines()]
    change(lines)
    path_of(small, file).write_text("".join(",".join(line) + "\n" for line in lines))


def edit_manifest(small: Small, change: Callable[[dict[str, Any]], None]) -> None:
    edit_json(path_of(small, MANIFEST), change, json.dumps)


def swapped(lines: Lines) -> None:
    for line in lines:
        line[7], line[8] = line[8], line[7]


def last_digit(lines: Lines) -> None:
    lines[1][4] = other_digit(lines[1][4], 34)


def problems(small: Small) -> str:
    return "\n".join(inspect(small.scene.name, small.folder)[1])


def judged(small: Small, fresh: GoldenRun) -> str:
    """Return the problems that are found though the hashes fit."""
    rehash(small.folder / small.scene.name)
    stored, found = inspect(small.scene.name, small.folder)
    assert stored is not None
    return "\n".join(judge(stored, found, fresh).problems)


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        (TRAJECTORY, lambda lines: lines.pop(4), "the row of t = 0.03 is missing"),
        (TRAJECTORY, lambda lines: lines.pop(), "ends at t = 0.05, before the horizon"),
        (TRAJECTORY, lambda lines: lines.__delitem__(slice(1, None)), "no row, expected one"),
        (TRAJECTORY, swapped, "columns are t,kx,ky,kz,Lx,Ly,Lz,vy,vx"),
        (TRAJECTORY, last_digit, "changed since it was written"),
        (EVENTS, last_digit, "changed since it was written"),
    ],
)
def test_a_changed_table_is_found_and_named(
    small: Small, file: str, change: Callable[[Lines], object], words: str
) -> None:
    edit_table(small, file, change)
    assert f"{file}: {words}" in problems(small)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m.update(digits=33), "manifest.json: digits is '33', the data say '34'"),
        (
            lambda m: m["files"][TRAJECTORY]["columns"]["kx"].update(digits=30),
            "columns: kx: digits is '30', the data say '34'",
        ),
        (lambda m: m["files"][EVENTS].update(rows=1), "events.csv: rows is '1'"),
        (lambda m: m.update(scene="other"), "manifest.json: scene is 'other'"),
        (lambda m: m.update(title="Another"), "title is 'Another', expected 'Reference"),
        (lambda m: m.update(schema="tt_precise.golden/0"), "got schema 'tt_precise.golden/0'"),
        (lambda m: m.pop("evidence"), "missing required field `evidence`"),
        (lambda m: m["files"].update({"scene.toml": {}}), "missing required field `sha256`"),
    ],
)
def test_an_edited_manifest_is_found_and_named(
    small: Small, change: Callable[[dict[str, Any]], None], words: str
) -> None:
    edit_manifest(small, change)
    assert words in problems(small)


def test_another_scene_text_is_found(small: Small) -> None:
    path = path_of(small, "scene.toml")
    path.write_text(path.read_text().replace('mu = "0.3"', 'mu = "0.31"'))
    assert "scene.toml: changed since it was written" in problems(small)
    path.write_text(path.read_text().replace('mu = "0.31"', 'mu = "0.3" # as it was'))
    assert problems(small) == ""
    path_of(small, MANIFEST).unlink()
    with pytest.raises(InputError, match="golden data"):
        store.read_files(small.scene.name, small.folder)


def wrong(cell: str) -> str:
    return other_digit(cell, FRESH_DIGITS - 1)


@pytest.mark.parametrize(
    ("file", "line", "column", "change", "words"),
    [
        *((TRAJECTORY, 5, name, wrong, "newton quad agrees to") for name in ("kx", "Lz", "theta")),
        (TRAJECTORY, 5, "omega_3", wrong, "newton quad agrees to"),
        (EVENTS, 2, "t", wrong, "newton quad agrees to"),
        (EVENTS, 2, "name", lambda _: "equator", "got equator, a fresh computation has"),
        # Euler columns are empty at a pole, vectors nowhere
        (TRAJECTORY, 4, "theta_dot", lambda _: "", "is empty, a fresh computation has a number"),
        (TRAJECTORY, 4, "kx", lambda _: "", "got '', expected a printed number"),
    ],
)
def test_a_wrong_cell_under_right_hashes_is_found(
    small: Small,
    fresh: GoldenRun,
    file: str,
    line: int,
    column: str,
    change: Callable[[str], str],
    words: str,
) -> None:
    edit_cell(path_of(small, file), line, column, change)
    assert f"{file}, line {line}, {column}: {words}" in judged(small, fresh)


def test_a_missing_event_under_right_hashes_is_found(small: Small, fresh: GoldenRun) -> None:
    edit_table(small, EVENTS, lambda lines: lines.pop())
    assert "events.csv: " in judged(small, fresh)


def test_rows_that_break_jellett_are_found_without_a_computation(small: Small) -> None:
    edit_cell(path_of(small, TRAJECTORY), 4, "Lz", lambda cell: other_digit(cell, 31))
    rehash(small.folder / small.scene.name)
    assert "trajectory.csv: jellett is constant to" in problems(small)
    assert "worst in line 4" in problems(small)


@pytest.mark.parametrize(
    ("phi_dot", "omega_3", "digits"), [("0", "155", 0), ("5", "17", 1), ("4", "17", 2)]
)
def test_digits_that_cancel_in_lambda_are_those_of_its_terms(
    phi_dot: str, omega_3: str, digits: int
) -> None:
    """By hand: I1 phi_dot sin^2 is 1.490 for 4 rad/s, I3 omega_3 (alpha - cos) 1.559 for 17."""
    scene = load_scene("reference").varied(theta="1.5", phi_dot=phi_dot, omega_3=omega_3)
    start = InitialState.in_si(scene, precision_named("double").arithmetic).vectors
    rows = Table.of_columns({name: [str(x)] for name, x in start._asdict().items()})
    stored: Any = SimpleNamespace(trajectory=rows, scene=scene)
    assert verifying._cancelled(stored) == digits


def test_a_small_lambda_may_lack_the_digits_that_cancel(small: Small, monkeypatch: Patch) -> None:
    short = [Constancy(name, CONSTANT_TO - 2, 0) for name in ("jellett", "energy")]
    monkeypatch.setattr(verifying, "constancies", lambda *_: short)
    monkeypatch.setattr(verifying, "_cancelled", lambda _: 2)
    found = problems(small)
    assert "energy is constant to" in found
    assert "jellett" not in found


@pytest.mark.evidence
def test_a_small_lambda_is_constant_to_fewer_digits(tmp_path: Path) -> None:
    text = shortened("reference", "0.02").text
    text = text.replace('theta = "0.1"', 'theta = "1.5"').replace('"155"', '"17"')
    scene = parse_scene(text.replace('phi_dot = "0"', 'phi_dot = "4"'), "level", "level.toml")
    build([scene], folder=tmp_path, workers=1)
    assert inspect("level", tmp_path)[1] == []


@pytest.mark.parametrize(
    ("digits", "bits", "needed"),
    [(28.0, 113, 113), (30.0, 113, 107), (24.0, 113, 127), (8.1, 53, 120), (5.0, 113, None)],
)
def test_a_sensitive_scene_gets_the_bits_it_needs(
    digits: float, bits: int, needed: int | None
) -> None:
    """None beyond those of the data."""
    assert bits_needed(digits, bits) == needed


def test_data_of_another_start_are_no_matter_of_bits(small: Small) -> None:
    other = small.scene.text.replace('omega_3 = "155"', 'omega_3 = "155.0001"')
    fresh = perform(Task(small.scene.name, other, "quad", None, "newton"))
    stored, _ = inspect(small.scene.name, small.folder)
    assert stored is not None
    found: Any = judge(stored, [], fresh)
    assert found.verdict == "fail"
    assert found.digits_found < 9
    assert bits_needed(found.digits_found, fresh.bits) is None


def test_a_scene_that_cannot_be_computed_fails_beside_the_others(small: Small) -> None:
    shutil.copytree(small.folder / "reference", small.folder / "lifted")
    path = small.folder / "lifted" / "scene.toml"
    path.write_text(path.read_text().replace('"0.1"', '"1.5"').replace('"155"', '"-1500"'))
    path.write_text(path.read_text().replace('phi_dot = "0"', 'phi_dot = "-30"'))
    lifted, whole = verify(folder=small.folder, workers=1)
    assert "no fresh computation: lifted: g_n is -" in lifted.problems[-1]
    assert "scene.toml: changed since it was written" in "".join(lifted.problems)
    assert (lifted.verdict, whole.verdict) == ("fail", "pass")


def test_a_table_without_rows_is_no_table(small: Small) -> None:
    """Whatever the hashes say, and how the motion ended."""
    edit_table(small, TRAJECTORY, lambda lines: lines.__delitem__(slice(1, None)))
    edit_manifest(small, lambda m: m.update(status="contact_lost"))
    assert "trajectory.csv: no row" in problems(small)
    with pytest.raises(InputError, match="no row"):
        store.read_whole("reference", small.folder)


def test_verify_computes_in_worker_processes(small: Small) -> None:
    found: Any = verify(folder=small.folder, workers=1)[0]
    assert (found.verdict, found.digits_claimed) == ("pass", 34)
    # all that are printed, as there is no proof of them
    assert found.digits_found == 34 > FRESH_DIGITS
    assert found.fresh == "newton 160"


def test_every_digit_of_what_is_not_proved_is_confirmed(small: Small) -> None:
    """The 33rd digit is beyond the 28 that suffice beside a proof."""
    edit_cell(path_of(small, TRAJECTORY), 4, "theta", _other_33rd)
    rehash(small.folder / small.scene.name)
    found: Any = verify(folder=small.folder, workers=1)[0]
    assert found.verdict == "fail"
    assert f"{TRAJECTORY}, line 4, theta, newton 160 rounds otherwise" in found.problems
    assert found.digits_found > 30


def _other_33rd(cell: str) -> str:
    return other_digit(cell, 33)


def test_what_quad_is_too_coarse_for_takes_more_bits(small: Small, monkeypatch: Patch) -> None:
    monkeypatch.setattr(verifying, "FRESH_DIGITS", 32.5)
    monkeypatch.setattr(verifying, "FINE", "quad")
    found: Any = verifying.recompute(store.read_files("reference", small.folder), [], True)
    assert found.verdict == "pass"
    assert found.digits_found >= 32.5
    assert found.fresh.startswith("newton 1")


def test_all_that_is_there_are_the_scenes_and_not_the_test_vectors(tmp_path: Path) -> None:
    for name in ("mine", "vectors", ".hidden"):
        (tmp_path / name).mkdir()
    # a folder without data is looked at, and fails
    assert [one.name for one in verifying.scenes_to_verify(None, tmp_path)] == ["mine"]
    shipped = {one.name for one in verifying.scenes_to_verify(None, None)}
    assert shipped & {"reference", "vectors"} == {"reference"}


def test_a_missing_row_is_found_where_contact_is_lost(tmp_path: Path) -> None:
    """Whose last row lies between two samples."""
    shutil.copytree(store.home() / "contact-lost", tmp_path / "contact-lost")
    path = tmp_path / "contact-lost" / TRAJECTORY
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:6] + lines[7:]))
    first = inspect("contact-lost", tmp_path)[1][0]
    assert first.startswith(f"{TRAJECTORY}: the row of t = {lines[6].partition(',')[0]} is missing")


def test_data_that_ship_are_of_the_scene_that_ships(small: Small, monkeypatch: Patch) -> None:
    """Everything else may fit: those of a shorter run are others under the same name."""
    assert problems(small) == ""
    monkeypatch.setattr(store, "home", lambda: small.folder)
    assert "scene.toml: another scene than the reference that ships" in problems(small)


def test_what_cannot_be_compared_does_not_pass(small: Small, fresh: GoldenRun) -> None:
    """Without ``inspect``, which finds other columns too."""
    stored, _ = inspect(small.scene.name, small.folder)
    assert stored is not None
    assert judge(stored, [], fresh).verdict == "pass"

    def renamed(table: Table) -> Table:
        return Table(tuple(f"{n}_" if n == "theta" else n for n in table.columns), table.rows)

    def without_rows(table: Table) -> Table:
        return Table(table.columns, ())

    columns = " has other columns than a fresh computation: theta, theta_"
    for change, said in (
        (renamed, [f"{file}:{columns}" for file in (TRAJECTORY, EVENTS)]),
        (without_rows, ["newton quad: no entry could be compared, expected all of them"]),
    ):
        other = replace(stored, trajectory=change(stored.trajectory), events=change(stored.events))
        found = judge(other, [], fresh)
        assert (found.digits_found, found.verdict) == (None, "fail")
        assert set(said) <= set(found.problems)


@pytest.mark.parametrize(
    ("cells", "fresh", "size", "errors"),
    [
        (["1", "2e-3", "-4"], ["1", "2e-3", "-4"], 4, [0, 0, 0]),
        (["0", "0"], ["1e-40", "-2e-40"], 2, [5e-41, 1e-40]),
        (["1", "", "3"], ["1.5", "2", "3.1"], 2, [0.25, 0, 0.05]),  # an undefined entry
        (["1", "2", "3"], ["1", "", "3"], 3, [0, math.inf, 0]),  # what is missing is far away
        (["1", "2", "3"], ["1.25", "nan"], 1, [0.25, math.inf]),  # fewer rows
    ],
)
def test_an_error_is_relative_to_a_size(
    cells: list[str], fresh: list[str], size: float, errors: list[float]
) -> None:
    found = cell_errors(cells, fresh, numpy.full(len(cells), size))
    assert found.tolist() == pytest.approx(errors, rel=1e-12)


def test_sizes_are_those_of_the_one_rule() -> None:
    stored = store.read_files("upright")
    found = column_sizes(stored, stored.trajectory)
    assert set(found) == set(stored.trajectory.columns)
    assert set(found["kx"]) == {1.0}
    body = stored.scene.body
    least = float(body.I1) * float(body.m * body.R**2) * math.sqrt(float(body.g / body.R))
    assert min(found["Lx"]) >= least * 0.99 or min(found["Lx"]) > 0


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


def said(stored: Stored) -> tuple[object, ...]:
    """Return the content of a folder without comments, layout and the evidence of a build."""
    derived = derive(stored.scene, stored.trajectory, stored.events)
    return stored.scene, stored.trajectory, stored.events, derived


@pytest.mark.parametrize(
    "seeds",
    [
        range(100),
        pytest.param(range(100, 300), marks=pytest.mark.slow),
        pytest.param(range(1000, 11_000), marks=pytest.mark.fuzz),
    ],
    ids=len,
)
def test_damage_is_found(small: Small, fresh: GoldenRun, tmp_path: Path, seeds: range) -> None:
    whole, place = said(store.read_files("reference", small.folder)), tmp_path / "spoiled"
    for seed in seeds:
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(small.folder, place)
        done = damaged(place / "reference", random.Random(seed))
        stored, problems = inspect("reference", place)
        if not problems:
            assert stored is not None
            if judge(stored, [], fresh).verdict == "pass":
                assert said(stored) == whole, f"seed {seed}: {done}"
