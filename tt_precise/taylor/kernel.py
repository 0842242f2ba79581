"""A graph of series as machine code: Taylor steps, and their polynomials read at any time.

The first orders of a step are computed in double-double and the rest in double: a coefficient of
order n is multiplied by h^n, and where that is below 2^-53 of the sum a double is enough for it.
In every order all products are added up at once, four to a vector: the sum of a_j b_(n-j) for
j = 1 to n - 1 contains nothing of order n. What is left goes through the graph once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir

from tt_precise.arithmetic import Scalar
from tt_precise.taylor.emit import (
    DOUBLE,
    INTEGER,
    LANES,
    VECTOR,
    Double,
    DoubleDouble,
    Emitter,
    Number,
    Value,
)
from tt_precise.taylor.graph import Constant, Graph, Series, constants_of, in_order

TOGETHER = {2: 2, 1: 4}  # vectors of products added up in one loop, by parts of a number
RUN, ROWS = "ppiiipdddpp", "ppiinppip"  # arguments, as ``Emitter`` has them


def padded(count: int) -> int:
    """The next multiple of a vector's length."""
    return -(-count // LANES) * LANES


class Kernel:
    """What stands where, and the functions that compute it.

    ``outputs`` are series to be kept beside the entries: pairs of one and whether its rate is
    wanted in its place. A step is a block of ``order`` + 2 rows of ``columns`` numbers, hi and lo
    apart: coefficients of the entries and behind them of the outputs.
    """

    def __init__(
        self, graph: Graph, rates: Sequence[Scalar], outputs: Sequence[tuple[Scalar, bool]]
    ):
        self.entries = graph.entries
        self.rates = list(map(graph.named, rates))
        self.outputs = [(graph.named(value), slope) for value, slope in outputs]
        kept = [*self.rates, *(value for value, _ in self.outputs)]
        self.nodes = in_order(graph, [*graph.entries, *kept])
        alone = [one for one in kept if isinstance(one, Constant)]
        self.constants = list(dict.fromkeys([*constants_of(self.nodes), *alone]))
        # the two series whose products a lane adds up
        factors: dict[str, Any] = {
            "product": lambda node: node.args,
            "quotient": lambda node: (node, node.args[1]),
            "root": lambda node: (node, node),
        }
        self.pairs = {n: factors[n.kind](n) for n in self.nodes if n.kind in factors}
        self.lane = {node: i for i, node in enumerate(self.pairs)}
        self.width = padded(max(len(self.pairs), 1))
        self.columns = padded(len(self.entries) + len(self.outputs))

    def work(self, order: int) -> int:
        """Doubles that ``run`` needs for itself."""
        return 4 * (order + 2) * self.width + 4 * self.width + 2 * self.columns

    def text(self) -> str:
        """The module: functions ``run`` and ``rows``."""
        module = ir.Module("taylor")
        self._row(module)
        self._rows(module)
        _Run(self, module).write()
        return str(module)

    def _row(self, module: ir.Module) -> None:
        """row(hi, lo, exact, order, tau hi, tau lo, columns, into): one step at tau; Horner."""
        e = Emitter(module, "row", "ppiiddip", ir.VoidType())
        e.function.attributes.add("alwaysinline")
        hi, lo, exact, order, tau_hi, tau_lo, columns, into = e.arguments
        tau, zero = (e.spread(tau_hi), e.spread(tau_lo)), ir.Constant(VECTOR, None)
        with e.loop(e.i(0), e.b.udiv(columns, e.i(LANES))) as (group, _):
            first = e.b.mul(group, e.i(LANES))
            above = e.b.add(order, e.i(1))
            with e.loop(e.i(0), e.b.sub(above, exact), [zero]) as (j, found):
                place = e.b.add(e.index(e.b.sub(order, j), self.columns), first)
                found[0] = e.call("fma", found[0], tau[0], e.load(hi, place, VECTOR))
            with e.loop(e.i(1), e.b.add(exact, e.i(1)), [found[0], zero]) as (j, number):
                place = e.b.add(e.index(e.b.sub(exact, j), self.columns), first)
                begun = e.load(hi, place, VECTOR), e.load(lo, place, VECTOR)
                number[:] = e.normal(*e.plus(*begun, e.two_product(tuple(number), tau)))
            e.store(number[0], into, first)
            e.store(number[1], into, e.b.add(first, columns))
        e.b.ret_void()

    def _rows(self, module: ir.Module) -> None:
        """rows(hi, lo, exact, order, steps, tau hi, tau lo, count, into): of many steps and taus.

        A row of ``into`` has hi parts of all columns, and behind them lo parts.
        """
        e = Emitter(module, "rows", ROWS, ir.VoidType())
        hi, lo, exact, order, steps, tau_hi, tau_lo, count, into = e.arguments
        block = e.index(e.b.add(order, e.i(2)), self.columns)
        with e.loop(e.i(0), count) as (i, _):
            there = e.b.mul(e.b.load(e.b.gep(steps, [i])), block)
            e.b.call(
                module.globals["row"],
                [
                    e.behind(hi, there), e.behind(lo, there), exact, order,
                    e.load(tau_hi, i), e.load(tau_lo, i), e.i(self.columns),
                    e.behind(into, e.index(i, 2 * self.columns)),
                ],
            )  # fmt: skip
        e.b.ret_void()


class _Run:
    """run(hi, lo, steps, exact, order, constants, tolerance, longest, until, times, work).

    Takes at most so many steps and returns how many; the first starts at row 0 of the first
    block. ``times`` has three numbers a step: where it begins, hi and lo, and its length.
    """

    def __init__(self, kernel: Kernel, module: ir.Module):
        self.kernel = kernel
        self.e = e = Emitter(module, "run", RUN, INTEGER)
        (self.all_hi, self.all_lo, self.steps, self.exact, self.order, self.constants,
         self.tolerance, self.longest, self.until, self.times, work) = e.arguments  # fmt: skip
        width = kernel.width
        area = e.index(e.b.add(self.order, e.i(2)), width)
        parts = [e.behind(work, e.b.mul(e.i(k), area)) for k in range(5)]
        self.left, self.right = parts[0:2], parts[2:4]
        self.sums = [parts[4], e.behind(parts[4], width)]
        self.inverses = [e.behind(parts[4], 2 * width), e.behind(parts[4], 3 * width)]
        self.next_row = e.behind(parts[4], 4 * width)

    def write(self) -> None:
        e, kernel = self.e, self.kernel
        block = e.index(e.b.add(self.order, e.i(2)), kernel.columns)
        last = e.function.append_basic_block("last")
        taken = e.b.alloca(INTEGER)
        e.b.store(self.steps, taken)
        with e.loop(e.i(0), self.steps) as (step, _):
            there = e.b.mul(step, block)
            self.block = [e.behind(self.all_hi, there), e.behind(self.all_lo, there)]
            self._coefficients(DoubleDouble(e), e.i(0), first=True)
            with e.loop(e.i(1), self.exact) as (n, _):
                self._sums(n, 2)
                self._coefficients(DoubleDouble(e), n)
            with e.loop(self.exact, e.b.add(self.order, e.i(1))) as (n, _):
                self._sums(n, 1)
                self._coefficients(Double(e), n)
            h = self._length()
            row = padded(len(kernel.entries))
            e.b.call(
                e.module.globals["row"],
                [*self.block, self.exact, self.order, h, e.d(0.0), e.i(row), self.next_row],
            )
            for i in range(len(kernel.entries)):
                following = e.b.add(e.b.add(there, block), e.i(i))
                e.store(e.load(self.next_row, i), self.all_hi, following)
                e.store(e.load(self.next_row, row + i), self.all_lo, following)
            begun = e.load(self.times, e.index(step, 3)), e.load(self.times, e.index(step, 3, 1))
            e.store(h, self.times, e.index(step, 3, 2))
            time = e.normal(*e.plus(*begun, (h, e.d(0.0))))
            for k in range(2):
                e.store(time[k], self.times, e.index(step, 3, 3 + k))
            stop, more = (e.function.append_basic_block(n) for n in ("stop", "more"))
            # NaN is not below the end either
            e.b.cbranch(e.b.fcmp_ordered("<", time[0], self.until), more, stop)
            e.b.position_at_end(stop)
            e.b.store(e.b.add(step, e.i(1)), taken)
            e.b.branch(last)
            e.b.position_at_end(more)
        e.b.branch(last)
        e.b.position_at_end(last)
        e.b.ret(e.b.load(taken))

    def _length(self) -> Value:
        """The step whose last two terms are at most ``tolerance`` of the largest entry."""
        e = self.e

        def largest(n: Value) -> Value:
            found = e.d(0.0)
            for i in range(len(self.kernel.entries)):
                entry = e.load(self.block[0], e.index(n, self.kernel.columns, i))
                found = e.call("maxnum", found, e.call("fabs", entry))
            return found

        whole, h = e.b.fmul(largest(e.i(0)), self.tolerance), self.longest
        for n in (self.order, e.b.sub(self.order, e.i(1))):
            power = e.b.fdiv(e.d(1.0), e.b.sitofp(n, DOUBLE))
            h = e.call("minnum", h, e.call("pow", e.b.fdiv(whole, largest(n)), power))
        return h

    def _sums(self, n: Value, parts: int) -> None:
        """For every lane, the sum of a_j b_(n-j) for j = 1 to n - 1."""
        e, width = self.e, self.kernel.width
        zero = ir.Constant(VECTOR, None)
        for first in range(0, width, LANES * TOGETHER[parts]):
            group = range(first, min(first + LANES * TOGETHER[parts], width), LANES)
            with e.loop(e.i(1), n, [zero] * (parts * len(group))) as (j, sums):
                for k, lane in enumerate(group):
                    places = e.index(j, width, lane), e.index(e.b.sub(n, j), width, lane)
                    a, b = (
                        tuple(e.load(side[part], place, VECTOR) for part in range(parts))
                        for side, place in zip((self.left, self.right), places, strict=True)
                    )
                    if parts == 1:
                        sums[k] = e.call("fma", a[0], b[0], sums[k])
                    else:
                        mine = slice(2 * k, 2 * k + 2)
                        sums[mine] = e.plus(*sums[mine], e.two_product(a, b))
            for k, value in enumerate(sums):
                e.store(value, self.sums[k % parts], group[k // parts])

    def _coefficients(self, ops: Any, n: Value, first: bool = False) -> None:
        """Coefficient n of every series, and n + 1 of the entries."""
        e, kernel = self.e, self.kernel
        self.ops, self.first = ops, first
        value: dict[Series, Number] = {}
        for i, entry in enumerate(kernel.entries):
            value[entry] = self._read(self.block, e.index(n, kernel.columns, i))
        for node in kernel.nodes:
            if node not in value:
                value[node] = getattr(self, f"_{node.kind}")(node, value)
        for node, pair in kernel.pairs.items():
            place = e.index(n, kernel.width, kernel.lane[node])
            for one, side in zip(pair, (self.left, self.right), strict=True):
                self._write(value[one], side, place)
        order = (e.b.sitofp(n, DOUBLE), e.d(0.0))
        for i, (output, slope) in enumerate(kernel.outputs, len(kernel.entries)):
            if isinstance(output, Constant):
                if first and not slope:
                    self._write(self._constant(output), self.block, e.i(i))
            elif not slope:
                self._write(value[output], self.block, e.index(n, kernel.columns, i))
            elif not first:
                before = e.index(e.b.sub(n, e.i(1)), kernel.columns, i)
                self._write(ops.product(order[: ops.parts], value[output]), self.block, before)
        # 1/(n + 1), of which lo is what hi leaves
        hi = e.b.fdiv(e.d(1.0), e.b.fadd(order[0], e.d(1.0)))
        left = e.call("fma", e.b.fneg(hi), e.b.fadd(order[0], e.d(1.0)), e.d(1.0))
        inverse = (hi, e.b.fmul(left, hi))[: ops.parts]
        for i, rate in enumerate(kernel.rates):
            place = e.index(e.b.add(n, e.i(1)), kernel.columns, i)
            if isinstance(rate, Series):
                self._write(ops.product(value[rate], inverse), self.block, place)
            elif first:
                self._write(self._constant(rate), self.block, place)

    def _read(self, parts: Sequence[Value], place: Value | int) -> Number:
        return tuple(self.e.load(part, place) for part in parts[: self.ops.parts])

    def _write(self, number: Number, parts: Sequence[Value], place: Value | int) -> None:
        for value, part in zip(number, parts, strict=False):
            self.e.store(value, part, place)

    def _constant(self, one: Constant) -> Number:
        place = 2 * self.kernel.constants.index(one)
        return self._read([self.constants, self.e.behind(self.constants, 1)], place)

    def _sum(self, node: Series, value: dict[Series, Number]) -> Number:
        offset, terms = node.args
        found = []
        for factor, series in terms:
            if isinstance(factor, Constant):
                found.append(self.ops.product(self._constant(factor), value[series]))
            else:
                found.append(value[series] if factor == 1 else self.ops.negative(value[series]))
        if self.first and isinstance(offset, Constant):
            found.append(self._constant(offset))
        return self.ops.total(*found) if len(found) > 1 else found[0]

    def _product(self, node: Series, value: dict[Series, Number]) -> Number:
        a, b = node.args
        if self.first:
            return self.ops.product(value[a], value[b])
        lane = self.kernel.lane[node]
        ends = [
            (self._read(self.left, lane), value[b]), (value[a], self._read(self.right, lane)),
        ]  # fmt: skip
        return self.ops.products(self._read(self.sums, lane), ends)

    def _quotient(self, node: Series, value: dict[Series, Number]) -> Number:
        a, b = node.args
        lane = self.kernel.lane[node]
        if self.first:
            self._write(self.ops.quotient(self.ops.one, value[b]), self.inverses, lane)
            return self.ops.quotient(value[a] if a in value else self._constant(a), value[b])
        known = [(self._read(self.left, lane), value[b])]
        rest = self.ops.negative(self.ops.products(self._read(self.sums, lane), known))
        if a in value:
            rest = self.ops.total(value[a], rest)
        return self.ops.product(rest, self._read(self.inverses, lane))

    def _root(self, node: Series, value: dict[Series, Number]) -> Number:
        (a,) = node.args
        lane = self.kernel.lane[node]
        if self.first:
            found = self.ops.root(value[a])
            twice = self.ops.total(found, found)
            self._write(self.ops.quotient(self.ops.one, twice), self.inverses, lane)
            return found
        rest = self.ops.total(value[a], self.ops.negative(self._read(self.sums, lane)))
        return self.ops.product(rest, self._read(self.inverses, lane))
