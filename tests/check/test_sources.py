"""Every format gives the same rows; what cannot be used ends in one line that says where."""

import gzip
import io
import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pandas
import pytest

from tests.check.conftest import VECTORS, Healthy, check, refuses
from tests.conftest import Patch, Said
from tests.golden.tables import edit_cell
from tt_precise.check import sources
from tt_precise.runtime.tables import write_table


def values(source: Any, **words: Any) -> dict[str, Any]:
    """Return the findings without golden digits, which differ for 0.1 as text and as float."""
    found = check(source, "reference", **words)
    return {f.name: (f.verdict, f.value, f.at) for f in found.checks if f.name != "golden"}


def test_every_format_gives_the_same_result(
    healthy: Healthy, written: Path, tmp_path: Path, monkeypatch: Patch
) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    frame = healthy()[VECTORS]
    zipped, commented, crlf = (tmp_path / name for name in ("run.csv.gz", "# .csv", "crlf.csv"))
    zipped.write_bytes(gzip.compress(written.read_bytes()))
    frame.to_parquet(tmp_path / "run.parquet")
    for suffix in (".json", ".arrow"):
        write_table(tmp_path / f"run{suffix}", dict(frame.astype(object)))
    arrays: dict[str, Any] = {name: frame[name].to_numpy() for name in VECTORS}
    numpy.savez(tmp_path / "run.npz", **arrays)
    text = written.read_text().replace("t,", "time,", 1)
    commented.write_text("# my engine, version 2\n# SI\n" + text)
    crlf.write_bytes(b"\xef\xbb\xbf# " + written.read_bytes().replace(b"\n", b"\r\n") + b"\r\n\r\n")
    expected = values(frame)
    for source in (
        written,
        str(zipped),
        crlf,
        commented,
        arrays,
        frame.astype(str),
        frame.astype(object),
        *(tmp_path / f"run{suffix}" for suffix in (".json", ".arrow", ".npz", ".parquet")),
        pyarrow.table(frame),
    ):
        assert values(source) == expected, source
    for piped in (written, zipped):
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(piped.read_bytes())))
        assert values("-") == expected
    assert values(frame.rename(columns={"kx": 0}), columns={"0": "kx"}) == expected


def test_small_blocks_change_nothing(healthy: Healthy, written: Path, monkeypatch: Patch) -> None:
    whole = check(written, "reference")
    monkeypatch.setattr(sources, "BLOCK_BYTES", 20_000)
    for source in (written, healthy()[VECTORS]):
        split = check(source, "reference")
        for one, other in zip(whole.checks, split.checks, strict=True):
            assert one.verdict == other.verdict
            if one.value is not None and other.value is not None:
                # sums over the rows are added up in another order
                assert one.value == pytest.approx(other.value, rel=0.2, abs=1e-14)
        assert split.rows == 801


def test_columns_that_nobody_reads_may_hold_anything(written: Path) -> None:
    header, *lines = written.read_text().splitlines()
    written.write_text("\n".join([header + ",note", *(line + ',"a, b"' for line in lines)]))
    assert check(written, "reference").passed


@pytest.mark.parametrize(
    ("column", "text", "message"),
    [
        ("kz", "abc", ", column kz: got 'abc', expected a number"),
        ("kz", "1_0", ", column kz: got '1_0', expected a number"),
        ("kz", "\u0660.\u0661", ", column kz: got '\u0660.\u0661', expected a number"),
        ("kz", "0x10", ", column kz: got '0x10', expected a number"),
        ("kz", "1e999", ", column kz: got '1e999', expected a number within the range"),
        ("t", "2.97", ": t = 2.97 occurs twice, expected strictly increasing time"),
        ("t", "1", ": t = 1.0 comes after t = 2.97, expected strictly increasing time"),
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
        (b"", "it is empty, expected a header line"),
        (b"\n\n", "it is empty"),
        (b"t,kx,ky,kz,Lx,Ly,Lz,vx,vy\n", "got no rows, expected a trajectory of at least two"),
        (b"t,kx,ky,kz,Lx,Ly,Lz,vx,vy\n0,0,0,1,0,0,1,0,0\n", "got one row"),
        (b"t,kx,ky,kz,Lx,Ly,Lz\n0,0,0,1,0,0,1\n1,0,0\n", "line 3 has 3 cells, expected 7"),
        (b"t;kx;ky\n0;0;0\n", "among the columns t, kx, ky; rename"),
        (b"t\tkx\n", "among the columns t, kx; rename"),
        (b"t kx\n0 1\n", "among the columns t, kx; rename"),
        (b"0.0,0.1,0.2\n", "no header line: line 1 has 3 numbers"),
        (b"Take,top\n\nt,kx\n0,1\n", "line 3 looks like the header, expected it first"),
        (b'{"t": 0}\n', "line 1 is JSON, expected CSV"),
        (b"\xff\xfe\x00", "not UTF-8 text, expected CSV"),
        (b"x" * 2_000_000, "no end of its first line"),
        (b"t,kx,ky,kz,Lx,Ly,Lz\n" + b"1" * 5_000_000, "line 2 is longer than 1000000 bytes"),
        (b"t,kx,ky,kz,Lx,Ly,Lz,kx\n", "column kx occurs twice"),
        (b"t,kx,ky,kz,Lx,Ly,Lz\n0,a\rb,0\n", "line 2: its lines end in bare"),
        (b"t,kx\rky,kz\n", "line 1: its lines end in bare"),
        (b"t,kx\r0,1\r1,1\r", "line 1: its lines end in bare carriage returns"),
        (b"t,qpos0,qpos1\n0,1,1\n", 'qpos0 ... are an engine.s own state: .*engine="mujoco"'),
        (b"# only\n# comments\n", "it is empty, expected a header line"),
    ],
)
def test_a_bad_file_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    refuses(message, path)


