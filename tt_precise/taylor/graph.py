"""A right-hand side as a graph of its operations, traced by one run with ``Traced`` scalars.

An expression without components of the state is a constant, computed once per run in mpmath. All
other expressions are sums with constant factors, products, quotients, roots and exponentials of
series, each stored once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from tt_precise.runtime.values import Functions, Ring, Scalar


class Operand(Ring):
    """An operation of a ``kind`` on ``args``: numbers, parameters, components and other nodes."""

    __slots__ = ("args", "graph", "kind")
    __array_ufunc__ = None

    def __init__(self, graph: Graph, kind: str, args: tuple[Any, ...]):
        self.graph, self.kind, self.args = graph, kind, args

    def __add__(self, other: Scalar) -> Scalar:
        return self.graph.added(self, other)

    def __neg__(self) -> Scalar:
        return self.graph.times(-1, self)

    def __mul__(self, other: Scalar) -> Scalar:
        return self.graph.times(other, self)

    def __truediv__(self, other: Scalar) -> Scalar:
        return self.graph.divided(self, other)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return self.graph.divided(other, self)


class Constant(Operand):
    """A number, a parameter, or a value computed only from these."""

    __slots__ = ()

    def value(self, parameters: Sequence[Scalar], fn: Functions, memo: dict[Any, Any]) -> Scalar:
        """The number of the constant; ``memo`` has the constants computed before."""
        if self not in memo:
            args = [
                a.value(parameters, fn, memo) if isinstance(a, Constant) else a for a in self.args
            ]
            if self.kind == "number":
                memo[self] = fn.mpf(args[0])
            elif self.kind == "parameter":
                memo[self] = parameters[args[0]]
            elif self.kind in ("root", "exponential"):
                memo[self] = (fn.sqrt if self.kind == "root" else fn.exp)(args[0])
            else:
                a, b = args
                memo[self] = a + b if self.kind == "+" else a * b if self.kind == "*" else a / b
        return memo[self]


class Traced(Operand):
    """A function of time, given by the rule for its Taylor coefficients.

    ``kind`` is "component" (of the state, with its index), "sum" (with a constant offset and pairs
    of a factor, which is 1, -1 or a ``Constant``, and a series), "product", "quotient", "root",
    "slope" (each coefficient times its order) or "exponential" (of a series, given with its slope).
    """

    __slots__ = ()

    @property
    def operands(self) -> tuple[Traced, ...]:
        """The series in its arguments."""
        if self.kind == "sum":
            return tuple(series for _, series in self.args[1])
        return tuple(a for a in self.args if isinstance(a, Traced))


def linear(value: Scalar, sign: int = 1) -> tuple[Any, tuple[tuple[Any, Traced], ...]]:
    """Offset, and pairs of factor and series, whose sum is this expression or its negative."""
    if not isinstance(value, Traced):
        return sign * value, ()
    if value.kind != "sum":
        return 0, ((sign, value),)
    offset, terms = value.args
    return sign * offset, tuple((sign * factor, series) for factor, series in terms)


class Graph:
    """The operations of ``components`` equations with ``parameters``; also their ``fn``.

    ``turning`` holds, for each angle, the two components that were added for its sine and cosine.
    Their rates are made of its rate, so an angle is a sum of components with factors.
    """

    def __init__(self, components: int, parameters: int):
        self._nodes: dict[Any, Any] = {}
        self._positions: dict[Any, int] = {}
        self.components = [self.series("component", i) for i in range(components)]
        self.parameters = [self._once(Constant, "parameter", (i,)) for i in range(parameters)]
        self.turning: dict[Traced, tuple[Traced, ...]] = {}

    def position(self, node: Any) -> int:
        """A number that orders the graph: operands come before their results."""
        return self._positions[node]

    def _once(self, kind: type, name: str, args: tuple[Any, ...]) -> Any:
        key = kind, name, args
        if key not in self._nodes:
            node = self._nodes[key] = kind(self, name, args)
            self._positions[node] = len(self._positions)
        return self._nodes[key]

    def series(self, kind: str, *args: Any) -> Traced:
        """The series of this kind, made once."""
        node: Traced = self._once(Traced, kind, args)
        return node

    def number(self, value: Scalar) -> Constant:
        """A plain number as a constant."""
        constant: Constant = (
            value if isinstance(value, Constant) else self._once(Constant, "number", (value,))
        )
        return constant

    def as_series(self, value: Scalar) -> Traced | Constant:
        """A series unchanged, anything else as a constant."""
        return value if isinstance(value, Traced) else self.number(value)

    def constant(self, kind: str, a: Scalar, b: Scalar) -> Scalar:
        """``a`` and ``b``, neither a series, combined; plain where that is exact."""
        if kind == "*" and (a == 0 or b == 0):
            return 0
        if b == (0 if kind == "+" else 1):
            return a
        if kind != "/" and a == (0 if kind == "+" else 1):
            return b
        return self._once(Constant, kind, (self.number(a), self.number(b)))

    def added(self, a: Scalar, b: Scalar) -> Scalar:
        if not (isinstance(a, Traced) or isinstance(b, Traced)):
            return self.constant("+", a, b)
        (offset, terms), (more, others) = linear(a), linear(b)
        return self.sum(offset + more, terms + others)

    def times(self, a: Scalar, b: Scalar) -> Scalar:
        if isinstance(a, Traced):
            if isinstance(b, Traced):
                return self.series("product", *sorted((a, b), key=self.position))
            a, b = b, a
        return self.scaled(a, b) if isinstance(b, Traced) else self.constant("*", a, b)

    def divided(self, a: Scalar, b: Scalar) -> Scalar:
        if isinstance(b, Traced):
            return self.series("quotient", self.as_series(a), b)
        if isinstance(a, Traced):
            return self.scaled(self.constant("/", 1, b), a)
        return self.constant("/", a, b)

    def scaled(self, factor: Scalar, series: Traced) -> Scalar:
        if not isinstance(factor, Constant):
            if factor == 0:
                return 0
            if abs(factor) == 1:
                return series if factor == 1 else self.sum(*linear(series, -1))
            factor = self.number(factor)
        if series.kind == "sum" and len(series.args[1]) == 1:
            offset, ((inner, term),) = series.args
            return self.sum(factor * offset, ((factor * inner, term),))
        return self.sum(0, ((factor, series),))

    def sum(self, offset: Scalar, terms: Iterable[tuple[Any, Traced]]) -> Scalar:
        """An offset and series with factors, equal series gathered."""
        gathered: dict[Traced, Any] = {}
        for factor, series in terms:
            gathered[series] = gathered[series] + factor if series in gathered else factor
        left = tuple(
            (factor if isinstance(factor, Constant) or abs(factor) == 1 else self.number(factor), s)
            for s, factor in gathered.items()
            if factor != 0
        )
        if not left:
            return offset
        if len(left) == 1 and offset == 0 and left[0][0] == 1:
            return left[0][1]
        if offset != 0:
            offset = self.number(offset)
        return self.series("sum", offset, left)

    def sqrt(self, value: Scalar) -> Scalar:
        """The positive root."""
        if isinstance(value, Traced):
            return self.series("root", value)
        return self._once(Constant, "root", (self.number(value),))

    def exp(self, value: Scalar) -> Scalar:
        """The exponential."""
        if isinstance(value, Traced):
            return self.series("exponential", value, self.series("slope", value))
        return self._once(Constant, "exponential", (self.number(value),))

    def sin(self, angle: Traced) -> Traced:
        """The sine of an angle, as one more component of the state."""
        return self._sine_cosine(angle)[0]

    def cos(self, angle: Traced) -> Traced:
        """The cosine, likewise."""
        return self._sine_cosine(angle)[1]

    def atan2(self, y: Scalar, x: Scalar) -> Traced:
        """An angle that no rate needs: Euler angles have theta beside the rate of phi."""
        return self.series("angle", y, x)

    def _sine_cosine(self, angle: Traced) -> tuple[Traced, ...]:
        if angle not in self.turning:
            first = len(self.components)
            self.turning[angle] = tuple(self.series("component", first + i) for i in (0, 1))
            self.components += self.turning[angle]
        return self.turning[angle]

    def with_turning(self, rates: Sequence[Scalar]) -> list[Scalar]:
        """``rates`` of the first components, followed by the rates of sines and cosines."""
        of_component = dict(zip(self.components, rates, strict=False))
        extended = list(rates)
        for angle, (sine, cosine) in self.turning.items():
            _, terms = linear(angle)
            rate = sum(factor * of_component[component] for factor, component in terms)
            extended += [cosine * rate, -(sine * rate)]
        return extended

    def with_turned(
        self, start: Sequence[Scalar], parameters: Sequence[Scalar], fn: Functions
    ) -> list[Scalar]:
        """A ``start`` of the first components, followed by sines and cosines."""
        extended, memo = list(start), dict[Any, Any]()
        for angle in self.turning:
            value, terms = linear(angle)
            value = self.number(value).value(parameters, fn, memo)
            for factor, component in terms:
                value += self.number(factor).value(parameters, fn, memo) * start[component.args[0]]
            extended += [fn.sin(value), fn.cos(value)]
        return extended


def in_order(graph: Graph, results: Iterable[Scalar]) -> list[Traced]:
    """The series ``results`` and all their operands, operands first."""
    nodes: set[Traced] = set()
    stack = [result for result in results if isinstance(result, Traced)]
    while stack:
        node = stack.pop()
        if node not in nodes:
            nodes.add(node)
            stack += node.operands
    return sorted(nodes, key=graph.position)


def constants_of(series: Sequence[Traced]) -> list[Constant]:
    """The constants among their arguments."""
    constants: dict[Constant, None] = {}
    for coefficients in series:
        if coefficients.kind == "sum":
            for factor in (coefficients.args[0], *(factor for factor, _ in coefficients.args[1])):
                if isinstance(factor, Constant):
                    constants[factor] = None
        else:
            constants.update({a: None for a in coefficients.args if isinstance(a, Constant)})
    return list(constants)


def numbers(
    constants: Iterable[Constant], parameters: Sequence[Scalar], fn: Functions
) -> Mapping[Constant, Scalar]:
    """The value of each constant for these parameters."""
    memo: dict[Any, Any] = {}
    return {constant: constant.value(parameters, fn, memo) for constant in constants}
