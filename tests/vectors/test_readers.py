"""Readers of the reference data in three languages: each run, and each seen to fail."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from tt_precise.golden.store import home
from tt_precise.vectors.states import JOINED, KINDS

READERS = Path(__file__).parents[2] / "examples" / "readers"
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
    """What the readers read, with an index of the trajectory alone."""
    for name in ("vectors/states.json", "reference/trajectory.csv"):
        (tmp_path / name).parent.mkdir()
        shutil.copy(home() / name, tmp_path / name)
    list_trajectory(tmp_path)
    return tmp_path


def list_trajectory(folder: Path) -> None:
    path = "reference/trajectory.csv"
    entry = {"path": path, "sha256": hashlib.sha256((folder / path).read_bytes()).hexdigest()}
    (folder / "index.json").write_text(json.dumps({"files": [entry]}, indent=1))


def test_it_reads_all_and_agrees(reader: list[str]) -> None:
    done = run(reader, home())
    files = json.loads((home() / "index.json").read_text())["files"]
    states = json.loads((home() / "vectors/states.json").read_text())["cases"]
    expected = f"{len(files)} files, {len(states)} states"
    assert (done.returncode, done.stdout[: len(expected)]) == (0, expected), done.stderr


@pytest.mark.parametrize("law", [*KINDS, *JOINED])
def test_a_wrong_force_does_not_pass(reader: list[str], copied: Path, law: str) -> None:
    states = copied / "vectors" / "states.json"
    file = json.loads(states.read_text())
    (case,) = (one for one in file["cases"] if one["name"] == f"{law}-1")
    weight = float(case["body"]["m"]) * float(case["body"]["g"])
    for wrong in (0.0, 1e-11):
        case["expected"]["F"][1] = str(float(case["expected"]["F"][1]) + wrong * weight)
        states.write_text(json.dumps(file, indent=1))
        assert run(reader, copied).returncode == (wrong > 0)


def test_an_invalid_case_must_not_agree(reader: list[str], copied: Path) -> None:
    states = copied / "vectors" / "states.json"
    file = json.loads(states.read_text())
    file["cases"][0]["result"] = "invalid"
    states.write_text(json.dumps(file, indent=1))
    assert run(reader, copied).returncode == 1


def test_an_axis_that_is_no_unit_vector_does_not_pass(reader: list[str], copied: Path) -> None:
    table = copied / "reference" / "trajectory.csv"
    rows = table.read_text().rstrip().split("\n")
    cells = rows[-1].split(",")
    assert rows[0].split(",")[3] == "kz"
    cells[3] = str(float(cells[3]) + 1e-14)
    table.write_text("\n".join([*rows[:-1], ",".join(cells)]) + "\n")
    list_trajectory(copied)
    assert run(reader, copied).returncode == 1


@pytest.mark.parametrize("name", ["index.json", "vectors/states.json", "reference/trajectory.csv"])
def test_a_missing_file_does_not_pass(reader: list[str], copied: Path, name: str) -> None:
    (copied / name).unlink()
    assert run(reader, copied).returncode not in (0, -11)
