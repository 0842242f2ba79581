"""Instructions of LLVM: loops, and the arithmetic of double-doubles.

A double-double is an unevaluated sum of two doubles, hi + lo with lo below half an ulp of hi: 106
bits. Everything is made of exactly rounded operations of IEEE 754 and its fused multiply-add, and
the compiler may neither contract nor reorder them: the bits are the same on every processor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from llvmlite import ir

Value: TypeAlias = Any
"""A double, four of them or an integer, as LLVM's value."""

Number: TypeAlias = tuple[Value, ...]
"""hi and lo, or hi alone."""

DOUBLE, INTEGER = ir.DoubleType(), ir.IntType(64)
LANES = 4
VECTOR = ir.VectorType(DOUBLE, LANES)
_ARGUMENTS = {
    "p": DOUBLE.as_pointer(), "n": INTEGER.as_pointer(), "i": INTEGER, "d": DOUBLE,
}  # fmt: skip


class Emitter:
    """Writes one function of ``module``; ``arguments`` has a letter for each.

    "p" stands for a pointer to doubles, "n" for one to integers, "i" for an integer, "d" for a
    double.
    """

    def __init__(self, module: ir.Module, name: str, arguments: str, result: ir.Type):
        kind = ir.FunctionType(result, [_ARGUMENTS[letter] for letter in arguments])
        self.function = ir.Function(module, kind, name)
        self.module, self.arguments = module, self.function.args
        self.b = ir.IRBuilder(self.function.append_basic_block("entry"))

    def i(self, value: int) -> Value:
        """An integer."""
        return ir.Constant(INTEGER, value)

    def d(self, value: float) -> Value:
        """A double."""
        return ir.Constant(DOUBLE, value)

    def index(self, row: Value, width: int, column: int = 0) -> Value:
        """Where an entry stands among rows of this width."""
        return self.b.add(self.b.mul(row, self.i(width)), self.i(column))

    def behind(self, pointer: Value, place: Value | int) -> Value:
        """The pointer ``place`` entries further on."""
        return self.b.gep(pointer, [self.i(place) if isinstance(place, int) else place])

    def load(self, pointer: Value, place: Value | int, kind: ir.Type = DOUBLE) -> Value:
        """What stands there: a double, or a vector of four."""
        there = self.behind(pointer, place)
        if kind == VECTOR:
            there = self.b.bitcast(there, VECTOR.as_pointer())
        return self.b.load(there, align=8)

    def store(self, value: Value, pointer: Value, place: Value | int) -> None:
        """Put a double or a vector there."""
        there = self.behind(pointer, place)
        if value.type == VECTOR:
            there = self.b.bitcast(there, VECTOR.as_pointer())
        self.b.store(value, there, align=8)

    def spread(self, value: Value) -> Value:
        """A vector of four times the same double."""
        made = ir.Constant(VECTOR, ir.Undefined)
        for lane in range(LANES):
            made = self.b.insert_element(made, value, ir.Constant(ir.IntType(32), lane))
        return made

    def call(self, name: str, *args: Value) -> Value:
        """LLVM's own function of that name: fma, sqrt, pow, fabs, maxnum, minnum."""
        full = f"llvm.{name}.{'v4f64' if args[0].type == VECTOR else 'f64'}"
        found = self.module.globals.get(full)
        if found is None:
            kind = ir.FunctionType(args[0].type, [a.type for a in args])
            found = ir.Function(self.module, kind, full)
        return self.b.call(found, args)

    @contextmanager
    def loop(
        self, start: Value, stop: Value, carried: Sequence[Value] = ()
    ) -> Iterator[tuple[Value, list[Value]]]:
        """For each integer from ``start`` below ``stop``: the counter and the carried values.

        The body replaces the carried values by those of its next turn; behind the loop the list
        holds the last ones.
        """
        before = self.b.block
        head, body, after = (self.function.append_basic_block(n) for n in ("head", "body", "after"))
        self.b.branch(head)
        self.b.position_at_end(head)
        counter = self.b.phi(INTEGER)
        counter.add_incoming(start, before)
        phis = [self.b.phi(value.type) for value in carried]
        for phi, value in zip(phis, carried, strict=True):
            phi.add_incoming(value, before)
        self.b.cbranch(self.b.icmp_signed("<", counter, stop), body, after)
        self.b.position_at_end(body)
        values = list(phis)
        yield counter, values
        counter.add_incoming(self.b.add(counter, self.i(1)), self.b.block)
        for phi, value in zip(phis, values, strict=True):
            phi.add_incoming(value, self.b.block)
        self.b.branch(head)
        self.b.position_at_end(after)
        values[:] = phis

    def two_sum(self, a: Value, b: Value) -> Number:
        """a + b and what its rounding leaves; Knuth."""
        f = self.b
        s = f.fadd(a, b)
        t = f.fsub(s, a)
        return s, f.fadd(f.fsub(a, f.fsub(s, t)), f.fsub(b, t))

    def normal(self, s: Value, rest: Value) -> Number:
        """s + rest as hi and lo, the rest not above s; Dekker."""
        hi = self.b.fadd(s, rest)
        return hi, self.b.fsub(rest, self.b.fsub(hi, s))

    def two_product(self, a: Number, b: Number) -> Number:
        """The rounded product of hi parts, and what it leaves of that of the double-doubles."""
        p = self.b.fmul(a[0], b[0])
        low = self.call("fma", a[0], b[0], self.b.fneg(p))
        return p, self.call("fma", a[1], b[0], self.call("fma", a[0], b[1], low))

    def plus(self, s: Value, rest: Value, a: Number) -> Number:
        """A running sum and one more number; the rest gathers what is small."""
        s, left = self.two_sum(s, a[0])
        return s, self.b.fadd(rest, self.b.fadd(left, a[1]))


