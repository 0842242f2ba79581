"""Plain text with symbols, numbers and formulas in it, as HTML and as Markdown with LaTeX.

Texts name quantities as in the code (``omega_3``, ``phi_dot``, ``E~``, ``9.381e-4 kg m^2/s``); the
page has mathematical symbols. Text in backticks is code and stays unchanged.

Formulas are in Python's notation, set as LaTeX and as MathML; terms keep their order. ``dot``,
``cross``, ``abs``, ``sqrt``, ``ddt`` and ``->`` have their usual signs, ``axis`` is the symmetry
axis (a bold 3 in the paper). Symbols in which two formulas differ are marked.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from difflib import SequenceMatcher
from html import escape
from unicodedata import normalize

import mpmath
from latex2mathml.converter import convert

from tt_precise.claims.part import Part
from tt_precise.runtime.values import Scalar

# ---- formulas ------------------------------------------------------------------------------------

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "eps": "ε", "epsilon": "ε",
    "lambda": "λ", "mu": "μ", "nu": "ν", "omega": "ω", "phi": "φ", "pi": "π", "psi": "ψ",
    "sigma": "σ", "tau": "τ", "theta": "θ", "xi": "ξ",
}  # fmt: skip
AXIS = "3"
_LATEX_GREEK = {letter: rf"\{name}" for name, letter in GREEK.items()} | {
    "ε": r"\varepsilon", "φ": r"\varphi",
}  # fmt: skip
_ACCENT = {"dot": "\u0307", "ddot": "\u0308", "dddot": "\u20db", "tilde": "\u0303", "hat": "\u0302"}
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
    accents = [part for part in rest if part in _ACCENT]
    indices = [part for part in rest if part not in _ACCENT]
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


# ---- texts ---------------------------------------------------------------------------------------

DIGITS = 8  # Significant digits of a number where the digits are not the point.

_GREEK = "|".join(sorted((name for name in GREEK if name != "pi"), key=len, reverse=True))
# Letters that are quantities where they have an index, a dot or a tilde.
_SYMBOL = (
    rf"(?:(?:{_GREEK})(?:~?\d?(?:_[A-Za-z0-9]+)*)|pi"
    r"|E~\d?|[A-Zagkrsv](?:_(?:dot|ddot|hat|tilde|[xyzns3A]|pot|rot|trans|upp|inv|min|up|f|tilde))+"
    r"|t_(?:init|end|inv)(?:_[ABC])?|z_(?:min|hat)|3_dot|[DEIL][013])"
)
_TOKEN = re.compile(
    r"(?P<code>`[^`]+`)"
    rf"|(?<![\w~])(?<!\w-)(?P<symbol>{_SYMBOL})_?(?![\w~]|-[a-z]|\.[a-z]{{3}})"
    r"|(?<![\w.])(?<![a-z]-)(?P<number>\d+(?:\.\d+)?)(?:e(?P<power>[+-]?\d+)|\*10\^(?P<ten>[+-]?\d+))?(?![\w.]\d)"
    r"|(?P<raised>(?<=[A-Za-z0-9)|])(?:\^|\*\*)(?P<exponent>-?\d+))"
    r"|(?P<minus>(?<![\w)\]\-])-(?=\d)|(?<= )-(?= ))"
    rf"|(?P<sign>->|<=|>=|(?<=[\w)]) x (?=\(|\w\b|\w_|{_GREEK})|(?<=[\w)])\*(?=[\w(|]))"
)


@dataclass(frozen=True)
class Language:
    """A markup language; ``formula`` marks the differences from another formula, or from ""."""

    plain: Callable[[str], str]
    code: Callable[[str], str]
    symbol: Callable[[str], str]
    formula: Callable[[str, str], str]
    power: str
    raised: str
    minus: str
    signs: Mapping[str, str]

    def text(self, text: str, digits: int | None = None) -> str:
        """The text in this language; numbers have at most ``digits`` digits if given."""
        texts, position = [], 0
        for match in _TOKEN.finditer(text):
            texts += [self.plain(text[position : match.start()]), self._token(match, digits)]
            position = match.end()
        return "".join([*texts, self.plain(text[position:])])

    def short(self, text: str) -> str:
        """The text; numbers have at most ``DIGITS`` digits."""
        return self.text(text, DIGITS)

    def paper_side(self, part: Part) -> str:
        """The paper's side of a part, a formula or words."""
        return self.formula(part.printed, "") if part.formula else self.short(part.printed)

    def pair(self, printed: Part, corrected: Part) -> tuple[str, str]:
        """A printed and a corrected formula with their differences marked, or words."""
        if not (printed.formula and corrected.formula):
            return self.paper_side(printed), self.paper_side(corrected)
        left, right = printed.printed, corrected.printed
        return self.formula(left, right), self.formula(right, left)

    def _token(self, match: re.Match[str], digits: int | None) -> str:
        if match["code"]:
            return self.code(match["code"][1:-1])
        if match["symbol"]:
            return self.symbol(match["symbol"])
        if match["number"]:
            return self._number(match, digits)
        if match["raised"]:
            return self.raised.format(match["exponent"].replace("-", self.minus))
        return self.minus if match["minus"] else self.signs[match["sign"]]

    def _number(self, match: re.Match[str], digits: int | None) -> str:
        number = shortened(match["number"], digits) if digits else match["number"]
        power = match["power"] or match["ten"]
        if not power or not float(number):
            return number
        written = self.power.format(number, str(int(power)).replace("-", self.minus))
        # 10^-6 rather than 1 times it
        return re.sub(r"^(\$?)1 (?:·|\\cdot) ", r"\1", written)


