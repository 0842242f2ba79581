"""Formulas are read as they are written, and set as people write them."""

from xml.etree import ElementTree

import pytest

from tt_precise.claims.committed import committed
from tt_precise.report.formula import latex, mathml

SET = {
    "R*I1*phi_dot*sin(theta)**2": r"R\, I_1\, \dot{\varphi}\, \sin^{2}\, \theta",
    "sigma = (1 - gamma)/(gamma + alpha**2 - 1)":
        r"\sigma = \frac{1 - \gamma}{\gamma + {\alpha}^{2} - 1}",
    "E_rot_dot = dot(omega, cross(a, F))":
        r"\dot{E}_{\mathrm{rot}} = \omega \cdot \left(a \times F\right)",
    "abs(cross(omega, a)) = abs(omega)*abs(a)*sin(theta)":
        r"\lvert \omega \times a \rvert = \lvert \omega \rvert\, \lvert a \rvert\, \sin\, \theta",
    "ddt(E_tilde) = m*dot(cross(omega, a), v_A_dot)":
        r"\frac{d \tilde{E}}{dt} = m\, \left(\omega \times a\right) \cdot \dot{v}_A",
    "theta -> 0, L -> L0*z_hat": r"\theta \to 0, L \to L_0\, \hat{z}",
    "-w0 + w = w0*(1 - w/w0)": r"- w_0 + w = w_0\, \left(1 - \frac{w}{w_0}\right)",
    "lambda/(R*I1) >= 2.5e-6": r"\frac{\lambda}{R\, I_1} \ge 2.5\cdot 10^{-6}",
    "-(a - b)**2": r"- {\left(a - b\right)}^{2}",
    "a - (b - c)": r"a - \left(b - c\right)",
    "(L, axis) = (-z_hat, 0)":
        r"\left(L, \mathbf{3}\right) = \left(- \hat{z}, 0\right)",
}  # fmt: skip


@pytest.mark.parametrize(("text", "wanted"), SET.items())
def test_formulas_are_set(text: str, wanted: str) -> None:
    assert latex(text) == wanted
    assert ElementTree.fromstring(mathml(text)).tag.endswith("math")


@pytest.mark.parametrize("text", ["", "a (b", "in 34 of 39 steps", "[a]", "a b)", "lambda x: x"])
def test_what_is_no_formula_is_refused(text: str) -> None:
    with pytest.raises(SyntaxError):
        latex(text)


def test_every_formula_of_a_claim_is_set() -> None:
    known = committed()
    assert known is not None
    formulas = [part.printed for one in known.claims for part in one.parts if part.formula]
    assert len(formulas) > 60
    assert all(latex(text) and mathml(text) for text in formulas)


DIFFERENCES = [
    ("a - I3*b", "a - R*I3*b", r"a - I_3\, b", r"a - \underline{R}\, I_3\, b"),
    (
        "(1 - alpha)/c", "(1 - gamma)/c", r"\frac{1 - \underline{\alpha}}{c}",
        r"\frac{1 - \underline{\gamma}}{c}",
    ),
    ("x = w*y", "x = -w*y", r"x = w\, y", r"x = \underline{-} w\, y"),
    ("a + b", "a - b", r"a \underline{+} b", r"a \underline{-} b"),
    ("a + b", "a + b", "a + b", "a + b"),
]  # fmt: skip


@pytest.mark.parametrize(("printed", "corrected", "left", "right"), DIFFERENCES)
def test_what_differs_is_marked_and_nothing_else(
    printed: str, corrected: str, left: str, right: str
) -> None:
    assert (latex(printed, corrected), latex(corrected, printed)) == (left, right)
    marks = (left + right).count("underline")
    both = mathml(printed, corrected) + mathml(corrected, printed)
    assert both.count('class="differs"') == marks
