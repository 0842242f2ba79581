"""Reading trajectories in blocks of rows: CSV, gzipped CSV, standard input, Parquet, tables.

However long a file is, only one block is in memory. Everything that makes a trajectory unusable
(text in a number, NaN, time that does not increase) ends in one line that names file and line.
"""

from __future__ import annotations

import csv
import gzip
import io
import math
import os
import sys
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO

import numpy

from tt_precise.check.columns import renamed
from tt_precise.errors import InputError
from tt_precise.progress import Progress, silent

BLOCK_BYTES = 2_000_000  # some 10,000 rows: what numpy makes of them stays in the cache
BLOCK_ROWS = 16_384
LONGEST_LINE = 1_000_000  # bytes; a row of numbers is a few hundred


@dataclass(frozen=True)
class Block:
    """Consecutive rows: name to float64 array, and how to say where a row stands.

    ``texts(row, names)`` gives the cells of a row as they were written, exact to the last digit.
    """

    values: dict[str, numpy.ndarray]
    place: Callable[[int], str]
    texts: Callable[[int, Sequence[str]], list[Any]]

    def __len__(self) -> int:
        return len(self.values["t"])


class RowSource:
    """A source of blocks: its column names after renaming, and where it comes from."""

    def __init__(self, where: str, names: Sequence[str], rename: Mapping[str, str]):
        self.where = where
        self.names = renamed([name.strip() for name in names], rename, where)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        """The columns ``wanted`` as arrays, block by block; can be asked for once.

        Cells of the columns ``also`` can be looked up as text, and need not be numbers.
        """
        raise NotImplementedError

    def close(self) -> None:
        """Let go of the file, if there is one."""


def open_source(source: Any, rename: Mapping[str, str] | None = None) -> RowSource:
    """A table from a path, "-" (standard input), a DataFrame, a mapping or a ``Trajectory``.

    The caller closes it.

    Raises
    ------
    InputError
        It cannot be opened, or has no header.
    """
    rename = rename or {}
    if isinstance(source, str | os.PathLike):
        name = os.fspath(source)
        if name == "-":
            return _TextSource("standard input", sys.stdin.buffer, 0, rename)
        return _open_file(Path(name), rename)
    if hasattr(source, "frame") and callable(source.frame):
        source = source.frame(numbers="float")
    if hasattr(source, "columns") and hasattr(source, "__getitem__"):
        return _ArraySource([str(name) for name in source.columns], source, rename)
    if isinstance(source, Mapping):
        return _ArraySource([str(name) for name in source], source, rename)
    raise InputError(
        f"trajectory: got a {type(source).__name__}, expected a path, a DataFrame or a mapping "
        "of columns"
    )


def _open_file(path: Path, rename: Mapping[str, str]) -> RowSource:
    try:
        size = path.stat().st_size
        if path.suffix == ".parquet":
            path.open("rb").close()
            return _ParquetSource(path, rename)
        opened = path.open("rb")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; expected a trajectory file") from None
    try:
        return _TextSource(str(path), opened, size, rename, path.name.endswith(".gz"))
    except BaseException:
        opened.close()
        raise


class _TextSource(RowSource):
    def __init__(
        self,
        where: str,
        opened: BinaryIO,
        size: int,
        rename: Mapping[str, str],
        gzipped: bool = False,
    ):
        self._opened, self._size, self._file = opened, size, where
        self._stream: Any = gzip.GzipFile(fileobj=opened) if gzipped else opened
        header = self._read_line()
        if not header.strip():
            raise InputError(f"{where}: it is empty, expected a header line and rows of numbers")
        # numpy.savetxt puts "# " before its header
        text = self._decoded(header).removeprefix("\ufeff").lstrip("# ").strip()
        for mark, name in ((";", "semicolons"), ("\t", "tabs")):
            if mark in text and "," not in text:
                raise InputError(f"{where}: the header is separated by {name}, expected commas")
        super().__init__(where, self._split(text, 1), rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        indices = [self.names.index(name) for name in wanted]
        rest, line = b"", 2
        while True:
            piece = self._read(BLOCK_BYTES)
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
                yield self._block(self._decoded(data), wanted, indices, line)
            line += data.count(b"\n")
            if not piece:
                return
            if self._size:
                progress(min(1.0, self._opened.tell() / self._size))

    def close(self) -> None:
        """Close the file, but not standard input."""
        if self._size:
            self._opened.close()

    def _block(self, text: str, wanted: Sequence[str], indices: list[int], line: int) -> Block:
        @cache
        def lines() -> list[tuple[int, str]]:
            return self._lines(text, line)

        def cells(row: int, names: Sequence[str]) -> list[Any]:
            split = self._split(lines()[row][1], lines()[row][0])
            positions = [self.names.index(name) for name in names]
            return [split[i].strip() if i < len(split) else "" for i in positions]

        def place(row: int) -> str:
            return f"line {lines()[row][0]}"

        try:
            parsed = numpy.loadtxt(
                io.StringIO(text), delimiter=",", usecols=indices, comments=None, ndmin=2,
                quotechar='"',
            )  # fmt: skip
        except ValueError as error:
            raise self._diagnosis(text, wanted, indices, line, error) from None
        columns = numpy.ascontiguousarray(parsed.T)
        return Block(dict(zip(wanted, columns, strict=True)), place, cells)

    def _split(self, row: str, number: int) -> list[str]:
        try:
            return next(csv.reader([row]), [])
        except csv.Error as error:  # a lone carriage return, most of all
            raise InputError(
                f"{self._file}: line {number}: {error}; expected cells between commas"
            ) from None

    @staticmethod
    def _lines(text: str, line: int) -> list[tuple[int, str]]:
        rows = text.replace("\r\n", "\n").split("\n")
        return [(number, row) for number, row in enumerate(rows, line) if row.strip()]

    def _diagnosis(
        self, text: str, wanted: Sequence[str], indices: list[int], line: int, error: ValueError
    ) -> InputError:
        for number, row in self._lines(text, line):
            split = self._split(row, number)
            for name, index in zip(wanted, indices, strict=True):
                if index >= len(split):
                    return InputError(
                        f"{self.where}: line {number} has {len(split)} cells, expected "
                        f"{len(self.names)} as in the header (was the file cut off?)"
                    )
                if not _is_number(split[index]):
                    return InputError(
                        f"{self.where}: line {number}, column {name}: got {split[index][:40]!r}, "
                        "expected a number"
                    )
        return InputError(f"{self.where}: from line {line} on: {error}; expected rows of numbers")

    def _read(self, count: int) -> bytes:
        try:
            return self._stream.read(count)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{self._file}: {error}; expected a readable file") from None

    def _read_line(self) -> bytes:
        try:
            line = self._stream.readline(LONGEST_LINE)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{self._file}: {error}; expected a readable file") from None
        if len(line) >= LONGEST_LINE:
            raise InputError(f"{self._file}: no end of its first line, expected a CSV header")
        return line

    def _decoded(self, data: bytes) -> str:
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self._file}: not UTF-8 text, expected CSV") from None


