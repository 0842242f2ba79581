"""Texts with symbols, and formulas: read as they are written, set as people write them."""

import pytest

from tt_precise.claims import part as v
from tt_precise.report import prose

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
