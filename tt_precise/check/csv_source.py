"""CSV text as blocks of rows: from a file, gzipped or not, or from standard input.

However long a file is, only one block is in memory.
"""

from __future__ import annotations

import csv
import io
import zlib
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, BinaryIO

import numpy

from tt_precise.check.blocks import Block, RowSource
from tt_precise.check.cells import bad_cell, number
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent

BLOCK_BYTES = 2_000_000  # some 10,000 rows: what numpy makes of them stays in the cache
LONGEST_LINE = 1_000_000  # bytes; a row of numbers is a few hundred


class TextSource(RowSource):
    """CSV text, plain or gzipped, with one header line."""

    def __init__(
        self,
        where: str,
        opened: BinaryIO,
        size: int,
        rename: Mapping[str, str],
        gzipped: bool = False,
    ):
        self._opened, self._size, self._file = opened, size, where
        self._stream: Any = opened
        if gzipped:
            import gzip

            self._stream = gzip.GzipFile(fileobj=opened)
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
        names = (*wanted, *also)
        indices = [self.names.index(name) for name in names]
        strict = [name in wanted for name in names]
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
                yield self._block(self._decoded(data), names, indices, strict, line)
            line += data.count(b"\n")
            if not piece:
                return
            if self._size:
                progress(min(1.0, self._opened.tell() / self._size))

    def close(self) -> None:
        """Close the file, but not standard input."""
        if self._size:
            self._opened.close()

    def _block(
        self,
        text: str,
        names: Sequence[str],
        indices: list[int],
        strict: Sequence[bool],
        line: int,
    ) -> Block:
        @cache
        def lines() -> list[tuple[int, str]]:
            return self._lines(text, line)

        def cells(row: int, wanted: Sequence[str]) -> list[str]:
            split = self._split(lines()[row][1], lines()[row][0])
            positions = [self.names.index(name) for name in wanted]
            return [split[i].strip() for i in positions]

        def place(row: int) -> str:
            return f"line {lines()[row][0]}"

        try:
            parsed = numpy.loadtxt(
                io.StringIO(text), delimiter=",", usecols=indices, comments=None, ndmin=2,
                quotechar='"',
            )  # fmt: skip
        except ValueError:
            parsed = self._cell_by_cell(lines(), names, indices, strict)
        else:
            if not self._even(text, len(parsed)) or not numpy.isfinite(parsed).all():
                # a row of another length, or a number that a double cannot hold, is refused there
                parsed = self._cell_by_cell(lines(), names, indices, strict)
        columns = numpy.ascontiguousarray(parsed.T)
        return Block(dict(zip(names, columns, strict=True)), place, cells)

    def _even(self, text: str, rows: int) -> bool:
        """Whether each of so many lines of ``text`` has as many cells as the header."""
        if '"' in text:
            return False
        data = numpy.frombuffer(text.encode(), dtype=numpy.uint8)
        ends = numpy.append(numpy.flatnonzero(data == ord("\n")), len(data) - 1)
        commas = numpy.diff(numpy.cumsum(data == ord(","))[ends], prepend=0)
        return bool(
            (commas == len(self.names) - 1).sum() == rows
            and numpy.isin(commas, (0, len(self.names) - 1)).all()
        )

    def _cell_by_cell(
        self,
        lines: Sequence[tuple[int, str]],
        names: Sequence[str],
        indices: Sequence[int],
        strict: Sequence[bool],
    ) -> numpy.ndarray:
        found = numpy.empty((len(lines), len(names)))
        for row, (at, line) in enumerate(lines):
            split = self._split(line, at)
            if len(split) != len(self.names):
                cut = " (was the file cut off?)" if len(split) < len(self.names) else ""
                raise InputError(
                    f"{self.where}: line {at} has {len(split)} cells, expected "
                    f"{len(self.names)} as in the header{cut}"
                )
            for column, index in enumerate(indices):
                try:
                    found[row, column] = number(split[index], strict=strict[column])
                except ValueError as error:
                    place = f"{self.where}: line {at}"
                    raise InputError(bad_cell(place, names[column], split[index], error)) from None
        return found

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
