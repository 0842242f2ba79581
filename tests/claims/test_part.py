"""Digits of measured numbers, and comparisons at the edge of their rules."""

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import Any

import pytest

from tt_precise.claims import part
from tt_precise.claims.part import Part, Value


@pytest.mark.parametrize(
    ("compare", "printed", "edges"),
    [
        (part.rounds_to, "0.005106", "0.00510649 rounded, 0.0051065 rounded, 0.00510651 refuted"),
        (part.rounds_to, "-6.667e-4", "-6.6674e-4 rounded, 6.667e-4 refuted"),
        (part.rounds_to, "155", "155.4 rounded, 155.6 refuted"),
        (part.rounds_to, "1.50", "1.504 rounded, 1.506 refuted"),
        (part.rounds_to, "3.", "3.4 rounded"),
        (part.about, "7.87", "7.874 rounded, 7.88 reproduced, 7.8801 refuted"),
        (part.about, "80", "80.3 rounded, 89 reproduced, 91 refuted"),
        (part.about, "0.34", "0.349 reproduced"),
        (part.about, "10.0", "10.1 reproduced, 10.2 refuted"),
        (part.about, "-85", "-84 reproduced, -82.9 refuted, 85 refuted"),
        (part.at_most, "0.8", "0.3 reproduced, 0.84 rounded, 0.86 refuted"),
        (part.at_most_order, "1e-6", "1e-15 reproduced, -3.16e-6 reproduced, 3.17e-6 refuted"),
        (partial(part.approximate, scale=1), "f", "0.1 reproduced, -0.1 reproduced, 0.101 refuted"),
        (lambda f, x: part.agrees(f, 1, 1 + x, 40), "f", "1e-42 reproduced, 2e-40 refuted"),
    ],
)
def test_a_part_at_the_edges_of_its_rule(
    compare: Callable[[str, Fraction], Part], printed: str, edges: str
) -> None:
    for edge in edges.split(", "):
        value, outcome = edge.split()
        assert compare(printed, Fraction(value)).outcome == outcome, edge
    assert part.untestable(printed).outcome == "open"


@pytest.mark.parametrize(
    ("compare", "low", "high", "proved"),
    [
        (part.rounds_to, "1.5", "1.54", True),
        (part.rounds_to, "1.5", "1.56", False),
        (part.rounds_to, "1.6", "1.61", False),
        (part.about, "1.5", "1.54", True),
        (part.about, "1.5", "1.59", False),  # it may be about 1.5 without rounding to it
    ],
)
def test_a_value_is_proved_where_both_ends_of_its_enclosure_agree(
    compare: Callable[[str, Value], Part], low: str, high: str, proved: bool
) -> None:
    value = Value(Fraction("1.51"), 3).within((Fraction(low), Fraction(high)))
    assert compare("1.5", value).holds
    assert compare("1.5", value).proved is proved
    assert not compare("1.5", value.within(None)).proved


def test_an_exact_number_encloses_itself_and_a_float_does_not() -> None:
    assert part.rounds_to("1.5", Fraction(3, 2)).proved
    assert not part.rounds_to("1.5", 1.5).proved


@pytest.mark.parametrize("bad", ["", "1,5", "0x10", "nan", "1.5 s"])
def test_a_printed_number_is_a_number(bad: str) -> None:
    with pytest.raises(ValueError, match="printed number"):
        part.rounds_to(bad, 1)


@pytest.mark.parametrize(
    "case",
    ["0 5 0", "1.5 3 1.50", "0.005106366 4 0.005106", "-82.86640856 4 -82.87", "9.996 3 10.0",
     "99999 2 1.0e5", "1.5e-33 2 1.5e-33", "0.00009 1 9e-5", "155 3 155", "155 1 2e2"],
)  # fmt: skip
def test_decimal(case: str) -> None:
    value, digits, text = case.split()
    assert part.decimal(Fraction(value), int(digits)) == text


@pytest.mark.parametrize(
    ("other", "digits"), [("1.0001", 3), ("1.00004", 4), ("1.0000001", 6), ("2", 0), ("-1", 0)]
)
def test_a_value_counts_agreeing_digits(other: str, digits: int) -> None:
    assert Value.of(Fraction(1), Fraction(other)).digits == digits
    assert Value.of(1, 1).digits == part.MOST_DIGITS
    assert Value.of(Fraction(1), 1 + Fraction(1, 10**60), most=40).digits == 40


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (Value(Fraction("1.4649"), 3), "1.46 s"),
        (2 / 3, "0.666666666667 s"),
        (Fraction(2, 3), "0.66666666666666666667 s"),
        (350, "350 s"),
    ],
)
def test_numbers_show_the_digits_they_have(number: Any, text: str) -> None:
    assert part.rounds_to("1.5", number, "s").measured == text
