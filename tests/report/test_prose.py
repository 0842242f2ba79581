"""Texts with symbols, and formulas: read as they are written, set as people write them."""

from xml.etree import ElementTree

import pytest

from tt_precise.claims import part as v
from tt_precise.claims.verdicts import committed
from tt_precise.report import prose
from tt_precise.report.prose import latex, mathml

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


SEEN = {
    "|a|^2": "|a|<sup>2</sup>",
    "theta_dot > 0": "<i>θ̇</i> &gt; 0",
    "omega_3_dot": "<i>ω̇</i><sub>3</sub>",
    "E~ - E": "<i>Ẽ</i> − E",
    "9.381e-4 kg m^2/s": "9.381 · 10<sup>−4</sup> kg m<sup>2</sup>/s",
    "order 1e-6": "order 10<sup>−6</sup>",
    "s_dot = -omega x a": "<i>ṡ</i> = -<i>ω</i> × a",
    "lambda -> E1": "<i>λ</i> → <i>E</i><sub>1</sub>",
    "from -85 to 3": "from −85 to 3",
    "<b>a & b": "&lt;b&gt;a &amp; b",
    "in the plane of x and z, so that x points": "in the plane of x and z, so that x points",
    "phi_dddot at v_s": "<i>φ⃛</i> at <i>v</i><sub>s</sub>",
    "0.0e+00": "0.0",
    "`theta_dot`": "<code>theta_dot</code>",
    "`a < b`": "<code>a &lt; b</code>",
    "phi-dot-195, regularised-1e-2": "phi-dot-195, regularised-1e-2",
}


@pytest.mark.parametrize(("text", "seen"), SEEN.items())
def test_symbols_are_seen_as_people_write_them(text: str, seen: str) -> None:
    assert prose.HTML.text(text) == seen


def test_markdown_has_latex() -> None:
    assert prose.MARKDOWN.text("`theta_dot`") == "`theta_dot`"
    assert prose.MARKDOWN.text("theta_dot > 9.4e-4") == r"$\dot{\theta}$ > $9.4 \cdot 10^{-4}$"
    assert prose.MARKDOWN.text("a * b < $c") == r"a \* b \< \$c"
    assert prose.MARKDOWN.text("b x a^2 -> 0") == r"b $\times$ a$^{2}$ $\to$ 0"
    assert prose.MARKDOWN.text("a <= b >= c") == r"a $\le$ b $\ge$ c"


@pytest.mark.parametrize(
    ("number", "short"),
    [
        ("7.8273864055617567", "7.8273864"), ("0.00072388523010547", "0.00072388523"),
        ("155.00000000000000000", "155.00000"), ("1.5", "1.5"), ("1306.5641", "1306.5641"),
        ("123456789012", "123456789012"), ("0.99999999999", "1.0000000"), ("0.000000000", "0"),
    ],
)  # fmt: skip
def test_no_number_shows_more_digits_than_mean_something(number: str, short: str) -> None:
    assert prose.shortened(number, 8) == short
    assert prose.HTML.text(f"{number} s", 8) == f"{short} s"
    assert prose.HTML.text(f"{number} s") == f"{number} s"


def test_a_part_says_whether_it_is_a_formula() -> None:
    formula = v.formula(True, "E_pot = m*g*R", "so")
    words = v.statement(True, "E_pot = m*g*R, 7.8273864055617567 s", "so")
    assert prose.HTML.paper_side(formula).startswith("<math")
    assert prose.HTML.paper_side(words).startswith("<i>E</i><sub>pot</sub> = m·g·R, 7.8273864 s")
    assert prose.MARKDOWN.paper_side(formula) == r"$E_{\mathrm{pot}} = m\, g\, R$"
    assert "$" not in prose.MARKDOWN.paper_side(v.statement(True, "increasing", ""))
