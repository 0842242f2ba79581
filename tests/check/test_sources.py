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

from tests.check.conftest import VECTORS, Healthy, check, matches, refuses
from tests.conftest import Patch, Said
from tests.golden.tables import edit_cell
from tt_precise.check import sources
from tt_precise.runtime import files

AXIS = b"t,kx,ky,kz,Lx,Ly,Lz\n"


def values(source: Any, **words: Any) -> dict[str, Any]:
    """Return the checks without golden digits, which differ for 0.1 as text and as float."""
    found = check(source, "reference", **words)
    return {f.name: (f.verdict, f.value, f.at) for f in found.checks if f.name != "golden"}


def test_every_format_gives_the_same_result(
    healthy: Healthy, written: Path, tmp_path: Path, monkeypatch: Patch
) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    frame, data = healthy()[VECTORS], written.read_bytes()
    arrays: dict[str, Any] = {name: frame[name].to_numpy() for name in VECTORS}
    numpy.savez(tmp_path / "run.npz", **arrays)
    frame.to_parquet(tmp_path / "run.parquet")
    for suffix in (".json", ".arrow"):
        files.write_table(tmp_path / f"run{suffix}", {n: frame[n].tolist() for n in VECTORS})
    frame.to_csv(tmp_path / "quoted.tsv", index=False, sep="\t", quoting=1)
    rows = "\n".join(json.dumps(row) for row in frame.to_dict("records"))
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


def test_columns_that_nobody_reads_may_hold_anything(written: Path) -> None:
    header, *lines = written.read_text().splitlines()
    written.write_text("\n".join([header + ",note", *(line + ',"a, b"' for line in lines)]))
    assert check(written, "reference").passed


