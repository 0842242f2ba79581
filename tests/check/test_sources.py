"""Every format gives the same rows; what cannot be used ends in one line that says where."""

import gzip
import io
import json
import os
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pandas
import pytest

from tests.check.conftest import VECTORS, check, matches, refuses, solved, vectors
from tests.conftest import Patch
from tests.golden.tables import edit_cell
from tt_precise.check import sources
from tt_precise.runtime import files

AXIS = b"t,kx,ky,kz,Lx,Ly,Lz\n"
ROW = b"0,0,0,1,0,0,1\n"


def values(source: Any, **words: Any) -> list[Any]:
    """Return the checks without golden digits, which differ for 0.1 as text and as float."""
    checks = check(source, "reference", **words).checks
    return [(each.name, each.verdict, each.value, each.at) for each in checks[:-1]]


def test_every_format_is_the_same(written: Path, tmp_path: Path, monkeypatch: Patch) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    frame, data = vectors(), written.read_bytes()
    arrays: dict[str, Any] = {name: frame[name].to_numpy() for name in VECTORS}
    numpy.savez(tmp_path / "run.npz", **arrays)
    frame.to_parquet(tmp_path / "run.parquet")
    for suffix in (".json", ".arrow"):
        files.write_table(tmp_path / f"run{suffix}", {n: frame[n].tolist() for n in VECTORS})
    frame.to_csv(tmp_path / "quoted.tsv", index=False, sep="\t", quoting=1)
    rows = "\n".join(json.dumps(row) for row in frame.to_dict("records"))
    header, *lines = data.splitlines()
    for name, content in {
        "run.csv.gz": gzip.compress(data),
        "run.feather": (tmp_path / "run.arrow").read_bytes(),
        "run.jsonl": rows.encode(),
        "commented.csv": b"# my engine, version 2\n# SI\n" + data.replace(b"t,", b"time,", 1),
        "preamble.csv": b"Take,top\n\n" + data,
        "excel.csv": b"sep=;\n" + data.replace(b",", b";"),
        "spaces.txt": data.replace(b",", b"  "),
        "crlf.csv": b"\xef\xbb\xbf# " + data.replace(b"\n", b"\r\n") + b"\r\n\r\n",
        "mac.csv": data.replace(b"\n", b"\r"),
        "unread.csv": b"\n".join([header + b",note", *(line + b',"a, b"' for line in lines)]),
    }.items():
        (tmp_path / name).write_bytes(content)
    expected = values(frame)
    in_memory = (arrays, frame.astype(str), frame.astype(object), pyarrow.table(frame))
    for source in (*tmp_path.iterdir(), str(written), *in_memory):
        assert values(source) == expected, source
    for piped in (data, gzip.compress(data)):
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(piped)))
        assert values("-") == expected
    assert values(frame.rename(columns={"kx": 0}), columns={"0": "kx"}) == expected


