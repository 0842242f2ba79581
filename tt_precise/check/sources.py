"""Tables of columns: CSV, Parquet, Arrow, HDF5, NumPy and JSON files, and tables in memory.

``open_table`` returns a ``Source``: the names of its columns, and the columns on request. Libraries
parse; this module adds names, the place of a bad cell, and bounds: a file must be a regular file,
and what it declares or unpacks to is compared with ``MOST_BYTES`` before it is allocated.
"""

from __future__ import annotations

import gzip
import io
import itertools
import json
import math
import os
import sys
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import KNOWN, choose_set, renamed
from tt_precise.runtime.files import MOST_BYTES, needed, too_large
from tt_precise.runtime.values import Array, Check, InputError

MOST_PREAMBLE = 50  # lines among which the header is sought
SEPARATORS = (",", ";", "\t", None)  # None stands for spaces
# What a text without a header is, by its beginning.
OTHER_TEXTS = {"version https://git-lfs": "a Git LFS pointer: git lfs pull", "<": "HTML or XML"}


@contextmanager
def _readable(where: str) -> Iterator[None]:
    """Raise ``InputError`` in place of the error of a library that cannot read a file."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # each library has its own
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        line = reason.splitlines()[0][:120]
        raise InputError(f"{where}: {line}; expected a trajectory file") from None


class Source:
    """Named columns; ``read`` returns one of them by the source's own name."""

    def __init__(
        self, where: str, names: Iterable[Any], rename: Mapping[str, str], read: Callable[..., Any]
    ):
        own = list(names)
        self.where, self._read = where, read
        self.names = renamed([str(name).strip() for name in own], rename, where)
        self._own = dict(zip(self.names, own, strict=True))

    def load(self, names: Sequence[str]) -> dict[str, Array]:
        """Return columns as float64 arrays of one length; a missing value is NaN.

        Raises ``InputError``: an entry is no number, or lengths differ.
        """
        columns = {name: self._numbers(name, cells) for name, cells in self.texts(names).items()}
        lengths = {name: len(column) for name, column in columns.items()}
        if len({*lengths.values()}) > 1:
            raise InputError(f"{self.where}: columns of different length: {lengths}")
        return columns

    def texts(self, names: Sequence[str]) -> dict[str, Any]:
        """Return columns as they are, to the last digit."""
        with _readable(self.where):
            return {name: self._read(self._own[name]) for name in names}

    def position(self, row: int) -> str:
        """Return where a row is, for a message."""
        return f"row {row}"

    def _numbers(self, name: str, values: Any) -> Array:
        masked = type(values).__name__ == "MaskedArray" and numpy.any(values.mask)
        with _readable(self.where):
            array = numpy.asarray(values)
        if masked or array.ndim != 1 or array.dtype.kind in "mMcb":
            got = "masked entries" if masked else f"{array.dtype} of shape {array.shape}"
            raise InputError(
                f"{self.where}: column {name}: got {got}, expected one real number for each row"
            )
        if array.dtype.kind in "fiu":
            return array.astype(float)
        return numpy.array([self._number(cell, row, name) for row, cell in enumerate(array)], float)

    def _number(self, cell: Any, row: int, name: str) -> float:
        try:
            return float(cell)
        except (TypeError, ValueError, OverflowError):
            text = "" if cell is None else str(cell).strip()
        if text in ("", "<NA>"):
            return math.nan
        place = f"{self.where}: {self.position(row)}, column {name}"
        raise InputError(f"{place}: got {text[:40]!r}, expected a number")