def test_no_rows_up_to_a_time_are_refused(healthy: Healthy) -> None:
    refuses("got no rows up to t = 1 s, expected", healthy()[VECTORS].head(0), until=1.0)


def test_files_that_are_no_files(healthy: Healthy, tmp_path: Path) -> None:
    broken, cut, wrong, damaged, pipe = (
        tmp_path / name
        for name in ("x.csv.gz", "cut.csv.gz", "x.parquet", "y.parquet", "z.parquet")
    )
    broken.write_bytes(b"no gzip")
    cut.write_bytes(gzip.compress(b"t,kx,ky,kz,Lx,Ly,Lz\n" + b"0,0,0,1,0,0,1\n" * 1000)[:60])
    wrong.write_bytes(b"no parquet")
    healthy()[VECTORS].to_parquet(damaged)
    data = damaged.read_bytes()
    damaged.write_bytes(data[:200] + bytes(1000) + data[1200:])
    os.mkfifo(pipe)
    for source, message in (
        (tmp_path / "absent.csv", "No such file or directory; expected a trajectory file"),
        (tmp_path / "absent.h5", "absent.h5: No such file or directory; expected a trajectory"),
        (tmp_path, "Is a directory"),
        (broken, "expected a readable file"),
        (cut, "expected a readable file"),
        (wrong, "expected a .parquet file"),
        (damaged, "expected a .parquet file"),
        (pipe, "no regular file"),
        ("nul\0", "expected a trajectory file"),
        (17, "got a int, expected a path, a DataFrame or a mapping"),
        ({"t": [0, 1], "kx": [0]}, "columns"),
    ):
        refuses(message, source)


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(
    ("column", "text", "at"),
    [("kz", "nan", 2.98), ("kz", "-inf", 2.98), ("kz", "", 2.98), ("t", "nan", 2.97)],
)
def test_a_simulation_that_blew_up_fails_at_its_time(
    written: Path, column: str, text: str, at: float, said: Said
) -> None:
    edit_cell(written, 300, column, lambda _: text)
    found = said("check", written, "--scene reference", status=1)
    assert "run.csv: FAIL (reference, 298 rows" in found
    result = check(written, "reference", digits=8)
    assert [finding.name for finding in result.failures] == ["finite", "golden"]
    assert result["finite"].at == pytest.approx(at)
    assert "line 300" in result["finite"].note
    assert result.rows == 298
    assert check(written, "reference", until=2.9).passed


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


def test_rows_of_another_length_are_refused(written: Path) -> None:
    lines = written.read_text().splitlines()
    for spoiled, message in (
        ([*lines[:9], lines[9] + ",0", *lines[10:]], "line 10 has 10 cells, expected 9"),
        ([lines[0], "\v".join(lines[1:])], "cells, expected 9 as in the header"),
    ):
        written.write_text("\n".join(spoiled))
        refuses(message, written)
    written.write_text("\n".join([*lines[:5], ""]))
    assert check(written, "reference").rows == 4


def test_input_that_would_lose_something_is_refused(healthy: Healthy) -> None:
    columns = {name: healthy()[name].to_numpy() for name in VECTORS}
    kz, t = columns["kz"], columns["t"]
    dates = numpy.datetime64("2026-01-01") + (t * 1e9).astype("timedelta64[ns]")
    for name, values, message in (
        ("kz", [*kz[:5], "abc", *kz[6:]], "row 5, column kz: got 'abc', expected a number"),
        ("kz", kz + 1j, "column kz: got complex128, expected real numbers"),
        ("kz", numpy.ma.masked_less(kz, 0), "column kz: got masked entries"),
        ("kz", kz.reshape(-1, 1), r"column kz: got an array of shape \(801, 1\)"),
        ("kz", kz > 0, "column kz: got bool, expected real numbers"),
        ("kz", [10**400, *kz[1:]], "row 0, column kz: got '10*', expected a number"),
        ("t", dates, r"column t: got datetime64\[ns\], expected seconds as a number"),
        ("t", dates - dates[0], r"column t: got timedelta64\[ns\], expected seconds"),
        ("t", pandas.Series(dates), r"column t: got datetime64\[ns\], expected seconds"),
    ):
        assert refuses(message, {**columns, name: values}).count("the table") == 1
    twice = pandas.concat([healthy(), healthy()[["kx"]]], axis=1)
    refuses("column kx occurs twice", twice)
