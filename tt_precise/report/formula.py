"""Formulas as the claims write them, read into a tree: ``R*I1*phi_dot*sin(theta)**2``.

What people write between such formulas is read too: products without a sign, ``L x 3`` and
``v_A.F``, ``|a|``, ``E~``, equations and inequalities. Terms keep the order that they are printed
in. Whatever is no formula is refused, so that words stay words.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "epsilon": "ε",
    "lambda": "λ", "mu": "μ", "nu": "ν", "omega": "ω", "phi": "φ", "pi": "π", "psi": "ψ",
    "sigma": "σ", "tau": "τ", "theta": "θ", "xi": "ξ",
}  # fmt: skip
FUNCTIONS = ("sin", "cos", "tan", "sqrt", "dot", "cross", "d", "V", "g", "D", "E~", "lim", "abs")
ACCENTS = {"dot": "dot", "ddot": "ddot", "tilde": "tilde", "hat": "hat"}
RELATIONS = {
    "=": "=", "<": "<", ">": ">", "<=": "≤", ">=": "≥", "->": "→",
}  # fmt: skip


class NoFormulaError(ValueError):
    """The text is no formula."""


@dataclass(frozen=True)
class Node:
    """A number, a symbol, or an operation on ``parts``.

    ``kind`` is one of: number, symbol, sum, product, negative, quotient, power, root, call, cross,
    dot, size, relation, derivative, tuple; ``text`` is the number, the symbol, the function or the
    relation.
    """

    kind: str
    text: str = ""
    parts: tuple[Node, ...] = ()

    @property
    def operates(self) -> bool:
        """Whether it is more than one number or symbol."""
        return self.kind not in ("number", "symbol")


_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w~]))"
    r"|(?P<word>3_dot|[A-Za-z]\w*?(?=_?(?:[^\w~]|$))|[A-Za-z]\w*?~\d*)_?"
    r"|(?P<sign>\*\*|<=|>=|->|[-+*/^().,|=<>]))"
)
_DERIVATIVE = re.compile(r"\bd ?([A-Za-z]\w*~?)/dt\b")
_UNIT = re.compile(r"\d (?:J|N|s|m|W|kg|rad|ms|%)(?![\w(])")
_SYMBOL = re.compile(
    rf"(?:{'|'.join(sorted(GREEK, key=len, reverse=True))}|[A-Za-z]|mg)~?(?:\d|_[A-Za-z0-9]+)*"
)


def read(text: str) -> Node:
    """The tree of a formula.

    Raises
    ------
    NoFormulaError
        It is none, or only a number or a symbol.
    """
    if _UNIT.search(text):
        raise NoFormulaError(text)
    reader = _FormulaReader(
        _tokens(_DERIVATIVE.sub(r"ddt(\1)", text.replace("lambdadot", "lambda_dot")))
    )
    node = reader.relations()
    if reader.rest or not node.operates or not _names_something(node):
        raise NoFormulaError(text)
    return node


def is_symbol(word: str) -> bool:
    """Whether a word is a symbol: a Greek letter's name or a letter, with indices and dots."""
    return _SYMBOL.fullmatch(word) is not None


def parts_of_symbol(word: str) -> tuple[str, tuple[str, ...], str]:
    """The letter, its accents and its index: ("ω", ("dot",), "3") of omega_3_dot."""
    if word == "3_dot":
        return "3", ("dot",), ""
    base, *rest = word.rstrip("_").split("_")
    accents = [ACCENTS[one] for one in rest if one in ACCENTS]
    indices = [one for one in rest if one not in ACCENTS]
    if "~" in base:
        base, digits = base.split("~")
        accents.insert(0, "tilde")
        indices[:0] = [digits] if digits else []
    found = re.fullmatch(r"([A-Za-z]+)(\d+)", base)
    if found:
        base, indices = found[1], [found[2], *indices]
    return GREEK.get(base, base), tuple(accents), ",".join(indices)


def _tokens(text: str) -> list[tuple[str, str, bool]]:
    """(kind, text, whether a space stands before it)."""
    found, position = [], 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if not match:
            raise NoFormulaError(text)
        assert match.lastgroup
        word = match[match.lastgroup]
        found.append((match.lastgroup, word, match.start(match.lastgroup) > position))
        position = match.end()
    return found