class TextSource(Source):
    """Text: lines before the header, a header with known names, and a row of cells a line.

    Cells are separated by commas, semicolons, tabs or spaces, as the header shows.
    """

    def __init__(self, where: str, data: bytes, rename: Mapping[str, str]):
        self.where, self._data = where, data
        self._header, names, self._separator = self._find_header({"time", *KNOWN, *rename})
        super().__init__(where, names, rename, self.texts)

    def load(self, names: Sequence[str]) -> dict[str, Array]:
        """Return columns as float64 arrays; an empty cell is NaN."""
        try:
            table = self._parse(names, float)
        except ValueError:  # an empty cell, or one that is no number
            return super().load(names)
        return {name: numpy.ascontiguousarray(column) for name, column in table.items()}

    def texts(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the cells of columns."""
        with _readable(self.where):
            return self._parse(names, object)

    def position(self, row: int) -> str:
        """Return the line of a row."""
        lines = enumerate(self._lines(), 1)
        rows = (number for number, line in lines if number > self._header and line.strip())
        return f"line {next(itertools.islice(rows, row, None))}"

    def _lines(self) -> Iterable[str]:
        return io.TextIOWrapper(io.BytesIO(self._data), "utf-8-sig")

    def _parse(self, names: Sequence[str], kind: type) -> dict[str, Array]:
        """Return columns of floats or of text; ``ValueError`` is numpy's."""
        if not any(map(str.strip, itertools.islice(self._lines(), self._header, None))):
            return {name: numpy.empty(0) for name in names}
        columns = [(str(i), kind if name in names else "U1") for i, name in enumerate(self.names)]
        place: Any = {"delimiter": self._separator, "skiprows": self._header, "ndmin": 1}
        table = numpy.loadtxt(self._lines(), columns, comments=None, quotechar='"', **place)
        return {name: table[str(self.names.index(name))] for name in names}

    def _find_header(self, recognised: set[str]) -> tuple[int, list[str], str | None]:
        """Return number, names and separator of the line with the most recognised names."""
        lines = [line.strip("# \n") for line in itertools.islice(self._lines(), MOST_PREAMBLE)]
        headers = [(number, [cell.strip(' "') for cell in line.split(separator)], separator)
                   for number, line in enumerate(lines, 1) for separator in SEPARATORS]  # fmt: skip
        header = max(headers, key=lambda each: len(recognised & {*each[1]}), default=None)
        if header and recognised & {*header[1]}:
            return header
        text = next(filter(None, lines), "")
        kinds = [kind for begin, kind in OTHER_TEXTS.items() if text.startswith(begin)]
        got = [*kinds, repr(text[:40])][0] if lines else "an empty file"
        raise InputError(
            f"{self.where}: got {got}, expected a header such as t,kx,ky,kz,Lx,Ly,Lz,vx,vy; rename "
            "yours with --columns theirs=ours"
        )


def open_table(source: object, rename: Mapping[str, str] | None = None) -> Source:
    """Return the table of a path, "-" (standard input), a DataFrame, a mapping or a trajectory.

    Raises ``InputError``: the source cannot be read, or has no header.
    """
    rename = rename or {}
    if isinstance(source, str | os.PathLike):
        return _open_file(os.fspath(source), rename)
    table: Any = source
    if callable(getattr(table, "frame", None)):
        table = table.frame(numbers="float")  # a Trajectory
    index = getattr(getattr(table, "index", None), "name", None)
    if index in ("t", "time") and index not in table.columns:
        table = table.reset_index()
    names = getattr(table, "column_names", None)  # of a pyarrow.Table
    if names is None:
        names = list(table) if isinstance(table, Mapping) else getattr(table, "columns", None)
    if names is None or not hasattr(table, "__getitem__"):
        raise InputError(
            f"trajectory: got a {type(source).__name__}, expected a path, a DataFrame or a mapping "
            "of columns"
        )
    return Source("the table", names, rename, table.__getitem__)


def _open_file(name: str, rename: Mapping[str, str]) -> Source:
    path, where = Path(name), "standard input" if name == "-" else name
    with _readable(where):
        if name != "-" and path.stat() and not path.is_file():  # a pipe waits for its writer
            raise OSError(0, "no regular file")
        if path.suffix in READERS:
            names, read = READERS[path.suffix](path)
            return Source(where, names, rename, read)
        stream = sys.stdin.buffer if name == "-" else path.open("rb")
        return TextSource(where, _unzipped(stream), rename)


def _unzipped(stream: Any) -> bytes:
    """Return the bytes of a stream, plain or gzipped, and close it."""
    with stream:
        data: bytes = stream.read(MOST_BYTES + 1)
    if data.startswith(b"\x1f\x8b"):
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            data = file.read(MOST_BYTES + 1)
    require_size(len(data), "text")
    return data


# ---- files whose columns have names ------------------------------------------------------------

Columns = tuple[Sequence[str], Callable[[str], Any]]  # names, and the function that reads one


def require_size(size: int, what: str) -> None:
    """Raise ``ValueError`` if a file holds more bytes than are read."""
    if size > MOST_BYTES:
        raise ValueError(too_large(what))


def _npz(path: Path) -> Columns:
    """Return the arrays of an archive; a member unpacks to no more than its declared size."""
    with zipfile.ZipFile(path) as archive:
        sizes = {each.filename.removesuffix(".npy"): each.file_size for each in archive.infolist()}

    def load(name: str) -> Array:
        require_size(sizes[name], f"numbers in {name}")
        with numpy.load(path, allow_pickle=False) as arrays:
            array: Array = arrays[name]
        return array

    return list(sizes), load


def _hdf5(path: Path) -> Columns:
    """Return the data sets of all groups; 1 x N or N x 1 is a column, as MATLAB writes it."""
    h5py = needed("h5py")
    places: list[str] = []  # links are not visited
    with h5py.File(path, "r") as file:
        file.visit(places.append)
        sets = [each for each in places if isinstance(file[each], h5py.Dataset) and each[0] != "#"]
    names = [each.rpartition("/")[2] for each in sets]

    def load(name: str) -> Array:
        with h5py.File(path, "r") as file:
            column = file[sets[names.index(name)]]
            if column.external or column.is_virtual:
                raise ValueError(f"{name} lies in another file")
            require_size((column.size or 0) * column.dtype.itemsize, f"numbers in {name}")
            text = h5py.check_string_dtype(column.dtype)
            array: Array = numpy.asarray(column.asstr()[()] if text else column[()])
        return array.ravel() if array.ndim == 2 and 1 in array.shape else array

    return names, load


def _arrow(path: Path) -> Columns:
    needed("pyarrow")
    from pyarrow import dataset

    table = dataset.dataset(path, format="parquet" if path.suffix == ".parquet" else "feather")
    require_size(8 * table.count_rows(), "numbers")
    return table.schema.names, lambda name: table.to_table(columns=[name]).column(name)


def _json(path: Path) -> Columns:
    """Return an object of columns, or the columns of one object a line."""
    require_size(path.stat().st_size, "text")
    text = path.read_text("utf-8")
    if path.suffix == ".json":
        content = json.loads(text)
    else:
        rows = [json.loads(line) for line in text.splitlines() if line.strip()]
        names = dict.fromkeys(name for row in rows for name in row)
        content = {name: [row.get(name) for row in rows] for name in names}
    return list(content), content.__getitem__


# The columns of a file by its suffix; every other file is text.
READERS: dict[str, Callable[[Path], Columns]] = {
    ".npz": _npz,
    **dict.fromkeys((".parquet", ".arrow", ".feather"), _arrow),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".mat"), _hdf5),
    **dict.fromkeys((".json", ".jsonl", ".ndjson"), _json),
}  # fmt: skip


