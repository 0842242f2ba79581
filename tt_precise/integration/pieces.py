"""Pieces of motion under equations of their own, joined in one trajectory.

A ``PiecewiseOutput`` stands where a ``DenseOutput`` does, with ``PiecewiseColumns`` and
``PiecewiseTables`` for the others: each time belongs to one piece, the earlier one at a bound, and
what is asked about it is asked of that piece, in its own time since its begin.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from tt_precise.integration.columns import Columns, Row, State
from tt_precise.integration.dense_output import DenseOutput
from tt_precise.integration.propagate import Propagation
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import Hit
from tt_precise.integration.tables import Numbers, Tables
from tt_precise.mechanics.conserved import Integral, drift
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.progress import Progress
from tt_precise.scene.numerals import as_fraction, shortest_texts

FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


@dataclass(frozen=True)
class MotionPiece:
    """A stretch under one set of equations, from ``begin`` (dimensionless, guarded) on.

    ``ended`` is the event that joins it to the next piece; "" where only the equations change, and
    of the last one.
    """

    begin: Scalar
    output: Any
    ended: str

    @cached_property
    def columns(self) -> Columns:
        """Columns of the piece's own rows."""
        return Columns(self.output.setup, self.output.start)

    @cached_property
    def tables(self) -> Tables:
        """Tables of the piece alone, over its own time."""
        return Tables(self.output, self.columns)

    @property
    def begin_s(self) -> Scalar:
        """Where it begins, in s."""
        return self.begin * self.output.start.units.time

    @property
    def model(self) -> str:
        """One of gliding, rolling, flight, and contact with an elastic table."""
        form = self.output.setup.formulation
        return "contact" if form.model == form.spring else form.model


class Placed(NamedTuple):
    """A row and the piece that it is of."""

    piece: MotionPiece
    row: Row


class PiecewiseOutput(DenseOutput):
    """Rows over the time of all pieces."""

    def __init__(
        self, pieces: Sequence[MotionPiece], whole: Propagation, setup: Setup, start: InitialState
    ):
        super().__init__(setup, start, whole)
        self.pieces = tuple(pieces)

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution."""
        last = self.pieces[-1]
        if self.propagation.status == "complete":
            return self.start.until
        return last.begin + last.output.end_time

    @cached_property
    def start_row(self) -> Any:
        """The row at t = 0."""
        return Placed(self.pieces[0], self.pieces[0].output.start_row)

    @cached_property
    def end_row(self) -> Any:
        """The row at the end."""
        return Placed(self.pieces[-1], self.pieces[-1].output.end_row)

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Any]:
        """Rows at guarded dimensionless ``times``."""
        found: list[Any] = []
        for time in times:
            piece = self.pieces[self.place(time)]
            local = time - piece.begin
            if piece is self.pieces[-1] and time == self.end_time:
                found.append(self.end_row)
            else:
                row = piece.output.rows([min(local, piece.output.end_time)])[0]
                found.append(Placed(piece, row))
        return found

    def place(self, time: Scalar) -> int:
        """The number of the piece that a dimensionless time belongs to."""
        begins = [piece.begin for piece in self.pieces]
        return max(bisect.bisect_left(begins, time) - 1, 0)


class PiecewiseColumns(Columns):
    """What can be asked of rows of several pieces."""

    def motion(self, row: Any) -> Motion:
        """The ``Motion`` of a row."""
        placed: Placed = row
        return placed.piece.columns.motion(placed.row)

    def of_rows(self, names: Sequence[str], rows: Sequence[Any]) -> dict[str, list[Scalar | None]]:
        """Named columns (SI) of ``rows``; None where a quantity is undefined."""
        found = [one.piece.columns.of_rows(names, [one.row]) for one in rows]
        return {name: [one[name][0] for one in found] for name in names}

    def states(self, times: Sequence[Scalar], rows: Sequence[Any]) -> list[State]:
        """The ``State`` (SI) of each row, at guarded dimensionless times."""
        return [
            one.piece.columns.states([time], [one.row])[0]
            for time, one in zip(times, rows, strict=True)
        ]


@dataclass(frozen=True)
class PiecewiseTables(Tables):
    """What is read from many rows of several pieces, in SI."""

    dense_output: PiecewiseOutput

    @property
    def in_long_double(self) -> bool:
        """Not at once: each piece has a state of its own."""
        return False

    def columns(
        self,
        names: Sequence[str],
        times: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None = None,
    ) -> dict[str, Any]:
        """``t`` and the named columns at exact ``times`` in s."""
        import numpy

        parts = []
        order: list[int] = []
        for piece, places in self._groups(times):
            local = [self._local(piece, times[i]) for i in places]
            parts.append(piece.tables.columns(names, local, numbers))
            order += places
        back = numpy.argsort(order)
        found: dict[str, Any] = {}
        for name in ("t", *names):
            values = [x for part in parts for x in part[name]] if parts else []
            found[name] = [values[i] for i in back.tolist()]
        found["t"] = self._times(times, numbers)
        if numbers == "text":
            return found
        double = numbers == "float" or self.of.precision.name == "double"
        return {n: numpy.array(c, dtype=float if double else object) for n, c in found.items()}

    def _times(self, times: Sequence[Fraction], numbers: Numbers) -> list[Any]:
        precision = self.of.precision
        if precision.name == "double":
            plain = list(map(float, times))
            return shortest_texts(plain) if numbers == "text" else plain
        found: list[Any] = self._converted(precision.wide.of_fractions(times), numbers)
        return found

    def _groups(self, times: Sequence[Fraction]) -> Iterator[tuple[MotionPiece, list[int]]]:
        groups: dict[int, list[int]] = {}
        for i, time in enumerate(times):
            inner = self.dense_output.dimensionless_time(time)
            groups.setdefault(self.dense_output.place(inner), []).append(i)
        for place in sorted(groups):
            yield self.dense_output.pieces[place], groups[place]

    def _local(self, piece: MotionPiece, time: Fraction) -> Fraction:
        """A time since the piece's begin; never behind its end by a rounding."""
        return min(
            max(time - as_fraction(piece.begin_s), Fraction(0)), as_fraction(piece.output.end)
        )

    def evaluated(
        self, function: Callable[[Motion], Scalar], times: Sequence[Scalar]
    ) -> list[Scalar]:
        """A function of the motion at guarded times in s, dimensionless, in guarded numbers."""
        rows = self.dense_output.rows(list(map(self.dense_output.dimensionless_time, times)))
        return [function(self.of.motion(row)) for row in rows]

    def event_columns(
        self, names: Sequence[str], at: Container[str] | None = None
    ) -> dict[str, Array]:
        """The recorded events in order of time, those that join the pieces among them."""
        context, leaving = self.of.precision.context, self.of.leaving
        columns: dict[str, Array] = {name: [] for name in ("name", "t", "direction", *names)}
        pieces = self.dense_output.pieces
        for number, piece in enumerate(pieces, start=1):
            found = piece.tables.event_columns(names, at)
            found["t"] = [leaving(context.mpf(t) + piece.begin_s) for t in found["t"]]
            for name, column in columns.items():
                column += list(found[name])
            if piece.ended and number < len(pieces):
                end = piece.output.end_time
                (state,) = piece.columns.states([end], [piece.output.end_row])
                time = leaving(context.mpf(piece.output.end) + piece.begin_s)
                row = {"name": piece.ended, "t": time, "direction": FALLING} | state.values
                for name, column in columns.items():
                    column.append(row.get(name))
        return columns

    def drift(
        self, integrals: Iterable[Integral], times: Sequence[Fraction]
    ) -> dict[str, Sequence[Scalar]]:
        """Relative change of each integral since the start, at ``times``, whose last is the end."""
        dense_output = self.dense_output
        inner = [dense_output.dimensionless_time(t) for t in times[:-1]]
        rows = [dense_output.start_row, *dense_output.rows(inner), dense_output.end_row]
        motions = list(map(self.of.motion, rows))
        return {integral.name: drift(integral, motions)[1:] for integral in integrals}


