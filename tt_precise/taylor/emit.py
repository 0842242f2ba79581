"""Instructions of LLVM: loops, and the arithmetic of double-doubles and triple-doubles.

These numbers are unevaluated sums of two or three doubles, each below half an ulp of the double
before: 106 or 159 bits. All operations are correctly rounded operations of IEEE 754 and its fused
multiply-add. The compiler may neither contract nor reorder these operations, so the bits are the
same on every processor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import factorial
from typing import Any, TypeAlias

from llvmlite import ir

Value: TypeAlias = Any
"""A double, four of them or an integer, as LLVM's value."""

Number: TypeAlias = tuple[Value, ...]
"""One to three limbs, the largest first."""

DOUBLE, INTEGER = ir.DoubleType(), ir.IntType(64)
LANES = 4
VECTOR = ir.VectorType(DOUBLE, LANES)
_ARGUMENTS = {
    "p": DOUBLE.as_pointer(), "n": INTEGER.as_pointer(), "i": INTEGER, "d": DOUBLE,
}  # fmt: skip

LN_2 = Fraction("0.693147180559945309417232121458176568075500134360255254120680009493393621969695")
# below the first an exponential is that of the first; that of the second is infinite
LEAST_EXPONENT, MOST_EXPONENT = -700.0, 710.0
# a 256th of what is left of it is below 0.0014; the first of its terms left out is below 2^-165
SQUARINGS, EXPONENTIAL_TERMS = 8, 14
SHIFT = 1.5 * 2.0**52  # a double plus this one ends in its nearest integer
EXPONENT_BIAS, MANTISSA_BITS = 1023, 52


def nearest(value: Fraction, limbs: int) -> list[float]:
    """An exact number as a sum of doubles, each nearest to the remainder."""
    doubles: list[float] = []
    for _ in range(limbs):
        doubles.append(float(value))
        value -= Fraction(doubles[-1])
    return doubles


class Emitter:
    """A writer of one function of ``module``; ``arguments`` has a letter per argument.

    "p" stands for a pointer to doubles, "n" for one to integers, "i" for an integer, "d" for a
    double.
    """

    def __init__(self, module: ir.Module, name: str, arguments: str, result: ir.Type):
        kind = ir.FunctionType(result, [_ARGUMENTS[letter] for letter in arguments])
        self.function = ir.Function(module, kind, name)
        self.module, self.arguments = module, self.function.args
        self.b = ir.IRBuilder(self.function.append_basic_block("entry"))

    def i(self, value: int) -> Value:
        return ir.Constant(INTEGER, value)

    def d(self, value: float) -> Value:
        return ir.Constant(DOUBLE, value)

    def table(self, values: Sequence[float]) -> Value:
        """A pointer to constant doubles."""
        kind = ir.ArrayType(DOUBLE, len(values))
        made = ir.GlobalVariable(self.module, kind, self.module.get_unique_name("table"))
        made.initializer, made.global_constant = ir.Constant(kind, list(values)), True
        made.linkage = "internal"
        return self.b.bitcast(made, DOUBLE.as_pointer())

    def index(self, row: Value, width: int, column: int = 0) -> Value:
        """The index of a component among rows of this width."""
        return self.b.add(self.b.mul(row, self.i(width)), self.i(column))

    def order(self, orders: Value, limbs: int) -> Value:
        """Return the number of orders that are computed in ``limbs`` limbs or more."""
        return self.b.load(self.b.gep(orders, [self.i(3 - limbs)]))

    def behind(self, pointer: Value, position: Value | int) -> Value:
        """The pointer moved by ``position`` components."""
        return self.b.gep(pointer, [self.i(position) if isinstance(position, int) else position])

    def load(self, pointer: Value, position: Value | int, kind: ir.Type = DOUBLE) -> Value:
        """Load a double, or a vector of four."""
        there = self.behind(pointer, position)
        if kind == VECTOR:
            there = self.b.bitcast(there, VECTOR.as_pointer())
        return self.b.load(there, align=8)

    def store(self, value: Value, pointer: Value, position: Value | int) -> None:
        """Store a double or a vector."""
        there = self.behind(pointer, position)
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
        """Call LLVM's function of that name: fma, sqrt, pow, fabs, maxnum, minnum."""
        full = f"llvm.{name}.{'v4f64' if args[0].type == VECTOR else 'f64'}"
        function = self.module.globals.get(full)
        if function is None:
            kind = ir.FunctionType(args[0].type, [a.type for a in args])
            function = ir.Function(self.module, kind, full)
        return self.b.call(function, args)

    @contextmanager
    def loop(
        self, start: Value, stop: Value, accumulators: Sequence[Value] = ()
    ) -> Iterator[tuple[Value, list[Value]]]:
        """Emit a loop from ``start`` below ``stop``; gives the counter and the accumulated values.

        The body replaces the accumulated values for its next turn; after the loop the list
        holds the last ones.
        """
        before = self.b.block
        head, body, after = (self.function.append_basic_block(n) for n in ("head", "body", "after"))
        self.b.branch(head)
        self.b.position_at_end(head)
        counter = self.b.phi(INTEGER)
        counter.add_incoming(start, before)
        phis = [self.b.phi(value.type) for value in accumulators]
        for phi, value in zip(phis, accumulators, strict=True):
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
        """a + b and its rounding error; Knuth."""
        f = self.b
        s = f.fadd(a, b)
        t = f.fsub(s, a)
        return s, f.fadd(f.fsub(a, f.fsub(s, t)), f.fsub(b, t))

    def two_product(self, a: Value, b: Value) -> Number:
        """a b and its rounding error."""
        p = self.b.fmul(a, b)
        return p, self.call("fma", a, b, self.b.fneg(p))