# ---- the rows that can be checked --------------------------------------------------------------


class FileRows(NamedTuple):
    """The columns of the rows that can be checked, the check ``finite``, the first time (s)."""

    columns: dict[str, Array]
    finite: Check
    t_first: float


@numpy.errstate(invalid="ignore")
def read_rows(table: Source, cutoff: float = math.inf) -> FileRows:
    """Return the leading rows up to the time ``cutoff`` (s) whose state is finite.

    Euler angles are undefined where the axis is vertical, and may be missing there.

    Raises ``InputError``: there are fewer than two rows, or time does not increase.
    """
    chosen = choose_set(table.names, table.where)
    columns = table.load([name for name in table.names if name in KNOWN])
    upto = _rows_until(columns["t"], cutoff)
    columns = {name: values[:upto] for name, values in columns.items()}
    broken = {name: ~numpy.isfinite(values) for name, values in columns.items()}
    state = [broken[name] for name in columns if name in ("t", *chosen.names)]
    count = int(numpy.argmax(numpy.append(numpy.any(state, axis=0), True)))
    tilt = [columns[name] != 0 for name in ("kx", "ky") if name in columns]
    for name in {*columns} - {"t", *chosen.names}:
        broken[name] &= numpy.any(tilt, axis=0) if tilt else True
    finite = _finiteness(table, columns, broken, count)
    if count < 2 and finite.holds:
        until = f" up to t = {cutoff:g} s" * (cutoff < math.inf)
        raise InputError(
            f"{table.where}: got {count} rows{until}, expected a trajectory of at least two"
        )
    columns = {name: values[:count] for name, values in columns.items()}
    t = columns["t"]
    back = numpy.flatnonzero(~(numpy.diff(t) > 0))
    if len(back):
        before, here = t[back[0] : back[0] + 2].tolist()
        raise InputError(
            f"{table.where}: {table.position(int(back[0]) + 1)}: t = {here!r} comes after "
            f"t = {before!r}, expected strictly increasing time"
        )
    return FileRows(columns, finite, float(t[0]) if count else 0.0)


def _rows_until(t: Array, cutoff: float) -> int:
    """Return the number of rows up to a time; NaN that fill up a table come after its last time."""
    count = int(numpy.logical_and.accumulate(t <= cutoff).sum())
    rest = t[count:]
    complete = count > 1 and 2 * t[count - 1] - t[count - 2] > cutoff
    padded = complete and numpy.isnan(rest).all()
    return count if padded or (rest[:1] > cutoff).any() else len(t)


def _finiteness(
    table: Source, columns: Mapping[str, Array], broken: Mapping[str, Array], count: int
) -> Check:
    """Return the check of the numbers up to row ``count``, the first broken state."""
    meaning = "every column holds finite numbers, except Euler angles where they are undefined"
    wrong = numpy.flatnonzero(numpy.any([*broken.values()], axis=0)[: count + 1])
    if not len(wrong):
        return Check("finite", "pass", 0.0, 0.0, meaning=meaning)
    row = int(wrong[0])
    name = next(name for name in columns if broken[name][row])
    note = f"{name} = {columns[name][row]} in {table.position(row)}"
    note += ", where the checks stop" if row == count else ""
    t = columns["t"][: row + 1]
    times = t[numpy.isfinite(t)]
    at = float(times[-1] - times[0]) if len(times) else 0.0
    return Check("finite", "fail", float(len(wrong)), 0.0, at, note, meaning, since=at)
