"""What a finished or interrupted sweep's folder holds counts only if it is what was written."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from tt_precise.cli import main
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import locked
from tt_precise.sweeps import read_rows, specification, sweep
from tt_precise.sweeps.place import Folder, Place, Url, place_of

SPEC = specification("reference", until="0.05", vary={"phi_dot": "-20:20:12"})
CHUNK = 4  # three chunks


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("finished") / "sweep"
    sweep(SPEC, out=out, chunk=CHUNK, one_in=0)
    return out


@pytest.fixture(scope="module")
def rows(finished: Path) -> pandas.DataFrame:
    return read_rows(finished)


def copied(finished: Path, tmp_path: Path) -> Path:
    return shutil.copytree(finished, tmp_path / "sweep")


def cut(path: Path) -> None:
    """Whole in itself, but with fewer rows, and NaN among them."""
    table = pandas.read_parquet(path)[:5]
    table.loc[2, "min_g_n"] = numpy.nan
    table.to_parquet(path)


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def test_a_finished_sweep_is_verified(finished: Path) -> None:
    again = sweep(SPEC, out=finished, one_in=0).summary
    assert again["how"]["rows_computed"] == 0
    assert again["how"]["damaged"] == []
    assert again["rows"] == 12


@pytest.mark.parametrize("damage", [cut, flip, Path.unlink, lambda path: path.write_bytes(b"")])
def test_damaged_rows_are_computed_again(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame, damage: Callable[[Path], Any]
) -> None:
    out = copied(finished, tmp_path)
    damage(out / "rows.parquet")
    again = sweep(SPEC, out=out, one_in=0).summary
    assert again["how"]["rows_computed"] == 12
    assert again["how"]["damaged"]
    assert again["rows"] == 12
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    assert not (out / "chunks").exists()


def test_a_lost_ledger_leaves_nothing_behind(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame
) -> None:
    out = copied(finished, tmp_path)
    (out / "ledger.jsonl").unlink()
    assert sweep(SPEC, out=out, one_in=0).summary["how"]["rows_computed"] == 12
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    assert sorted(one.name for one in out.iterdir()) == [
        "ledger.jsonl", "rows.parquet", "summary.json", "sweep.json",
    ]  # fmt: skip


@pytest.mark.parametrize("content", ["", "{", "[]", "null", '{"chunk": "x"}', "\x00" * 9])
def test_a_damaged_manifest_is_bad_input(finished: Path, tmp_path: Path, content: str) -> None:
    out = copied(finished, tmp_path)
    (out / "sweep.json").write_text(content)
    with pytest.raises(InputError, match=r"sweep\.json is damaged"):
        sweep(SPEC, out=out, one_in=0)


LINES = ("[]", "null", "7", "{}", '{"chunk": "x"}', '{"chunk": 1, "sha256": 3}', "\x00\x00",
         '{"index": [], "found": {}}', '{"gathered": "rows.parquet", "rows": 12, "sha256": ""}',
         '{"chunk": 99, "rows": 4, "sha256": "", "outcomes": {}, "columns": {}}')  # fmt: skip


def test_lines_that_are_none_are_left_out(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame
) -> None:
    out = copied(finished, tmp_path)
    for log in ("ledger.jsonl", "recheck.jsonl"):
        with (out / log).open("a") as file:
            file.write("\n".join(LINES) + "\n")
    assert sweep(SPEC, out=out, one_in=0).summary["rows"] == 12
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)


def test_a_flipped_bit_in_a_line_of_the_ledger_makes_it_none(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame
) -> None:
    """Also where it is still JSON: in a column's name, or in a digit of a statistic."""
    whole = (finished / "ledger.jsonl").read_text()
    name = whole.index("min_g_n")
    digit = next(at for at in range(name, len(whole)) if whole[at].isdigit())
    for at in (name, digit):
        out = copied(finished, tmp_path / str(at))
        text = f"{whole[:at]}{chr(ord(whole[at]) ^ 1)}{whole[at + 1 :]}"
        (out / "ledger.jsonl").write_text(text)
        found = sweep(SPEC, out=out, one_in=0).summary
        assert found["rows"] == 12
        assert found["columns"] == json.loads((finished / "summary.json").read_text())["columns"]
        pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)


