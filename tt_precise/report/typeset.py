"""Formulas as MathML for the page and as LaTeX for its Markdown twin.

``differences`` finds what of a printed formula is not in the corrected one, to be marked.
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import SequenceMatcher
from html import escape

from tt_precise.report.formula import RELATIONS, Node, parts_of_symbol

# a node in a tree, by the positions of the branches that lead to it
Place = tuple[int, ...]
Places = frozenset[Place]
NONE: Places = frozenset()
SIGN = -1  # the minus of a negative

THIN = '<mo>&#x2062;</mo><mspace width="0.14em"/>'
_LOOSE = ("sum", "negative", "relation", "tuple")
# set above the letter: as accents, fonts without tables for mathematics draw them over it
_ACCENT = {"dot": ".", "ddot": "..", "tilde": "~", "hat": "^"}
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
    return f"<math>{_Mathml(marked).of(node, ())}</math>"


def latex(node: Node, marked: Places = NONE) -> str:
    """LaTeX without dollars; the marked places are underlined."""
    return _Latex(marked).of(node, ())


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


class _Writer:
    """What both languages share: which parts need brackets."""

    def __init__(self, marked: Places):
        self.marked = marked

    def of(self, node: Node, place: Place) -> str:
        written = getattr(self, f"_{node.kind}")(node, place)
        return self._mark(written) if place in self.marked else written

    def _part(self, node: Node, place: Place, i: int, loose: Sequence[str] = _LOOSE) -> str:
        part = node.parts[i]
        written = self.of(part, (*place, i))
        return self._bracketed(written) if part.kind in loose else written

    def _mark(self, written: str) -> str:
        raise NotImplementedError

    def _bracketed(self, written: str) -> str:
        raise NotImplementedError


class _Mathml(_Writer):
    def _mark(self, written: str) -> str:
        return f'<mrow class="differs">{written}</mrow>'

    def _bracketed(self, written: str) -> str:
        return f'<mrow><mo stretchy="true">(</mo>{written}<mo stretchy="true">)</mo></mrow>'

    def _number(self, node: Node, place: Place) -> str:
        mantissa, _, power = node.text.lower().partition("e")
        if not power:
            return f"<mn>{mantissa}</mn>"
        ten = f"<msup><mn>10</mn><mn>{str(int(power)).replace('-', '−')}</mn></msup>"
        return f"<mrow><mn>{mantissa}</mn><mo>·</mo>{ten}</mrow>"

    def _symbol(self, node: Node, _: Place) -> str:
        letter, accents, index = parts_of_symbol(node.text)
        written = f"<mi>{letter}</mi>" if letter != AXIS else f'<mn class="axis">{letter}</mn>'
        if node.text in _UPRIGHT:
            written = f'<mi mathvariant="normal">{letter}</mi>'
        for accent in accents:
            written = f"<mover>{written}<mo>{_ACCENT[accent]}</mo></mover>"
        return f"<msub>{written}<mtext>{escape(index)}</mtext></msub>" if index else written

    def _sum(self, node: Node, place: Place) -> str:
        found = [self._part(node, place, 0, ("relation",))]
        for i, part in enumerate(node.parts[1:], 1):
            if part.kind == "negative" and (*place, i) not in self.marked:
                found.append(self._minus((*place, i)) + self._part(part, (*place, i), 0))
            elif part.kind == "negative":  # brings its own sign
                found.append(self.of(part, (*place, i)))
            else:
                found.append(f"<mo>+</mo>{self._part(node, place, i, ('relation',))}")
        return f"<mrow>{''.join(found)}</mrow>"

    def _minus(self, place: Place) -> str:
        return self._mark("<mo>−</mo>") if (*place, SIGN) in self.marked else "<mo>−</mo>"

    def _negative(self, node: Node, place: Place) -> str:
        return f"<mrow>{self._minus(place)}{self._part(node, place, 0)}</mrow>"

    def _product(self, node: Node, place: Place) -> str:
        parts = [self._part(node, place, i) for i in range(len(node.parts))]
        numbers = [part.kind == "number" for part in node.parts]
        written = parts[0]
        for i, part in enumerate(parts[1:], 1):
            sign = "<mo>·</mo>" if numbers[i] else THIN
            written += sign + part
        return f"<mrow>{written}</mrow>"

    def _quotient(self, node: Node, place: Place) -> str:
        over, under = (self.of(part, (*place, i)) for i, part in enumerate(node.parts))
        return f"<mfrac>{over}{under}</mfrac>"

    def _power(self, node: Node, place: Place) -> str:
        base, exponent = node.parts
        power = self.of(exponent, (*place, 1))
        if base.kind == "call" and base.parts[0].text in _UPRIGHT:  # sin² θ
            name = self.of(base.parts[0], (*place, 0, 0))
            argument = self._argument(base, (*place, 0))
            return f"<mrow><msup>{name}{power}</msup>{argument}</mrow>"
        loose = (*_LOOSE, "product", "quotient", "cross", "dot", "call", "power")
        return f"<msup>{self._part(node, place, 0, loose)}{power}</msup>"

    def _root(self, node: Node, place: Place) -> str:
        return f"<msqrt>{self.of(node.parts[0], (*place, 0))}</msqrt>"

    def _call(self, node: Node, place: Place) -> str:
        name = self.of(node.parts[0], (*place, 0))
        return f"<mrow>{name}{self._argument(node, place)}</mrow>"

    def _argument(self, node: Node, place: Place) -> str:
        written = self.of(node.parts[1], (*place, 1))
        if node.parts[0].text in _UPRIGHT and node.parts[1].kind == "symbol":
            return f'<mo>&#x2061;</mo><mspace width="0.17em"/>{written}'
        return f"<mo>&#x2061;</mo>{self._bracketed(written)}"

    def _cross(self, node: Node, place: Place) -> str:
        left, right = (self._part(node, place, i) for i in (0, 1))
        return f"<mrow>{left}<mo>×</mo>{right}</mrow>"

    def _dot(self, node: Node, place: Place) -> str:
        left, right = (self._part(node, place, i, (*_LOOSE, "cross")) for i in (0, 1))
        return f"<mrow>{left}<mo>·</mo>{right}</mrow>"

    def _size(self, node: Node, place: Place) -> str:
        written = self.of(node.parts[0], (*place, 0))
        return f"<mrow><mo>|</mo>{written}<mo>|</mo></mrow>"

    def _relation(self, node: Node, place: Place) -> str:
        signs = [escape(RELATIONS[sign]) for sign in node.text.split()]
        parts = [self.of(part, (*place, i)) for i, part in enumerate(node.parts)]
        rest = (f"<mo>{sign}</mo>{part}" for sign, part in zip(signs, parts[1:], strict=True))
        return f"<mrow>{parts[0]}{''.join(rest)}</mrow>"

    def _derivative(self, node: Node, place: Place) -> str:
        over = f"<mi>d</mi>{self.of(node.parts[0], (*place, 0))}"
        return f"<mfrac><mrow>{over}</mrow><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>"

    def _tuple(self, node: Node, place: Place) -> str:
        parts = [self.of(part, (*place, i)) for i, part in enumerate(node.parts)]
        written = f"<mrow>{'<mo>,</mo>'.join(parts)}</mrow>"
        return self._bracketed(written) if node.text else written


class _Latex(_Writer):
    def _mark(self, written: str) -> str:
        return rf"\underline{{{written}}}"

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
            return f" {written}"
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
