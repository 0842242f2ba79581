"""Small mistakes that a programmer makes, put into a module one at a time."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult, ast.Pow: ast.Mult,
}  # fmt: skip

Key = tuple[str, str, str, str]  # path, within, before, after


@dataclass(frozen=True)
class Mutant:
    """One mistake: where it is, what stood there, what stands there now, and the whole module.

    ``within`` is the qualified name of the function or class around it; lines move, names do not.
    """

    path: str
    line: int
    within: str
    before: str
    after: str
    source: str

    @property
    def key(self) -> Key:
        """What names it in the list of equivalent mutants."""
        return self.path, self.within, self.before, self.after


def count(text: str) -> int:
    """How many mutants a module has. Annotations, messages and docstrings are left alone."""
    return sum(1 for _ in _places(ast.parse(text)))


def mutant(path: str, text: str, number: int) -> Mutant:
    """One of the mutants of a module, from 0 to ``count(text) - 1``."""
    tree = ast.parse(text)
    place = next(islice(_places(tree), number, None))
    before = ast.unparse(place.shown)
    place.change()
    ast.fix_missing_locations(tree)
    after = ast.unparse(place.shown)
    return Mutant(path, place.line, place.within, before, after, ast.unparse(tree) + "\n")


def keys(path: str, text: str) -> list[Key]:
    """The names of all mutants of a module, by their numbers."""
    found = []
    for place in list(_places(ast.parse(text))):
        before = ast.unparse(place.shown)
        place.change()
        found.append((path, place.within, before, ast.unparse(place.shown)))
        place.change()
    return found


@dataclass
class _Place:
    shown: ast.AST  # the expression or statement that is quoted
    within: str
    line: int
    change: Callable[[], None]  # and back, when it is called again


def _places(tree: ast.Module) -> Iterator[_Place]:
    yield from _walk(tree, [], None)


def _walk(node: ast.AST, names: list[str], around: ast.AST | None) -> Iterator[_Place]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        names = [*names, node.name]
    # an expression is quoted as part of the one around it, or it would not be clear which it is
    shown = around if isinstance(around, ast.expr) else node
    for change in _changes(node):
        yield _Place(shown, ".".join(names), getattr(node, "lineno", 0), change)
    for child in _children(node):
        yield from _walk(child, names, _quoted(node, around))


def _quoted(node: ast.AST, around: ast.AST | None) -> ast.AST | None:
    """The largest expression around a child, but not a whole comprehension of many lines."""
    if not isinstance(node, ast.expr):
        return node if isinstance(node, ast.comprehension | ast.keyword) and around else None
    return around if isinstance(around, ast.expr) else node


def _children(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Import | ast.ImportFrom):
        return
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
        return
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "type_params", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child


def _changes(node: ast.AST) -> Iterator[Callable[[], None]]:
    """The mistakes that can be made at a node, each as a function that makes it in place."""
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            yield _setting(node.ops, i, COMPARISONS[type(operator)]())
    elif isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in ARITHMETIC:
        yield _replacing(node, "op", ARITHMETIC[type(node.op)]())
    elif isinstance(node, ast.BoolOp):
        yield _replacing(node, "op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield _replacing(node, "op", ast.UAdd())
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield _replacing(node, "operand", ast.UnaryOp(ast.Not(), copy.copy(node.operand)))
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield _replacing(node, "value", not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield _replacing(node, "value", node.value + 1)
    elif isinstance(node, ast.If | ast.While | ast.IfExp):
        yield _replacing(node, "test", ast.UnaryOp(ast.Not(), copy.copy(node.test)))


def _setting(where: list[ast.cmpop], i: int, value: ast.cmpop) -> Callable[[], None]:
    other = [value]

    def swap() -> None:
        where[i], other[0] = other[0], where[i]

    return swap


def _replacing(node: ast.AST, name: str, value: object) -> Callable[[], None]:
    other = [value]

    def swap() -> None:
        now = getattr(node, name)
        setattr(node, name, other[0])
        other[0] = now

    return swap
