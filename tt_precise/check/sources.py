"""Trajectories as one table of rows: CSV, standard input, Parquet, HDF5, tables in memory.

The checks receive a ``Block``, independent of its source. An unusable trajectory (text in a number,
dates, time that does not increase) gives one line that names file and line. The declared size of a
file is bounded before the file is read.
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
from dataclasses import replace
from decimal import Decimal, InvalidOperation
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import ENGINES_OWN, OURS, Block, renamed
from tt_precise.check.precision import times_of
from tt_precise.runtime.tables import MOST_BYTES, too_large
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError


class RowSource:
    """A source of rows: its column names after renaming, and its origin."""

    def __init__(self, where: str, names: Sequence[str], rename: Mapping[str, str]):
        self.where = where
        self.names = renamed([name.strip() for name in names], rename, where)

    def load(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Block:
        """Return the columns as arrays; can be called once.

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


class UsableRows(NamedTuple):
    """The rows that can be checked, with times from the first row on, and that row's own time.

    ``broken`` is the first row that is not finite, where the rows end early.
    """

    block: Block
    t_first: float
    broken: NotFinite | None = None


# The last row before padding lies at most so many intervals before the time asked for: half way to
# a missing row.
PADDED = 1.5


def usable_rows(
    block: Block, wanted: Sequence[str], where: str, until: float = math.inf
) -> UsableRows:
    """Return the rows up to time ``until`` (s) and up to the first row that is not finite.

    Raises ``InputError``: time does not increase.
    """
    t = block.values["t"]
    beyond = numpy.flatnonzero(t > until)
    if len(beyond):
        block = block.head(int(beyond[0]))
    elif len(t) and until < math.inf:
        block = _without_padding(block, wanted, until)
    t = block.values["t"]
    finite = numpy.all([numpy.isfinite(block.values[name]) for name in wanted], axis=0)
    broken = None
    t_first = float(t[0]) if len(t) and math.isfinite(t[0]) else 0.0
    if not finite.all():
        row = int(numpy.argmin(finite))
        name = next(name for name in wanted if not math.isfinite(block.values[name][row]))
        # a row without a time is identified by the previous row
        times = (t[row], t[row - 1] if row else t_first)
        at = next((float(x) for x in times if math.isfinite(x)), t_first)
        value = float(block.values[name][row])
        broken = NotFinite(at - t_first, name, value, block.where(row))
        block = block.head(row)
    t = block.values["t"]
    wrong = numpy.flatnonzero(~(numpy.diff(t, prepend=-math.inf) > 0))
    if len(wrong):
        row = int(wrong[0])
        same = row > 0 and t[row] == t[row - 1]
        raise InputError(
            f"{where}: {block.where(row)}: t = {float(t[row])!r} "
            + ("occurs twice" if same else f"comes after t = {float(t[row - 1])!r}")
            + ", expected strictly increasing time"
        )
    if len(t) > 1:
        block = replace(block, values={**block.values, "t": _times_after_the_first(block)})
    return UsableRows(block, t_first, broken)


def _times_after_the_first(block: Block) -> Array:
    """Return the times since the first row, which decimals give to all the digits of the file.

    Times that are evenly spaced but for the digits in which they are written are made even.
    """
    even = times_of(block.values["t"])
    if even.words or not block.values["t"][0]:
        return even.t - even.t[0]
    cells = [block.texts(row, ["t"])[0] for row in range(len(block))]
    try:
        times = [Decimal(str(cell)) for cell in cells]
    except InvalidOperation:
        return even.t - even.t[0]
    return numpy.array([float(time - times[0]) for time in times])


def _without_padding(block: Block, wanted: Sequence[str], until: float) -> Block:
    """Leave out rows of NaN with which a table was filled up behind its last row at ``until``."""
    t = block.values["t"]
    rows = int(numpy.argmax(numpy.isnan(t)))
    padding = [block.values[name][rows:] for name in wanted]
    if rows < 2 or not all(numpy.isnan(column).all() for column in padding):
        return block
    reached = t[rows - 1] + PADDED * (t[rows - 1] - t[rows - 2])
    return block.head(rows) if reached >= until else block


