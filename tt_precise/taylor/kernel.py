"""A graph of series as machine code: Taylor steps, and their polynomials at any time.

The first orders of a step are computed in three or two doubles, the other orders in fewer: a
coefficient of order n is multiplied by h^n, and one limb less suffices where this term is below
2^-53 of the sum. In every order all products are summed at once, four to a vector: the sum of
a_j b_(n-j) for j = 1 to n - 1 contains nothing of order n. The remaining terms need one pass
through the graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from llvmlite import ir

from tt_precise.runtime.values import Scalar
from tt_precise.taylor.emit import (
    DOUBLE,
    INTEGER,
    LANES,
    VECTOR,
    Emitter,
    Number,
    SeveralDoubles,
    Value,
    nearest,
)
from tt_precise.taylor.graph import Constant, Graph, Traced, constants_of, in_order
from tt_precise.taylor.machine import MOST_LIMBS, MOST_ORDER, ROWS, RUN, TIMES

TOGETHER = {3: 1, 2: 2, 1: 4}  # vectors of products added up in one loop, by limbs of a number
LONGEST = 8.0  # step in its unit; its powers stay in range where nothing else bounds it


def padded(count: int) -> int:
    """The next multiple of a vector's length."""
    return -(-count // LANES) * LANES


class Kernel:
    """The layout of memory, and the functions that compute in it, in ``limbs`` limbs.

    ``outputs`` are series to be kept with the components. A step is a block of ``order`` + 2 rows
    of ``columns`` numbers: coefficients of the components and behind them of the outputs, of powers
    of time over a unit that is a power of two about as long as the step, so that they are in range.
    The limbs of the numbers of all steps stand one behind the other, ``plane`` doubles apart.
    ``orders`` are, for the functions, how many coefficients are computed in 3 limbs, in 2 or more,
    in 1 or more.
    """

    def __init__(
        self, limbs: int, graph: Graph, rates: Sequence[Scalar], outputs: Sequence[Scalar]
    ):
        self.limbs, self.components = limbs, graph.components
        self.rates = list(map(graph.as_series, rates))
        self.outputs = list(map(graph.as_series, outputs))
        kept = [*self.rates, *self.outputs]
        self.nodes = in_order(graph, [*graph.components, *kept])
        alone = [output for output in kept if isinstance(output, Constant)]
        self.constants = list(dict.fromkeys([*constants_of(self.nodes), *alone]))
        # the two series whose products a lane adds up
        factors: dict[str, Any] = {
            "product": lambda node: node.args,
            "quotient": lambda node: (node, node.args[1]),
            "root": lambda node: (node, node),
            "exponential": lambda node: (node.args[1], node),
        }
        self.pairs = {n: factors[n.kind](n) for n in self.nodes if n.kind in factors}
        self.lane = {node: i for i, node in enumerate(self.pairs)}
        self.width = padded(max(len(self.pairs), 1))
        self.columns = padded(len(self.components) + len(self.outputs))

    def work(self, order: int) -> int:
        """The number of doubles in the working memory of ``run``."""
        lanes = 2 * (order + 2) * self.width + 2 * self.width
        return self.limbs * lanes + 2 * self.width + self.columns

    def text(self) -> str:
        """The module: functions ``run`` and ``rows``."""
        module = ir.Module("taylor")
        self._rows(module)
        _RunWriter(self, module).write()
        return str(module)

    def horner(
        self, e: Emitter, planes: Sequence[Value], orders: Value, tau: Number, columns: int
    ) -> list[Number]:
        """One step, whose series begin at ``planes``, at ``tau``: the first columns, by vectors."""
        at = tuple(map(e.spread, tau))
        groups = range(0, columns, LANES)
        sums: list[Number] = [(ir.Constant(VECTOR, None),) for _ in groups]
        for limbs in range(1, self.limbs + 1):
            ops = SeveralDoubles(e, limbs)
            above = e.order(orders, limbs)
            below = e.order(orders, limbs + 1) if limbs < self.limbs else e.i(0)
            count = e.b.add(e.b.sub(above, below), e.i(1))
            initial = [value for number in sums for value in ops.widened(number)]
            with e.loop(e.i(1), count, initial) as (j, values):
                row = e.index(e.b.sub(above, j), self.columns)
                for k, first in enumerate(groups):
                    position, mine = e.b.add(row, e.i(first)), slice(limbs * k, limbs * (k + 1))
                    term = tuple(e.load(limb, position, VECTOR) for limb in planes[:limbs])
                    values[mine] = ops.products(term, (tuple(values[mine]), at[:limbs]))
            sums = [tuple(values[limbs * k :][:limbs]) for k in range(len(groups))]
        return sums

    def _rows(self, module: ir.Module) -> None:
        """rows(data, plane, orders, times, steps, moments, count, into): many, each in its step.

        ``moments`` are times in three limbs. Row by row of ``into`` all columns, limb by limb.
        """
        e = Emitter(module, "rows", ROWS, ir.VoidType())
        data, plane, orders, times, steps, moments, count, into = e.arguments
        block = e.index(e.b.add(e.order(orders, 1), e.i(1)), self.columns)
        limbs, ops = range(self.limbs), SeveralDoubles(e, MOST_LIMBS)
        with e.loop(e.i(0), count) as (i, _):
            step = e.b.load(e.b.gep(steps, [i]))
            there = e.b.mul(step, block)
            planes = [e.behind(data, e.b.add(there, e.b.mul(e.i(k), plane))) for k in limbs]
            unit, *begin = (e.load(times, e.index(step, TIMES, k)) for k in range(1 + MOST_LIMBS))
            now = tuple(e.load(moments, e.index(i, MOST_LIMBS, k)) for k in range(MOST_LIMBS))
            since = ops.total(now, ops.negative(tuple(begin)))
            tau = tuple(e.b.fdiv(limb, unit) for limb in since[: self.limbs])
            for group, number in enumerate(self.horner(e, planes, orders, tau, self.columns)):
                for limb, value in enumerate(number):
                    position = limb * self.columns + group * LANES
                    e.store(value, into, e.index(i, self.limbs * self.columns, position))
        e.b.ret_void()


class _RunWriter:
    """run(data, plane, steps, orders, constants, tolerance, longest, until, times, work).

    Takes at most so many steps and returns how many; the first starts at row 0 of the first
    block. ``times`` has six numbers a step: its unit of time, where it begins in three limbs, its
    length in that unit, and whether an output may vanish in it; ``longest`` bounds it in the unit
    of ``until``.
    """

    def __init__(self, kernel: Kernel, module: ir.Module):
        self.kernel = kernel
        self.e = e = Emitter(module, "run", RUN, INTEGER)
        (self.data, self.plane, self.steps, self.orders, self.constants, self.tolerance,
         self.longest, self.until, self.times, work) = e.arguments  # fmt: skip
        self.order = e.b.sub(e.order(self.orders, 1), e.i(1))
        inverses = (nearest(Fraction(1, n + 1), MOST_LIMBS) for n in range(MOST_ORDER + 1))
        self.reciprocals = e.table([limb for number in inverses for limb in number])
        width, limbs = kernel.width, range(kernel.limbs)
        area = e.index(e.b.add(self.order, e.i(2)), width)
        taken = [e.b.mul(e.i(k), area) for k in range(2 * kernel.limbs + 1)]
        self.left = [e.behind(work, taken[k]) for k in limbs]
        self.right = [e.behind(work, taken[kernel.limbs + k]) for k in limbs]
        rest = e.behind(work, taken[-1])
        self.sums = [e.behind(rest, k * width) for k in limbs]
        self.inverses = [e.behind(rest, (kernel.limbs + k) * width) for k in limbs]
        self.initial = e.behind(rest, 2 * kernel.limbs * width)  # products of order 0
        self.latest = e.behind(self.initial, width)  # products of the order before
        self.next_row = e.behind(self.latest, width)

    def write(self) -> None:
        """All of the function."""
        e, kernel = self.e, self.kernel
        block = e.index(e.b.add(self.order, e.i(2)), kernel.columns)
        last = e.function.append_basic_block("last")
        taken = e.b.alloca(INTEGER)
        e.b.store(self.steps, taken)
        with e.loop(e.i(0), self.steps) as (step, _):
            there = e.b.mul(step, block)
            planes = [e.b.mul(e.i(k), self.plane) for k in range(kernel.limbs)]
            self.block = [e.behind(self.data, e.b.add(there, plane)) for plane in planes]
            time = e.behind(self.times, e.index(step, TIMES))
            self.unit = e.load(time, 0)
            self._coefficients(kernel.limbs, e.i(0), first=True)
            initial: Value = e.i(1)
            self.sizes: dict[int, Value] = {}
            for limbs in range(kernel.limbs, 0, -1):
                with e.loop(initial, e.order(self.orders, limbs)) as (n, _):
                    self._sums(n, limbs)
                    self._coefficients(limbs, n)
                initial = e.order(self.orders, limbs)
                if limbs > 1:
                    self.sizes[limbs] = self._largest_product()
            h = self._length()
            e.store(h, time, 1 + MOST_LIMBS)
            e.store(self._may_vanish(h), time, 2 + MOST_LIMBS)
            tau = SeveralDoubles(e, kernel.limbs).widened((h,))
            row = padded(len(kernel.components))
            reached = kernel.horner(e, self.block, self.orders, tau, row)
            for limb, plane in enumerate(self.block):
                for group, number in enumerate(reached):
                    e.store(number[limb], self.next_row, group * LANES)
                following = e.behind(plane, block)
                for i in range(len(kernel.components)):
                    e.store(e.load(self.next_row, i), following, i)
            ops = SeveralDoubles(e, MOST_LIMBS)
            begins = tuple(e.load(time, 1 + limb) for limb in range(MOST_LIMBS))
            length = e.b.fmul(h, self.unit)
            ends = ops.total(begins, ops.widened((length,)))
            for limb, value in enumerate((self._power_of_two(length), *ends)):
                e.store(value, time, TIMES + limb)
            stop, more = (e.function.append_basic_block(n) for n in ("stop", "more"))
            # NaN is not below the end either
            e.b.cbranch(e.b.fcmp_ordered("<", ends[0], self.until), more, stop)
            e.b.position_at_end(stop)
            e.b.store(e.b.add(step, e.i(1)), taken)
            e.b.branch(last)
            e.b.position_at_end(more)
        e.b.branch(last)
        e.b.position_at_end(last)
        e.b.ret(e.b.load(taken))

    def _power_of_two(self, value: Value) -> Value:
        """The largest power of two up to a positive value: the value's exponent alone."""
        bits = self.e.b.bitcast(value, INTEGER)
        return self.e.b.bitcast(self.e.b.and_(bits, self.e.i(0x7FF << 52)), DOUBLE)

    def _length(self) -> Value:
        """The step whose last two terms are at most ``tolerance`` of the largest component.

        And in which products are as small as ``orders`` supposes where one limb less begins.
        """
        e = self.e
        allowed = e.b.fmul(self._largest(e.i(0)), self.tolerance)
        checked = [(n, self._largest(n), 1.0) for n in (self.order, e.b.sub(self.order, e.i(1)))]
        for limbs, size in self.sizes.items():
            last = e.b.sub(e.order(self.orders, limbs), e.i(1))
            checked.append((last, size, 2.0 ** (53 * (limbs - 1))))
        h = e.call("minnum", e.b.fdiv(self.longest, self.unit), e.d(LONGEST))
        for n, size, factor in checked:
            ratio = e.b.fdiv(e.b.fmul(allowed, e.d(factor)), size)
            power = e.b.fdiv(e.d(1.0), e.b.sitofp(n, DOUBLE))
            h = e.call("minnum", h, e.call("pow", ratio, power))
        return h

    def _may_vanish(self, h: Value) -> Value:
        """1 if the later terms of an output's series exceed half of the first, or are NaN."""
        e, kernel = self.e, self.kernel
        first, wide = len(kernel.components), e.spread(h)
        groups = range(first // LANES * LANES, kernel.columns, LANES)
        with e.loop(e.i(0), self.order, [ir.Constant(VECTOR, None)] * len(groups)) as (j, sums):
            row = e.index(e.b.sub(self.order, j), kernel.columns)
            for k, group in enumerate(groups):
                term = e.load(self.block[0], e.b.add(row, e.i(group)), VECTOR)
                sums[k] = e.b.fmul(e.b.fadd(sums[k], e.call("fabs", term)), wide)
        vanishes: Value = ir.Constant(ir.IntType(1), 0)
        for i in range(first, first + len(kernel.outputs)):
            lane = ir.Constant(ir.IntType(32), i % LANES)
            rest = e.b.extract_element(sums[i // LANES - first // LANES], lane)
            size = e.call("fabs", e.load(self.block[0], i))
            small = e.b.fcmp_ordered("<", e.b.fadd(rest, rest), size)
            vanishes = e.b.or_(vanishes, e.b.not_(small))
        return e.b.uitofp(vanishes, DOUBLE)

    def _largest(self, n: Value) -> Value:
        """The largest coefficient of order n of the components."""
        e = self.e
        row = e.behind(self.block[0], e.index(n, self.kernel.columns))
        with e.loop(e.i(0), e.i(len(self.kernel.components)), [e.d(0.0)]) as (i, largest):
            largest[0] = e.call("maxnum", largest[0], e.call("fabs", e.load(row, i)))
        return largest[0]

    def _largest_product(self) -> Value:
        """The largest of the latest products, in the scale of the components.

        A product that exceeds all components, such as 1/v near rest, counts relative to its own
        value: measured against the components, it would stop the steps.
        """
        e, scale = self.e, self._largest(self.e.i(0))
        with e.loop(e.i(0), e.i(len(self.kernel.pairs)), [e.d(0.0)]) as (i, largest):
            own = e.call("maxnum", e.call("fabs", e.load(self.initial, i)), scale)
            size = e.b.fmul(e.call("fabs", e.load(self.latest, i)), e.b.fdiv(scale, own))
            largest[0] = e.call("maxnum", largest[0], size)
        return largest[0]

    def _sums(self, n: Value, limbs: int) -> None:
        """The sum of a_j b_(n-j) for j = 1 to n - 1, in every lane."""
        e, width = self.e, self.kernel.width
        ops, zero = SeveralDoubles(e, limbs), ir.Constant(VECTOR, None)
        for first in range(0, width, LANES * TOGETHER[limbs]):
            group = range(first, min(first + LANES * TOGETHER[limbs], width), LANES)
            with e.loop(e.i(1), n, [zero] * (limbs * len(group))) as (j, sums):
                for k, lane in enumerate(group):
                    positions = e.index(j, width, lane), e.index(e.b.sub(n, j), width, lane)
                    a, b = (
                        tuple(e.load(side[limb], position, VECTOR) for limb in range(limbs))
                        for side, position in zip((self.left, self.right), positions, strict=True)
                    )
                    mine = slice(limbs * k, limbs * (k + 1))
                    if limbs == 1:
                        sums[mine] = ops.products(tuple(sums[mine]), (a, b))
                    else:
                        sums[mine] = ops.plus(tuple(sums[mine]), ops.times(a, b))
            for k, value in enumerate(sums):
                e.store(value, self.sums[k % limbs], group[k // limbs])

    def _coefficients(self, limbs: int, n: Value, first: bool = False) -> None:
        """Coefficient n of every series, and n + 1 of the components."""
        e, kernel = self.e, self.kernel
        ops = SeveralDoubles(e, limbs)
        self.ops, self.first, self.n = ops, first, n
        self.order_number = ops.widened((e.b.sitofp(n, DOUBLE),))
        value: dict[Traced, Number] = {}
        for i, component in enumerate(kernel.components):
            value[component] = self._load(self.block, e.index(n, kernel.columns, i))
        for node in kernel.nodes:
            if node not in value:
                value[node] = getattr(self, f"_{node.kind}")(node, value)
        for node, pair in kernel.pairs.items():
            if limbs > 1:
                products = self.initial if first else self.latest
                e.store(value[node][0], products, kernel.lane[node])
            position = e.index(n, kernel.width, kernel.lane[node])
            for operand, side in zip(pair, (self.left, self.right), strict=True):
                self._write(value[operand], side, position)
        # what is written nowhere else is zero: the rest of a constant
        every = SeveralDoubles(e, kernel.limbs)
        zero = every.widened((e.d(0.0),))
        for i, output in enumerate(kernel.outputs, len(kernel.components)):
            if isinstance(output, Constant):
                limbs_of_output = self._constant(output) if first else zero
            else:
                limbs_of_output = value[output]
            self._write(limbs_of_output, self.block, e.index(n, kernel.columns, i))
        unit = ops.widened((self.unit,))
        inverse = tuple(e.b.fmul(limb, self.unit) for limb in self._reciprocal(n))
        for i, rate in enumerate(kernel.rates):
            position = e.index(e.b.add(n, e.i(1)), kernel.columns, i)
            if isinstance(rate, Traced):
                self._write(ops.times(value[rate], inverse), self.block, position)
            else:
                rest = ops.product(unit, self._constant(rate)) if first else zero
                self._write(rest, self.block, position)

    def _load(self, limbs: Sequence[Value], position: Value | int) -> Number:
        return tuple(self.e.load(limb, position) for limb in limbs[: self.ops.limbs])

    def _write(self, number: Number, limbs: Sequence[Value], position: Value | int) -> None:
        for value, limb in zip(number, limbs, strict=False):
            self.e.store(value, limb, position)

    def _reciprocal(self, n: Value) -> Number:
        return self._load([self.e.behind(self.reciprocals, limb) for limb in range(MOST_LIMBS)],
                          self.e.index(n, MOST_LIMBS))  # fmt: skip

    def _constant(self, constant: Constant) -> Number:
        position = self.kernel.constants.index(constant) * self.kernel.limbs
        limbs = [self.e.behind(self.constants, limb) for limb in range(self.kernel.limbs)]
        return self._load(limbs, position)

    def _sum(self, node: Traced, value: dict[Traced, Number]) -> Number:
        offset, terms = node.args
        summands = []
        for factor, series in terms:
            if isinstance(factor, Constant):
                summands.append(self.ops.times(self._constant(factor), value[series]))
            else:
                summands.append(value[series] if factor == 1 else self.ops.negative(value[series]))
        if self.first and isinstance(offset, Constant):
            summands.append(self._constant(offset))
        first, *rest = summands
        for number in rest:
            first = self.ops.plus(first, number)
        return first

    def _product(self, node: Traced, value: dict[Traced, Number]) -> Number:
        a, b = node.args
        if self.first:
            return self.ops.product(value[a], value[b])
        lane = self.kernel.lane[node]
        ends = (self._load(self.left, lane), value[b]), (value[a], self._load(self.right, lane))
        return self.ops.products(self._load(self.sums, lane), *ends)

    def _quotient(self, node: Traced, value: dict[Traced, Number]) -> Number:
        (a, b), ops, lane = node.args, self.ops, self.kernel.lane[node]
        if self.first:
            self._write(ops.quotient(ops.one, value[b]), self.inverses, lane)
            return ops.quotient(value[a] if a in value else self._constant(a), value[b])
        last = self._load(self.left, lane), value[b]
        rest = ops.negative(ops.products(self._load(self.sums, lane), last))
        if a in value:
            rest = ops.total(value[a], rest)
        return ops.product(rest, self._load(self.inverses, lane))

    def _root(self, node: Traced, value: dict[Traced, Number]) -> Number:
        ops, a, lane = self.ops, value[node.args[0]], self.kernel.lane[node]
        if self.first:
            root = ops.root(a)
            self._write(ops.quotient(ops.one, ops.total(root, root)), self.inverses, lane)
            return root
        rest = ops.total(a, ops.negative(self._load(self.sums, lane)))
        return ops.product(rest, self._load(self.inverses, lane))

    def _slope(self, node: Traced, value: dict[Traced, Number]) -> Number:
        return self.ops.product(self.order_number, value[node.args[0]])

    def _exponential(self, node: Traced, value: dict[Traced, Number]) -> Number:
        """n e_n is the sum of j a_j e_(n-j)."""
        (a, slope), lane = node.args, self.kernel.lane[node]
        if self.first:
            return self.ops.exponential(value[a])
        last = value[slope], self._load(self.right, lane)
        rest = self.ops.products(self._load(self.sums, lane), last)
        return self.ops.product(rest, self._reciprocal(self.e.b.sub(self.n, self.e.i(1))))
