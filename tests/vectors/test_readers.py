"""Readers of the reference data in three languages: each run, and each seen to fail."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from tt_precise.golden.store import home

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


def run(reader: list[str], folder: Path) -> int:
    return subprocess.run([*reader, str(folder)], capture_output=True, check=False).returncode


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    source = home()
    (tmp_path / "reference").mkdir()
    for name in ("index.json", "vectors/states.json", "reference/trajectory.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(source / name, tmp_path / name)
    return tmp_path


def test_it_reads_all_and_agrees(reader: list[str]) -> None:
    assert run(reader, home()) == 0


@pytest.mark.parametrize("name", ["states.json", "trajectory.csv"])
def test_a_wrong_number_does_not_pass(reader: list[str], copied: Path, name: str) -> None:
    file = copied / ("vectors" if name == "states.json" else "reference") / name
    text = file.read_text()
    if name == "states.json":
        at = text.index('"F": [') + text[text.index('"F": [') :].index(".") + 6
    else:
        start = text.rstrip().rindex("\n") + 1
        at = start + text[start:].index(",", 4) - 30
    digit = next(i for i in range(at, len(text)) if text[i] in "0123456789")
    file.write_text(text[:digit] + str((int(text[digit]) + 5) % 10) + text[digit + 1 :])
    assert run(reader, copied) != 0


@pytest.mark.parametrize("law", ["linear-1", "hunt-crossley-1"])
def test_the_force_of_an_elastic_table_is_computed_in_javascript(law: str, copied: Path) -> None:
    if shutil.which("node") is None:
        pytest.skip("node is not installed, so reader.mjs cannot run")
    reader = ["node", str(READERS / "reader.mjs")]
    index, states = copied / "index.json", copied / "vectors" / "states.json"
    index.write_text(json.dumps({"files": []}))
    assert run(reader, copied) == 0
    file = json.loads(states.read_text())
    (case,) = (one for one in file["cases"] if one["name"] == law)
    case["contact"]["damping"] = str(1.0001 * float(case["contact"]["damping"]))
    states.write_text(json.dumps(file))
    assert run(reader, copied) == 1


def test_a_missing_file_does_not_pass(reader: list[str], copied: Path) -> None:
    (copied / "index.json").unlink()
    assert run(reader, copied) != 0


def test_readers_are_short() -> None:
    for file in READERS.iterdir():
        assert len(file.read_text().splitlines()) <= 80, file