def joined(pieces: Sequence[MotionPiece], setup: Setup, start: InitialState) -> DenseOutput:
    """The output of ``pieces``, one behind the other; of a single one its own."""
    if len(pieces) == 1 and pieces[0].output.setup == setup:
        output: DenseOutput = pieces[0].output
        return output
    number = setup.precision.number
    hits = []
    for piece in pieces:
        hits += piece.output.propagation.hits
        if piece.ended and piece is not pieces[-1]:
            hits.append(Hit(piece.ended, number(piece.output.end_time), FALLING, ()))
    steps = sum(piece.output.propagation.steps for piece in pieces)
    whole = replace(pieces[-1].output.propagation, steps=steps, hits=tuple(hits))
    return PiecewiseOutput(pieces, whole, setup, start)


def reading(output: DenseOutput) -> tuple[Columns, Tables]:
    """What is asked of the rows of ``output``."""
    if isinstance(output, PiecewiseOutput):
        columns = PiecewiseColumns(output.setup, output.start)
        return columns, PiecewiseTables(output, columns)
    plain = Columns(output.setup, output.start)
    return plain, Tables(output, plain)


class MotionPart(NamedTuple):
    """A stretch of one model as users see it: times in s, and how it ended.

    ``status`` is one of ``events.JOINING`` where another stretch follows, else the trajectory's.
    """

    model: str
    begin: Scalar
    end: Scalar
    status: str


def parts(output: DenseOutput, leaving: Callable[[Scalar], Scalar]) -> tuple[MotionPart, ...]:
    """The stretches that ``output`` consists of, from one event that joins them to the next."""
    begin, status = output.end * 0, output.propagation.status
    pieces: tuple[MotionPiece, ...] = getattr(output, "pieces", ())
    found = []
    for piece in pieces[:-1]:
        if piece.ended:
            end = piece.begin_s + piece.output.end
            found.append(MotionPart(piece.model, leaving(begin), leaving(end), piece.ended))
            begin = end
    last = (pieces[-1] if pieces else MotionPiece(begin, output, "")).model
    return (*found, MotionPart(last, leaving(begin), leaving(output.end), status))
