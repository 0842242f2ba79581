"""Plain text with symbols and numbers in it, as HTML and as Markdown with LaTeX.

Texts name quantities as in the code (``omega_3``, ``phi_dot``, ``E~``, ``9.381e-4 kg m^2/s``); the
page has mathematical symbols. Text in backticks is code and stays unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from html import escape
from unicodedata import normalize

import mpmath

from tt_precise.claims.part import Part
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
    written = f"<i>{letter}</i>" if letter[0] != formula.AXIS else f"<b>{letter}</b>"
    return written + (f"<sub>{escape(index)}</sub>" if index else "")


HTML = Language(
    plain=escape,
    code=lambda text: f"<code>{escape(text)}</code>",
    symbol=_html_symbol,
    formula=formula.mathml,
    power="{} · 10<sup>{}</sup>",
    raised="<sup>{}</sup>",
    minus="−",
    signs={"->": "→", "<=": "≤", ">=": "≥", " x ": " × ", "*": "·"},
)
MARKDOWN = Language(
    plain=lambda text: text.replace("*", r"\*").replace("$", r"\$").replace("<", r"\<"),
    code=lambda text: f"`{text}`",
    symbol=lambda word: f"${formula.latex_symbol(word)}$",
    formula=lambda text, other: f"${formula.latex(text, other)}$",
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
