"""Formulas as the claims write them, set as LaTeX and as MathML.

``R*I1*phi_dot*sin(theta)**2`` is read, and what people write between such formulas: products
without a sign, ``L x 3`` and ``v_A.F``, ``|a|``, ``E~``, equations and inequalities. Terms keep the
order that they are printed in. Whatever is not a formula is refused, so that words stay words.
Of two formulas the symbols, numbers and signs in which they differ are marked.
"""

from __future__ import annotations

import re
from difflib import SequenceMatcher
from typing import NamedTuple

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "epsilon": "ε",
    "lambda": "λ", "mu": "μ", "nu": "ν", "omega": "ω", "phi": "φ", "pi": "π", "psi": "ψ",
    "sigma": "σ", "tau": "τ", "theta": "θ", "xi": "ξ",
}  # fmt: skip
AXIS = "3"  # the symmetry axis, a bold 3 in the paper
_LATEX_GREEK = {letter: rf"\{name}" for name, letter in GREEK.items()} | {
    "ε": r"\varepsilon", "φ": r"\varphi",
}  # fmt: skip
_ACCENTS = ("dot", "ddot", "dddot", "tilde", "hat")
_UPRIGHT = ("sin", "cos", "tan", "lim")
_RELATIONS = {"=": "=", "<": "<", ">": ">", "<=": r"\le", ">=": r"\ge", "->": r"\to"}
# kinds of parts that need brackets inside a product, and those that need them below an exponent
_LOOSE = ("sum", "negative", "relation")
_LOOSE_BASE = (*_LOOSE, "product", "quotient", "cross", "dot", "call", "power")

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


class NoFormulaError(ValueError):
    """The text is not a formula."""


def latex(text: str, other: str = "") -> str:
    """A formula as LaTeX without dollars; what ``other``, if given, has not is underlined.

    Raises ``NoFormulaError``: it is not a formula, or only a number or a symbol.
    """
    return _Writer(text, other, r"\underline{...}", " ").formula()


def mathml(text: str, other: str = "") -> str:
    """The same as a ``<math>`` element; what ``other`` has not is of the class ``differs``."""
    from latex2mathml.converter import convert

    # the converter needs a space behind the name of a function, which TeX makes itself
    return str(convert(_Writer(text, other, r"\class{differs}{...}", r"\, ").formula()))


def parts_of_symbol(word: str) -> tuple[str, tuple[str, ...], str]:
    """The letter, its accents and its index: ("ω", ("dot",), "3") of omega_3_dot."""
    if word == "3_dot":
        return AXIS, ("dot",), ""
    base, *rest = word.rstrip("_").split("_")
    accents = [part for part in rest if part in _ACCENTS]
    indices = [part for part in rest if part not in _ACCENTS]
    if "~" in base:
        base, digits = base.split("~")
        accents.insert(0, "tilde")
        indices[:0] = [digits] if digits else []
    numbered = re.fullmatch(r"([A-Za-z]+)(\d+)", base)
    if numbered:
        base, indices = numbered[1], [numbered[2], *indices]
    return GREEK.get(base, base), tuple(accents), ",".join(indices)


def latex_symbol(word: str) -> str:
    """A symbol such as omega_3_dot as LaTeX."""
    letter, accents, index = parts_of_symbol(word)
    written = _LATEX_GREEK.get(letter, r"\mathbf{3}" if letter == AXIS else letter)
    for accent in accents:
        written = rf"\{accent}{{{written}}}"
    if not index:
        return written
    return f"{written}_{index}" if len(index) == 1 else rf"{written}_{{\mathrm{{{index}}}}}"


class _Token(NamedTuple):
    """``kind`` is number, word or sign; ``spaced`` says whether a space stands before it."""

    kind: str
    text: str
    spaced: bool
    marked: bool = False


class _Part(NamedTuple):
    """LaTeX of a part of a formula, and what it is, on which its brackets depend."""

    latex: str
    kind: str

    def inside(self, loose: tuple[str, ...] = _LOOSE) -> str:
        """The LaTeX, in brackets if the kind is one of ``loose``."""
        return _bracketed(self.latex) if self.kind in loose else self.latex


