"""The equations as a list of operations: each common subexpression once, nothing that is not used.

The mechanics write formulas for reading: k_dot stands in three of them, and of a vector product
often one component is wanted. Products of long polynomials are what an enclosure costs; written
down once as a list of operations, there are half as many.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any

from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar

Operation = tuple[Any, ...]  # what to do, and the positions of what to do it with


class Tape:
    """A function of parameters and variables as a list of operations; see ``Tape.of``."""

    def __init__(self, operations: Sequence[Operation], results: Sequence[int]):
        self._operations, self._results = operations, results

    @classmethod
    def of(cls, function: Callable[..., Sequence[Scalar]], parameters: int, variables: int) -> Tape:
        """The tape of ``function(parameters, variables, fn)``, made by calling it once."""
        writer = _TapeWriter()
        given = [writer.node("parameter", i) for i in range(parameters)]
        state = [writer.node("variable", i) for i in range(variables)]
        results = [writer.position(one) for one in function(given, state, _Functions)]
        used: set[int] = set()
        waiting = list(results)
        while waiting:
            position = waiting.pop()
            if position not in used:
                used.add(position)
                name, *operands = writer.operations[position]
                if name in _OPERATIONS:
                    waiting += operands
        order = sorted(used)
        moved = {position: i for i, position in enumerate(order)}
        needed: list[Operation] = []
        for position in order:
            name, *operands = writer.operations[position]
            needed.append((name, *(moved[i] if name in _OPERATIONS else i for i in operands)))
        return cls(needed, [moved[position] for position in results])

    @property
    def key(self) -> Hashable:
        """Equal for tapes with the same operations."""
        return tuple(self._operations), tuple(self._results)

    def __call__(self, parameters: Sequence[Scalar], variables: Sequence[Scalar]) -> list[Scalar]:
        """The values of the function, in the arithmetic of what it is given."""
        values: list[Scalar] = []
        for name, *operands in self._operations:
            if name in _OPERATIONS:
                values.append(_OPERATIONS[name](*(values[i] for i in operands)))
            elif name == "number":
                values.append(operands[0])
            else:
                values.append((parameters if name == "parameter" else variables)[operands[0]])
        return [values[i] for i in self._results]


def _undefined(*operands: Scalar) -> Scalar:
    raise NotProved("S1", "the equations contain a function that bands do not have")


_OPERATIONS: dict[str, Callable[..., Scalar]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "negative": lambda a: -a,
    "sqrt": lambda a: a.sqrt(),
    "undefined": _undefined,
}


class _TapeWriter:
    """Writes each operation once."""

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self._positions: dict[Operation, int] = {}

    def node(self, *operation: Any) -> _Node:
        position = self._positions.setdefault(operation, len(self.operations))
        if position == len(self.operations):
            self.operations.append(operation)
        return _Node(self, position)

    def position(self, value: Scalar) -> int:
        if isinstance(value, _Node):
            return value.position
        return self.node("number", value).position

    def combined(self, name: str, left: Scalar, right: Scalar) -> Scalar:
        for number, other in ((left, right), (right, left)):
            if isinstance(number, int) and isinstance(other, _Node):
                if number == 0 and name == "*":
                    return 0
                if number == 0 and name == "+":
                    return other
                if number == 1 and name == "*":
                    return other
        pair = [self.position(left), self.position(right)]
        return self.node(name, *(sorted(pair) if name in "+*" else pair))


class _Node:
    """A value that is not known yet."""

    def __init__(self, writer: _TapeWriter, position: int):
        self.writer, self.position = writer, position

    def __add__(self, other: Scalar) -> Scalar:
        return self.writer.combined("+", self, other)

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        return self.writer.combined("-", self, other)

    def __rsub__(self, other: Scalar) -> Scalar:
        return self.writer.combined("-", other, self)

    def __mul__(self, other: Scalar) -> Scalar:
        return self.writer.combined("*", self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        return self.writer.combined("/", self, other)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return self.writer.combined("/", other, self)

    def __neg__(self) -> Scalar:
        return self.writer.node("negative", self.position)


class _Functions:
    """What the mechanics may ask of an arithmetic; only roots can be had."""

    @staticmethod
    def sqrt(x: Scalar) -> Scalar:
        return x.writer.node("sqrt", x.position)

    @staticmethod
    def undefined(*operands: Scalar) -> Scalar:
        nodes = [one for one in operands if isinstance(one, _Node)]
        return nodes[0].writer.node("undefined", *(one.position for one in nodes))

    sin = cos = acos = atan2 = undefined
