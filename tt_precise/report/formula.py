"""Formulas as the claims write them: read into a tree, set as LaTeX and as MathML.

``R*I1*phi_dot*sin(theta)**2`` is read, and what people write between such formulas: products
without a sign, ``L x 3`` and ``v_A.F``, ``|a|``, ``E~``, equations and inequalities. Terms keep the
order that they are printed in. Whatever is no formula is refused, so that words stay words.
``differences`` finds what of a printed formula is not in the corrected one, to be marked.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

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


# a node in a tree, by the positions of the branches that lead to it
Place = tuple[int, ...]
Places = frozenset[Place]
NONE: Places = frozenset()
SIGN = -1  # the minus of a negative

_LOOSE = ("sum", "negative", "relation", "tuple")
AXIS = "3"  # the symmetry axis
_UPRIGHT = ("sin", "cos", "tan", "lim")
_LATEX_GREEK = {
    "α": r"\alpha", "β": r"\beta", "γ": r"\gamma", "δ": r"\delta", "ε": r"\varepsilon",
    "λ": r"\lambda", "μ": r"\mu", "ν": r"\nu", "ω": r"\omega", "φ": r"\varphi", "π": r"\pi",
    "ψ": r"\psi", "σ": r"\sigma", "τ": r"\tau", "θ": r"\theta", "ξ": r"\xi",
}  # fmt: skip
_LATEX_RELATION = {"=": "=", "<": "<", ">": ">", "≤": r"\le", "≥": r"\ge", "→": r"\to"}


def mathml(node: Node, marked: Places = NONE) -> str:
    """A ``<math>`` element; the marked places carry the class ``differs``."""
    from latex2mathml.converter import convert

    return str(convert(_Latex(marked, r"\class{differs}{...}", r"\, ").of(node, ())))


def latex(node: Node, marked: Places = NONE) -> str:
    """LaTeX without dollars; the marked places are underlined."""
    return _Latex(marked, r"\underline{...}").of(node, ())


def differences(printed: Node, corrected: Node) -> tuple[Places, Places]:
    """The places in either tree where it differs from the other."""
    left: set[Place] = set()
    right: set[Place] = set()
    _compare(printed, (), corrected, (), left, right)
    return frozenset(left), frozenset(right)


def _compare(
    a: Node, at_a: Place, b: Node, at_b: Place, left: set[Place], right: set[Place]
) -> None:
    if a == b:
        return
    if a.kind != b.kind or a.text != b.text or not a.parts:
        # an operation that only one side has, around something that both have
        for outer, place, inner, mine in ((a, at_a, b, left), (b, at_b, a, right)):
            if outer.kind in ("product", "quotient", "negative") and inner in outer.parts:
                others = [i for i, part in enumerate(outer.parts) if part != inner]
                mine.update((*place, i) for i in others or [SIGN])
                return
        left.add(at_a)
        right.add(at_b)
        return
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, a.parts, b.parts, False).get_opcodes():
        if tag == "replace" and i2 - i1 == j2 - j1:
            for i, j in zip(range(i1, i2), range(j1, j2), strict=True):
                _compare(a.parts[i], (*at_a, i), b.parts[j], (*at_b, j), left, right)
        elif tag != "equal":
            left.update((*at_a, i) for i in range(i1, i2))
            right.update((*at_b, j) for j in range(j1, j2))


class _Latex:
    """LaTeX of a tree; ``mark`` wraps what stands at the marked places.

    ``space`` stands behind the name of a function; TeX needs none there.
    """

    def __init__(self, marked: Places, mark: str, space: str = " "):
        self.marked, self._mark_form, self._space = marked, mark, space

    def of(self, node: Node, place: Place) -> str:
        written = getattr(self, f"_{node.kind}")(node, place)
        return self._mark(written) if place in self.marked else written

    def _part(self, node: Node, place: Place, i: int, loose: Sequence[str] = _LOOSE) -> str:
        part = node.parts[i]
        written = self.of(part, (*place, i))
        return self._bracketed(written) if part.kind in loose else written

    def _mark(self, written: str) -> str:
        return self._mark_form.replace("...", written)

    def _bracketed(self, written: str) -> str:
        return rf"\left({written}\right)"

    def _number(self, node: Node, place: Place) -> str:
        mantissa, _, power = node.text.lower().partition("e")
        return rf"{mantissa}\cdot 10^{{{int(power)}}}" if power else mantissa

    def _symbol(self, node: Node, _: Place) -> str:
        return latex_symbol(node.text)

    def _sum(self, node: Node, place: Place) -> str:
        written = self._part(node, place, 0, ("relation",))
        for i, part in enumerate(node.parts[1:], 1):
            sign = " " if part.kind == "negative" else " + "
            written += sign + self._part(node, place, i, ("relation",))
        return written

    def _negative(self, node: Node, place: Place) -> str:
        minus = self._mark("-") if (*place, SIGN) in self.marked else "-"
        return f"{minus} {self._part(node, place, 0)}"

    def _product(self, node: Node, place: Place) -> str:
        written = self._part(node, place, 0)
        for i, part in enumerate(node.parts[1:], 1):
            sign = r" \cdot " if part.kind == "number" else r"\, "
            written += sign + self._part(node, place, i)
        return written

    def _quotient(self, node: Node, place: Place) -> str:
        over, under = (self.of(part, (*place, i)) for i, part in enumerate(node.parts))
        return rf"\frac{{{over}}}{{{under}}}"

    def _power(self, node: Node, place: Place) -> str:
        base, exponent = node.parts
        power = self.of(exponent, (*place, 1))
        if base.kind == "call" and base.parts[0].text in _UPRIGHT:
            name = rf"\{base.parts[0].text}"
            return f"{name}^{_grouped(power)}{self._argument(base, (*place, 0))}"
        loose = (*_LOOSE, "product", "quotient", "cross", "dot", "call", "power")
        written = self._part(node, place, 0, loose)
        return f"{written if base.kind in loose else _grouped(written)}^{_grouped(power)}"

    def _root(self, node: Node, place: Place) -> str:
        return rf"\sqrt{{{self.of(node.parts[0], (*place, 0))}}}"

    def _call(self, node: Node, place: Place) -> str:
        name = node.parts[0].text
        head = rf"\{name}" if name in _UPRIGHT else self.of(node.parts[0], (*place, 0))
        return head + self._argument(node, place)

    def _argument(self, node: Node, place: Place) -> str:
        written = self.of(node.parts[1], (*place, 1))
        if node.parts[0].text in _UPRIGHT and node.parts[1].kind == "symbol":
            return self._space + written
        return self._bracketed(written)

    def _cross(self, node: Node, place: Place) -> str:
        return r" \times ".join(self._part(node, place, i) for i in (0, 1))

    def _dot(self, node: Node, place: Place) -> str:
        return r" \cdot ".join(self._part(node, place, i, (*_LOOSE, "cross")) for i in (0, 1))

    def _size(self, node: Node, place: Place) -> str:
        return rf"\lvert {self.of(node.parts[0], (*place, 0))} \rvert"

    def _relation(self, node: Node, place: Place) -> str:
        written = self.of(node.parts[0], (*place, 0))
        for i, sign in enumerate(node.text.split(), 1):
            written += f" {_LATEX_RELATION[RELATIONS[sign]]} {self.of(node.parts[i], (*place, i))}"
        return written

    def _derivative(self, node: Node, place: Place) -> str:
        return rf"\frac{{d {self.of(node.parts[0], (*place, 0))}}}{{dt}}"

    def _tuple(self, node: Node, place: Place) -> str:
        written = ", ".join(self.of(part, (*place, i)) for i, part in enumerate(node.parts))
        return self._bracketed(written) if node.text else written


def _grouped(written: str) -> str:
    return written if len(written) == 1 else f"{{{written}}}"


def latex_symbol(word: str) -> str:
    """A symbol such as omega_3_dot as LaTeX."""
    letter, accents, index = parts_of_symbol(word)
    written = _LATEX_GREEK.get(letter, r"\mathbf{3}" if letter == AXIS else letter)
    for accent in accents:
        written = rf"\{accent}{{{written}}}"
    if not index:
        return written
    return f"{written}_{index}" if len(index) == 1 else rf"{written}_{{\mathrm{{{index}}}}}"
