"""Plain text with symbols and numbers in it, as HTML and as Markdown with LaTeX.

Texts name quantities as in the code (``omega_3``, ``phi_dot``, ``E~``, ``9.381e-4 kg m^2/s``); the
page has mathematical symbols. Text in backticks is code and stays unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import Decimal
from functools import partial
from html import escape
from unicodedata import normalize

import mpmath

from tt_precise.claims.verdicts import Part
from tt_precise.report import formula
from tt_precise.report.formula import GREEK, split_symbol
from tt_precise.runtime.values import Scalar

DIGITS = 8  # Significant digits of a number where the digits are not the point.

_ACCENT = {"dot": "\u0307", "ddot": "\u0308", "dddot": "\u20db", "tilde": "\u0303", "hat": "\u0302"}
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
_SIGNS = {"->": "→", "<=": "≤", ">=": "≥", " x ": " × ", "*": "·"}
_LATEX_SIGNS = {"->": r"$\to$", "<=": r"$\le$", ">=": r"$\ge$", " x ": r" $\times$ ", "*": r"·"}


def html(text: str, digits: int | None = None) -> str:
    """The text as HTML; numbers have at most ``digits`` digits if given."""
    return _replaced(text, partial(_as_html, digits=digits), escape)


def markdown(text: str, digits: int | None = None) -> str:
    """The text as Markdown."""
    return _replaced(text, partial(_as_markdown, digits=digits), _unmarked)


def printed_html(part: Part, digits: int | None = DIGITS) -> str:
    """The paper's side of a part, a formula or words, as HTML."""
    return formula.mathml(part.printed) if part.formula else html(part.printed, digits)


def printed_markdown(part: Part, digits: int | None = DIGITS) -> str:
    """The paper's side of a part, a formula or words, as Markdown."""
    return f"${formula.latex(part.printed)}$" if part.formula else markdown(part.printed, digits)


def pair_html(printed: Part, corrected: Part) -> tuple[str, str]:
    """A printed and a corrected formula with their differences marked, or words."""
    if not (printed.formula and corrected.formula):
        return printed_html(printed), printed_html(corrected)
    left, right = printed.printed, corrected.printed
    return formula.mathml(left, right), formula.mathml(right, left)


def pair_markdown(printed: Part, corrected: Part) -> tuple[str, str]:
    """A printed and a corrected formula with their differences underlined, or words."""
    if not (printed.formula and corrected.formula):
        return printed_markdown(printed), printed_markdown(corrected)
    left, right = printed.printed, corrected.printed
    return f"${formula.latex(left, right)}$", f"${formula.latex(right, left)}$"


def shortened(number: str, digits: int) -> str:
    """A decimal number with at most ``digits`` significant digits."""
    significant = number.replace(".", "").lstrip("0")
    if "." not in number or 0 < len(significant) <= digits:
        return number
    rounded = Decimal(f"{Decimal(number):.{digits - 1}e}")
    return f"{rounded:.{max(digits - 1 - rounded.adjusted(), 0)}f}" if rounded else "0"


def _replaced(text: str, token: Callable[[re.Match[str]], str], other: Callable[[str], str]) -> str:
    texts, position = [], 0
    for match in _TOKEN.finditer(text):
        texts += [other(text[position : match.start()]), token(match)]
        position = match.end()
    return "".join([*texts, other(text[position:])])


def _as_html(match: re.Match[str], digits: int | None) -> str:
    if match["code"]:
        return f"<code>{escape(match['code'][1:-1])}</code>"
    if match["symbol"]:
        letter, accents, index = split_symbol(match["symbol"])
        letter = normalize("NFC", letter + "".join(_ACCENT[accent] for accent in accents))
        written = f"<i>{letter}</i>" if letter[0] != formula.AXIS else f"<b>{letter}</b>"
        return written + (f"<sub>{escape(index)}</sub>" if index else "")
    if match["number"]:
        return _number(match, digits, "{} · 10<sup>{}</sup>", "−")
    if match["raised"]:
        return f"<sup>{match['exponent'].replace('-', '−')}</sup>"
    if match["minus"]:
        return "−"
    return _SIGNS[match["sign"]]


def _as_markdown(match: re.Match[str], digits: int | None) -> str:
    if match["code"]:
        return match["code"]
    if match["symbol"]:
        return f"${formula.latex_symbol(match['symbol'])}$"
    if match["number"]:
        return _number(match, digits, r"${} \cdot 10^{{{}}}$", "-")
    if match["raised"]:
        return f"$^{{{match['exponent']}}}$"
    if match["minus"]:
        return "-"
    return _LATEX_SIGNS[match["sign"]]


def _number(match: re.Match[str], digits: int | None, form: str, minus: str) -> str:
    number = shortened(match["number"], digits) if digits else match["number"]
    power = match["power"] or match["ten"]
    if not power or not float(number):
        return number
    written = form.format(number, str(int(power)).replace("-", minus))
    # 10^-6 rather than 1 times it
    return re.sub(r"^(\$?)1 (?:·|\\cdot) ", r"\1", written)


def _unmarked(text: str) -> str:
    return text.replace("*", r"\*").replace("$", r"\$").replace("<", r"\<")


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