class SeveralDoubles:
    """Numbers of ``limbs`` limbs: 1 a double, 2 a double-double, 3 a triple-double.

    The last limb gathers in plain doubles what the others leave, so errors are a few units in the
    last place of the last limb, 2^-53, 2^-104 and 2^-156 of the largest term. What is added up is
    put in order at the end (``normal``).
    """

    def __init__(self, emitter: Emitter, limbs: int):
        self.e, self.limbs = emitter, limbs
        self.one = self.widened((emitter.d(1.0),))

    def widened(self, a: Number) -> Number:
        """A number of fewer limbs with zeros behind."""
        return (*a, *(ir.Constant(a[0].type, 0.0 if a[0].type == DOUBLE else None)
                      for _ in range(self.limbs - len(a))))  # fmt: skip

    def plus(self, s: Number, a: Number) -> Number:
        """The sum of a running sum and one more number, not in order of size."""
        f, two_sum = self.e.b, self.e.two_sum
        if self.limbs == 1:
            return (f.fadd(s[0], a[0]),)
        s0, left = two_sum(s[0], a[0])
        if self.limbs == 2:
            return s0, f.fadd(s[1], f.fadd(left, a[1]))
        s1, rest = two_sum(s[1], a[1])
        s1, more = two_sum(s1, left)
        return s0, s1, f.fadd(s[2], f.fadd(a[2], f.fadd(rest, more)))

    def times(self, a: Number, b: Number) -> Number:
        """A product, not in order."""
        e, f = self.e, self.e.b
        if self.limbs == 1:
            return (f.fmul(a[0], b[0]),)
        p, left = e.two_product(a[0], b[0])
        if self.limbs == 2:
            return p, e.call("fma", a[1], b[0], e.call("fma", a[0], b[1], left))
        q, q_left = e.two_product(a[0], b[1])
        r, r_left = e.two_product(a[1], b[0])
        s, s_left = e.two_sum(q, r)
        s, more = e.two_sum(s, left)
        rest = f.fadd(f.fadd(q_left, r_left), f.fadd(s_left, more))
        for i in range(3):
            rest = e.call("fma", a[i], b[2 - i], rest)
        return p, s, rest

    def normal(self, s: Number) -> Number:
        """Return the sum with limbs of at most half a unit in the last place of the limb before."""
        e = self.e
        if self.limbs == 1:
            return s
        if self.limbs == 2:
            # Dekker's sum: the second limb is the smaller one, or both are rounding errors
            hi = e.b.fadd(s[0], s[1])
            return hi, e.b.fsub(s[1], e.b.fsub(hi, s[0]))
        s0, s1 = e.two_sum(s[0], s[1])
        s1, s2 = e.two_sum(s1, s[2])
        s0, s1 = e.two_sum(s0, s1)
        return s0, *e.two_sum(s1, s2)

    def product(self, a: Number, b: Number) -> Number:
        return self.normal(self.times(a, b))

    def products(self, start: Number, *pairs: tuple[Number, Number]) -> Number:
        """``start`` and the products of the pairs, added up."""
        for a, b in pairs:
            if self.limbs == 1:
                start = (self.e.call("fma", a[0], b[0], start[0]),)
            else:
                start = self.plus(start, self.times(a, b))
        return self.normal(start)

    def total(self, first: Number, *terms: Number) -> Number:
        """All terms added up."""
        for term in terms:
            first = self.plus(first, term)
        return self.normal(first)

    def negative(self, a: Number) -> Number:
        return tuple(map(self.e.b.fneg, a))

    def quotient(self, a: Number, b: Number) -> Number:
        """The quotient a/b: of the first limbs, corrected once per limb."""
        quotient = self.widened((self.e.b.fdiv(a[0], b[0]),))
        for _ in range(self.limbs):
            left = self.total(a, self.negative(self.product(quotient, b)))
            quotient = self.total(quotient, self.widened((self.e.b.fdiv(left[0], b[0]),)))
        return quotient

    def root(self, a: Number) -> Number:
        """The positive root, likewise."""
        root = self.widened((self.e.call("sqrt", a[0]),))
        for _ in range(self.limbs):
            left = self.total(a, self.negative(self.product(root, root)))
            more = self.e.b.fdiv(left[0], self.e.b.fadd(root[0], root[0]))
            root = self.total(root, self.widened((more,)))
        return root

    def constant(self, value: Fraction) -> Number:
        return tuple(map(self.e.d, nearest(value, self.limbs)))

    def exponential(self, a: Number) -> Number:
        """e^a = 2^k e^r with the integer k next to a/ln 2; e^r - 1 by its series and doubling."""
        f, d = self.e.b, self.e.d
        for sign, limit in (("<", LEAST_EXPONENT), (">", MOST_EXPONENT)):
            beyond = f.fcmp_ordered(sign, a[0], d(limit))
            limbs = zip(self.widened((d(limit),)), a, strict=True)
            a = tuple(f.select(beyond, limb, own) for limb, own in limbs)
        shifted = f.fadd(f.fmul(a[0], d(float(1 / LN_2))), d(SHIFT))
        k = self.widened((f.fsub(shifted, d(SHIFT)),))
        rest = self.total(a, self.negative(self.product(k, self.constant(LN_2))))
        small = tuple(f.fmul(limb, d(2.0**-SQUARINGS)) for limb in rest)
        series = self.constant(Fraction(1, factorial(EXPONENTIAL_TERMS)))
        for n in range(EXPONENTIAL_TERMS - 1, 0, -1):
            series = self.products(self.constant(Fraction(1, factorial(n))), (series, small))
        series = self.product(series, small)
        for _ in range(SQUARINGS):  # (1 + x)^2 - 1 = 2 x + x^2
            series = self.products(self.total(series, series), (series, series))
        biased = f.add(f.bitcast(shifted, INTEGER), self.e.i(EXPONENT_BIAS))
        power = f.bitcast(f.shl(biased, self.e.i(MANTISSA_BITS)), DOUBLE)
        return tuple(f.fmul(limb, power) for limb in self.total(self.one, series))
