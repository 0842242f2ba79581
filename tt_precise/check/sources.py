"""Tables of columns: CSV, Parquet, Arrow, HDF5, NumPy and JSON files, and tables in memory.

``open_table`` returns a ``Source``: the names of its columns, and the columns on request. Libraries
parse; this module adds names, the place of a bad cell, and bounds: a file must be a regular file,
and what it declares or unpacks to is compared with ``MOST_BYTES`` before it is allocated.
"""

from __future__ import annotations

import csv
import io
import itertools
import json
import math
import os
import re
import sys
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import ENGINES_OWN, KNOWN, choose_set, renamed
from tt_precise.runtime.files import MOST_BYTES, needed, too_large
from tt_precise.runtime.values import Array, Check, InputError

LONGEST_HEADER = 1_000_000  # characters among which the header is sought
MOST_PREAMBLE = 50  # lines among which the header is sought
LINE = re.compile(r"[^\n]*\S[^\n]*")
NUMBER = re.compile(r"[-+.\deE]+|nan")
SEPARATORS = (",", ";", "\t", None)  # None stands for spaces
GZIPPED = b"\x1f\x8b"
MISSING = ("", "nan", "na", "n/a", "null", "none", "<na>")
# What text without a header is, by its beginning.
OTHER_TEXTS = {
    "version https://git-lfs": "a Git LFS pointer, expected the table itself: git lfs pull",
    "<": "HTML or XML, expected CSV",
    "{": "JSON, expected a name that ends in .json (an object of columns) or .jsonl (rows)",
}
# Each library has its own errors for a broken file.
BROKEN = (OSError, ValueError, TypeError, KeyError, AttributeError, RuntimeError, EOFError,
          zipfile.BadZipFile, zlib.error)  # fmt: skip


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
        try:
            return {name: self._read(self._own[name]) for name in names}
        except BROKEN as error:
            raise unreadable(self.where, error) from None

    def position(self, row: int) -> str:
        """Return where a row is, for a message."""
        return f"row {row}"

    def _numbers(self, name: str, values: Any) -> Array:
        masked = type(values).__name__ == "MaskedArray" and numpy.any(values.mask)
        array = numpy.asarray(values)
        if masked or array.ndim != 1 or array.dtype.kind in "mMcb":
            got = "masked entries" if masked else f"{array.dtype} of shape {array.shape}"
            raise InputError(
                f"{self.where}: column {name}: got {got}, expected one real number for each row"
                + " (seconds, such as (t - t[0]) / numpy.timedelta64(1, 's'))" * (name == "t")
            )
        if array.dtype.kind in "fiu":
            return array.astype(float)
        return numpy.array([self._number(cell, row, name) for row, cell in enumerate(array)], float)

    def _number(self, cell: Any, row: int, name: str) -> float:
        """Return the number in a cell, NaN where it is missing.

        Raises ``InputError``: it is no number, or none that a double holds.
        """
        text = "" if cell is None else str(cell).strip()
        if text.lower() in MISSING:
            return math.nan
        try:
            if "_" not in text and text.isascii():  # float reads the digits of every script
                return float(text if isinstance(cell, str) else cell)
        except (TypeError, ValueError, OverflowError):
            pass
        place = f"{self.where}: {self.position(row)}, column {name}"
        raise InputError(f"{place}: got {text[:40]!r}, expected a number")


