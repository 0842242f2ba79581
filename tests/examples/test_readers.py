"""Readers of the reference data in three languages: each run, and each seen to fail."""

import json
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from benchmarks.vectors.states import JOINED, KINDS
from tests.golden.tables import edit_cell, edit_json
from tt_precise.golden.store import home

READERS = Path(__file__).parents[2] / "examples" / "readers"
FILES = ("vectors/states.json", "reference/trajectory.csv")
COMPILERS: dict[str, Sequence[str]] = {
    "reader.c": ("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "{source}", "-o", "{out}",
                 "-lm"),
    "reader.rs": ("rustc", "--edition", "2021", "-D", "warnings", "{source}", "-o", "{out}"),
    "reader.mjs": ("node", "--check", "{source}"),
}  # fmt: skip


@pytest.fixture(scope="module", params=COMPILERS)
def reader(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    source, words = READERS / request.param, COMPILERS[request.param]
    if shutil.which(words[0]) is None:
        pytest.skip(f"{words[0]} is not installed, so {request.param} cannot run")
    out = tmp_path_factory.mktemp("reader") / "reader"
    filled = [word.format(source=source, out=out) for word in words]
    subprocess.run(filled, check=True, capture_output=True)
    return ["node", str(source)] if source.suffix == ".mjs" else [str(out)]


def run(reader: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*reader, str(folder)], capture_output=True, text=True, check=False)


def test_it_reads_all_and_agrees(reader: list[str]) -> None:
    done = run(reader, home())
    states = json.loads((home() / FILES[0]).read_text())["cases"]
    expected = f"{len(states)} states, 801 rows"
    assert (done.returncode, done.stdout[: len(expected)]) == (0, expected), done.stderr


def edit_state(name: str, change: Callable[[Any], object], folder: Path) -> None:
    """Change a case of the test vectors."""

    def edit(file: Any) -> None:
        (case,) = (case for case in file["cases"] if case["name"] == name)
        change(case)

    edit_json(folder / FILES[0], edit, partial(json.dumps, indent=1))


def wrong_force(case: Any) -> None:
    force, weight = case["expected"]["F"], float(case["body"]["m"]) * float(case["body"]["g"])
    force[1] = str(float(force[1]) + 1e-11 * weight)


def longer_axis(folder: Path) -> None:
    edit_cell(folder / FILES[1], 802, "kz", lambda kz: str(float(kz) + 1e-14))


def remove(name: str, folder: Path) -> None:
    (folder / name).unlink()


FAULTS: dict[str, Callable[[Path], object]] = {
    **{f"a wrong force: {law}": partial(edit_state, f"{law}-1", wrong_force)
       for law in (*KINDS, *JOINED)},
    "an invalid case that agrees":
        partial(edit_state, "viscous-1", lambda case: case.update(result="invalid")),
    "an axis that is no unit vector": longer_axis,
    **{f"no {name}": partial(remove, name) for name in FILES},
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_spoiled_and_missing_files_do_not_pass(
    reader: list[str], tmp_path: Path, fault: str
) -> None:
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(home() / name, tmp_path / name)
    FAULTS[fault](tmp_path)
    assert run(reader, tmp_path).returncode not in (0, -11)
