"""Every damage to golden data is found and named, with and without a fresh computation."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tt_precise.golden import integrity, store, verifying
from tt_precise.golden import manifest as manifests
from tt_precise.golden.integrity import inspect
from tt_precise.golden.runs import Run, Task, perform
from tt_precise.golden.store import EVENTS, FILES, MANIFEST, TRAJECTORY
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import FRESH_DIGITS, bits_needed, judge, verify
from tt_precise.runtime.errors import InputError

if TYPE_CHECKING:
    from tests.golden.conftest import Small


@pytest.fixture(scope="module")
def fresh(small_built: Small) -> list[Run]:
    """The fresh computations of the small scene, in quad and in double."""
    name, text = small_built.scene.name, small_built.scene.text
    return [perform(Task(name, text, kind, None, "newton")) for kind in ("quad", "double")]


def path_of(small: Small, file: str) -> Path:
    return small.folder / small.scene.name / file


def edit_table(small: Small, file: str, change: Callable[[list[list[str]]], object]) -> None:
    lines = [line.split(",") for line in path_of(small, file).read_text().splitlines()]
    change(lines)
    path_of(small, file).write_text("".join(",".join(line) + "\n" for line in lines))


def edit_manifest(small: Small, change: Callable[[dict[str, Any]], None], seal: bool) -> None:
    manifest = json.loads(path_of(small, MANIFEST).read_text())
    change(manifest)
    if seal:
        path_of(small, MANIFEST).write_text(manifests.dump(manifest))
    else:
        path_of(small, MANIFEST).write_text(json.dumps(manifest))


def with_digit_flipped(cell: str, place: int) -> str:
    """A printed number with another digit at ``place``, counted from 1."""
    index = cell.index(".") + place - 1
    assert cell[index].isdigit()
    return cell[:index] + str((int(cell[index]) + 5) % 10) + cell[index + 1 :]


def problems(small: Small) -> str:
    return "\n".join(inspect(small.scene.name, small.folder)[1])


def reseal(small: Small) -> None:
    """Make the manifest say what the spoiled tables say, all hashes included."""
    stored = store.read(small.scene.name, small.folder)
    derived = manifests.derive(stored.scene, stored.trajectory, stored.events)

    def change(manifest: dict[str, Any]) -> None:
        for file in (TRAJECTORY, EVENTS):
            for name, column in derived["files"][file]["columns"].items():
                manifest["files"][file]["columns"][name] |= column
            rest = {k: v for k, v in derived["files"][file].items() if k != "columns"}
            manifest["files"][file] |= rest
            manifest["row_marks"][file] = stored.table(file).row_marks
        manifest |= {key: derived[key] for key in ("t_end", "digits")}

    edit_manifest(small, change, seal=True)


def judged(small: Small, fresh: list[Run]) -> str:
    stored, found = inspect(small.scene.name, small.folder)
    assert stored is not None
    return "\n".join(judge(stored, found, fresh).problems)


def test_good_data_have_no_problems(small: Small) -> None:
    assert problems(small) == ""


def test_a_digit_in_the_30th_place_is_found_and_named(small: Small) -> None:
    def change(lines: list[list[str]]) -> None:
        column = lines[0].index("Lx")
        lines[4][column] = with_digit_flipped(lines[4][column], 30)

    edit_table(small, TRAJECTORY, change)
    assert "trajectory.csv: changed since it was built: line 5, column Lx" in problems(small)


def test_a_digit_of_an_event_is_found_and_named(small: Small) -> None:
    def change(lines: list[list[str]]) -> None:
        column = lines[0].index("t")
        lines[1][column] = with_digit_flipped(lines[1][column], 34)

    edit_table(small, EVENTS, change)
    assert "events.csv: changed since it was built: line 2, column t" in problems(small)


def test_a_missing_row_is_found_and_named(small: Small) -> None:
    edit_table(small, TRAJECTORY, lambda lines: lines.pop(4))
    found = problems(small)
    assert "the row of t = 0.03 is missing" in found
    assert "6 rows, expected 7; the first change at line 5" in found


def test_a_missing_last_row_is_found_and_named(small: Small) -> None:
    edit_table(small, TRAJECTORY, lambda lines: lines.pop())
    assert "ends at t = 0.05, before the horizon" in problems(small)


def test_a_missing_event_is_found(small: Small) -> None:
    edit_table(small, EVENTS, lambda lines: lines.pop(2))
    assert "events.csv" in problems(small)
    assert "the first change at line 3" in problems(small)


def swap(lines: list[list[str]], a: str, b: str) -> None:
    i, j = lines[0].index(a), lines[0].index(b)
    for line in lines:
        line[i], line[j] = line[j], line[i]


def test_swapped_columns_are_found_and_named(small: Small) -> None:
    edit_table(small, TRAJECTORY, lambda lines: swap(lines, "vx", "nu_x"))
    assert "trajectory.csv: columns are t,kx,ky,kz,Lx,Ly,Lz,nu_x" in problems(small)


def test_swapped_columns_under_their_old_names_are_found_and_named(small: Small) -> None:
    def change(lines: list[list[str]]) -> None:
        header = list(lines[0])
        swap(lines, "kx", "kz")
        lines[0] = header

    edit_table(small, TRAJECTORY, change)
    assert "trajectory.csv: columns kx and kz are swapped" in problems(small)


@pytest.mark.parametrize("seal", [False, True])
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
        (lambda m: m.update(schema="tt_precise.golden/0"), "schema is 'tt_precise.golden/0'"),
        (lambda m: m.pop("evidence"), "manifest.json: evidence missing"),
        (lambda m: m["files"].update({"scene.toml": {}}), "scene.toml: says something else"),
    ],
)
def test_an_edited_manifest_is_found_and_named(
    small: Small, change: Callable[[dict[str, Any]], None], words: str, seal: bool
) -> None:
    edit_manifest(small, change, seal)
    assert words in problems(small)


def test_an_edited_number_of_the_evidence_is_found(small: Small) -> None:
    edit_manifest(small, lambda m: m["evidence"]["runs"][0].update(bits=200), seal=False)
    assert "manifest.json: edited after it was built" in problems(small)


def test_another_scene_text_is_found(small: Small) -> None:
    path = path_of(small, "scene.toml")
    path.write_text(path.read_text().replace('mu = "0.3"', 'mu = "0.31"'))
    assert "scene.toml: says something else" in problems(small)
    path.write_text(path.read_text().replace('mu = "0.31"', 'mu = "0.3" # as it was'))
    assert problems(small) == ""


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe", b"nonsense"])
def test_a_missing_or_broken_file_is_named(small: Small, file: str, content: bytes | None) -> None:
    if content is None:
        path_of(small, file).unlink()
    else:
        path_of(small, file).write_bytes(content)
    if file == MANIFEST and content is None:
        with pytest.raises(InputError, match="golden data"):
            store.read(small.scene.name, small.folder)
    assert problems(small) != ""


def test_a_cell_that_is_no_printed_number_is_named(small: Small) -> None:
    def change(lines: list[list[str]]) -> None:
        lines[2][1] = "nan"

    edit_table(small, TRAJECTORY, change)
    assert "trajectory.csv, line 3, kx: got 'nan'" in problems(small)


def test_the_fresh_computation_agrees(small: Small, fresh: list[Run]) -> None:
    assert fresh[0].label == "newton quad"
    assert judged(small, fresh) == ""


def test_a_double_that_lost_more_than_the_scene_does_is_found(
    small: Small, fresh: list[Run]
) -> None:
    """What the scene loses is read off the run between the finest and double."""
    quad, double = fresh
    other = replace(quad, label="newton double-double")
    assert judged(small, [quad, other, double]) == ""
    table = double.trajectory
    row, at = list(table.rows[3]), table.columns.index("vy")
    row[at] = repr(float(row[at]) * (1 + 1e-7))
    rows = (*table.rows[:3], tuple(row), *table.rows[4:])
    spoiled = replace(double, trajectory=Table(table.columns, rows))
    found = judged(small, [quad, other, spoiled])
    assert "trajectory.csv, line 5, vy: double agrees to 7.6 digits" in found
    assert "as newton double-double lost" in found
    assert "as newton quad lost" in judged(small, [quad, spoiled])


@pytest.mark.parametrize("column", ["kx", "Lz", "theta", "omega_3"])
def test_a_wrong_digit_under_right_hashes_is_found(
    small: Small, fresh: list[Run], column: str
) -> None:
    def change(lines: list[list[str]]) -> None:
        at = lines[0].index(column)
        lines[4][at] = with_digit_flipped(lines[4][at], FRESH_DIGITS - 1)

    edit_table(small, TRAJECTORY, change)
    reseal(small)
    found = judged(small, fresh)
    assert f"trajectory.csv, line 5, {column}: newton quad agrees to" in found


def test_a_wrong_event_time_under_right_hashes_is_found(small: Small, fresh: list[Run]) -> None:
    def change(lines: list[list[str]]) -> None:
        at = lines[0].index("t")
        lines[1][at] = with_digit_flipped(lines[1][at], FRESH_DIGITS - 1)

    edit_table(small, EVENTS, change)
    reseal(small)
    assert "events.csv, line 2, t: newton quad agrees to" in judged(small, fresh)


def test_a_dropped_event_under_right_hashes_is_found(small: Small, fresh: list[Run]) -> None:
    edit_table(small, EVENTS, lambda lines: lines.pop())
    reseal(small)
    assert "events.csv: " in judged(small, fresh)


def test_rows_that_break_jellett_are_found_without_a_computation(small: Small) -> None:
    def change(lines: list[list[str]]) -> None:
        at = lines[0].index("Lz")
        lines[3][at] = with_digit_flipped(lines[3][at], 31)

    edit_table(small, TRAJECTORY, change)
    reseal(small)
    assert "trajectory.csv: jellett is constant to" in problems(small)
    assert "worst in line 4" in problems(small)


@pytest.mark.parametrize(
    ("digits", "bits", "needed"),
    [(28.0, 113, 113), (30.0, 113, 107), (24.0, 113, 127), (8.1, 53, 120)],
)
def test_a_sensitive_scene_gets_the_bits_it_needs(digits: float, bits: int, needed: int) -> None:
    assert bits_needed(digits, bits) == needed


def test_bits_are_not_raised_beyond_those_of_the_data() -> None:
    assert bits_needed(5.0, 113) is None


def test_data_of_another_start_are_no_matter_of_bits(small: Small) -> None:
    other = small.scene.text.replace('omega_3 = "155"', 'omega_3 = "155.0001"')
    name = small.scene.name
    fresh = [perform(Task(name, other, kind, None, "newton")) for kind in ("quad", "double")]
    stored, _ = inspect(name, small.folder)
    assert stored is not None
    found = judge(stored, [], fresh)
    assert found.verdict == "fail"
    assert found.digits_found is not None
    assert found.digits_found < 9
    assert bits_needed(found.digits_found, fresh[0].bits) is None


def test_verify_computes_in_worker_processes(small: Small) -> None:
    (found,) = verify(folder=small.folder, workers=1)
    assert found.verdict == "pass"
    assert found.digits_claimed == 34
    assert found.digits_found is not None
    assert found.digits_found >= FRESH_DIGITS
    assert found.double_digits is not None
    assert found.double_digits > 11
    assert found.fresh == "newton triple-double"
    # all that are printed, the last one rounded
    assert found.digits_found > 33


def test_what_quad_is_too_coarse_for_takes_more_bits(
    small: Small, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(verifying, "FRESH_DIGITS", 32.5)
    monkeypatch.setattr(verifying, "FINE", "quad")
    (found,) = verify(folder=small.folder, workers=1)
    assert found.verdict == "pass"
    assert found.digits_found is not None
    assert found.digits_found >= 32.5
    assert found.fresh.startswith("newton 1")


def test_unknown_scenes_are_refused(small: Small) -> None:
    with pytest.raises(InputError, match="expected one of: reference"):
        verify(["nowhere"], folder=small.folder)


def test_tables_without_rows_do_not_break_the_inspection(small: Small) -> None:
    empty = Table(store.read(small.scene.name, small.folder).trajectory.columns, ())
    path_of(small, TRAJECTORY).write_text(empty.csv())
    assert "before the horizon" in problems(small)


def test_all_that_is_there_are_the_scenes_and_not_the_test_vectors(tmp_path: Path) -> None:
    for name in ("mine", "vectors", ".hidden"):
        (tmp_path / name).mkdir()
    # a folder without data is looked at, and fails
    assert [one.name for one in verifying._asked_for(None, tmp_path)] == ["mine"]
    assert "reference" in [one.name for one in verifying._asked_for(None, None)]
    assert "vectors" not in [one.name for one in verifying._asked_for(None, None)]


def test_a_missing_row_is_found_where_contact_is_lost(tmp_path: Path) -> None:
    """Whose last row lies between two samples."""
    shutil.copytree(store.home() / "contact-lost", tmp_path / "contact-lost")
    path = tmp_path / "contact-lost" / TRAJECTORY
    assert inspect("contact-lost", tmp_path)[1] == []
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:6] + lines[7:]))
    first = inspect("contact-lost", tmp_path)[1][0]
    assert first.startswith(f"{TRAJECTORY}: the row of t = {lines[6].partition(',')[0]} is missing")


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("theta_dot", "is empty, a fresh computation has a number"),
        ("kx", "got '', expected a printed number"),
    ],
)
def test_an_empty_cell_under_right_hashes_is_found(
    small: Small, fresh: list[Run], column: str, message: str
) -> None:
    """Euler columns are empty at a pole, vectors nowhere."""
    edit_table(small, TRAJECTORY, lambda lines: emptied(lines, column))
    reseal(small)
    assert f"{TRAJECTORY}, line 4, {column}: {message}" in judged(small, fresh)


def emptied(lines: list[list[str]], column: str) -> None:
    lines[3][lines[0].index(column)] = ""


def test_data_that_ship_are_of_the_scene_that_ships(
    small: Small, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Everything else may fit: those of a shorter run are others under the same name."""
    assert problems(small) == ""
    monkeypatch.setattr(integrity, "home", lambda: small.folder)
    assert "scene.toml: another scene than the reference that ships" in problems(small)


def test_what_cannot_be_compared_does_not_pass(small: Small, fresh: list[Run]) -> None:
    """Without ``inspect``, which finds other columns too."""
    stored, _ = inspect(small.scene.name, small.folder)
    assert stored is not None
    assert judge(stored, [], fresh).verdict == "pass"

    def renamed(table: Table) -> Table:
        return Table(tuple(f"{n}_" if n == "theta" else n for n in table.columns), table.rows)

    table, happened = renamed(stored.trajectory), renamed(stored.events)
    found = judge(replace(stored, trajectory=table, events=happened), [], fresh)
    assert found.digits_found is None
    assert found.verdict == "fail"
    for file in (TRAJECTORY, EVENTS):
        text = f"{file}: has other columns than a fresh computation: theta, theta_"
        assert text in found.problems
    nothing = replace(stored, trajectory=Table(stored.trajectory.columns, ()))
    found = judge(replace(nothing, events=Table(stored.events.columns, ())), [], fresh)
    assert "newton quad: no entry could be compared, expected all of them" in found.problems
