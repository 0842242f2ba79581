"""``System``: equations of motion, compiled, and stepped from any start."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

from tt_precise.arithmetic import Array, Functions, Scalar
from tt_precise.taylor.graph import Graph, numbers
from tt_precise.taylor.kernel import ROWS, RUN, Kernel
from tt_precise.taylor.machine import Machine, aligned

STEPS = 128  # of a piece
SPARE = 4  # orders computed in more parts than they need in theory


def order_of(tolerance: float) -> int:
    """The order that costs least: measured, on the reference scene."""
    return round(20 - math.log(tolerance) / 3)


def orders_of(tolerance: float, most: int) -> tuple[int, int, int]:
    """How many coefficients are computed in three doubles, in two or more, in one or more.

    As terms fall by the same factor from order to order, down to ``tolerance`` in the last one,
    those of some order on are below 2^-53 of the entries, and need one part less.
    """
    order = order_of(tolerance)

    def at_least(parts: int) -> int:
        if parts > most:
            return 0
        share = 1 + 53 * (parts - 1) * math.log(2) / math.log(tolerance)
        return min(max(math.ceil(order * share), 0) + SPARE, order + 1)

    return at_least(3), at_least(2), order + 1


def split(value: Scalar, parts: int) -> tuple[float, ...]:
    """An mpmath number as so many doubles."""
    found = []
    for _ in range(parts):
        part = float(value)
        found.append(part)
        value = value - part if math.isfinite(part) else 0
    return tuple(found)


def number(parts: Sequence[float], fn: Functions) -> Scalar:
    """The mpmath number of its parts."""
    return sum((fn.mpf(float(part)) for part in parts[1:]), fn.mpf(float(parts[0])))


class System:
    """y' = f(y) with parameters, for numbers of two or three ``parts``.

    ``define(entries, parameters, fn)`` gives the rates, and outputs as ``Kernel`` takes them.
    """

    def __init__(self, parts: int, entries: int, parameters: int, define: Callable[..., Any]):
        self.parts, self.graph = parts, Graph(entries, parameters)
        rates, outputs = define(tuple(self.graph.entries), self.graph.parameters, self.graph)
        self.kernel = Kernel(parts, self.graph, self.graph.with_turning(rates), outputs)

    @cached_property
    def machine(self) -> Machine:
        """The compiled functions."""
        return Machine(self.kernel.text())

    def pieces(
        self,
        start: Sequence[Scalar],
        parameters: Sequence[Scalar],
        until: Scalar,
        tolerance: float,
        fn: Functions,
        longest: float = math.inf,
        first: float | None = None,
    ) -> Iterator[Piece]:
        """Taylor steps from ``start`` at time 0, until they reach ``until`` or are no numbers.

        Numbers are those of an mpmath context, ``fn``. No step is longer than ``longest``; the
        ``first`` one has a bound of its own if it is given, and is a piece of its own then. The
        last one may end later than ``until``.
        """
        import numpy

        kernel, order, parts = self.kernel, order_of(tolerance), self.parts
        found = numbers(kernel.constants, parameters, fn)
        constants = numpy.array([split(found[one], parts) for one in kernel.constants] or [0.0])
        row = numpy.array([split(x, parts) for x in self.graph.with_turned(start, parameters, fn)]).T
        orders = numpy.array(orders_of(tolerance, parts), dtype=numpy.int64)
        work = aligned(kernel.work(order))
        run = self.machine.function("run", RUN, ctypes.c_int64)
        time, end = (0.0, 0.0, 0.0), float(until)
        longest = min(longest, end)
        while True:
            steps = STEPS if first is None else 1
            plane = (steps + 1) * (order + 2) * kernel.columns
            data = aligned(parts * plane)
            for part in range(parts):
                data[part * plane :][: row.shape[1]] = row[part]
            times = numpy.zeros(4 * (steps + 1))
            times[1:4] = time
            taken = run(
                data.ctypes.data, plane, steps, orders.ctypes.data, constants.ctypes.data,
                tolerance, min(first or longest, longest), end, times.ctypes.data,
                work.ctypes.data,
            )  # fmt: skip
            piece = Piece(self, orders, data.reshape(parts, steps + 1, order + 2, -1), times, taken)
            yield piece
            time, row, first = piece.end_time, piece.end_row, None
            if piece.good < taken or not time[0] < end:
                return


class Piece:
    """The series of some steps, one behind the other.

    ``coefficients`` has the axes (part, step, order, column). ``begins`` are the times of the
    steps' beginnings (step, part), ``lengths`` are doubles. Only the first ``good`` steps are
    finite numbers.
    """

    def __init__(self, system: System, orders: Array, data: Array, times: Array, taken: int):
        import numpy

        self.system, self.order = system, int(orders[-1]) - 1
        self._orders, self._data = orders, data
        self.coefficients = data[:, :taken, : self.order + 1]
        table = times.reshape(-1, 4)
        self.begins, self.lengths = table[:taken, 1:], table[:taken, 0]
        self.end_time = tuple(table[taken, 1:].tolist())
        entries = len(system.graph.entries)
        self.end_row = data[:, taken, 0, :entries].copy()
        finite = numpy.isfinite(data[0, 1 : taken + 1, 0, :entries]).all(axis=1)
        finite &= numpy.isfinite(self.coefficients[0]).all(axis=(1, 2))
        finite &= numpy.isfinite(self.lengths)
        self.good = taken if finite.all() else int(finite.argmin())

    def rows(self, steps: Array, taus: Sequence[Sequence[float]]) -> Array:
        """All columns in these steps, taus (in parts) behind their beginnings.

        Axes (row, part, column).
        """
        import numpy

        parts, columns = self.system.parts, self.system.kernel.columns
        steps = numpy.ascontiguousarray(steps, dtype=numpy.int64)
        at = numpy.ascontiguousarray(taus, dtype=float)
        into = numpy.empty((len(steps), parts, columns))
        self.system.machine.function("rows", ROWS)(
            self._data.ctypes.data, self._data[0].size, self._orders.ctypes.data,
            steps.ctypes.data, at.ctypes.data, len(steps), into.ctypes.data,
        )  # fmt: skip
        return into