class _ParquetSource(RowSource):
    def __init__(self, path: Path, rename: Mapping[str, str]):
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise InputError(
                f"{path}: reading Parquet needs pyarrow; pip install 'tt-precise[parquet]'"
            ) from None
        try:
            self._file = pyarrow.parquet.ParquetFile(path)
        except (pyarrow.ArrowException, OSError) as error:
            reason = str(error).splitlines()[0]
            raise InputError(f"{path}: {reason}; expected a Parquet file") from None
        self._theirs = list(self._file.schema_arrow.names)
        super().__init__(str(path), self._theirs, rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        every = (*wanted, *also)
        theirs = [self._theirs[self.names.index(name)] for name in every]
        total, done = self._file.metadata.num_rows, 0
        for batch in self._file.iter_batches(BLOCK_ROWS, columns=theirs):
            given = {
                ours: numpy.asarray(batch.column(name))
                for ours, name in zip(every, theirs, strict=True)
            }
            found = {name: _floats(given[name], name, self.where) for name in wanted}
            yield _array_block(found, done, given)
            done += len(batch)
            progress(done / total)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class _ArraySource(RowSource):
    def __init__(self, names: list[str], frame: Any, rename: Mapping[str, str]):
        self._theirs, self._frame = names, frame
        super().__init__("the table", names, rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        given = {
            name: numpy.asarray(self._frame[self._theirs[self.names.index(name)]])
            for name in (*wanted, *also)
        }
        lengths = {name: len(column) for name, column in given.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{self.where}: columns of different length: {lengths}")
        arrays = {name: _floats(given[name], name, self.where) for name in wanted}
        for first in range(0, lengths["t"], BLOCK_ROWS):
            part = slice(first, first + BLOCK_ROWS)
            yield _array_block(
                {name: array[part] for name, array in arrays.items()},
                first,
                {name: column[part] for name, column in given.items()},
            )


def _array_block(
    values: dict[str, numpy.ndarray], first: int, given: Mapping[str, numpy.ndarray]
) -> Block:
    return Block(
        values,
        lambda row: f"row {first + row}",
        lambda row, names: [given[name][row] for name in names],
    )


def _floats(column: Any, name: str, where: str) -> numpy.ndarray:
    try:
        return numpy.asarray(column, dtype=float)
    except (TypeError, ValueError):
        cells = numpy.asarray(column, dtype=object)
    for row, value in enumerate(cells):
        if value is not None and not _is_number(value):
            raise InputError(
                f"{where}: row {row}, column {name}: got {str(value)[:40]!r}, expected a number"
            )
    return numpy.array([math.nan if value is None else float(value) for value in cells])


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError):
        return False
    return not (isinstance(value, str) and "_" in value)


def checked_blocks(blocks: Iterator[Block], where: str, until: float = math.inf) -> Iterator[Block]:
    """The blocks up to time ``until``, refused unless finite and with strictly increasing time.

    Raises
    ------
    InputError
        A value is NaN or infinite, or time stands still or goes back; the line says where.
    """
    before = -math.inf
    for block in blocks:
        t = block.values["t"]
        # NaN compares false, so a NaN time is kept here and refused below
        beyond = numpy.flatnonzero(t > until) if until < math.inf else numpy.empty(0, int)
        kept = len(t) if not len(beyond) else int(beyond[0])
        values = {name: array[:kept] for name, array in block.values.items()}
        for name, array in values.items():
            wrong = numpy.flatnonzero(~numpy.isfinite(array))
            if len(wrong):
                row = int(wrong[0])
                raise InputError(
                    f"{where}: {block.place(row)}, column {name}: got {float(array[row])}, "
                    "expected a finite number (cut a tail off with --until)"
                )
        t = values["t"]
        steps = numpy.diff(t, prepend=before)
        wrong = numpy.flatnonzero(~(steps > 0))
        if len(wrong):
            row = int(wrong[0])
            previous = t[row - 1] if row else before
            repeated = t[row] == previous
            raise InputError(
                f"{where}: {block.place(row)}: t = {float(t[row])!r} "
                + ("occurs twice" if repeated else f"comes after t = {float(previous)!r}")
                + ", expected strictly increasing time"
            )
        if kept:
            before = float(t[-1])
            yield Block(values, block.place, block.texts)
        if len(beyond):
            return
