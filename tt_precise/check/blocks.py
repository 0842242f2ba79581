"""Blocks of rows, whatever they are read from: what the checks get, and which rows they may use."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy

from tt_precise.check.columns import renamed
from tt_precise.check.readings import Reading
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent


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

    def head(self, count: int) -> Block:
        """The first rows."""
        if count >= len(self):
            return self
        values = {name: array[:count] for name, array in self.values.items()}
        return Block(values, self.place, self.texts)


class RowSource:
    """A source of blocks: its column names after renaming, and where it comes from.

    ``otherwise`` has further readings of its first rows, by what each supposes.
    """

    otherwise: Mapping[str, Reading] = MappingProxyType({})

    def __init__(self, where: str, names: Sequence[str], rename: Mapping[str, str]):
        self.where = where
        self.names = renamed([name.strip() for name in names], rename, where)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        """The columns as arrays, block by block; can be asked for once.

        What is missing is NaN. In the columns ``also``, text that is no number is NaN too.
        """
        raise NotImplementedError

    def close(self) -> None:
        """Let go of the file, if there is one."""


@dataclass(frozen=True)
class NotFinite:
    """The first row without a finite number in a column that was wanted: time (s), what, where."""

    t: float
    column: str
    value: float
    place: str

    def __str__(self) -> str:
        return f"{self.column} = {self.value} in {self.place}"


class UsableRows:
    """The blocks of a source up to time ``until`` and up to the first row that is not finite.

    Iterating raises ``InputError`` where time stands still or goes back. Afterwards ``broken`` is
    the row that is not finite, if there is one.
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
        if not len(block):
            return block
        finite = numpy.all([numpy.isfinite(block.values[name]) for name in self._wanted], axis=0)
        if finite.all():
            return block
        row = int(numpy.argmin(finite))
        t = block.values["t"]
        name = next(name for name in self._wanted if not math.isfinite(block.values[name][row]))
        # a row without a time is known by the one before it
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