SHOWN = 40  # characters of a bad cell
INFINITIES = ("inf", "infinity")
MISSING = ("", "nan", "na", "n/a", "null", "none", "<na>")


def number(value: Any, *, strict: bool) -> float:
    """The number in a cell (text, or a number of any kind); NaN without a number.

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


def numbers_of(array: Array, name: str, where: str, *, strict: bool = True) -> numpy.ndarray:
    """The numbers in an array of ``column_of``, NaN for missing numbers.

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
            raise InputError(bad_cell(f"{where}: row {row}", name, value, error)) from None
    return numbers


def bad_cell(where: str, name: str, value: object, error: ValueError) -> str:
    """The error message for a cell."""
    return f"{where}, column {name}: got {str(value)[:SHOWN]!r}, expected {error}"


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:120]


BLOCK_BYTES = 2_000_000  # some 10,000 rows of text: what numpy makes of them stays in the cache
GZIPPED = b"\x1f\x8b"
LONGEST_LINE = 1_000_000  # bytes; a row of numbers is a few hundred
MOST_PREAMBLE = 50  # lines of metadata before the header in which the header is sought
SEPARATORS: tuple[str | None, ...] = (",", ";", "\t", None)  # None: spaces
KNOWN = {"time", *OURS}


class TextSource(RowSource):
    """Text, plain or gzipped, with one header line, and comments above the header.

    Cells are separated by commas, semicolons, tabs or spaces, as the header shows.
    """

    def __init__(self, where: str, opened: io.BufferedReader, size: int, rename: Mapping[str, str]):
        self._opened, self._size, self._file = opened, size, where
        self._stream: Any = opened
        if where.endswith(".gz") or opened.peek(2)[:2] == GZIPPED:
            import gzip

            self._stream = gzip.GzipFile(fileobj=opened)
        self._separator: str | None = ","
        super().__init__(where, self._header({*KNOWN, *rename}), rename)

    def _header(self, expected: set[str]) -> list[str]:
        """Return the names in the header, the first line that is not a comment."""
        separators = SEPARATORS
        for number in itertools.count(1):
            line = self._line()
            if not line.strip():
                raise InputError(
                    f"{self._file}: it is empty, expected a header line and rows of numbers"
                )
            text = line.removeprefix("\ufeff").strip()
            if text.lower().startswith("sep=") and len(text) == 5:  # Excel's own first line
                separators = (text[4],)
                continue
            # numpy.savetxt puts "# " before its header
            names = self._names(text.lstrip("# "), number, separators, expected)
            if not expected & set(names) and not any(map(ENGINES_OWN.fullmatch, names)):
                if text.startswith("#"):
                    continue
                self._refuse_other_lines(names, number, expected)
            self._rows_begin = number + 1
            return names
        raise AssertionError

    def _names(
        self, text: str, number: int, separators: Sequence[str | None], expected: set[str]
    ) -> list[str]:
        """Split a header by the separator that gives known names, or else several names."""
        split: dict[str | None, list[str]] = {}
        for separator in separators:
            self._separator = separator
            split[separator] = [name.strip() for name in self._split(text, number)]
        known = [one for one, names in split.items() if len(expected & set(names)) > 1]
        several = [one for one, names in split.items() if len(names) > 1]
        self._separator = next(iter([*known, *several, *separators]))
        return split[self._separator]

    def _refuse_other_lines(self, names: Sequence[str], number: int, expected: set[str]) -> None:
        """Refuse a first line of numbers or JSON, and metadata before a header further down."""
        if names[0].startswith(("{", "[")):
            raise InputError(
                f"{self._file}: line {number} is JSON, expected CSV, or a name that ends in .json "
                "(an object of columns) or .jsonl (an object a line)"
            )
        if len(names) > 1 and all(_is_number(name) for name in names):
            raise InputError(
                f"{self._file}: no header line: line {number} has {len(names)} numbers, expected "
                "the names of the columns first, such as t,kx,ky,kz,Lx,Ly,Lz,vx,vy"
            )
        for below in range(number + 1, number + MOST_PREAMBLE):
            read = self._line()
            line = read.strip()
            if len(expected & {*self._names(line.lstrip("# "), below, SEPARATORS, expected)}) > 1:
                raise InputError(
                    f"{self._file}: line {below} looks like the header, expected it first: delete "
                    "the lines before it, or begin them with #"
                )
            if not read:
                return

    def load(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Block:
        names = (*wanted, *also)
        texts: list[str] = []
        tables: list[Array] = []
        firsts = [self._rows_begin]  # lines at which the texts begin
        for text in self._texts(progress):
            tables.append(self._table(text, names, wanted, firsts[-1]))
            texts.append(text)
            firsts.append(firsts[-1] + text.count("\n"))
        columns = numpy.concatenate(tables, axis=1) if tables else numpy.empty((len(names), 0))
        ends = numpy.cumsum([table.shape[1] for table in tables])

        @lru_cache(2)
        def lines(part: int) -> list[tuple[int, str]]:
            return _numbered_lines(texts[part], firsts[part])

        def line(row: int) -> tuple[int, str]:
            part = int(numpy.searchsorted(ends, row, side="right"))
            return lines(part)[row - (int(ends[part - 1]) if part else 0)]

        def cells(row: int, asked: Sequence[str]) -> list[str]:
            number, text = line(row)
            split = self._split(text, number)
            return [split[self.names.index(name)].strip() for name in asked]

        values = dict(zip(names, columns, strict=True))
        return Block(values, lambda row: f"line {line(row)[0]}", cells)

    def _texts(self, progress: Progress) -> Iterator[str]:
        """Whole lines of the file, some 10,000 at a time."""
        rest, count, line = b"", 0, self._rows_begin
        while True:
            piece = self._guarded(self._stream.read, BLOCK_BYTES)
            data, count = rest + piece, count + len(piece)
            if piece:
                cut = data.rfind(b"\n") + 1
                data, rest = data[:cut], data[cut:]
                if len(rest) > LONGEST_LINE:
                    raise InputError(
                        f"{self.where}: line {line + data.count(10)} is longer than "
                        f"{LONGEST_LINE} bytes, expected a row of numbers"
                    )
            if count > MOST_BYTES:
                raise InputError(f"{self.where}: {too_large('text')}")
            if data.strip():
                yield self._decoded(data)
                line += data.count(10)
            if not piece:
                return
            if self._size:
                progress(min(1.0, self._opened.tell() / self._size))

    def close(self) -> None:
        """Close the file, but not standard input."""
        if self._size:
            self._opened.close()

    def _table(self, text: str, names: Sequence[str], wanted: Sequence[str], first: int) -> Array:
        """Return the numbers in lines of text, one row of the array for each of ``names``."""
        indices = [self.names.index(name) for name in names]
        try:
            parsed = numpy.loadtxt(
                io.StringIO(text), delimiter=self._separator, usecols=indices, comments=None,
                ndmin=2, quotechar='"',
            )  # fmt: skip
        except ValueError:
            parsed = None
        if parsed is None or not (self._even(text, len(parsed)) and numpy.isfinite(parsed).all()):
            # a row of another length, or a number that a double cannot hold, is refused there
            parsed = self._cell_by_cell(_numbered_lines(text, first), names, wanted)
        return numpy.ascontiguousarray(parsed.T)

    def _even(self, text: str, rows: int) -> bool:
        """True if ``text`` has ``rows`` lines with as many cells as the header."""
        lines = [line for line in text.split("\n") if line.strip()]
        if self._separator is None:
            counts = [len(line.split()) - 1 for line in lines]
        else:
            counts = [line.count(self._separator) for line in lines]
        return '"' not in text and counts == rows * [len(self.names) - 1]

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
                    where = f"{self.where}: line {at}"
                    raise InputError(bad_cell(where, name, cells[name], error)) from None
        return table

    def _split(self, row: str, number: int) -> list[str]:
        if self._separator is None:
            return row.split()
        try:
            return next(csv.reader([row], delimiter=self._separator), [])
        except csv.Error as error:
            bare = "\r" in row.strip()
            reason = "its lines end in bare carriage returns" if bare else error
            raise InputError(
                f"{self._file}: line {number}: {reason}; expected cells between commas, and line "
                "feeds"
            ) from None

    def _line(self) -> str:
        read = self._guarded(self._stream.readline, LONGEST_LINE)
        if len(read) >= LONGEST_LINE:
            raise InputError(f"{self._file}: no end of its first line, expected a CSV header")
        return self._decoded(read)

    def _guarded(self, read: Callable[[int], bytes], most: int) -> bytes:
        try:
            return read(most)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"{self._file}: {error}; expected a readable file") from None

    def _decoded(self, data: bytes) -> str:
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self._file}: not UTF-8 text, expected CSV") from None