def test_two_sweeps_do_not_share_a_folder(finished: Path, tmp_path: Path) -> None:
    out = copied(finished, tmp_path)
    with locked(out, "sweep"), pytest.raises(InputError, match="another sweep is at work"):
        sweep(SPEC, out=out, one_in=0)
    assert sweep(SPEC, out=out, one_in=0).summary["rows"] == 12


def corrupted(out: Path, draws: numpy.random.Generator) -> str:
    """Damage a folder in one of many ways; what was done."""
    file = sorted(one for one in out.rglob("*") if one.is_file())[draws.integers(0, 4)]
    if file.name == "sweep.json":  # without it the folder is somebody else's
        file = out / "rows.parquet"
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


def survives(finished: Path, tmp_path: Path, rows: pandas.DataFrame, seed: int) -> None:
    out = copied(finished, tmp_path / str(seed))
    done = corrupted(out, numpy.random.default_rng([22, seed]))
    try:
        found = sweep(SPEC, out=out, one_in=0).summary
        pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
        assert (found["rows"], found["quarantined"]) == (12, []), done
    except AssertionError as error:
        raise AssertionError(done) from error
    shutil.rmtree(out.parent)


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_folder_comes_out_whole(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame, seed: int
) -> None:
    survives(finished, tmp_path, rows, seed)


@pytest.mark.fuzz
def test_a_thousand_damaged_folders_come_out_whole(
    finished: Path, tmp_path: Path, rows: pandas.DataFrame
) -> None:
    for seed in range(12, 1012):
        survives(finished, tmp_path, rows, seed)


# ---- places ----------------------------------------------------------------------------------


def test_a_url_holds_the_same_rows(tmp_path: Path, rows: pandas.DataFrame) -> None:
    pytest.importorskip("fsspec", reason="needs the extra dask")
    out = f"file://{tmp_path}/far/sweep"
    found = sweep(SPEC, out=out, chunk=CHUNK, one_in=5, workers=2).summary
    assert found["out"] == out
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    again = sweep(SPEC, out=out, one_in=5).summary
    assert (again["how"]["rows_computed"], again["recheck"]) == (0, found["recheck"])
    flip(tmp_path / "far" / "sweep" / "chunks" / "00000001.parquet")
    again = sweep(SPEC, out=out, one_in=5).summary
    assert (again["how"]["rows_computed"], again["rows"]) == (CHUNK, 12)
    assert again["how"]["damaged"] == ["chunks/00000001.parquet"]
    pandas.testing.assert_frame_equal(read_rows(out), rows, check_exact=True)
    with pytest.raises(InputError, match="not empty"):
        sweep(SPEC, out=f"file://{tmp_path}/far", one_in=0)


def keeps_files_and_logs(place: Place) -> None:
    assert (place.read("none"), place.log("log"), place.names()) == (None, "", set())
    place.write("chunks/1", b"one")
    place.write("chunks/1", b"two")
    assert place.read("chunks/1") == b"two"
    place.append("log", "first\n")
    place.append("log", "second\n")
    assert place.log("log") == "first\nsecond\n"
    assert "chunks" in place.names()
    place.remove("chunks")
    place.remove("chunks")
    assert place.read("chunks/1") is None


@pytest.mark.parametrize("kind", ["folder", "url"])
def test_a_place_keeps_files_and_logs(tmp_path: Path, kind: str) -> None:
    if kind == "url":
        pytest.importorskip("fsspec", reason="needs the extra dask")
    place = place_of(tmp_path / "a" if kind == "folder" else f"memory://{tmp_path}/a")
    assert isinstance(place, Folder if kind == "folder" else Url)
    keeps_files_and_logs(place)
    assert str(place).endswith("/a")


def test_an_unknown_url_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("fsspec", reason="needs the extra dask")
    words = ["--vary", "phi_dot=1", "--workers", "1", "--out", "nowhere://x/y"]
    assert main(["sweep", "reference", *words]) == 2
    assert "nowhere://x/y: " in capsys.readouterr().err


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
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    assert main(["sweep", "plot", str(tmp_path / name), "--x", "phi_dot", "--y", "climb"]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert name in line


def test_the_summary_does_not_depend_on_the_order_of_chunks(finished: Path) -> None:
    written = json.loads((finished / "summary.json").read_text())
    memory = sweep(SPEC, chunk=CHUNK, one_in=0).summary
    assert written["columns"] == memory["columns"]
    assert written["outcomes"] == memory["outcomes"]
    assert written["columns"]["phi_dot"]["mean"] == pytest.approx(0, abs=1e-14)