def _bracketed(latex: str) -> str:
    return rf"\left({latex}\right)"


def _grouped(latex: str) -> str:
    return latex if len(latex) == 1 else f"{{{latex}}}"


def _tokens(text: str) -> list[_Token]:
    text = _DERIVATIVE.sub(r"ddt(\1)", text.replace("lambdadot", "lambda_dot")).rstrip()
    read: list[_Token] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if not match or not match.lastgroup:
            raise NoFormulaError(text)
        kind = match.lastgroup
        read.append(_Token(kind, match[kind], match.start(kind) > position))
        position = match.end()
    return read


def _marked(tokens: list[_Token], others: list[_Token]) -> list[_Token]:
    """The tokens, marked where ``others`` have something else."""
    own, their = ([token.text for token in some] for some in (tokens, others))
    codes = SequenceMatcher(None, own, their, False).get_opcodes()
    changed = [code for code in codes if code[0] != "equal"]
    places = {i for _, begin, end, _, _ in changed for i in range(begin, end)}
    return [token._replace(marked=i in places) for i, token in enumerate(tokens)]


class _Writer:
    """Reads tokens by falling precedence, as Python does, with the module's exceptions."""

    def __init__(self, text: str, other: str, mark: str, space: str):
        if _UNIT.search(text):
            raise NoFormulaError(text)
        tokens = _tokens(text)
        self.text, self.mark, self.space = text, mark, space
        self.rest = (_marked(tokens, _tokens(other)) if other else tokens)[::-1]
        self.names_something = False

    def formula(self) -> str:
        """The whole formula."""
        parts = [self.relation()]
        while parts[-1].kind == "relation" and self.take(","):
            parts.append(self.relation())
        is_list = len(parts) > 1 and any(part.kind != "relation" for part in parts)
        operates = parts[0].kind not in ("number", "symbol")
        if self.rest or is_list or not operates or not self.names_something:
            raise NoFormulaError(self.text)
        return ", ".join(part.latex for part in parts)

    def relation(self) -> _Part:
        part = self.sum()
        while self.at(*_RELATIONS):
            sign = self.rest.pop()
            written = self.set(sign, _RELATIONS[sign.text])
            part = _Part(f"{part.latex} {written} {self.sum().latex}", "relation")
        return part

    def sum(self) -> _Part:
        part = self.negative() if self.at("-") else self.product()
        while self.at("+", "-"):
            if self.at("-"):
                added = self.negative().latex
            else:
                added = f"{self.set(self.rest.pop())} {self.product().inside(('relation',))}"
            part = _Part(f"{part.inside(('relation',))} {added}", "sum")
        return part

    def negative(self) -> _Part:
        return _Part(f"{self.set(self.rest.pop())} {self.product().inside()}", "negative")

    def product(self) -> _Part:
        part = self.power()
        while self.rest:
            following = self.rest[-1]
            if self.take("*"):
                part = self.times(part, self.power())
            elif self.take("/"):
                part = _Part(rf"\frac{{{part.latex}}}{{{self.power().latex}}}", "quotient")
            elif self.at("x") and following.spaced and len(self.rest) > 1 and self.rest[-2].spaced:
                self.rest.pop()
                left, right = self.axis(part), self.axis(self.power())
                part = _Part(rf"{left.inside()} \times {right.inside()}", "cross")
            elif following.kind in ("word", "number") or (self.at("(") and following.spaced):
                if not following.spaced:
                    raise NoFormulaError(self.text)
                part = self.times(part, self.axis(self.power()))
            else:
                break
        return part

    def times(self, left: _Part, right: _Part) -> _Part:
        sign = r" \cdot " if right.kind == "number" else r"\, "
        return _Part(left.inside() + sign + right.inside(), "product")

    def axis(self, part: _Part) -> _Part:
        """The symmetry axis, where the number 3 can stand for nothing else."""
        if part != (AXIS, "number"):
            return part
        self.names_something = True
        return _Part(latex_symbol(AXIS), "symbol")

    def power(self) -> _Part:
        part = self.atom()
        while self.at(".") and len(self.rest) > 1 and not self.rest[-2].spaced:
            self.rest.pop()
            loose = (*_LOOSE, "cross")
            right = self.axis(self.atom())
            part = _Part(rf"{part.inside(loose)} \cdot {right.inside(loose)}", "dot")
        exponent = self.exponent()
        if not exponent:
            return part
        base = part.inside(_LOOSE_BASE)
        return _Part((base if part.kind in _LOOSE_BASE else _grouped(base)) + exponent, "power")

    def exponent(self) -> str:
        """``^2``, or nothing."""
        if not self.at("**", "^"):
            return ""
        self.rest.pop()
        return "^" + _grouped((self.negative() if self.at("-") else self.power()).latex)

    def atom(self) -> _Part:
        if not self.rest:
            raise NoFormulaError(self.text)
        token = self.rest.pop()
        if token.kind == "number":
            mantissa, _, power = token.text.lower().partition("e")
            written = rf"{mantissa}\cdot 10^{{{int(power)}}}" if power else mantissa
            return _Part(self.set(token, written), "number")
        if token.text == "(":
            parts = self.arguments()
            return parts[0] if len(parts) == 1 else _Part(_listed(parts), "tuple")
        if token.text == "|":
            inner = self.sum()
            self.expect("|")
            return _Part(rf"\lvert {inner.latex} \rvert", "size")
        if token.kind != "word":
            raise NoFormulaError(self.text)
        if token.text in ("sin", "cos", "tan") and self.rest and self.rest[-1].kind == "word":
            return self.call(token, [self.atom()])
        if self.at("(") and not self.rest[-1].spaced:
            self.rest.pop()
            return self.call(token, self.arguments())
        return self.symbol(token)

    def arguments(self) -> list[_Part]:
        parts = [self.relation()]
        while self.take(","):
            parts.append(self.relation())
        self.expect(")")
        return parts

    def call(self, token: _Token, arguments: list[_Part]) -> _Part:
        first = arguments[0]
        if token.text in ("dot", "cross") and len(arguments) == 2:
            loose = (*_LOOSE, "cross") if token.text == "dot" else _LOOSE
            sign = r" \cdot " if token.text == "dot" else r" \times "
            return _Part(sign.join(part.inside(loose) for part in arguments), token.text)
        if token.text == "sqrt":
            return _Part(rf"\sqrt{{{first.latex}}}", "root")
        if token.text == "abs":
            return _Part(rf"\lvert {first.latex} \rvert", "size")
        if token.text == "ddt":
            return _Part(rf"\frac{{d {first.latex}}}{{dt}}", "derivative")
        if token.text not in _UPRIGHT:
            return _Part(self.symbol(token).latex + _listed(arguments), "call")
        self.names_something = True
        exponent = self.exponent()  # between the function and its argument
        alone = len(arguments) == 1 and first.kind == "symbol"
        written = self.space + first.latex if alone else _listed(arguments)
        name = self.set(token, rf"\{token.text}")
        return _Part(name + exponent + written, "power" if exponent else "call")

    def symbol(self, token: _Token) -> _Part:
        if token.text != "3_dot" and not _SYMBOL.fullmatch(token.text):
            raise NoFormulaError(self.text)
        self.names_something = True
        return _Part(self.set(token, latex_symbol(token.text)), "symbol")

    def set(self, token: _Token, written: str = "") -> str:
        written = written or token.text
        return self.mark.replace("...", written) if token.marked else written

    def at(self, *signs: str) -> bool:
        return bool(self.rest) and self.rest[-1].text in signs

    def take(self, sign: str) -> bool:
        return self.at(sign) and bool(self.rest.pop())

    def expect(self, sign: str) -> None:
        if not self.take(sign):
            raise NoFormulaError(self.text)


def _listed(parts: list[_Part]) -> str:
    return _bracketed(", ".join(part.latex for part in parts))