class TextSource(Source):
    """Text with one header line, and comments above the header.

    Cells are separated by commas, semicolons, tabs or spaces, as the header shows.
    """

    def __init__(self, where: str, data: Callable[[], bytes], rename: Mapping[str, str]):
        self.where, self._data = where, data
        self._begin = 0  # characters before the first row
        names, self._separator = self._header({"time", *KNOWN, *rename})
        super().__init__(where, names, rename, self.texts)

    @cached_property
    def text(self) -> str:
        """The whole text; read again where it is needed after the numbers."""
        try:
            text = self._data().decode("utf-8-sig")
        except UnicodeDecodeError:
            raise InputError(f"{self.where}: not UTF-8 text, expected CSV") from None
        return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text

    def load(self, names: Sequence[str]) -> dict[str, Array]:
        """Return columns as float64 arrays; a missing value is NaN."""
        if next(self._lines(), None) is None:
            return {name: numpy.empty(0) for name in names}
        lines = map(re.Match.group, self._lines())
        try:
            table = numpy.loadtxt(
                lines, delimiter=self._separator, comments=None, quotechar='"', ndmin=2
            )
        except ValueError:  # a missing value, or a cell that nobody needs
            table = numpy.empty((0, 0))
        if table.shape[1] == len(self.names):
            del self.text  # as large as the numbers, and rarely needed again
            return {n: numpy.ascontiguousarray(table[:, self.names.index(n)]) for n in names}
        return super().load(names)

    def texts(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the cells of columns.

        Raises ``InputError``: a row has more or fewer cells than the header.
        """
        indices = [self.names.index(name) for name in names]
        columns: list[list[str]] = [[] for _ in names]
        for row, line in enumerate(self._lines()):
            cells = split(line.group(), self._separator)
            if len(cells) != len(self.names):
                cut = " (was the file cut off?)" if len(cells) < len(self.names) else ""
                raise InputError(
                    f"{self.where}: {self.position(row)} has {len(cells)} cells, expected "
                    f"{len(self.names)} as in the header{cut}"
                )
            for column, index in zip(columns, indices, strict=True):
                column.append(cells[index])
        return dict(zip(names, columns, strict=True))

    def position(self, row: int) -> str:
        """Return the line of a row."""
        start = next(itertools.islice(self._lines(), row, None)).start()
        return f"line {self.text.count(chr(10), 0, start) + 1}"

    def _lines(self) -> Iterator[re.Match[str]]:
        """Yield the lines behind the header that are not empty."""
        return LINE.finditer(self.text, self._begin)

    def _header(self, recognised: set[str]) -> tuple[list[str], str | None]:
        """Return the names in the first line that is no comment, and their separator."""
        separators: Sequence[str | None] = SEPARATORS
        first: tuple[list[str], str | None] | None = None
        lines = self.text[:LONGEST_HEADER].split("\n")[:MOST_PREAMBLE]
        for number, line in enumerate(lines, 1):
            self._begin += len(line) + 1
            text = line.strip()
            if text.lower().startswith("sep=") and len(text) == 5:  # the first line of Excel
                separators = (text[4],)
                continue
            splits = [(split(text.lstrip("# "), mark), mark) for mark in separators]
            header = max(splits, key=lambda one: (len(recognised & {*one[0]}), len(one[0]) > 1))
            names = header[0]
            ours = len(recognised & {*names}) + any(map(ENGINES_OWN.fullmatch, names))
            if ours and first is None:
                return header
            if ours > 1:
                raise InputError(
                    f"{self.where}: line {number} looks like the header, expected it first: delete "
                    "the lines before it, or begin them with #"
                )
            if text and not text.startswith("#") and first is None:
                first = header
                other = [kind for mark, kind in OTHER_TEXTS.items() if text.startswith(mark)]
                if len(names) > 1 and all(map(NUMBER.fullmatch, names)):
                    other = [f"{len(names)} numbers, expected the names of the columns first"]
                if other:
                    raise InputError(f"{self.where}: no header: line {number} is {other[0]}")
        if first is None:
            raise InputError(
                f"{self.where}: it is empty, expected a header line and rows of numbers"
            )
        return first


def split(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line; None stands for spaces."""
    if separator is None:
        return line.split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error:  # a cell of more than 131,072 characters
        return [line]


def unreadable(where: str, error: Exception) -> InputError:
    """Return the error for a file that its library cannot read."""
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    suffix = Path(where).suffix
    kind = f"{suffix} file" if suffix in READERS else "trajectory file"
    return InputError(f"{where}: {reason.splitlines()[0][:120]}; expected a {kind}")


def open_table(source: object, rename: Mapping[str, str] | None = None) -> Source:
    """Return the table of a path, "-" (standard input), a DataFrame, a mapping or a trajectory.

    Raises ``InputError``: the source cannot be read, or has no header.
    """
    rename = rename or {}
    if isinstance(source, Source):
        return source
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
    try:
        if name == "-":
            data = _unzipped(sys.stdin.buffer)
            return TextSource(where, lambda: data, rename)
        path.stat()
        if not path.is_file():  # opening a pipe waits for its writer
            raise OSError(0, "no regular file")
        if path.suffix in READERS:
            names, read = READERS[path.suffix](path)
            return Source(where, names, rename, read)
        return TextSource(where, lambda: _unzipped(path.open("rb")), rename)
    except InputError:
        raise
    except BROKEN as error:
        raise unreadable(where, error) from None


def _unzipped(stream: Any) -> bytes:
    """Return the bytes of a stream, plain or gzipped, and close it."""
    with stream:
        data: bytes = stream.read(MOST_BYTES + 1)
    if data.startswith(GZIPPED):
        import gzip

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
    """Return the arrays of an archive, whose headers say their sizes."""
    archive = zipfile.ZipFile(path)
    members = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}

    def load(name: str) -> Array:
        stored = members[name].file_size
        with archive.open(members[name]) as file:
            version = numpy.lib.format.read_magic(file)[0]
            header = getattr(numpy.lib.format, f"read_array_header_{version}_0")
            shape, _, dtype = header(file)
            size = math.prod(shape) * dtype.itemsize
            require_size(max(size, stored), f"numbers in {name}")
            if size > stored:
                raise ValueError(f"{name} is shorter than it says")
        with numpy.load(path, allow_pickle=False) as arrays:
            array: Array = arrays[name]
        return array

    return list(members), load


