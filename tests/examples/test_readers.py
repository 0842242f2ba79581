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


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """Copy the files of the readers to a folder of its own."""
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(home() / name, tmp_path / name)
    return tmp_path


def edit_states(folder: Path, change: Callable[[Any], object]) -> None:
    edit_json(folder / "vectors" / "states.json", change, partial(json.dumps, indent=1))


def test_it_reads_all_and_agrees(reader: list[str]) -> None:
    done = run(reader, home())
    states = json.loads((home() / "vectors/states.json").read_text())["cases"]
    expected = f"{len(states)} states, 801 rows"
    assert (done.returncode, done.stdout[: len(expected)]) == (0, expected), done.stderr


@pytest.mark.parametrize("law", [*KINDS, *JOINED])
def test_a_wrong_force_does_not_pass(reader: list[str], copied: Path, law: str) -> None:
    assert run(reader, copied).returncode == 0

    def wrong(file: Any) -> None:
        (case,) = (one for one in file["cases"] if one["name"] == f"{law}-1")
        F, weight = case["expected"]["F"], float(case["body"]["m"]) * float(case["body"]["g"])
        F[1] = str(float(F[1]) + 1e-11 * weight)

    edit_states(copied, wrong)
    assert run(reader, copied).returncode == 1


def longer_axis(folder: Path) -> None:
    edit_cell(folder / FILES[1], 802, "kz", lambda kz: str(float(kz) + 1e-14))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda folder: edit_states(folder, lambda file: file["cases"][0].update(result="invalid")),
        longer_axis,
        *(lambda folder, name=name: (folder / name).unlink() for name in FILES),
    ],
    ids=["an invalid case that agrees", "an axis that is no unit vector", *FILES],
)
def test_spoiled_and_missing_files_do_not_pass(
    reader: list[str], copied: Path, spoil: Callable[[Path], None]
) -> None:
    spoil(copied)
    assert run(reader, copied).returncode not in (0, -11)
