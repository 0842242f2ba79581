"""Files that claim more than they hold, or point elsewhere: one line, before anything is read."""

import gzip
import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy
import pytest

from tests.check.conftest import VECTORS, Healthy, check, refuses
from tt_precise.check import formats, sources
from tt_precise.runtime import tables


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> int:
    """A bound that tests reach."""
    for module in (formats, sources, tables):
        monkeypatch.setattr(module, "MOST_BYTES", 100_000)
    return 100_000


def test_archives_that_unpack_to_more_are_refused(tmp_path: Path, small: int) -> None:
    path = tmp_path / "bomb.npz"
    zeros: dict[str, Any] = dict.fromkeys(VECTORS, numpy.zeros(small))
    numpy.savez_compressed(path, **zeros)
    assert path.stat().st_size < 10_000
    refuses("bomb.npz: more than 0 GB of numbers in t", path)
    zipped = tmp_path / "bomb.csv.gz"
    zipped.write_bytes(gzip.compress(b"t,kx,ky,kz,Lx,Ly,Lz\n" + small * b"0,0,0,1,0,0,1\n"))
    refuses("bomb.csv.gz: more than 0 GB of text", zipped)


def test_an_array_longer_than_its_member_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "short.npz"
    header = {"descr": "<f8", "fortran_order": False, "shape": (10**8,)}
    with zipfile.ZipFile(path, "w") as archive:
        for name in VECTORS:
            with archive.open(f"{name}.npy", "w") as file:
                numpy.lib.format.write_array_header_1_0(file, header)
    refuses("t is shorter than it says", path)


def test_json_that_is_nested_deeply_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "deep.json"
    path.write_text('{"t": ' + 200_000 * "[" + 200_000 * "]" + "}")
    refuses("deep.json: nested too deeply", path)
    lines = tmp_path / "deep.jsonl"
    lines.write_text('{"t": 0}\n' + 200_000 * "[" + "\n")
    refuses("line 2 is no JSON object", lines)


def test_json_lines_are_rows(healthy: Healthy, tmp_path: Path) -> None:
    frame = healthy("reference", 81, 0.8)[VECTORS]
    path = tmp_path / "run.jsonl"
    path.write_text("\n".join(json.dumps(row) for row in frame.to_dict("records")))
    assert check(path, "reference").passed


h5py = pytest.importorskip("h5py", reason="needs the extra hdf5")


def test_a_data_set_larger_than_the_bound_is_refused(tmp_path: Path, small: int) -> None:
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("t", shape=(small,), dtype="f8", chunks=(1000,), compression="gzip")
        for name in VECTORS[1:]:
            file[name] = [0.0]
    refuses("bomb.h5: more than 0 GB of numbers in t", path)


def test_nothing_outside_the_file_is_followed(tmp_path: Path) -> None:
    pipe, circle, other, stored = (tmp_path / n for n in ("p", "c.h5", "o.h5", "s.h5"))
    os.mkfifo(pipe)
    with h5py.File(circle, "w") as file:
        file["t"] = h5py.SoftLink("/u")
        file["u"] = h5py.SoftLink("/t")
    refuses("no column t", circle)
    with h5py.File(other, "w") as file:
        file["t"] = h5py.ExternalLink(str(pipe), "/t")
    refuses("o.h5: /t lies in another file", other)
    with h5py.File(stored, "w") as file:
        for name in VECTORS:
            file.create_dataset(name, shape=(4,), dtype="f8", external=[(str(pipe), 0, 32)])
    refuses("s.h5: t lies in another file", stored)


def test_columns_in_two_groups_are_not_guessed(tmp_path: Path) -> None:
    path = tmp_path / "two.h5"
    with h5py.File(path, "w") as file:
        file["a/t"] = file["b/t"] = [0.0, 1.0]
    refuses("columns in the groups /a, /b, and not at root", path)


def test_an_older_file_of_matlab_is_named(tmp_path: Path) -> None:
    path = tmp_path / "old.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(200))
    said = refuses("old.mat: no HDF5 data, which MATLAB writes with save", path)
    assert said.endswith("expected a .mat file")
