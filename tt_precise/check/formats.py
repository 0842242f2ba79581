"""Files whose columns are read by name: NumPy, HDF5, MATLAB 7.3, Parquet, Arrow, JSON.

Each entry of ``READERS`` opens a file and returns its columns as a mapping. The declared size of a
file is compared with ``MOST_BYTES`` before a column is allocated. Links to other files are not
followed.
"""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy

from tt_precise.runtime.tables import MOST_BYTES, needed, too_large
from tt_precise.runtime.values import Array, Json

Columns = Mapping[str, Any]
MOST_COLUMNS = 1000  # Columns that are read of an HDF5 file; a trajectory has some twenty.
DEEPEST = 4  # groups of an HDF5 file within each other


class Named(Columns):
    """Columns of a file by name, each read on request."""

    _names: Iterable[str]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len([*self._names])


class Npz(Named):
    """The arrays of an .npz archive."""

    def __init__(self, path: Path):
        self._path = path
        with zipfile.ZipFile(path) as archive:
            self._members = {
                member.filename.removesuffix(".npy"): member for member in archive.infolist()
            }
        self._names = self._members

    def __getitem__(self, name: str) -> Array:
        member = self._members[name]
        with zipfile.ZipFile(self._path) as archive, archive.open(member) as file:
            version = numpy.lib.format.read_magic(file)
            header = numpy.lib.format.read_array_header_1_0
            if version != (1, 0):
                header = numpy.lib.format.read_array_header_2_0
            shape, _, dtype = header(file)
            size = math.prod(shape) * dtype.itemsize
            if size > MOST_BYTES or member.file_size > MOST_BYTES:
                raise ValueError(too_large(f"numbers in {name}"))
            if size > member.file_size:
                raise ValueError(f"{name} is shorter than it says")
        with numpy.load(self._path, allow_pickle=False) as arrays:
            array: Array = arrays[name]
        return array


class Hdf5(Named):
    """The data sets of an HDF5 file: at the root, or in the only group with data sets.

    A data set is read when it is asked for; one of 1 x N or N x 1 is a column.
    """

    def __init__(self, path: Path):
        self._h5py = needed("h5py")
        self._path = path
        if path.is_file() and not self._h5py.is_hdf5(path):
            raise ValueError("no HDF5 data, which MATLAB writes with save(..., '-v7.3')")
        with self._h5py.File(path, "r") as file:
            places = self._data_sets(file, "", DEEPEST)
        found = {group: names for group, names in places.items() if names}
        group = "" if "" in found else next(iter(found), "")
        if group and len(found) > 1:
            raise ValueError(f"columns in the groups {', '.join(list(found)[:8])}, and not at root")
        self._group, self._names = group, found.get(group, [])

    def _data_sets(self, group: Any, path: str, depth: int) -> dict[str, list[str]]:
        """Return the names of data sets by the path of their group, the nearest groups first."""
        names: list[str] = []
        below: dict[str, list[str]] = {}
        if len(group) > MOST_COLUMNS:
            raise ValueError(f"more than {MOST_COLUMNS} objects in one group")
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, self._h5py.ExternalLink):
                raise ValueError(f"{path}/{name} lies in another file")
            if not isinstance(link, self._h5py.HardLink):
                continue
            item = group[name]
            if isinstance(item, self._h5py.Dataset):
                names.append(name)
            elif isinstance(item, self._h5py.Group) and depth and name != "#refs#":
                below |= self._data_sets(item, f"{path}/{name}", depth - 1)
        return {path: names, **below}

    def __getitem__(self, name: str) -> Array:
        with self._h5py.File(self._path, "r") as file:
            column = file[f"{self._group}/{name}"]
            if column.external or column.is_virtual:
                raise ValueError(f"{name} lies in another file")
            if column.size is None or column.dtype.itemsize * column.size > MOST_BYTES:
                raise ValueError(too_large(f"numbers in {name}"))
            text = self._h5py.check_string_dtype(column.dtype)
            values: Array = column.asstr()[()] if text else column[()]
        if numpy.ndim(values) == 2 and 1 in numpy.shape(values):
            return numpy.ravel(values)
        return values


class Parquet(Named):
    """The columns of a Parquet file."""

    def __init__(self, path: Path):
        needed("pyarrow")
        import pyarrow.parquet

        self._open = partial(pyarrow.parquet.ParquetFile, path)
        with self._open() as file:
            self._names = list(file.schema_arrow.names)
            if 8 * file.metadata.num_rows > MOST_BYTES:
                raise ValueError(too_large("numbers"))

    def __getitem__(self, name: str) -> Array:
        with self._open() as file:
            return file.read(columns=[name]).column(name)


def _read_json(path: Path) -> Columns:
    try:
        content = json.loads(_text(path))
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if not isinstance(content, dict):
        raise ValueError("no object of columns")
    return content


def _read_json_lines(path: Path) -> Columns:
    """One JSON object a row; an entry that a row lacks is missing."""
    rows: list[dict[str, Json]] = []
    for number, line in enumerate(_text(path).splitlines(), start=1):
        if not line.strip():
            continue
        try:
            row = json.loads(line)
        except (RecursionError, ValueError):
            row = None
        if not isinstance(row, dict):
            raise ValueError(f"line {number} is no JSON object")
        rows.append(row)
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: [row.get(name) for row in rows] for name in names}


def _text(path: Path) -> str:
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(too_large("text"))
    return path.read_text("utf-8")


def _read_arrow(path: Path) -> Columns:
    needed("pyarrow")
    import pyarrow.feather

    table = pyarrow.feather.read_table(path, memory_map=True)
    if table.nbytes > MOST_BYTES:
        raise ValueError(too_large("numbers"))
    return {name: table.column(name) for name in table.column_names}


READERS: dict[str, Callable[[Path], Columns]] = {
    ".npz": Npz,
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".mat"), Hdf5),
    ".json": _read_json,
    **dict.fromkeys((".jsonl", ".ndjson"), _read_json_lines),
    ".parquet": Parquet,
    ".arrow": _read_arrow,
}