@pytest.mark.parametrize(
    ("column", "text", "message"),
    [
        ("kz", "abc", ", column kz: got 'abc', expected a number"),
        ("kz", "0x10", ", column kz: got '0x10', expected a number"),
        ("t", "2.97", ": t = 2.97 comes after t = 2.97, expected strictly increasing time"),
    ],
)
def test_a_bad_cell_is_named(written: Path, column: str, text: str, message: str) -> None:
    edit_cell(written, 300, column, lambda _: text)
    refuses(f"run.csv: line 300{message}", written)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("bad.csv", b"", "got an empty file, expected a header such as t,kx"),
        ("bad.csv", b"\n# only\n# comments\n", "got 'only', expected a header"),
        ("bad.csv", AXIS, "got 0 rows, expected a trajectory of at least two"),
        ("bad.csv", AXIS + ROW + b"1,0,0\n", "7 columns but 3 were found at row 2"),
        ("bad.csv", b"t;kx;ky\n0;0;0\n", "among the columns t, kx, ky; rename"),
        ("bad.csv", b"<!DOCTYPE html>\n", "got HTML or XML, expected a header"),
        ("bad.csv", b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        ("bad.csv", b"\xff\xfe\x00", "can't decode byte 0xff"),
        ("bad.csv", b"x" * 2_000_000, "got 'x{40}', expected a header"),
        ("bad.csv", AXIS[:-1] + b",kx\n", "column kx occurs twice"),
        ("cut.csv.gz", gzip.compress(AXIS + 1000 * ROW, mtime=0)[:60], "expected a trajectory"),
        ("bad.mat", b"MATLAB 5.0 MAT-file, Platform".ljust(200), "expected a trajectory file"),
        ("deep.json", b'{"t": ' + 40_000 * b"[" + 40_000 * b"]" + b"}", "recursion depth"),
    ],
    ids=lambda value: value[:40].decode("latin1") if isinstance(value, bytes) else "",
)
def test_a_bad_file_is_refused(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(content)
    refuses(message, tmp_path / name)


def test_sources_that_are_no_files(tmp_path: Path) -> None:
    pipes = [tmp_path / name for name in ("z.csv", "z.parquet")]
    for pipe in pipes:
        os.mkfifo(pipe)
    for path in (tmp_path, *pipes):
        refuses("no regular file", path)
    for name in ("absent.csv", "nul\0"):
        refuses("expected a trajectory file", tmp_path / name)
    refuses("got a int, expected a path, a DataFrame or a mapping", 17)
    refuses("missing ky", {"t": [0, 1], "kx": [0]})


@pytest.mark.parametrize(
    ("column", "text", "at"),
    [("kz", "nan", 2.98), ("kz", "-inf", 2.98), ("kz", "", 2.98), ("kz", "1e999", 2.98),
     ("t", "nan", 2.97)],
)  # fmt: skip
def test_a_blow_up_fails_at_its_time(written: Path, column: str, text: str, at: float) -> None:
    edit_cell(written, 300, column, lambda _: text)
    result = check(written, "reference")
    assert [each.name for each in result.failures] == ["finite"]
    assert result.rows == 298
    assert result["finite"].at == pytest.approx(at)
    assert "line 300" in result["finite"].note
    assert check(written, "reference", until=2.9).passed
    with pytest.raises(AssertionError, match="where the checks stop"):
        matches(written, "reference", digits=8)


@pytest.mark.parametrize("row", [0, 1])
def test_a_blow_up_at_the_start_leaves_nothing_to_check(row: int) -> None:
    frame = vectors(9).astype(object)
    frame.loc[row, "kz"] = None
    result = check(frame, "reference", digits=8)
    assert [each.verdict for each in result.checks if each.verdict != "skipped"] == ["fail"]
    assert f"kz = nan in row {row}" in str(result)
    assert result["finite"].at == frame["t"][row]


def test_every_known_column_is_finite(no_cause: None) -> None:
    """Euler angles are undefined where the axis is vertical only."""
    frame = solved([*VECTORS, "phi_dot"], 101)
    frame.loc[50, "phi_dot"] = numpy.nan
    result = check(frame, "reference")
    assert (result["finite"].verdict, result["finite"].at, result.rows) == ("fail", 0.5, 101)
    poles = vectors(41, 40, "upright").assign(theta=numpy.nan)
    assert check(poles, "upright")["finite"].verdict == "pass"


KZ, T = vectors(9)["kz"].to_numpy(), vectors(9)["t"].to_numpy()
DATES = numpy.datetime64("2026-01-01") + (T * 1e9).astype("timedelta64[ns]")


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("kz", [*KZ[:5], "abc", *KZ[6:]], "row 5, column kz: got 'abc', expected a number"),
        ("kz", [10**400, *KZ[1:]], "row 0, column kz: got '10*', expected a number"),
        ("kz", numpy.ma.masked_less(KZ, 1), "column kz: got masked entries"),
        ("kz", [[0.0], *KZ[1:]], "inhomogeneous shape"),
        ("kz", KZ.reshape(-1, 1), r"column kz: got float64 of shape \(9, 1\)"),
        ("t", pandas.Series(DATES), r"column t: got datetime64\[ns\]"),
    ],
)
def test_input_that_would_lose_something_is_refused(name: str, values: Any, message: str) -> None:
    columns = {each: vectors(9)[each].to_numpy() for each in VECTORS}
    refuses(message, {**columns, name: values})


@pytest.fixture
def small(monkeypatch: Patch) -> int:
    """A bound that tests reach."""
    for module in (sources, files):
        monkeypatch.setattr(module, "MOST_BYTES", 100_000)
    return 100_000


def test_archives_that_unpack_to_more_are_refused(tmp_path: Path, small: int) -> None:
    zeros: dict[str, Any] = dict.fromkeys(VECTORS, numpy.zeros(small))
    numpy.savez_compressed(tmp_path / "bomb.npz", **zeros)
    assert (tmp_path / "bomb.npz").stat().st_size < 10_000
    (tmp_path / "bomb.csv.gz").write_bytes(gzip.compress(AXIS + small * ROW))
    (tmp_path / "bomb.json").write_text(small * "  ")
    for name, what in (("npz", "numbers in t"), ("csv.gz", "text"), ("json", "text")):
        refuses(f"bomb.{name}: more than 0 GB of {what}", tmp_path / f"bomb.{name}")


def test_an_array_longer_than_its_member_is_refused(tmp_path: Path) -> None:
    header = {"descr": "<f8", "fortran_order": False, "shape": (10**8,)}
    with zipfile.ZipFile(tmp_path / "short.npz", "w") as archive:
        for name in VECTORS:
            with archive.open(f"{name}.npy", "w") as file:
                numpy.lib.format.write_array_header_1_0(file, header)
    refuses("expected .* bytes got 0", tmp_path / "short.npz")


def test_nothing_outside_an_hdf5_file_is_followed(tmp_path: Path, small: int) -> None:
    h5py = pytest.importorskip("h5py", reason="needs the extra hdf5")
    pipe, axis = tmp_path / "p", VECTORS[1:7]
    os.mkfifo(pipe)
    elsewhere: Any = {"shape": (4,), "dtype": "f8", "external": [(str(pipe), 0, 32)]}
    large: Any = {"shape": (small,), "dtype": "f8", "chunks": (1000,), "compression": "gzip"}
    for links, data, message in (
        ({"t": h5py.SoftLink("/u"), "u": h5py.SoftLink("/t")}, {}, "missing t"),
        ({"t": h5py.ExternalLink(str(pipe), "/t")}, {}, "missing t"),
        ({"a/t": [0.0, 1.0], "b/t": [0.0, 1.0]}, {}, "column t occurs twice"),
        ({"t": [0.0]}, dict.fromkeys(axis, elsewhere), "lies in another file"),
        ({name: [0.0] for name in axis}, {"t": large}, "more than 0 GB of numbers in t"),
    ):
        with h5py.File(tmp_path / "run.h5", "w") as file:
            for name, link in links.items():
                file[name] = link
            for name, options in data.items():
                file.create_dataset(name, **options)
        refuses(message, tmp_path / "run.h5")