class _FormulaReader:
    """Reads tokens by falling precedence, as Python does but for what is said above."""

    def __init__(self, tokens: list[tuple[str, str, bool]]):
        self.rest = tokens[::-1]

    def relations(self) -> Node:
        parts = [self.relation()]
        while parts[-1].kind == "relation" and self._take(","):
            parts.append(self.relation())
        if len(parts) > 1 and any(part.kind != "relation" for part in parts):
            raise NoFormulaError("a list")
        return Node("tuple", "", tuple(parts)) if len(parts) > 1 else parts[0]

    def relation(self) -> Node:
        node = self._sum()
        parts, signs = [node], []
        while self._at(*RELATIONS):
            signs.append(self.rest.pop()[1])
            parts.append(self._sum())
        return Node("relation", " ".join(signs), tuple(parts)) if signs else node

    def _sum(self) -> Node:
        parts = [self._negative() if self._take("-") else self._product()]
        while self._at("+", "-"):
            parts.append(self._negative() if self.rest.pop()[1] == "-" else self._product())
        return Node("sum", "", tuple(parts)) if len(parts) > 1 else parts[0]

    def _negative(self) -> Node:
        return Node("negative", "", (self._product(),))

    def _product(self) -> Node:
        node = self._power()
        while self.rest:
            if self._take("*"):
                node = _times(node, self._power())
            elif self._take("/"):
                node = Node("quotient", "", (node, self._power()))
            elif self._at("x") and self._beside_spaces():
                self.rest.pop()
                node = Node("cross", "", (_axis(node), _axis(self._power())))
            elif self.rest[-1][0] in ("word", "number") or (self._at("(") and self.rest[-1][2]):
                if not self.rest[-1][2]:
                    raise NoFormulaError("two words in one")
                node = _times(node, _axis(self._power()))
            else:
                break
        return node

    def _beside_spaces(self) -> bool:
        return self.rest[-1][2] and len(self.rest) > 1 and self.rest[-2][2]

    def _power(self) -> Node:
        node = self._atom()
        while self._at(".") and len(self.rest) > 1 and not self.rest[-2][2]:
            self.rest.pop()
            node = Node("dot", "", (node, _axis(self._atom())))
        if self._at("**", "^"):
            self.rest.pop()
            exponent = self._negative() if self._take("-") else self._power()
            return Node("power", "", (node, exponent))
        return node

    def _atom(self) -> Node:
        if not self.rest:
            raise NoFormulaError("ends too early")
        kind, text, _ = self.rest.pop()
        if kind == "number":
            return Node("number", text)
        if text == "(":
            return self._list(")")
        if text == "|":
            return Node("size", "", (self._until("|"),))
        if kind != "word":
            raise NoFormulaError(text)
        if text in ("sin", "cos", "tan") and self.rest and self.rest[-1][0] == "word":
            return _called(text, self._atom())
        if self._at("(") and not self.rest[-1][2] and (text in FUNCTIONS or text == "ddt"):
            self.rest.pop()
            return _called(text, self._list(")"))
        if self._at("(") and not self.rest[-1][2]:  # such as theta(0) or phi_dot(t)
            self.rest.pop()
            return Node("call", text, (Node("symbol", _known(text)), self._list(")")))
        return Node("symbol", _known(text))

    def _list(self, end: str) -> Node:
        parts = [self.relation()]
        while self._take(","):
            parts.append(self.relation())
        if not self._take(end):
            raise NoFormulaError(f"no {end}")
        return Node("tuple", "(", tuple(parts)) if len(parts) > 1 else parts[0]

    def _until(self, end: str) -> Node:
        node = self._sum()
        if not self._take(end):
            raise NoFormulaError(f"no {end}")
        return node

    def _at(self, *signs: str) -> bool:
        return bool(self.rest) and self.rest[-1][1] in signs

    def _take(self, sign: str) -> bool:
        if self._at(sign):
            self.rest.pop()
            return True
        return False


def _names_something(node: Node) -> bool:
    return node.kind == "symbol" or any(map(_names_something, node.parts))


def _axis(node: Node) -> Node:
    """The symmetry axis, a bold 3 in the paper, where the number 3 can stand for nothing else."""
    return Node("symbol", "3") if node == Node("number", "3") else node


def _known(word: str) -> str:
    if word != "3_dot" and not is_symbol(word):
        raise NoFormulaError(word)
    return word


def _times(left: Node, right: Node) -> Node:
    parts = left.parts if left.kind == "product" else (left,)
    return Node("product", "", (*parts, right))


def _called(name: str, argument: Node) -> Node:
    two = argument.parts if argument.kind == "tuple" else (argument,)
    if name in ("dot", "cross") and len(two) == 2:
        return Node(name, "", two)
    special = {"sqrt": "root", "abs": "size", "ddt": "derivative"}
    if name in special:
        return Node(special[name], "", (argument,))
    return Node("call", name, (Node("symbol", name), argument))