class DoubleDouble:
    """Operations on numbers of two parts. Errors are some 2^-104 of the largest term."""

    parts = 2

    def __init__(self, emitter: Emitter):
        self.e = emitter
        self.one = emitter.d(1.0), emitter.d(0.0)

    def product(self, a: Number, b: Number) -> Number:
        return self.e.normal(*self.e.two_product(a, b))

    def products(self, start: Number, pairs: Sequence[tuple[Number, Number]]) -> Number:
        """``start`` and the products of the pairs, added up."""
        s, rest = start
        for a, b in pairs:
            s, rest = self.e.plus(s, rest, self.e.two_product(a, b))
        return self.e.normal(s, rest)

    def total(self, *terms: Number) -> Number:
        (s, rest), *others = terms
        for term in others:
            s, rest = self.e.plus(s, rest, term)
        return self.e.normal(s, rest)

    def negative(self, a: Number) -> Number:
        return tuple(map(self.e.b.fneg, a))

    def quotient(self, a: Number, b: Number) -> Number:
        """The quotient of hi parts, corrected twice."""
        found = self.e.b.fdiv(a[0], b[0]), self.e.d(0.0)
        for _ in range(2):
            left = self.total(a, self.product(self.negative(found), b))
            found = self.total(found, (self.e.b.fdiv(left[0], b[0]), self.e.d(0.0)))
        return found

    def root(self, a: Number) -> Number:
        """The root of the hi part, corrected twice."""
        found = self.e.call("sqrt", a[0]), self.e.d(0.0)
        for _ in range(2):
            left = self.total(a, self.product(self.negative(found), found))
            more = self.e.b.fdiv(left[0], self.e.b.fadd(found[0], found[0]))
            found = self.total(found, (more, self.e.d(0.0)))
        return found


class Double:
    """The same operations on the hi part alone."""

    parts = 1

    def __init__(self, emitter: Emitter):
        self.e = emitter
        self.one = (emitter.d(1.0),)

    def product(self, a: Number, b: Number) -> Number:
        return (self.e.b.fmul(a[0], b[0]),)

    def products(self, start: Number, pairs: Sequence[tuple[Number, Number]]) -> Number:
        s = start[0]
        for a, b in pairs:
            s = self.e.call("fma", a[0], b[0], s)
        return (s,)

    def total(self, *terms: Number) -> Number:
        s = terms[0][0]
        for term in terms[1:]:
            s = self.e.b.fadd(s, term[0])
        return (s,)

    def negative(self, a: Number) -> Number:
        return (self.e.b.fneg(a[0]),)

    def quotient(self, a: Number, b: Number) -> Number:
        return (self.e.b.fdiv(a[0], b[0]),)
