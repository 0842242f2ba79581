"""Formulas in Python's notation, set as LaTeX and as MathML; terms keep their order.

``dot``, ``cross``, ``abs``, ``sqrt``, ``ddt`` and ``->`` have their usual signs, ``axis`` is the
symmetry axis (a bold 3 in the paper). Symbols in which two formulas differ are marked.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from difflib import SequenceMatcher

from latex2mathml.converter import convert

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "epsilon": "ε",
    "lambda": "λ", "mu": "μ", "nu": "ν", "omega": "ω", "phi": "φ", "pi": "π", "psi": "ψ",
    "sigma": "σ", "tau": "τ", "theta": "θ", "xi": "ξ",
}  # fmt: skip
AXIS = "3"
_LATEX_GREEK = {letter: rf"\{name}" for name, letter in GREEK.items()} | {
    "ε": r"\varepsilon", "φ": r"\varphi",
}  # fmt: skip
_ACCENTS = ("dot", "ddot", "dddot", "tilde", "hat")
_UPRIGHT = ("sin", "cos", "tan")
_RELATIONS = {ast.Eq: "=", ast.Lt: "<", ast.Gt: ">", ast.LtE: r"\le", ast.GtE: r"\ge"}
_SIGNS = {ast.Add: "+", ast.Sub: "-", ast.RShift: r"\to"}
# Precedence, as in Python; a product of vectors binds less than a product of numbers.
_RELATION, _SUM, _VECTORS, _PRODUCT, _ATOM = range(5)
_LEAF = "\0"  # begins a token that can be marked: a symbol, a number, a sign


def latex(text: str, other: str = "") -> str:
    """A formula as LaTeX without dollars; differences from ``other``, if given, are underlined.

    Raises ``SyntaxError``: the text is no formula.
    """
    return _marked(text, other, r"\underline{%s}")


def mathml(text: str, other: str = "") -> str:
    """A formula as a ``<math>`` element; differences from ``other`` have the class ``differs``.

    Raises ``SyntaxError``: the text is no formula.
    """
    return str(convert(_marked(text, other, r"\class{differs}{%s}")))


def split_symbol(word: str) -> tuple[str, tuple[str, ...], str]:
    """The letter, its accents and its index: ("ω", ("dot",), "3") of omega_3_dot."""
    word = re.sub(r"^(?:axis|3)(?=_dot|$)", "AXIS", word).rstrip("_")
    base, *rest = word.split("_")
    accents = [part for part in rest if part in _ACCENTS]
    indices = [part for part in rest if part not in _ACCENTS]
    if "~" in base:
        base, digits = base.split("~")
        accents.insert(0, "tilde")
        indices[:0] = [digits] if digits else []
    numbered = re.fullmatch(r"([A-Za-z]+)(\d+)", base)
    if numbered:
        base, indices = numbered[1], [numbered[2], *indices]
    letter = AXIS if base == "AXIS" else GREEK.get(base, base)
    return letter, tuple(accents), ",".join(indices)


def latex_symbol(word: str) -> str:
    """A symbol such as omega_3_dot as LaTeX."""
    letter, accents, index = split_symbol(word)
    written = _LATEX_GREEK.get(letter, r"\mathbf{3}" if letter == AXIS else letter)
    for accent in accents:
        written = rf"\{accent}{{{written}}}"
    if not index:
        return written
    return f"{written}_{index}" if len(index) == 1 else rf"{written}_{{\mathrm{{{index}}}}}"


def _marked(text: str, other: str, mark: str) -> str:
    own, their = _tokens(text), _tokens(other) if other else []
    changed = set()
    if other:
        codes = SequenceMatcher(None, own, their, autojunk=False).get_opcodes()
        changed = {i for code, a, b, _, _ in codes if code != "equal" for i in range(a, b)}
    written = [
        mark % token[1:] if i in changed and token[0] == _LEAF else token.lstrip(_LEAF)
        for i, token in enumerate(own)
    ]
    return re.sub(r" +", " ", "".join(written)).strip()


def _tokens(text: str) -> list[str]:
    code = re.sub(r"\blambda\b", "lambda_", text).replace("->", ">>")
    code = re.sub(r"(?<![=<>])=(?!=)", "==", code)
    code = code.strip()
    body = ast.parse(code, mode="eval").body
    for node in ast.walk(body):
        if isinstance(node, ast.Constant):  # 0.10 keeps its zero
            node.kind = ast.get_source_segment(code, node)
    return _listed(body.elts) if isinstance(body, ast.Tuple) else _set(body)[0]


def _set(node: ast.expr) -> tuple[list[str], int]:
    """The tokens of a node, and its precedence."""
    match node:
        case ast.Constant(value=int() | float(), kind=str(text)):
            return [_LEAF + _number(text)], _ATOM
        case ast.Name(id=name):
            return [_LEAF + latex_symbol(name)], _ATOM
        case ast.Tuple(elts=elements):
            return _bracketed(_listed(elements)), _ATOM
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return [_LEAF + "-", " ", *_inside(operand, _VECTORS)], _SUM
        case ast.Compare(left=left, ops=signs, comparators=rights):
            tokens = _set(left)[0]
            for sign, right in zip(signs, rights, strict=True):
                tokens += [" ", _LEAF + _RELATIONS[type(sign)], " ", *_set(right)[0]]
            return tokens, _RELATION
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.RShift() as sign, right=right):
            least = _VECTORS if isinstance(sign, ast.Sub) else _SUM
            signed = [" ", _LEAF + _SIGNS[type(sign)], " "]
            return [*_set(left)[0], *signed, *_inside(right, least)], _SUM
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            times = r" \cdot " if isinstance(right, ast.Constant) else r"\, "
            leading = isinstance(left, ast.UnaryOp)  # -a*b needs no brackets
            vectors = isinstance(right, ast.Call) and _name(right) in ("dot", "cross")
            factors = _inside(left, _SUM if leading else _PRODUCT), _inside(right, _VECTORS)
            return [*factors[0], times, *factors[1]], _VECTORS if vectors else _PRODUCT
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            return [r"\frac{", *_set(left)[0], "}{", *_set(right)[0], "}"], _ATOM
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            raised = ["^{", *_set(right)[0], "}"]
            if isinstance(left, ast.Call) and _name(left) in _UPRIGHT:
                return _call(left, raised), _PRODUCT
            simple = isinstance(left, ast.Name | ast.Constant)
            base = _set(left)[0] if simple else _bracketed(_set(left)[0])
            return ["{", *base, "}", *raised], _PRODUCT
        case ast.Call():
            return _call(node), _ATOM if _name(node) not in ("dot", "cross") else _VECTORS
    raise SyntaxError(f"formula: got {ast.unparse(node)!r}, expected sums, products and functions")


def _call(node: ast.Call, exponent: list[str] | None = None) -> list[str]:
    name = _name(node)
    if name in ("dot", "cross"):
        sign = r" \cdot " if name == "dot" else r" \times "
        left, right = (_product_inside(argument) for argument in node.args)
        return [*left, sign, *right]
    if name in ("sqrt", "abs", "ddt"):
        opening, closing = {
            "sqrt": (r"\sqrt{", "}"),
            "abs": (r"\lvert ", r" \rvert"),
            "ddt": (r"\frac{d ", "}{dt}"),
        }[name]
        return [opening, *_set(node.args[0])[0], closing]
    written = rf"\{name}" if name in _UPRIGHT else latex_symbol(name)
    alone = name in _UPRIGHT and isinstance(node.args[0], ast.Name)
    listed = _listed(node.args)
    # MathML needs the space behind a function's name that TeX makes itself
    return [
        _LEAF + written,
        *(exponent or []),
        *([r"\, ", *listed] if alone else _bracketed(listed)),
    ]


def _listed(nodes: Sequence[ast.expr]) -> list[str]:
    return [token for node in nodes for token in [", ", *_set(node)[0]]][1:]


def _name(node: ast.Call) -> str:
    return ast.unparse(node.func)


def _inside(node: ast.expr, least: int) -> list[str]:
    tokens, precedence = _set(node)
    return tokens if precedence >= least else _bracketed(tokens)


def _product_inside(node: ast.expr) -> list[str]:
    tokens, precedence = _set(node)
    return tokens if precedence == _ATOM else _bracketed(tokens)


def _bracketed(tokens: list[str]) -> list[str]:
    return [r"\left(", *tokens, r"\right)"]


def _number(text: str) -> str:
    mantissa, _, power = text.lower().partition("e")
    return rf"{mantissa}\cdot 10^{{{int(power)}}}" if power else mantissa
