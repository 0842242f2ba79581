"""Digits of measured numbers, and the rules that make verdicts, at the edge of each."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.claims import verdicts as v

TRUE, FALSE = v.statement(True, "so", "so"), v.statement(False, "so", "not so")
OPEN = v.untestable("so")
ROUNDED = v.rounds_to("1.5", Fraction("1.46"))
ONES = Fraction("1." + "1" * 50)


@pytest.mark.parametrize(
    ("check", "edges"),
    [
        (
            lambda x: v.rounds_to("0.005106", x),
            "0.00510649 rounded, 0.0051065 rounded, 0.00510651 refuted",
        ),
        (lambda x: v.rounds_to("-6.667e-4", x), "-6.6674e-4 rounded, 6.667e-4 refuted"),
        (lambda x: v.rounds_to("155", x), "155.4 rounded, 155.6 refuted"),
        (lambda x: v.rounds_to("1.50", x), "1.504 rounded, 1.506 refuted"),
        (lambda x: v.rounds_to("3.", x), "3.4 rounded"),
        (lambda x: v.about("7.87", x), "7.874 rounded, 7.88 reproduced, 7.8801 refuted"),
        (lambda x: v.about("80", x), "80.3 rounded, 89 reproduced, 91 refuted"),
        (lambda x: v.about("0.34", x), "0.349 reproduced"),
        (lambda x: v.about("10.0", x), "10.1 reproduced, 10.2 refuted"),
        (lambda x: v.about("-85", x), "-84 reproduced, -82.9 refuted, 85 refuted"),
        (lambda x: v.at_most("0.8", x), "0.3 reproduced, 0.84 rounded, 0.86 refuted"),
        (
            lambda x: v.at_most_order("1e-6", x),
            "1e-15 reproduced, -3.16e-6 reproduced, 3.17e-6 refuted",
        ),
        (lambda x: v.approximate("about", x, 1), "0.1 reproduced, -0.1 reproduced, 0.101 refuted"),
        (lambda x: v.agrees("f", ONES, ONES + x, 40), "1e-42 reproduced, 2e-40 refuted"),
        (lambda x: v.untestable("so"), "0 untestable"),
    ],
)
def test_a_part_at_the_edges_of_its_rule(check: Callable[[Fraction], v.Part], edges: str) -> None:
    for edge in edges.split(", "):
        value, verdict = edge.split()
        found = check(Fraction(value))
        assert found.verdict == v.conclude("all of", (found, "A note.")).verdict == verdict, edge


@pytest.mark.parametrize(
    ("rule", "parts", "verdict", "note"),
    [
        ("all of", (TRUE, TRUE), "reproduced", ""),
        ("all of", (ROUNDED, ROUNDED), "rounded", ""),
        ("all of", (ROUNDED, TRUE), "reproduced", ""),
        ("all of", (TRUE, FALSE), "partly", " Holds: a. Fails: b."),
        ("all of", (TRUE, OPEN), "partly", " Holds: a. Open: b."),
        ("all of", (FALSE, OPEN), "refuted", ""),
        ("all of", (OPEN, FALSE), "refuted", ""),
        ("all of", (OPEN, OPEN), "untestable", ""),
        ("all of", (FALSE, FALSE), "refuted", ""),
        ("interpretations", (TRUE, TRUE), "reproduced", ""),
        ("interpretations", (FALSE, FALSE), "refuted", ""),
        ("interpretations", (TRUE, FALSE), "ambiguous", " Holds if read as: a. Fails as: b."),
        ("interpretations", (OPEN, TRUE), "ambiguous", " Holds if read as: b. Open as: a."),
        ("all of", (FALSE, OPEN, TRUE), "partly", " Holds: c. Fails: a. Open: b."),
    ],
)
def test_a_rule_makes_the_verdict_of_the_parts(
    rule: v.Rule, parts: tuple[v.Part, ...], verdict: str, note: str
) -> None:
    judged = v.conclude(rule, (dict(zip("abc", parts, strict=False)), "A note."))
    assert (judged.verdict, judged.note, judged.remark) == (verdict, "A note." + note, "A note.")
    assert [part.verdict for part in judged.parts] == [part.verdict for part in parts]
    if parts == (TRUE, FALSE):
        assert judged.measured == "a: so; b: not so"
        assert judged.essential.name == "b"
    # what fails decides, then what is open
    assert judged.essential.holds is min(
        (part.holds for part in parts), key=[False, None, True].index
    )


def test_the_printed_side_is_that_of_every_part_or_of_all_meanings_together() -> None:
    parts = {"a": v.rounds_to("1.5", 1.5, "s"), "b": v.rounds_to("2.5", 2.5, "s")}
    assert v.conclude("all of", (parts, "A note.")).printed == "a: 1.5 s; b: 2.5 s"
    assert v.conclude("interpretations", (parts, "A note.")).printed == "1.5 s"
    assert v.conclude("misprint", (parts.values(), "A note.")).printed == "1.5 s"


@pytest.mark.parametrize(
    ("printed", "corrected", "verdict"),
    [
        (FALSE, TRUE, "misprint"),
        (TRUE, TRUE, "reproduced"),
        (TRUE, FALSE, "reproduced"),
        (ROUNDED, TRUE, "rounded"),
        (FALSE, FALSE, "refuted"),
    ],
)
def test_misprint_needs_the_printed_form_to_fail_and_the_corrected_to_hold(
    printed: v.Part, corrected: v.Part, verdict: str
) -> None:
    judged = v.conclude("misprint", ((printed, corrected), "A note."))
    assert judged.verdict == verdict
    assert judged.correction == (corrected.printed if verdict == "misprint" else "")
    assert bool(judged.lines) == (verdict == "misprint")
    assert judged.essential.name == ("as corrected" if verdict == "misprint" else "as printed")
    with pytest.raises(ValueError, match="zip"):  # two parts, and no other
        v.conclude("misprint", ((printed, corrected, corrected), "A note."))


@pytest.mark.parametrize(
    ("low", "high", "proved"),
    [("1.5", "1.54", True), ("1.5", "1.56", False), ("1.6", "1.61", False)],
)
def test_a_value_is_proved_where_both_ends_of_its_enclosure_agree(
    low: str, high: str, proved: bool
) -> None:
    value = v.Value(Fraction("1.51"), 3)
    assert v.rounds_to("1.5", value.within((Fraction(low), Fraction(high)))).proved is proved
    assert not v.rounds_to("1.5", value).proved
    assert not v.rounds_to("1.5", value.within((value.value, value.value)).within(None)).proved
    # the outcome is one of three: a number that is about 1.5 need not round to it
    near = v.Value(Fraction("1.58"), 3, (Fraction("1.54"), Fraction("1.59")))
    assert v.about("1.5", near).holds
    assert not v.about("1.5", near).proved
    # an exact number encloses itself, a float does not
    assert v.rounds_to("1.5", Fraction(3, 2)).proved
    assert not v.rounds_to("1.5", 1.5).proved


@pytest.mark.parametrize(
    ("outcomes", "holds"),
    [((3, 0, 0), True), ((3, 1, 0), False), ((3, 1, 1), False), ((3, 0, 1), None),
     ((0, 0, 1), False), ((0, 0, 0), False)],
)  # fmt: skip
def test_a_statement_about_all_is_open_while_an_outcome_is_undecided(
    outcomes: tuple[int, int, int], holds: bool | None
) -> None:
    holding, failing, undecided = outcomes
    part = v.of_all("all", "x", holding=holding, failing=failing, undecided=undecided)
    assert part.holds is holds


def test_a_claim_is_proved_if_every_part_is() -> None:
    proved = v.rounds_to("1.5", Fraction(3, 2))
    assert v.conclude("all of", ({"a": proved, "b": proved}, "A note.")).proved
    assert not v.conclude("all of", ({"a": proved, "b": TRUE}, "A note.")).proved


@pytest.mark.parametrize("bad", ["", "1,5", "0x10", "nan", "1.5 s"])
def test_a_printed_number_is_a_number(bad: str) -> None:
    with pytest.raises(ValueError, match="printed number"):
        v.rounds_to(bad, 1)
    with pytest.raises(ValueError, match="expected one or more"):  # a claim needs a part
        v.conclude("all of", ({}, "A note."))


@pytest.mark.parametrize(
    "case",
    [
        "0 5 0",
        "1.5 3 1.50",
        "0.005106366 4 0.005106",
        "-82.86640856 4 -82.87",
        "9.996 3 10.0",
        "99999 2 1.0e5",
        "1.5e-33 2 1.5e-33",
        "0.00009 1 9e-5",
        "155 3 155",
        "155 1 2e2",
    ],
)
def test_decimal(case: str) -> None:
    value, digits, text = case.split()
    assert v.decimal(Fraction(value), int(digits)) == text


@pytest.mark.parametrize(
    ("other", "digits"), [("1.0001", 3), ("1.00004", 4), ("1.0000001", 6), ("2", 0), ("-1", 0)]
)
def test_a_value_counts_agreeing_digits(other: str, digits: int) -> None:
    assert v.Value.of(Fraction(1), Fraction(other)).digits == digits
    assert v.Value.of(1, 1).digits == v.MOST_DIGITS
    assert v.Value.of(Fraction(1), 1 + Fraction(1, 10**60), most=40).digits == 40


@pytest.mark.parametrize("number", [3, 0.1, Fraction(1, 3), mpmath.mpf("-0.3"), mpmath.mpf(0)])
def test_fraction_of_is_exact(number: Any) -> None:
    assert v.fraction_of(number) == v.fraction_of(v.Value(number, 5))
    assert float(v.fraction_of(number)) == float(v.Value(number, 5)) == float(number)


@pytest.mark.parametrize("bad", [mpmath.nan, mpmath.inf, float("nan")])
def test_nan_is_not_a_measurement(bad: object) -> None:
    with pytest.raises(ValueError, match=r"finite|NaN"):
        v.fraction_of(bad)


def test_numbers_show_the_digits_they_have() -> None:
    assert v.rounds_to("1.5", v.Value(Fraction("1.4649"), 3), "s").measured == "1.46 s"
    assert v.measured_text(2 / 3) == "0.666666666667"
    assert v.measured_text(Fraction(2, 3)) == "0.66666666666666666667"
    assert v.measured_text(350) == "350"


@pytest.mark.parametrize(
    ("value", "power"), [("1", 0), ("9.99", 0), ("10", 1), ("1e-40", -40), ("9.9e-41", -41)]
)
def test_power_of_ten_of_a_value(value: str, power: int) -> None:
    assert v.decade(Fraction(value)) == power
