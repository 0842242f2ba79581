"""What a finished or interrupted sweep's folder holds counts only if it is what was written."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest
from pyarrow import parquet

from tests.conftest import Said
from tt_precise.runtime.files import locked
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import SweepSpec, read_rows, run_sweep, store

SPEC = SweepSpec.of("reference", until="0.05", vary={"phi_dot": "-20:20:12"})
CHUNK = 4  # three chunks
ONE = "chunks/00000001.parquet"


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("finished") / "sweep"
    run_sweep(SPEC, out=out, chunk=CHUNK, recheck=0)
    return out


@pytest.fixture(scope="module")
def rows(finished: Path) -> pandas.DataFrame:
    return read_rows(finished)


@pytest.fixture
def out(finished: Path, tmp_path: Path) -> Path:
    """A copy of the finished sweep's folder."""
    return shutil.copytree(finished, tmp_path / "sweep")


def cut(path: Path) -> None:
    """Whole in itself, but with fewer rows, and NaN among them."""
    table = pandas.read_parquet(path)[:5]
    table.loc[2, "min_g_n"] = numpy.nan
    table.to_parquet(path)


def flip(path: Path) -> None:
    """One wrong bit in the last value of the first column."""
    column = parquet.ParquetFile(path).metadata.row_group(0).column(0)
    content = bytearray(path.read_bytes())
    content[column.dictionary_page_offset + column.total_compressed_size - 1] ^= 1
    path.write_bytes(content)


def rename(path: Path) -> None:
    """Another name of a column, as one wrong bit makes it."""
    path.write_bytes(path.read_bytes().replace(b"min_g_n", b"lin_g_n", 1))


def swap(path: Path) -> None:
    """The rows of another chunk of the same sweep."""
    shutil.copy(path.with_name(store.name_of(0)), path)


@pytest.mark.parametrize(
    "damage", [cut, swap, flip, rename, Path.unlink, lambda path: path.write_bytes(b"")]
)
def test_damaged_rows_are_computed_again(
    out: Path, rows: pandas.DataFrame, damage: Callable[[Path], Any]
) -> None:
    damage(out / ONE)
    with pytest.raises(InputError, match="run it again"):
        read_rows(out)
    again = run_sweep(SPEC, out=out, recheck=0).summary
    assert again["how"]["rows_computed"] == CHUNK
    assert again["rows"] == 12
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)


def test_rows_that_were_damaged_are_not_drawn(out: Path, tmp_path: Path, said: Said) -> None:
    drawn = "--x phi_dot --y min_g_n --out", tmp_path / "picture.svg"
    said("sweep plot", out, *drawn)
    flip(out / ONE)
    for what in (out, out / ONE):
        refused = said("sweep plot", what, *drawn, status=2)
        assert "has changed since the sweep wrote it" in refused


@pytest.mark.parametrize("content", ["", "{", "[]", "null", '{"chunk": "x"}', "\x00" * 9])
def test_a_damaged_manifest_is_bad_input(out: Path, content: str) -> None:
    (out / "sweep.json").write_text(content)
    with pytest.raises(InputError, match=r"sweep\.json is damaged"):
        run_sweep(SPEC, out=out, recheck=0)


@pytest.mark.parametrize("law", ["viscous", "coulomb"])
def test_a_folder_knows_the_law_of_friction(tmp_path: Path, law: str) -> None:
    scene = load_scene("reference").varied(friction={"law": law, "mu": "0.3"}, until="0")
    spec = SweepSpec.of(scene, vary={"mu": "0.2,0.3"})
    run_sweep(spec, out=tmp_path / "sweep", workers=1, recheck=0)
    assert read_rows(tmp_path / "sweep").attrs["law"] == law


def test_two_sweeps_do_not_share_a_folder(out: Path) -> None:
    with locked(out, "sweep"), pytest.raises(InputError, match="another sweep is"):
        run_sweep(SPEC, out=out, recheck=0)
    assert run_sweep(SPEC, out=out, recheck=0).summary["rows"] == 12


