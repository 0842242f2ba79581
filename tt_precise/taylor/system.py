"""``System``: compiled differential equations, and Taylor steps from any start."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy
from mpmath.libmp import from_float, fzero, mpf_add, mpf_sub, to_float

from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.taylor.graph import Graph, numbers
from tt_precise.taylor.machine import MOST_LIMBS, MOST_ORDER, TIMES, Machine, aligned

# Taylor steps in the first piece and at most in one: few are in vain behind the end of a motion.
FEWEST_STEPS, MOST_STEPS = 64, 512
# of time; where 57 powers of it are out of range, less by and by
FIRST_UNIT, LESS, LEAST_UNIT = 2.0**-3, 2.0**-16, 2.0**-200
SPARE_ORDERS = 4  # orders computed in more limbs than they need in theory


def order_of(tolerance: float) -> int:
    """The order that costs least: measured, on the reference scene.

    Raises ``ValueError``: the tolerance is not between 0 and 1, or needs an order above
    ``MOST_ORDER``.
    """
    order = round(20 - math.log(tolerance) / 3) if 0 < tolerance < 1 else 0
    if not 0 < order <= MOST_ORDER:
        raise ValueError(
            f"tolerance: got {tolerance:g}, expected one below 1 that an order of {MOST_ORDER} "
            "reaches, some 1e-103"
        )
    return order


def orders_of(tolerance: float, most: int) -> tuple[int, int, int]:
    """Numbers of coefficients computed in three doubles, in two or more, in one or more.

    As terms fall by the same factor from order to order, down to ``tolerance`` in the last one,
    those of some order on are below 2^-53 of the components, and need one limb less.
    """
    order = order_of(tolerance)

    def at_least(limbs: int) -> int:
        if limbs > most:
            return 0
        share = 1 + 53 * (limbs - 1) * math.log(2) / math.log(tolerance)
        return min(max(math.ceil(order * share), 0) + SPARE_ORDERS, order + 1)

    return at_least(3), at_least(2), order + 1


Definition: TypeAlias = Callable[..., Any]
"""A function of components, parameters and fn that returns rates and outputs."""


class System:
    """y' = f(y) with parameters, for numbers of two or three ``limbs``.

    ``define(components, parameters, fn)`` gives the rates, and outputs as ``Kernel`` takes them.
    A ``brief`` motion has so few steps that optimised code would not pay.
    """

    def __init__(
        self, limbs: int, components: int, parameters: int, define: Definition, brief: bool = False
    ):
        from tt_precise.taylor.kernel import Kernel

        self.limbs, self.graph = limbs, Graph(components, parameters)
        rates, outputs = define(tuple(self.graph.components), self.graph.parameters, self.graph)
        self.kernel = Kernel(limbs, self.graph, self.graph.with_turning(rates), outputs)
        self.machine = Machine(self.kernel.text(), brief=brief)

    def initial_data(
        self, start: Sequence[Scalar], parameters: Sequence[Scalar], fn: Functions
    ) -> tuple[Array, Array]:
        """The initial data of ``pieces``, in limbs: the first row and the constants.

        Numbers are those of an mpmath context, ``fn``.
        """
        constants = numbers(self.kernel.constants, parameters, fn)
        row = self.graph.with_turned(start, parameters, fn)
        return numpy.array([split(x, self.limbs) for x in row]).T, numpy.array(
            [split(constants[constant], self.limbs) for constant in self.kernel.constants]
        )

    def pieces(
        self,
        initial: tuple[Array, Array],
        until: float,
        tolerance: float,
        longest: float = math.inf,
    ) -> Iterator[StepBlock]:
        """Taylor steps from time 0 to ``until``, or to a step with NaN.

        No step is longer than ``longest``. The last one may end later than ``until``.
        """
        kernel, order, limbs = self.kernel, order_of(tolerance), self.limbs
        row, constants = initial
        orders = numpy.array(orders_of(tolerance, limbs), dtype=numpy.int64)
        work = numpy.zeros(kernel.work(order))
        time = numpy.array([FIRST_UNIT, 0.0, 0.0, 0.0])
        longest, count = min(longest, until), FEWEST_STEPS
        while True:
            plane = (count + 1) * (order + 2) * kernel.columns
            data = aligned(limbs * plane)
            for limb in range(limbs):
                data[limb * plane :][: row.shape[1]] = row[limb]
            times = numpy.zeros((count + 1, TIMES))
            times[0, :4] = time
            taken = self.machine.run(
                data.ctypes.data, plane, count, orders.ctypes.data, constants.ctypes.data,
                tolerance, longest, until, times.ctypes.data, work.ctypes.data,
            )  # fmt: skip
            steps = data.reshape(limbs, count + 1, order + 2, -1)
            piece = StepBlock(self, orders, steps, times, taken)
            if piece.good < taken and times[piece.good, 0] > LEAST_UNIT:
                # its terms may only be too large for this unit of time
                taken, shorter = piece.good, LESS
                piece = StepBlock(self, orders, piece.data, times, taken)
            else:
                shorter = 1.0
            if taken:
                yield piece
                time, row, count = times[taken, :4], piece.end_row, min(4 * count, MOST_STEPS)
            time[0] *= shorter
            if piece.good < taken or not piece.end_time[0] < until:
                return


class StepBlock:
    """The series of consecutive steps, each in powers of time over its unit.

    ``coefficients`` are the first limbs, axes (step, order, column). ``begins`` are the times of
    the steps' beginnings (step, limb), ``units`` powers of two, and ``lengths`` the steps' in
    these. Only the first ``good`` steps are finite numbers; outputs vanish in none but the
    ``suspect`` ones.
    """

    def __init__(self, system: System, orders: Array, data: Array, times: Array, taken: int):
        self.system, self.order = system, int(orders[-1]) - 1
        self._orders, self.data, self._times = orders, data, times
        components = len(system.graph.components)
        self._used = components + len(system.kernel.outputs)
        self.coefficients = data[0, :taken, : self.order + 1, : self._used]
        self.units, self.lengths = times[:taken, 0], times[:taken, 4]
        self.begins = times[:taken, 1:4]
        self.end_time = tuple(times[taken, 1:4].tolist())
        self.end_row = self.row(taken)
        suspect = times[:taken, 5].nonzero()[0]
        # a NaN in the series of a component makes the state at the end of the step NaN
        finite = numpy.isfinite(self.lengths) & (self.lengths > 0)
        finite &= numpy.isfinite(data[0, 1 : taken + 1, 0, :components]).all(axis=1)
        outputs = self.coefficients[suspect, :, components:]
        finite[suspect] &= numpy.isfinite(outputs).all(axis=(1, 2))
        self.good = taken if finite.all() else int(finite.argmin())
        self.suspect = suspect[suspect < self.good]

    def row(self, step: int) -> Array:
        """The components where a step begins: axes (limb, component)."""
        components: Array = self.data[:, step, 0, : len(self.system.graph.components)].copy()
        return components

    def at(self, times: Array) -> Array:
        """All columns at these times, given in three limbs: axes (time, limb, column)."""
        steps = numpy.searchsorted(self.begins[:, 0], times[:, 0], side="right") - 1
        return self.rows(numpy.maximum(steps, 0), times)

    def rows(self, steps: Array, times: Array) -> Array:
        """Return the rows by the series of given steps."""
        times = numpy.ascontiguousarray(times)
        into = numpy.empty((len(steps), self.system.limbs, self.system.kernel.columns))
        self.system.machine.rows(
            self.data.ctypes.data, self.data[0].size, self._orders.ctypes.data,
            self._times.ctypes.data, steps.ctypes.data, times.ctypes.data, len(steps),
            into.ctypes.data,
        )  # fmt: skip
        return into[:, :, : self._used]


# ---- numbers of several doubles, in and out of mpmath ------------------------------------------


def split(value: Scalar, limbs: int) -> tuple[float, ...]:
    """An mpmath number as ``limbs`` doubles, each the nearest to the remainder."""
    left, doubles = value._mpf_, []
    for _ in range(limbs):
        limb = to_float(left, rnd="n")
        doubles.append(limb)
        left = mpf_sub(left, from_float(limb)) if math.isfinite(limb) else fzero
    return tuple(doubles)


def moments(times: Iterable[Scalar]) -> Array:
    """Times for ``StepBlock``: axes (time, limb), with ``MOST_LIMBS`` limbs."""
    return numpy.array([split(time, MOST_LIMBS) for time in times])


def number(limbs: Sequence[float], fn: Functions) -> Scalar:
    """The mpmath number of its limbs."""
    total = from_float(limbs[0])
    for limb in limbs[1:]:
        total = mpf_add(total, from_float(limb))
    return fn.make_mpf(total)


def numbers_of(row: Array, fn: Functions) -> tuple[Scalar, ...]:
    """Return the numbers of a row (limb, column)."""
    return tuple(number(limbs, fn) for limbs in row.T.tolist())
