"""``System``: differential equations, compiled, and stepped from any start."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

from tt_precise.arithmetic import Array, Functions, Scalar
from tt_precise.taylor.graph import Graph, numbers
from tt_precise.taylor.machine import Machine, aligned
from tt_precise.taylor.numbers import added, split

STEPS = 512  # of a piece
# After so many steps the time has been lost that optimising takes: 9 of 14 us a step in
# double-double and 18 of 31 us in triple-double, 0.5 and 2.5 s to compile.
WORTH_OPTIMISING = 60_000
FIRST_UNIT = 2.0**-3  # of time; any that 57 powers of do not take out of range
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


class System:
    """y' = f(y) with parameters, for numbers of two or three ``parts``.

    ``define(entries, parameters, fn)`` gives the rates, and outputs as ``Kernel`` takes them.
    """

    def __init__(self, parts: int, entries: int, parameters: int, define: Callable[..., Any]):
        from tt_precise.taylor.kernel import Kernel

        self.parts, self.graph, self._steps = parts, Graph(entries, parameters), 0
        rates, outputs = define(tuple(self.graph.entries), self.graph.parameters, self.graph)
        self.kernel = Kernel(parts, self.graph, self.graph.with_turning(rates), outputs)

    @cached_property
    def machine(self) -> Machine:
        """The compiled functions, not optimised before that has paid for itself."""
        return Machine(self._text, level=0)

    @cached_property
    def _text(self) -> str:
        return self.kernel.text()

    def _stepped(self, steps: int) -> None:
        """Optimise after many steps: the bits stay."""
        before, self._steps = self._steps, self._steps + steps
        if before < WORTH_OPTIMISING <= self._steps:
            # another thread may still be inside the one that is replaced
            self._slow, self.machine = self.machine, Machine(self._text)

    def pieces(
        self,
        start: Sequence[Scalar],
        parameters: Sequence[Scalar],
        until: Scalar,
        tolerance: float,
        fn: Functions,
        longest: float = math.inf,
        first: float | None = None,
    ) -> Iterator[StepBlock]:
        """Taylor steps from ``start`` at time 0, until they reach ``until`` or are no numbers.

        Numbers are those of an mpmath context, ``fn``. No step is longer than ``longest``; the
        ``first`` one has a bound of its own if it is given, and is a piece of its own then. The
        last one may end later than ``until``.
        """
        import numpy

        kernel, order, parts = self.kernel, order_of(tolerance), self.parts
        found = numbers(kernel.constants, parameters, fn)
        constants = numpy.array([split(found[one], parts) for one in kernel.constants])
        first_row = self.graph.with_turned(start, parameters, fn)
        row = numpy.array([split(x, parts) for x in first_row]).T
        orders = numpy.array(orders_of(tolerance, parts), dtype=numpy.int64)
        work = aligned(kernel.work(order))
        time, end = numpy.array([FIRST_UNIT, 0.0, 0.0, 0.0]), float(until)
        longest = min(longest, end)
        while True:
            steps = STEPS if first is None else 1
            plane = (steps + 1) * (order + 2) * kernel.columns
            data = aligned(parts * plane)
            for part in range(parts):
                data[part * plane :][: row.shape[1]] = row[part]
            times = numpy.zeros((steps + 1, 5))
            times[0, :4] = time
            taken = self.machine.run(
                data.ctypes.data, plane, steps, orders.ctypes.data, constants.ctypes.data,
                tolerance, min(first or longest, longest), end, times.ctypes.data,
                work.ctypes.data,
            )  # fmt: skip
            piece = StepBlock(
                self, orders, data.reshape(parts, steps + 1, order + 2, -1), times, taken
            )
            self._stepped(taken)
            yield piece
            time, row = times[taken, :4], piece.end_row
            if first is not None:
                time[0], first = FIRST_UNIT, None  # a step that was cut says nothing of the next
            if piece.good < taken or not piece.end_time[0] < end:
                return


class StepBlock:
    """The series of some steps, one behind the other, each in powers of time over its unit.

    ``coefficients`` has the axes (part, step, order, column). ``begins`` are the times of the
    steps' beginnings (step, part), ``units`` powers of two, and ``lengths`` the steps' in these.
    Only the first ``good`` steps are finite numbers.
    """

    def __init__(self, system: System, orders: Array, data: Array, times: Array, taken: int):
        import numpy

        self.system, self.order = system, int(orders[-1]) - 1
        self._orders, self._data = orders, data
        self.coefficients = data[:, :taken, : self.order + 1]
        self.units, self.begins, self.lengths = (
            times[:taken].T[0],
            times[:taken, 1:4],
            times[:taken, 4],
        )
        self.end_time = tuple(times[taken, 1:4].tolist())
        entries = len(system.graph.entries)
        self.end_row = data[:, taken, 0, :entries].copy()
        # what is no number in the series of an entry leaves none where the step ends
        finite = numpy.isfinite(data[0, 1 : taken + 1, 0, :entries]).all(axis=1)
        finite &= numpy.isfinite(self.coefficients[0, :, :, entries:]).all(axis=(1, 2))
        finite &= numpy.isfinite(self.lengths)
        self.good = taken if finite.all() else int(finite.argmin())

    def at(self, times: Array) -> Array:
        """All columns at these times, given in parts: axes (time, part, column)."""
        import numpy

        steps = numpy.searchsorted(self.begins[:, 0], times[:, 0], side="right") - 1
        steps = numpy.maximum(steps, 0)
        taus = added([*times.T, *-self.begins[steps].T], self.system.parts)
        return self.rows(steps, taus / self.units[steps, None])

    def rows(self, steps: Sequence[int] | Array, taus: Sequence[Sequence[float]]) -> Array:
        """All columns in these steps, taus (in parts, of their units) behind their beginnings.

        Axes (row, part, column).
        """
        import numpy

        parts, columns = self.system.parts, self.system.kernel.columns
        steps = numpy.ascontiguousarray(steps, dtype=numpy.int64)
        at = numpy.ascontiguousarray(taus, dtype=float)
        into = numpy.empty((len(steps), parts, columns))
        self.system.machine.rows(
            self._data.ctypes.data, self._data[0].size, self._orders.ctypes.data,
            steps.ctypes.data, at.ctypes.data, len(steps), into.ctypes.data,
        )  # fmt: skip
        return into