def corrupted(out: Path, draws: numpy.random.Generator) -> str:
    """Damage a folder in one of many ways; what was done."""
    file = sorted(one for one in out.rglob("*") if one.is_file())[draws.integers(0, 5)]
    if file.name == "sweep.json":  # without it the folder is somebody else's
        file = out / ONE
    content = bytearray(file.read_bytes())
    kind = draws.choice(["flip", "cut", "remove", "zero", "append", "swap", "empty"])
    at = int(draws.integers(0, max(1, len(content))))
    if kind == "remove":
        file.unlink()
        return f"{file.name}: removed"
    if kind == "flip":
        content[at] ^= 1 << int(draws.integers(0, 8))
    elif kind == "cut":
        del content[at:]
    elif kind == "zero":
        content[at : at + 16] = bytes(len(content[at : at + 16]))
    elif kind == "append":
        content += bytes(draws.integers(0, 256, 7, dtype=numpy.uint8))
    elif kind == "swap":
        content[at:], content[:at] = content[:at], content[at:]
    else:
        content.clear()
    file.write_bytes(content)
    return f"{file.name}: {kind} at {at}"


@pytest.mark.parametrize(
    "seeds", [range(12), pytest.param(range(12, 1012), marks=pytest.mark.fuzz)]
)
def test_a_damaged_folder_comes_out_whole(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame, seeds: range
) -> None:
    for seed in seeds:
        out = shutil.copytree(finished, tmp_path / str(seed))
        done = corrupted(out, numpy.random.default_rng([22, seed]))
        found = run_sweep(SPEC, out=out, recheck=0).summary
        assert found["rows"] == 12, done
        assert read_rows(out).equals(rows), done
        shutil.rmtree(out)


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_url_holds_the_same_rows(tmp_path: Path, rows: pandas.DataFrame, workers: int) -> None:
    out = f"file://{tmp_path}/far/sweep"
    found = run_sweep(SPEC, out=out, chunk=CHUNK, recheck=1, workers=workers).summary
    assert found["out"] == out
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    again = run_sweep(SPEC, out=out, recheck=1).summary
    assert (again["how"]["rows_computed"], again["recheck"]) == (0, found["recheck"])
    flip(tmp_path / "far" / "sweep" / ONE)
    again = run_sweep(SPEC, out=out, recheck=1).summary
    assert (again["how"]["rows_computed"], again["rows"]) == (CHUNK, 12)
    assert again["how"]["damaged"] == [ONE]
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    with pytest.raises(InputError, match="not empty"):
        run_sweep(SPEC, out=f"file://{tmp_path}/far", recheck=0)


@pytest.mark.parametrize("kind", ["", "memory://"])
def test_a_file_is_whole_or_not_there(tmp_path: Path, kind: str) -> None:
    out = f"{kind}{tmp_path}/a"
    assert (store.content_of(out, "none"), store.names(out)) == (None, set())
    store.write(out, "chunks/1", b"one")
    store.write(out, "chunks/1", b"two")
    assert store.content_of(out, "chunks/1") == b"two"
    assert (store.names(out), store.names(out, "chunks")) == ({"chunks"}, {"1"})


def test_an_unknown_url_is_bad_input(said: Said) -> None:
    words = "sweep reference --vary phi_dot=1 --workers 1 --out nowhere://x/y"
    assert "nowhere://x/y: " in said(words, status=2)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("rows.parquet", b"torn"),
        ("rows.csv", b"a,b\n1,2,3,4\n5\n"),
        ("rows.csv", b""),
        ("rows.csv", b"\xff\xfe\x00"),
        ("rows.parquet", b"PAR1" + bytes(100) + b"PAR1"),
    ],
)
def test_torn_or_ragged_files_cannot_be_drawn(
    tmp_path: Path, said: Said, name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    line = said("sweep plot", tmp_path / name, "--x phi_dot --y climb", status=2)
    assert line.count("\n") == 1
    assert name in line
