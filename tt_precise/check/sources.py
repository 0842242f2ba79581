"""Trajectories as blocks of rows: CSV, gzipped CSV, standard input, Parquet, tables in memory.

The checks receive a ``Block``, independent of its source; of a long file only one block is in
memory. Every reason why a trajectory is unusable (text in a number, dates, time that does not
increase) gives one line that names file and line.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import os
import sys
import zlib
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import Block, Reading, renamed
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError


class RowSource:
    """A source of blocks: its column names after renaming, and its origin.

    ``otherwise`` has further readings of its first rows, by what each supposes.
    """

    otherwise: Mapping[str, Reading] = MappingProxyType({})

    def __init__(self, where: str, names: Sequence[str], rename: Mapping[str, str]):
        self.where = where
        self.names = renamed([name.strip() for name in names], rename, where)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        """The columns as arrays, block by block; can be read once.

        Missing values are NaN. In the columns ``also``, text that is not a number is NaN too.
        """
        raise NotImplementedError

    def close(self) -> None:
        """Close the file, if there is one."""


class NotFinite(NamedTuple):
    """The first row without a finite number in a wanted column: time (s), value, place."""

    t: float
    column: str
    value: float
    place: str

    def __str__(self) -> str:
        return f"{self.column} = {self.value} in {self.place}"


class UsableRows:
    """The blocks of a source up to time ``until`` and up to the first row that is not finite.

    Iterating raises ``InputError`` if time does not increase. Afterwards ``broken`` is the first
    row that is not finite, if any.
    """

    def __init__(
        self, blocks: Iterator[Block], wanted: Sequence[str], where: str, until: float = math.inf
    ):
        self._blocks, self._wanted, self._where, self._until = blocks, wanted, where, until
        self.broken: NotFinite | None = None

    def __iter__(self) -> Iterator[Block]:
        before = -math.inf
        for given in self._blocks:
            beyond = numpy.flatnonzero(given.values["t"] > self._until)
            block = given.head(int(beyond[0])) if len(beyond) else given
            block = self._finite(block, before)
            self._require_rising(block, before)
            if len(block):
                before = float(block.values["t"][-1])
                yield block
            if len(beyond) or self.broken:
                return

    def _finite(self, block: Block, before: float) -> Block:
        finite = numpy.all([numpy.isfinite(block.values[name]) for name in self._wanted], axis=0)
        if finite.all():
            return block
        row = int(numpy.argmin(finite))
        t = block.values["t"]
        name = next(name for name in self._wanted if not math.isfinite(block.values[name][row]))
        # a row without a time is identified by the previous row
        times = [float(t[row]), float(t[row - 1]) if row else before]
        at = next((time for time in times if math.isfinite(time)), 0.0)
        self.broken = NotFinite(at, name, float(block.values[name][row]), block.place(row))
        return block.head(row)

    def _require_rising(self, block: Block, before: float) -> None:
        t = block.values["t"]
        wrong = numpy.flatnonzero(~(numpy.diff(t, prepend=before) > 0))
        if len(wrong):
            row = int(wrong[0])
            previous = float(t[row - 1]) if row else before
            raise InputError(
                f"{self._where}: {block.place(row)}: t = {float(t[row])!r} "
                + ("occurs twice" if t[row] == previous else f"comes after t = {previous!r}")
                + ", expected strictly increasing time"
            )


SHOWN = 40  # characters of a bad cell
INFINITIES = ("inf", "infinity")
MISSING = ("", "nan", "na", "n/a", "null", "none", "<na>")


def number(value: Any, *, strict: bool) -> float:
    """The number in a cell (text, or a number of any kind); NaN if there is none.

    Text that is not a number is also NaN, unless ``strict``.

    Raises ``ValueError``: it is not a real number within the range of a double; the message has the
    expectation.
    """
    if value is None or type(value).__name__ == "NAType":
        return math.nan
    if isinstance(value, str):
        return _number_of_text(value.strip(), strict)
    try:
        return float(value)
    except OverflowError:
        raise ValueError("a number within the range of a double") from None
    except (TypeError, ValueError):
        if strict:
            raise ValueError("a number") from None
        return math.nan


def _number_of_text(text: str, strict: bool) -> float:
    if text.lower() in MISSING:
        return math.nan
    try:
        if "_" in text or not text.isascii():  # float reads the digits of every script
            raise ValueError
        value = float(text)
    except ValueError:
        if strict:
            raise ValueError("a number") from None
        return math.nan
    if math.isinf(value) and text.lstrip("+-").lower() not in INFINITIES:
        raise ValueError("a number within the range of a double")
    return value


def column_of(values: Any, name: str, where: str) -> Array:
    """``values`` as an array with one entry a row.

    Raises ``InputError``: it has another shape, or a mask, or holds dates, complex numbers or truth
    values.
    """
    # naming numpy.ma would import it
    if type(values).__name__ == "MaskedArray" and numpy.any(values.mask):
        raise InputError(f"{where}: column {name}: got masked entries, expected numbers")
    try:
        array = numpy.asarray(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: column {name}: {_line(error)}, expected numbers") from None
    if array.ndim != 1:
        raise InputError(
            f"{where}: column {name}: got an array of shape {array.shape}, expected one number "
            "for each row"
        )
    if array.dtype.kind in "mM":
        raise InputError(
            f"{where}: column {name}: got {array.dtype}, expected seconds as a number, such as "
            f"({name} - {name}[0]) / numpy.timedelta64(1, 's')"
        )
    if array.dtype.kind in "cb":
        raise InputError(f"{where}: column {name}: got {array.dtype}, expected real numbers")
    return array


def numbers_of(
    array: Array, name: str, where: str, first: int = 0, *, strict: bool = True
) -> numpy.ndarray:
    """The numbers in an array of ``column_of``, NaN where there are none; row ``first`` onwards.

    Raises ``InputError``: an entry is not a real number; the line names the row.
    """
    if array.dtype.kind in "fiu":
        with numpy.errstate(over="ignore"):
            rounded = numpy.asarray(array, dtype=float)
        if array.dtype.itemsize <= 8 or not numpy.any(numpy.isinf(rounded) & ~numpy.isinf(array)):
            return rounded
    numbers = numpy.empty(len(array))
    for row, value in enumerate(array):
        try:
            numbers[row] = number(value, strict=strict)
        except ValueError as error:
            raise InputError(bad_cell(f"{where}: row {first + row}", name, value, error)) from None
    return numbers


def bad_cell(place: str, name: str, value: object, error: ValueError) -> str:
    """The error message for a cell."""
    return f"{place}, column {name}: got {str(value)[:SHOWN]!r}, expected {error}"


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:120]


BLOCK_BYTES = 2_000_000  # some 10,000 rows: what numpy makes of them stays in the cache
GZIPPED = b"\x1f\x8b"
LONGEST_LINE = 1_000_000  # bytes; a row of numbers is a few hundred


class TextSource(RowSource):
    """CSV text, plain or gzipped, with one header line, and comments above it."""

    def __init__(self, where: str, opened: io.BufferedReader, size: int, rename: Mapping[str, str]):
        self._opened, self._size, self._file = opened, size, where
        self._stream: Any = opened
        if where.endswith(".gz") or opened.peek(2)[:2] == GZIPPED:
            import gzip

            self._stream = gzip.GzipFile(fileobj=opened)
        super().__init__(where, self._header({"t", "time", *rename}), rename)

    def _header(self, expected: set[str]) -> list[str]:
        """The names in the header, the first line that is not a comment."""
        for number in itertools.count(1):
            read = self._read(self._stream.readline, LONGEST_LINE)
            if len(read) >= LONGEST_LINE:
                raise InputError(f"{self._file}: no end of its first line, expected a CSV header")
            line = self._decoded(read)
            if not line.strip():
                raise InputError(
                    f"{self._file}: it is empty, expected a header line and rows of numbers"
                )
            text = line.removeprefix("\ufeff").strip()
            # numpy.savetxt puts "# " before its header
            names = self._split(text.lstrip("# "), number)
            if text.startswith("#") and not expected & {name.strip() for name in names}:
                continue
            for mark, name in ((";", "semicolons"), ("\t", "tabs"), (" ", "spaces")):
                if mark in text.lstrip("# ") and "," not in text:
                    raise InputError(
                        f"{self._file}: the header is separated by {name}, expected commas"
                    )
            self._rows_begin = number + 1
            return names
        raise AssertionError

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        names = (*wanted, *also)
        rest, line = b"", self._rows_begin
        while True:
            piece = self._read(self._stream.read, BLOCK_BYTES)
            data = rest + piece
            if piece:
                cut = data.rfind(b"\n") + 1
                data, rest = data[:cut], data[cut:]
                if len(rest) > LONGEST_LINE:
                    raise InputError(
                        f"{self.where}: line {line + data.count(10)} is longer than "
                        f"{LONGEST_LINE} bytes, expected a row of numbers"
                    )
            if data.strip():
                yield self._block(self._decoded(data), names, wanted, line)
            line += data.count(b"\n")
            if not piece:
                return
            if self._size:
                progress(min(1.0, self._opened.tell() / self._size))

    def close(self) -> None:
        """Close the file, but not standard input."""
        if self._size:
            self._opened.close()

    def _block(self, text: str, names: Sequence[str], wanted: Sequence[str], first: int) -> Block:
        @cache
        def lines() -> list[tuple[int, str]]:
            rows = text.replace("\r\n", "\n").split("\n")
            return [(number, row) for number, row in enumerate(rows, first) if row.strip()]

        def cells(row: int, asked: Sequence[str]) -> list[str]:
            number, line = lines()[row]
            split = self._split(line, number)
            return [split[self.names.index(name)].strip() for name in asked]

        indices = [self.names.index(name) for name in names]
        try:
            parsed = numpy.loadtxt(
                io.StringIO(text), delimiter=",", usecols=indices, comments=None, ndmin=2,
                quotechar='"',
            )  # fmt: skip
        except ValueError:
            parsed = None
        if parsed is None or not (self._even(text, len(parsed)) and numpy.isfinite(parsed).all()):
            # a row of another length, or a number that a double cannot hold, is refused there
            parsed = self._cell_by_cell(lines(), names, wanted)
        columns = numpy.ascontiguousarray(parsed.T)
        values = dict(zip(names, columns, strict=True))
        return Block(values, lambda row: f"line {lines()[row][0]}", cells)

    def _even(self, text: str, rows: int) -> bool:
        """Whether each of so many lines of ``text`` has as many cells as the header."""
        commas = [line.count(",") for line in text.split("\n") if line.strip()]
        return '"' not in text and commas == rows * [len(self.names) - 1]

    def _cell_by_cell(
        self, lines: Sequence[tuple[int, str]], names: Sequence[str], wanted: Sequence[str]
    ) -> numpy.ndarray:
        table = numpy.empty((len(lines), len(names)))
        for row, (at, line) in enumerate(lines):
            split = self._split(line, at)
            if len(split) != len(self.names):
                cut = " (was the file cut off?)" if len(split) < len(self.names) else ""
                raise InputError(
                    f"{self.where}: line {at} has {len(split)} cells, expected "
                    f"{len(self.names)} as in the header{cut}"
                )
            cells = dict(zip(self.names, split, strict=True))
            for column, name in enumerate(names):
                try:
                    table[row, column] = number(cells[name], strict=name in wanted)
                except ValueError as error:
                    place = f"{self.where}: line {at}"
                    raise InputError(bad_cell(place, name, cells[name], error)) from None
        return table

    def _split(self, row: str, number: int) -> list[str]:
        try:
            return next(csv.reader([row]), [])
        except csv.Error as error:
            bare = "\r" in row.strip()
            reason = "its lines end in bare carriage returns" if bare else error
            raise InputError(
                f"{self._file}: line {number}: {reason}; expected cells between commas, and line "
                "feeds"
            ) from None

    def _read(self, read: Callable[[int], bytes], most: int) -> bytes:
        try:
            return read(most)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{self._file}: {error}; expected a readable file") from None

    def _decoded(self, data: bytes) -> str:
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self._file}: not UTF-8 text, expected CSV") from None


BLOCK_ROWS = 16_384


class ParquetSource(RowSource):
    """A Parquet file, read a batch of rows at a time."""

    def __init__(self, path: Path, rename: Mapping[str, str]):
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise InputError(
                f"{path}: reading Parquet needs pyarrow; pip install 'tt-precise[parquet]'"
            ) from None
        self._failures = (pyarrow.ArrowException, OSError)
        try:
            self._file = pyarrow.parquet.ParquetFile(path)
        except self._failures as error:
            raise InputError(f"{path}: {_line(error)}; expected a Parquet file") from None
        self._theirs = list(self._file.schema_arrow.names)
        super().__init__(str(path), self._theirs, rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        every = (*wanted, *also)
        theirs = [self._theirs[self.names.index(name)] for name in every]
        total, done = self._file.metadata.num_rows, 0
        batches = self._file.iter_batches(BLOCK_ROWS, columns=theirs)
        while True:
            try:
                batch = next(batches, None)
            except self._failures as error:
                raise InputError(f"{self.where}: {_line(error)}; expected a Parquet file") from None
            if batch is None:
                return
            given = {
                ours: column_of(batch.column(name), ours, self.where)
                for ours, name in zip(every, theirs, strict=True)
            }
            yield _block(given, wanted, self.where, done)
            done += len(batch)
            progress(done / total)

    def close(self) -> None:
        self._file.close()


class ColumnSource(RowSource):
    """Columns in memory; ``column(name)`` gives one of those called ``names``.

    ``where`` is what messages call them.
    """

    def __init__(
        self,
        names: Sequence[Hashable],
        column: Callable[[Hashable], object],
        rename: Mapping[str, str],
        where: str = "the table",
    ):
        self._theirs, self._column = list(names), column
        super().__init__(where, [str(name) for name in names], rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        given = {}
        for name in (*wanted, *also):
            theirs = self._theirs[self.names.index(name)]
            given[name] = column_of(self._column(theirs), name, self.where)
        lengths = {name: len(column) for name, column in given.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{self.where}: columns of different length: {lengths}")
        for first in range(0, lengths["t"], BLOCK_ROWS):
            part = {name: column[first : first + BLOCK_ROWS] for name, column in given.items()}
            yield _block(part, wanted, self.where, first)


def _block(
    given: Mapping[str, numpy.ndarray], wanted: Sequence[str], where: str, first: int
) -> Block:
    return Block(
        {
            name: numbers_of(column, name, where, first, strict=name in wanted)
            for name, column in given.items()
        },
        lambda row: f"row {first + row}",
        lambda row, names: [given[name][row] for name in names],
    )


def open_source(source: object, rename: Mapping[str, str] | None = None) -> RowSource:
    """A table from a path, "-" (standard input), a DataFrame, a mapping or a ``Trajectory``.

    The caller closes it. A source that is open already is returned as it is.

    Raises ``InputError``: it cannot be opened, or has no header.
    """
    rename = rename or {}
    if isinstance(source, RowSource):
        return source
    if isinstance(source, str | os.PathLike):
        name = os.fspath(source)
        if name == "-":
            piped: Any = sys.stdin.buffer
            if not hasattr(piped, "peek"):
                piped = io.BufferedReader(piped)
            return TextSource("standard input", piped, 0, rename)
        return _open_file(Path(name), rename)
    if hasattr(source, "frame") and callable(source.frame):
        source = source.frame(numbers="float")
    names = getattr(source, "column_names", None)  # a pyarrow.Table
    if names is None:
        names = list(source) if isinstance(source, Mapping) else getattr(source, "columns", None)
    if names is not None and hasattr(source, "__getitem__"):
        return ColumnSource(list(names), source.__getitem__, rename)
    raise InputError(
        f"trajectory: got a {type(source).__name__}, expected a path, a DataFrame or a mapping "
        "of columns"
    )


def _npz(path: Path) -> Any:
    with numpy.load(path, allow_pickle=False) as file:
        return dict(file)


def _whole_reader(suffix: str) -> Callable[[Path], Any] | None:
    if suffix in ("", ".csv", ".gz", ".parquet"):
        return None
    from tt_precise.runtime.tables import FORMATS  # few need it

    if suffix == ".npz":
        return _npz
    return FORMATS[suffix].read if suffix in FORMATS else None


def _open_file(path: Path, rename: Mapping[str, str]) -> RowSource:
    read, parquet = _whole_reader(path.suffix), path.suffix == ".parquet"
    try:
        # opening a pipe waits for its writer, and these formats cannot be read from one
        if (read or parquet) and path.exists() and not path.is_file():
            raise OSError(0, "no regular file")
        size = path.stat().st_size
        opened = path.open("rb")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; expected a trajectory file") from None
    if read or parquet:
        opened.close()
        return _whole(path, read, rename) if read else ParquetSource(path, rename)
    try:
        return TextSource(str(path), opened, size, rename)
    except BaseException:
        opened.close()
        raise


def _whole(path: Path, read: Callable[[Path], Any], rename: Mapping[str, str]) -> ColumnSource:
    """All columns of a file at once."""
    import zipfile  # few files are archives

    try:
        table = read(path)
        names = list(getattr(table, "column_names", table))
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: {_line(error)}; expected a {path.suffix} file") from None
    return ColumnSource(names, table.__getitem__, rename, str(path))
