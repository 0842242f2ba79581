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
SPARE = 4  # orders computed in double-double beyond those that need it in theory


def order_of(tolerance: float) -> int:
    """The order that costs least: measured, on the reference scene."""
    return round(20 - math.log(tolerance) / 3)


def exact_orders(tolerance: float) -> int:
    """How many orders need double-double: the others' terms are below 2^-53 of the entries.

    As terms fall by the same factor from order to order, down to ``tolerance`` in the last one.
    """
    share = 1 + 53 * math.log(2) / math.log(tolerance)
    return max(math.ceil(order_of(tolerance) * share), 0) + SPARE


def split(value: Scalar) -> tuple[float, float]:
    """An mpmath number as hi and lo."""
    hi = float(value)
    return hi, float(value - hi) if math.isfinite(hi) else 0.0


class System:
    """y' = f(y) with parameters.

    ``define(entries, parameters, fn)`` gives the rates, and outputs as ``Kernel`` takes them.
    """

    def __init__(self, entries: int, parameters: int, define: Callable[..., Any]):
        self.graph = Graph(entries, parameters)
        rates, outputs = define(tuple(self.graph.entries), self.graph.parameters, self.graph)
        self.kernel = Kernel(self.graph, self.graph.with_turning(rates), outputs)

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
        longest: Callable[[int], float] = lambda piece: math.inf,
    ) -> Iterator[Piece]:
        """Taylor steps from ``start`` at time 0, until they reach ``until`` or are no numbers.

        Numbers are those of an mpmath context, ``fn``. ``longest(i)`` bounds the steps of the i-th
        piece; where it is finite for the first, that has one step. The last one may end later
        than ``until``.
        """
        import numpy

        kernel, order = self.kernel, order_of(tolerance)
        found = numbers(kernel.constants, parameters, fn)
        constants = numpy.array([split(found[one]) for one in kernel.constants] or [(0.0, 0.0)])
        row = numpy.array(
            [split(x) for x in self.graph.with_turned(start, parameters, fn)]
        ).T  # hi, lo
        work = aligned(kernel.work(order))
        run = self.machine.function("run", RUN, ctypes.c_int64)
        time, end, number = (0.0, 0.0), float(until), 0
        while True:
            steps = 1 if number == 0 and math.isfinite(longest(0)) else STEPS
            hi, lo = (aligned((steps + 1) * (order + 2) * kernel.columns) for _ in range(2))
            hi[: row.shape[1]], lo[: row.shape[1]] = row
            times = numpy.zeros(3 * steps + 2)
            times[:2] = time
            taken = run(
                hi.ctypes.data, lo.ctypes.data, steps, exact_orders(tolerance), order,
                constants.ctypes.data, tolerance, longest(number), end, times.ctypes.data,
                work.ctypes.data,
            )  # fmt: skip
            piece = Piece(self, tolerance, (hi, lo), times, taken)
            yield piece
            time, row = piece.end_time, piece.end_row
            if piece.good < taken or not time[0] < end:
                return
            number += 1


class Piece:
    """The series of some steps, one behind the other.

    ``coefficients`` are arrays (step, order, column), hi and lo; ``times`` those of the steps'
    beginnings (hi, lo) and lengths (hi alone). Only the first ``good`` steps are finite numbers.
    """

    def __init__(
        self, system: System, tolerance: float, data: tuple[Array, Array], times: Array, taken: int
    ):
        import numpy

        self.system, self.order = system, order_of(tolerance)
        self._exact, self._data = exact_orders(tolerance), data
        shape = -1, self.order + 2, system.kernel.columns
        hi, lo = (part.reshape(shape) for part in data)
        self.coefficients = hi[:taken, : self.order + 1], lo[:taken, : self.order + 1]
        table = times[: 3 * taken].reshape(-1, 3)
        self.begins, self.lengths = table[:, :2], table[:, 2]
        self.end_time = float(times[3 * taken]), float(times[3 * taken + 1])
        entries = len(system.graph.entries)
        self.end_row = numpy.array([hi[taken, 0, :entries], lo[taken, 0, :entries]])
        finite = numpy.isfinite(hi[1 : taken + 1, 0, :entries]).all(axis=1)
        finite &= numpy.isfinite(self.coefficients[0]).all(axis=(1, 2))
        finite &= numpy.isfinite(self.lengths)
        self.good = taken if finite.all() else int(finite.argmin())

    def rows(self, steps: Array, tau: tuple[Array, Array]) -> tuple[Array, Array]:
        """All columns in these steps, ``tau`` (hi, lo) behind their beginnings: (row, column)."""
        import numpy

        steps = numpy.ascontiguousarray(steps, dtype=numpy.int64)
        hi, lo = (numpy.ascontiguousarray(part, dtype=float) for part in tau)
        columns = self.system.kernel.columns
        into = numpy.empty((len(steps), 2 * columns))
        self.system.machine.function("rows", ROWS)(
            *(part.ctypes.data for part in self._data), self._exact, self.order,
            steps.ctypes.data, hi.ctypes.data, lo.ctypes.data, len(steps), into.ctypes.data,
        )  # fmt: skip
        return into[:, :columns], into[:, columns:]