def _html_symbol(word: str) -> str:
    letter, accents, index = split_symbol(word)
    letter = normalize("NFC", letter + "".join(_ACCENT[accent] for accent in accents))
    written = f"<i>{letter}</i>" if letter[0] != AXIS else f"<b>{letter}</b>"
    return written + (f"<sub>{escape(index)}</sub>" if index else "")


HTML = Language(
    plain=escape,
    code=lambda text: f"<code>{escape(text)}</code>",
    symbol=_html_symbol,
    formula=mathml,
    power="{} · 10<sup>{}</sup>",
    raised="<sup>{}</sup>",
    minus="−",
    signs={"->": "→", "<=": "≤", ">=": "≥", " x ": " × ", "*": "·"},
)
MARKDOWN = Language(
    plain=lambda text: text.replace("*", r"\*").replace("$", r"\$").replace("<", r"\<"),
    code=lambda text: f"`{text}`",
    symbol=lambda word: f"${latex_symbol(word)}$",
    formula=lambda text, other: f"${latex(text, other)}$",
    power=r"${} \cdot 10^{{{}}}$",
    raised="$^{{{}}}$",
    minus="-",
    signs={"->": r"$\to$", "<=": r"$\le$", ">=": r"$\ge$", " x ": r" $\times$ ", "*": "·"},
)


def shortened(number: str, digits: int) -> str:
    """A decimal number with at most ``digits`` significant digits."""
    significant = number.replace(".", "").lstrip("0")
    if "." not in number or 0 < len(significant) <= digits:
        return number
    rounded = Decimal(f"{Decimal(number):.{digits - 1}e}")
    return f"{rounded:.{max(digits - 1 - rounded.adjusted(), 0)}f}" if rounded else "0"


def short(value: Scalar, digits: int = 2) -> str:
    """A number with few significant digits: 1.8e-15, 0.053, 12."""
    if value is None:
        return "-"
    return str(mpmath.nstr(_mpf(value), digits, min_fixed=-3, max_fixed=6)).removesuffix(".0")


def full(value: Scalar, digits: int) -> str:
    """A number with all its trusted digits."""
    return str(mpmath.nstr(_mpf(value), digits, min_fixed=-4, max_fixed=12))


def _mpf(value: Scalar) -> Scalar:
    return value if hasattr(value, "_mpf_") else mpmath.mpf(value)