def _hdf5(path: Path) -> Columns:
    """Return the data sets at the root, or in the only group that has some.

    Links are not followed. A data set of 1 x N or N x 1 is a column, as MATLAB writes it.
    """
    h5py = needed("h5py")
    if not h5py.is_hdf5(path):
        raise ValueError("no HDF5 data, which MATLAB writes with save(..., '-v7.3')")
    groups: dict[str, list[str]] = {}

    def visit(name: str, item: Any) -> None:
        group, _, column = f"/{name}".rpartition("/")
        if isinstance(item, h5py.Dataset) and not name.startswith("#refs#"):
            groups.setdefault(group, []).append(column)

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    group = "" if "" in groups else next(iter(groups), "")
    if group and len(groups) > 1:
        raise ValueError(f"columns in the groups {', '.join([*groups][:8])}, and not at root")

    def load(name: str) -> Array:
        with h5py.File(path, "r") as file:
            column = file[f"{group}/{name}"]
            if column.external or column.is_virtual:
                raise ValueError(f"{name} lies in another file")
            require_size((column.size or 0) * column.dtype.itemsize, f"numbers in {name}")
            text = h5py.check_string_dtype(column.dtype)
            array: Array = numpy.asarray(column.asstr()[()] if text else column[()])
        return array.ravel() if array.ndim == 2 and 1 in array.shape else array

    return groups.get(group, []), load


def _parquet(path: Path) -> Columns:
    needed("pyarrow")
    import pyarrow.parquet

    file = pyarrow.parquet.ParquetFile(path)
    require_size(8 * file.metadata.num_rows, "numbers")
    return file.schema_arrow.names, lambda name: file.read(columns=[name]).column(name)


def _arrow(path: Path) -> Columns:
    needed("pyarrow")
    import pyarrow.feather

    table = pyarrow.feather.read_table(path, memory_map=True)
    require_size(table.nbytes, "numbers")
    return table.column_names, table.column


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
    ".npz": _npz, ".parquet": _parquet, ".json": _json,
    **dict.fromkeys((".arrow", ".feather"), _arrow),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".mat"), _hdf5),
    **dict.fromkeys((".jsonl", ".ndjson"), _json),
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
    own = [name for name in columns if name in ("t", *chosen.names)]
    upto = _last_row(columns["t"], cutoff)
    columns = {name: values[:upto] for name, values in columns.items()}
    broken = {name: ~numpy.isfinite(values) for name, values in columns.items()}
    count = int(numpy.argmax(numpy.append(numpy.any([broken[n] for n in own], axis=0), True)))
    tilt = [columns[name] != 0 for name in ("kx", "ky") if name in columns]
    for name in {*columns} - {*own}:
        broken[name] &= numpy.any(tilt, axis=0) if tilt else True
    finite = _finiteness(table, columns, broken, count)
    t = columns["t"][:count]
    if count < 2 and finite.holds:
        rows, end = "one row" if count else "no rows", f" up to t = {cutoff:g} s"
        raise InputError(
            f"{table.where}: got {rows}{end if cutoff < math.inf else ''}, expected a trajectory "
            "of at least two"
        )
    back = numpy.flatnonzero(~(numpy.diff(t) > 0))
    if len(back):
        before, here = t[back[0] : back[0] + 2].tolist()
        order = "occurs twice" if here == before else f"comes after t = {before!r}"
        raise InputError(
            f"{table.where}: {table.position(int(back[0]) + 1)}: t = {here!r} {order}, expected "
            "strictly increasing time"
        )
    columns = {name: values[:count] for name, values in columns.items()}
    return FileRows(columns, finite, float(t[0]) if count else 0.0)


def _finiteness(
    table: Source, columns: Mapping[str, Array], broken: Mapping[str, Array], count: int
) -> Check:
    """Return the check of the numbers up to row ``count``, the first broken state."""
    meaning = "every column holds finite numbers, except Euler angles where they are undefined"
    wrong = numpy.any([*broken.values()], axis=0)[: count + 1]
    if not wrong.any():
        return Check("finite", "pass", 0.0, 0.0, meaning=meaning)
    row = int(numpy.argmax(wrong))
    name = next(name for name in columns if broken[name][row])
    note = f"{name} = {columns[name][row]} in {table.position(row)}"
    note += ", where the checks stop" if row == count else ""
    times = columns["t"][: row + 1][numpy.isfinite(columns["t"][: row + 1])]
    at = float(times[-1] - times[0]) if len(times) else 0.0
    value = float(wrong.sum())
    return Check("finite", "fail", value, 0.0, at, note, meaning, since=at)


def _last_row(t: Array, cutoff: float) -> int:
    """Return the number of rows up to a time; NaN behind the last one only fill up the table."""
    beyond = numpy.flatnonzero(~(t <= cutoff))
    if cutoff == math.inf or not len(beyond):
        return len(t)
    count = int(beyond[0])
    # less than one row is missing up to the time
    whole = count > 1 and t[count - 1] + 1.5 * (t[count - 1] - t[count - 2]) >= cutoff
    padded = whole and numpy.isnan(t[count:]).all()
    return count if t[count] > cutoff or padded else len(t)
