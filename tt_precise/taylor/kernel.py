"""A graph of series as machine code: Taylor steps, and their polynomials read at any time.

The first orders of a step are computed in three or two doubles, the rest in fewer: a coefficient
of order n is multiplied by h^n, and where that is below 2^-53 of the sum one part less will do.
In every order all products are added up at once, four to a vector: the sum of a_j b_(n-j) for
j = 1 to n - 1 contains nothing of order n. What is left goes through the graph once.
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
from tt_precise.taylor.machine import MOST_ORDER, MOST_PARTS, ROWS, RUN, TIMES

TOGETHER = {3: 1, 2: 2, 1: 4}  # vectors of products added up in one loop, by parts of a number
LONGEST = 8.0  # step in its unit; its powers stay in range where nothing else bounds it


def padded(count: int) -> int:
    """The next multiple of a vector's length."""
    return -(-count // LANES) * LANES


class Kernel:
    """The layout of memory, and the functions that compute in it, in so many ``parts``.

    ``outputs`` are series to be kept with the entries: pairs of a series and whether its rate is
    wanted in its place. A step is a block of ``order`` + 2 rows of ``columns`` numbers:
    coefficients of the entries and behind them of the outputs, of powers of time over a unit that
    is a power of two about as long as the step, so that they are in range. The parts of the numbers
    of all steps stand one behind the other, ``plane`` doubles apart. ``orders`` are, for the
    functions, how many coefficients are computed in 3 parts, in 2 or more, in 1 or more.
    """

    def __init__(
        self,
        parts: int,
        graph: Graph,
        rates: Sequence[Scalar],
        outputs: Sequence[tuple[Scalar, bool]],
    ):
        self.parts, self.entries = parts, graph.entries
        self.rates = list(map(graph.named, rates))
        self.outputs = [(graph.named(value), slope) for value, slope in outputs]
        kept = [*self.rates, *(value for value, _ in self.outputs)]
        self.nodes = in_order(graph, [*graph.entries, *kept])
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
        self.columns = padded(len(self.entries) + len(self.outputs))

    def work(self, order: int) -> int:
        """Doubles that ``run`` needs for itself."""
        lanes = 2 * (order + 2) * self.width + 2 * self.width
        return self.parts * lanes + self.width + self.columns

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
        for parts in range(1, self.parts + 1):
            ops = SeveralDoubles(e, parts)
            above = e.order(orders, parts)
            below = e.order(orders, parts + 1) if parts < self.parts else e.i(0)
            count = e.b.add(e.b.sub(above, below), e.i(1))
            begun = [value for number in sums for value in ops.widened(number)]
            with e.loop(e.i(1), count, begun) as (j, values):
                row = e.index(e.b.sub(above, j), self.columns)
                for k, first in enumerate(groups):
                    place, mine = e.b.add(row, e.i(first)), slice(parts * k, parts * (k + 1))
                    term = tuple(e.load(part, place, VECTOR) for part in planes[:parts])
                    values[mine] = ops.products(term, (tuple(values[mine]), at[:parts]))
            sums = [tuple(values[parts * k :][:parts]) for k in range(len(groups))]
        return sums

    def _rows(self, module: ir.Module) -> None:
        """rows(data, plane, orders, times, steps, moments, count, into): many, each in its step.

        ``moments`` are times in three parts. Row by row of ``into`` all columns, part by part.
        """
        e = Emitter(module, "rows", ROWS, ir.VoidType())
        data, plane, orders, times, steps, moments, count, into = e.arguments
        block = e.index(e.b.add(e.order(orders, 1), e.i(1)), self.columns)
        parts, ops = range(self.parts), SeveralDoubles(e, MOST_PARTS)
        with e.loop(e.i(0), count) as (i, _):
            step = e.b.load(e.b.gep(steps, [i]))
            there = e.b.mul(step, block)
            planes = [e.behind(data, e.b.add(there, e.b.mul(e.i(k), plane))) for k in parts]
            unit, *begin = (e.load(times, e.index(step, TIMES, k)) for k in range(1 + MOST_PARTS))
            now = tuple(e.load(moments, e.index(i, MOST_PARTS, k)) for k in range(MOST_PARTS))
            since = ops.total(now, ops.negative(tuple(begin)))
            tau = tuple(e.b.fdiv(part, unit) for part in since[: self.parts])
            for group, number in enumerate(self.horner(e, planes, orders, tau, self.columns)):
                for part, value in enumerate(number):
                    place = part * self.columns + group * LANES
                    e.store(value, into, e.index(i, self.parts * self.columns, place))
        e.b.ret_void()


class _RunWriter:
    """run(data, plane, steps, orders, constants, tolerance, longest, until, times, work).

    Takes at most so many steps and returns how many; the first starts at row 0 of the first
    block. ``times`` has six numbers a step: its unit of time, where it begins in three parts, its
    length in that unit, and whether an output may vanish in it; ``longest`` bounds it in the unit
    of ``until``.
    """

    def __init__(self, kernel: Kernel, module: ir.Module):
        self.kernel = kernel
        self.e = e = Emitter(module, "run", RUN, INTEGER)
        (self.data, self.plane, self.steps, self.orders, self.constants, self.tolerance,
         self.longest, self.until, self.times, work) = e.arguments  # fmt: skip
        self.order = e.b.sub(e.order(self.orders, 1), e.i(1))
        inverses = (nearest(Fraction(1, n + 1), MOST_PARTS) for n in range(MOST_ORDER + 1))
        self.reciprocals = e.table([part for number in inverses for part in number])
        width, parts = kernel.width, range(kernel.parts)
        area = e.index(e.b.add(self.order, e.i(2)), width)
        taken = [e.b.mul(e.i(k), area) for k in range(2 * kernel.parts + 1)]
        self.left = [e.behind(work, taken[k]) for k in parts]
        self.right = [e.behind(work, taken[kernel.parts + k]) for k in parts]
        rest = e.behind(work, taken[-1])
        self.sums = [e.behind(rest, k * width) for k in parts]
        self.inverses = [e.behind(rest, (kernel.parts + k) * width) for k in parts]
        self.latest = e.behind(rest, 2 * kernel.parts * width)  # products of the order before
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
            planes = [e.b.mul(e.i(k), self.plane) for k in range(kernel.parts)]
            self.block = [e.behind(self.data, e.b.add(there, plane)) for plane in planes]
            time = e.behind(self.times, e.index(step, TIMES))
            self.unit = e.load(time, 0)
            self._coefficients(kernel.parts, e.i(0), first=True)
            begun: Value = e.i(1)
            self.sizes: dict[int, Value] = {}
            for parts in range(kernel.parts, 0, -1):
                with e.loop(begun, e.order(self.orders, parts)) as (n, _):
                    self._sums(n, parts)
                    self._coefficients(parts, n)
                begun = e.order(self.orders, parts)
                if parts > 1:
                    self.sizes[parts] = self._largest(self.latest, len(kernel.pairs))
            h = self._length()
            e.store(h, time, 1 + MOST_PARTS)
            e.store(self._may_vanish(h), time, 2 + MOST_PARTS)
            tau = SeveralDoubles(e, kernel.parts).widened((h,))
            row = padded(len(kernel.entries))
            reached = kernel.horner(e, self.block, self.orders, tau, row)
            for part, plane in enumerate(self.block):
                for group, number in enumerate(reached):
                    e.store(number[part], self.next_row, group * LANES)
                following = e.behind(plane, block)
                for i in range(len(kernel.entries)):
                    e.store(e.load(self.next_row, i), following, i)
            ops = SeveralDoubles(e, MOST_PARTS)
            begins = tuple(e.load(time, 1 + part) for part in range(MOST_PARTS))
            length = e.b.fmul(h, self.unit)
            ends = ops.total(begins, ops.widened((length,)))
            for part, value in enumerate((self._power_of_two(length), *ends)):
                e.store(value, time, TIMES + part)
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
        """The largest one that is not above a positive value: its exponent alone."""
        bits = self.e.b.bitcast(value, INTEGER)
        return self.e.b.bitcast(self.e.b.and_(bits, self.e.i(0x7FF << 52)), DOUBLE)

    def _length(self) -> Value:
        """The step whose last two terms are at most ``tolerance`` of the largest entry.

        And in which products are as small as ``orders`` supposes where one part less begins.
        """
        e, entries = self.e, len(self.kernel.entries)

        def entries_of(n: Value) -> Value:
            return self._largest(e.behind(self.block[0], e.index(n, self.kernel.columns)), entries)

        allowed = e.b.fmul(entries_of(e.i(0)), self.tolerance)
        checked = [(n, entries_of(n), 1.0) for n in (self.order, e.b.sub(self.order, e.i(1)))]
        for parts, size in self.sizes.items():
            last = e.b.sub(e.order(self.orders, parts), e.i(1))
            checked.append((last, size, 2.0 ** (53 * (parts - 1))))
        h = e.call("minnum", e.b.fdiv(self.longest, self.unit), e.d(LONGEST))
        for n, size, factor in checked:
            ratio = e.b.fdiv(e.b.fmul(allowed, e.d(factor)), size)
            power = e.b.fdiv(e.d(1.0), e.b.sitofp(n, DOUBLE))
            h = e.call("minnum", h, e.call("pow", ratio, power))
        return h

    def _may_vanish(self, h: Value) -> Value:
        """1 where the terms of an output's series outweigh half of its first one, or are none."""
        e, kernel = self.e, self.kernel
        first, wide = len(kernel.entries), e.spread(h)
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

    def _largest(self, pointer: Value, count: int) -> Value:
        e = self.e
        with e.loop(e.i(0), e.i(count), [e.d(0.0)]) as (i, largest):
            largest[0] = e.call("maxnum", largest[0], e.call("fabs", e.load(pointer, i)))
        return largest[0]

    def _sums(self, n: Value, parts: int) -> None:
        """For every lane, the sum of a_j b_(n-j) for j = 1 to n - 1."""
        e, width = self.e, self.kernel.width
        ops, zero = SeveralDoubles(e, parts), ir.Constant(VECTOR, None)
        for first in range(0, width, LANES * TOGETHER[parts]):
            group = range(first, min(first + LANES * TOGETHER[parts], width), LANES)
            with e.loop(e.i(1), n, [zero] * (parts * len(group))) as (j, sums):
                for k, lane in enumerate(group):
                    places = e.index(j, width, lane), e.index(e.b.sub(n, j), width, lane)
                    a, b = (
                        tuple(e.load(side[part], place, VECTOR) for part in range(parts))
                        for side, place in zip((self.left, self.right), places, strict=True)
                    )
                    mine = slice(parts * k, parts * (k + 1))
                    if parts == 1:
                        sums[mine] = ops.products(tuple(sums[mine]), (a, b))
                    else:
                        sums[mine] = ops.plus(tuple(sums[mine]), ops.times(a, b))
            for k, value in enumerate(sums):
                e.store(value, self.sums[k % parts], group[k // parts])

    def _coefficients(self, parts: int, n: Value, first: bool = False) -> None:
        """Coefficient n of every series, and n + 1 of the entries."""
        e, kernel = self.e, self.kernel
        ops = SeveralDoubles(e, parts)
        self.ops, self.first, self.n = ops, first, n
        order = self.order_number = ops.widened((e.b.sitofp(n, DOUBLE),))
        value: dict[Traced, Number] = {}
        for i, entry in enumerate(kernel.entries):
            value[entry] = self._read(self.block, e.index(n, kernel.columns, i))
        for node in kernel.nodes:
            if node not in value:
                value[node] = getattr(self, f"_{node.kind}")(node, value)
        for node, pair in kernel.pairs.items():
            if parts > 1:
                e.store(value[node][0], self.latest, kernel.lane[node])
            place = e.index(n, kernel.width, kernel.lane[node])
            for operand, side in zip(pair, (self.left, self.right), strict=True):
                self._write(value[operand], side, place)
        # what is written nowhere else is zero: the rest of a constant, the last term of a slope
        every = SeveralDoubles(e, kernel.parts)
        zero = every.widened((e.d(0.0),))
        for i, (output, slope) in enumerate(kernel.outputs, len(kernel.entries)):
            place = e.index(n, kernel.columns, i)
            if isinstance(output, Constant):
                constant = first and not slope
                self._write(self._constant(output) if constant else zero, self.block, place)
                continue
            self._write(zero if slope else value[output], self.block, place)
            if slope and not first:
                before = e.index(e.b.sub(n, e.i(1)), kernel.columns, i)
                self._write(every.widened(ops.product(order, value[output])), self.block, before)
        unit = ops.widened((self.unit,))
        inverse = tuple(e.b.fmul(part, self.unit) for part in self._reciprocal(n))
        for i, rate in enumerate(kernel.rates):
            place = e.index(e.b.add(n, e.i(1)), kernel.columns, i)
            if isinstance(rate, Traced):
                self._write(ops.times(value[rate], inverse), self.block, place)
            else:
                rest = ops.product(unit, self._constant(rate)) if first else zero
                self._write(rest, self.block, place)

    def _read(self, parts: Sequence[Value], place: Value | int) -> Number:
        return tuple(self.e.load(part, place) for part in parts[: self.ops.parts])

    def _write(self, number: Number, parts: Sequence[Value], place: Value | int) -> None:
        for value, part in zip(number, parts, strict=False):
            self.e.store(value, part, place)

    def _reciprocal(self, n: Value) -> Number:
        return self._read([self.e.behind(self.reciprocals, part) for part in range(MOST_PARTS)],
                          self.e.index(n, MOST_PARTS))  # fmt: skip

    def _constant(self, constant: Constant) -> Number:
        place = self.kernel.constants.index(constant) * self.kernel.parts
        parts = [self.e.behind(self.constants, part) for part in range(self.kernel.parts)]
        return self._read(parts, place)

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
        ends = (self._read(self.left, lane), value[b]), (value[a], self._read(self.right, lane))
        return self.ops.products(self._read(self.sums, lane), *ends)

    def _quotient(self, node: Traced, value: dict[Traced, Number]) -> Number:
        (a, b), ops, lane = node.args, self.ops, self.kernel.lane[node]
        if self.first:
            self._write(ops.quotient(ops.one, value[b]), self.inverses, lane)
            return ops.quotient(value[a] if a in value else self._constant(a), value[b])
        known = self._read(self.left, lane), value[b]
        rest = ops.negative(ops.products(self._read(self.sums, lane), known))
        if a in value:
            rest = ops.total(value[a], rest)
        return ops.product(rest, self._read(self.inverses, lane))

    def _root(self, node: Traced, value: dict[Traced, Number]) -> Number:
        ops, a, lane = self.ops, value[node.args[0]], self.kernel.lane[node]
        if self.first:
            root = ops.root(a)
            self._write(ops.quotient(ops.one, ops.total(root, root)), self.inverses, lane)
            return root
        rest = ops.total(a, ops.negative(self._read(self.sums, lane)))
        return ops.product(rest, self._read(self.inverses, lane))

    def _slope(self, node: Traced, value: dict[Traced, Number]) -> Number:
        return self.ops.product(self.order_number, value[node.args[0]])

    def _exponential(self, node: Traced, value: dict[Traced, Number]) -> Number:
        """n e_n is the sum of j a_j e_(n-j)."""
        (a, slope), lane = node.args, self.kernel.lane[node]
        if self.first:
            return self.ops.exponential(value[a])
        last = value[slope], self._read(self.right, lane)
        rest = self.ops.products(self._read(self.sums, lane), last)
        return self.ops.product(rest, self._reciprocal(self.e.b.sub(self.n, self.e.i(1))))