def _numbered_lines(text: str, first: int) -> list[tuple[int, str]]:
    """The lines of ``text`` that are not empty, with their numbers in the file."""
    rows = text.replace("\r\n", "\n").split("\n")
    return [(number, row) for number, row in enumerate(rows, first) if row.strip()]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


class ColumnSource(RowSource):
    """Columns in memory; ``column(name)`` returns a column of ``names``.

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

    def load(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Block:
        given = {name: column_of(self.column(name), name, self.where) for name in (*wanted, *also)}
        lengths = {name: len(column) for name, column in given.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{self.where}: columns of different length: {lengths}")
        return _block(given, wanted, self.where)

    def column(self, name: str) -> Any:
        """Return a column as it is."""
        return self._column(self._theirs[self.names.index(name)])


def _block(given: Mapping[str, numpy.ndarray], wanted: Sequence[str], where: str) -> Block:
    return Block(
        {
            name: numbers_of(column, name, where, strict=name in wanted)
            for name, column in given.items()
        },
        lambda row: f"row {row}",
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
    table: Any = source
    index = getattr(getattr(table, "index", None), "name", None)
    if index in ("t", "time") and index not in table.columns:
        table = table.reset_index()
    names = getattr(table, "column_names", None)  # a pyarrow.Table
    if names is None:
        names = list(table) if isinstance(table, Mapping) else getattr(table, "columns", None)
    if names is not None and hasattr(table, "__getitem__"):
        return ColumnSource(list(names), table.__getitem__, rename)
    raise InputError(
        f"trajectory: got a {type(source).__name__}, expected a path, a DataFrame or a mapping "
        "of columns"
    )


# Suffixes of text files, for which no other format is imported.
TEXT_SUFFIXES = ("", ".csv", ".tsv", ".txt", ".gz")


def _open_file(path: Path, rename: Mapping[str, str]) -> RowSource:
    reader: Callable[[Path], Mapping[str, Any]] | None = None
    if path.suffix not in TEXT_SUFFIXES:
        from tt_precise.check.formats import READERS

        reader = READERS.get(path.suffix)
    try:
        # opening a pipe waits for its writer, and these formats cannot be read from one
        if reader is not None and path.exists() and not path.is_file():
            raise OSError(0, "no regular file")
        size = path.stat().st_size
        opened = path.open("rb")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: {reason}; expected a trajectory file") from None
    if reader is not None:
        opened.close()
        return _by_name(path, reader, rename)
    try:
        return TextSource(str(path), opened, size, rename)
    except BaseException:
        opened.close()
        raise


def _by_name(
    path: Path, reader: Callable[[Path], Mapping[str, Any]], rename: Mapping[str, str]
) -> ColumnSource:
    """Open a file whose columns are read on request."""

    def readable(read: Callable[[], Any]) -> Any:
        import zipfile

        try:
            return read()
        except InputError:
            raise
        except (OSError, ValueError, TypeError, EOFError, KeyError, RuntimeError,
                zipfile.BadZipFile, zlib.error) as error:  # fmt: skip
            raise InputError(f"{path}: {_line(error)}; expected a {path.suffix} file") from None

    table = readable(lambda: reader(path))

    def column(name: Hashable) -> Any:
        return readable(lambda: table[name])

    return ColumnSource(list(table), column, rename, str(path))