@pytest.mark.parametrize(
    ("column", "text", "message"),
    [
        ("kz", "abc", ", column kz: got 'abc', expected a number"),
        ("kz", "0x10", ", column kz: got '0x10', expected a number"),
        ("t", "2.97", ": t = 2.97 comes after t = 2.97, expected strictly increasing time"),
        ("t", "1", ": t = 1.0 comes after t = 2.97, expected strictly increasing time"),
        ("kz", "1,2", " has 10 cells, expected 9 cells a row"),
    ],
)
def test_a_bad_cell_is_named(
    written: Path, column: str, text: str, message: str, said: Said
) -> None:
    edit_cell(written, 300, column, lambda _: text)
    refused = said("check", written, "--scene reference", status=2)
    assert refused.count("\n") == 1
    assert f"run.csv: line 300{message}" in refused


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "got an empty file, expected a header such as t,kx"),
        (b"\n# only\n# comments\n", "got 'only', expected a header"),
        (AXIS, "got 0 rows, expected a trajectory of at least two"),
        (AXIS + b"0,0,0,1,0,0,1\n", "got 1 row"),
        (AXIS + b"0,0,0,1,0,0,1\n1,0,0\n", "line 3 has 3 cells, expected 7 cells a row"),
        (AXIS + b"0,0,0,1,0,0,1\n\n" + b"1" * 500_000, "line 4 has 1 cells"),
        (b"t;kx;ky\n0;0;0\n", "among the columns t, kx, ky; rename"),
        (b"0.0,0.1,0.2\n", "got a row of numbers, expected a header"),
        (b"<!DOCTYPE html>\n", "got HTML or XML, expected a header"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer: git lfs pull"),
        (b"\xff\xfe\x00", "can't decode byte 0xff"),
        (b"x" * 2_000_000, "got 'x{40}', expected a header"),
        (b"t,kx,ky,kz,Lx,Ly,Lz,kx\n", "column kx occurs twice"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    refuses(message, path)


def test_files_that_are_no_files(healthy: Healthy, tmp_path: Path) -> None:
    names = ("x.csv.gz", "x.parquet", "y.parquet", "x.mat", "z.csv", "z.parquet")
    cut, wrong, damaged, old, *pipes = (tmp_path / name for name in names)
    cut.write_bytes(gzip.compress(AXIS + b"0,0,0,1,0,0,1\n" * 1000)[:60])
    wrong.write_bytes(b"no parquet")
    healthy()[VECTORS].to_parquet(damaged)
    data = damaged.read_bytes()
    damaged.write_bytes(data[:200] + bytes(1000) + data[1200:])
    old.write_bytes(b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(200))
    for pipe in pipes:
        os.mkfifo(pipe)
    for source in (cut, wrong, damaged, old, "nul\0"):
        refuses("expected a trajectory file", source)
    for source in (tmp_path, *pipes):
        refuses("no regular file", source)
    for name in ("absent.csv", "absent.h5"):
        refuses(f"{name}: No such file or directory; expected a trajectory file", tmp_path / name)
    refuses("got a int, expected a path, a DataFrame or a mapping", 17)
    refuses("missing ky", {"t": [0, 1], "kx": [0]})


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(
    ("column", "text", "at"),
    [("kz", "nan", 2.98), ("kz", "-inf", 2.98), ("kz", "", 2.98), ("kz", "1e999", 2.98),
     ("t", "nan", 2.97)],
)  # fmt: skip
def test_a_simulation_that_blew_up_fails_at_its_time(
    written: Path, column: str, text: str, at: float, said: Said
) -> None:
    edit_cell(written, 300, column, lambda _: text)
    found = said("check", written, "--scene reference", status=1)
    assert "run.csv: FAIL (reference, 298 rows" in found
    result = check(written, "reference")
    assert [finding.name for finding in result.failures] == ["finite"]
    assert result["finite"].at == pytest.approx(at)
    assert "line 300" in result["finite"].note
    assert result.rows == 298
    assert check(written, "reference", until=2.9).passed
    with pytest.raises(AssertionError, match="where the checks stop"):
        matches(written, "reference", digits=8)


@pytest.mark.parametrize("row", [0, 1])
def test_a_blow_up_at_the_start_leaves_nothing_to_check(healthy: Healthy, row: int) -> None:
    frame = healthy()[VECTORS].astype(object)
    frame.loc[row, "kz"] = None
    result = check(frame, "reference", digits=8)
    assert [finding.name for finding in result.failures] == ["finite"]
    assert {finding.verdict for finding in result.checks} == {"fail", "skipped"}
    assert f"kz = nan in row {row}" in str(result)
    assert result["finite"].at == frame["t"][row]
    frame.loc[row, "t"] = None  # the time is that of the row before, or 0
    assert check(frame, "reference")["finite"].at == 0


def test_every_known_column_is_finite(healthy: Healthy) -> None:
    """Euler angles are undefined where the axis is vertical only."""
    frame = healthy("reference", 101, 1)
    frame.loc[50, "phi_dot"] = numpy.nan
    result = check(frame, "reference")
    assert (result["finite"].verdict, result["finite"].at, result.rows) == ("fail", 0.5, 101)
    poles = healthy("upright", 41, 1).assign(theta=numpy.nan)
    assert check(poles, "upright")["finite"].verdict == "pass"


def test_input_that_would_lose_something_is_refused(healthy: Healthy) -> None:
    columns = {name: healthy()[name].to_numpy() for name in VECTORS}
    kz, t = columns["kz"], columns["t"]
    dates = numpy.datetime64("2026-01-01") + (t * 1e9).astype("timedelta64[ns]")
    for name, spoilt, message in (
        ("kz", [*kz[:5], "abc", *kz[6:]], "row 5, column kz: got 'abc', expected a number"),
        ("kz", kz + 1j, "column kz: got complex128 .*, expected one real number"),
        ("kz", numpy.ma.masked_less(kz, 0), "column kz: got masked entries"),
        ("kz", kz.reshape(-1, 1), r"column kz: got float64 of shape \(801, 1\)"),
        ("kz", kz > 0, "column kz: got bool"),
        ("kz", [10**400, *kz[1:]], "row 0, column kz: got '10*', expected a number"),
        ("t", dates, r"column t: got datetime64\[ns\] .* one real number"),
        ("t", dates - dates[0], r"column t: got timedelta64\[ns\]"),
        ("t", pandas.Series(dates), r"column t: got datetime64\[ns\]"),
    ):
        assert refuses(message, {**columns, name: spoilt}).count("the table") == 1
    twice = pandas.concat([healthy(), healthy()[["kx"]]], axis=1)
    refuses("column kx occurs twice", twice)


# ---- files that claim more than they hold, or point elsewhere ----------------------------------


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> int:
    """A bound that tests reach."""
    for module in (sources, files):
        monkeypatch.setattr(module, "MOST_BYTES", 100_000)
    return 100_000


def test_archives_that_unpack_to_more_are_refused(tmp_path: Path, small: int) -> None:
    path = tmp_path / "bomb.npz"
    zeros: dict[str, Any] = dict.fromkeys(VECTORS, numpy.zeros(small))
    numpy.savez_compressed(path, **zeros)
    assert path.stat().st_size < 10_000
    refuses("bomb.npz: more than 0 GB of numbers in t", path)
    zipped = tmp_path / "bomb.csv.gz"
    zipped.write_bytes(gzip.compress(AXIS + small * b"0,0,0,1,0,0,1\n"))
    refuses("bomb.csv.gz: more than 0 GB of text", zipped)
    for name, text, message in (
        ("large.json", small * "  ", "more than 0 GB of text"),
        ("deep.json", '{"t": ' + 40_000 * "[" + 40_000 * "]" + "}", "maximum recursion depth"),
    ):
        (tmp_path / name).write_text(text)
        refuses(f"{name}: {message}", tmp_path / name)


def test_an_array_longer_than_its_member_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "short.npz"
    header = {"descr": "<f8", "fortran_order": False, "shape": (10**8,)}
    with zipfile.ZipFile(path, "w") as archive:
        for name in VECTORS:
            with archive.open(f"{name}.npy", "w") as file:
                numpy.lib.format.write_array_header_1_0(file, header)
    refuses("expected .* bytes got 0", path)


def test_nothing_outside_an_hdf5_file_is_followed(tmp_path: Path, small: int) -> None:
    h5py = pytest.importorskip("h5py", reason="needs the extra hdf5")
    pipe, circle, other, stored, large, two = (
        tmp_path / n for n in ("p", "c.h5", "o.h5", "s.h5", "bomb.h5", "two.h5")
    )
    os.mkfifo(pipe)
    with h5py.File(circle, "w") as file:
        file["t"], file["u"] = h5py.SoftLink("/u"), h5py.SoftLink("/t")
    refuses("missing t", circle)
    with h5py.File(other, "w") as file:
        file["t"] = h5py.ExternalLink(str(pipe), "/t")
    refuses("missing t", other)
    with h5py.File(stored, "w") as file:
        for name in VECTORS:
            file.create_dataset(name, shape=(4,), dtype="f8", external=[(str(pipe), 0, 32)])
    refuses("s.h5: Lx lies in another file", stored)
    with h5py.File(large, "w") as file:
        file.create_dataset("t", shape=(small,), dtype="f8", chunks=(1000,), compression="gzip")
        for name in VECTORS[1:]:
            file[name] = [0.0]
    refuses("bomb.h5: more than 0 GB of numbers in t", large)
    with h5py.File(two, "w") as file:
        file["a/t"] = file["b/t"] = [0.0, 1.0]
    refuses("column t occurs twice", two)
