"""Digits of measured numbers, and the rules that make verdicts, at the edge of each."""

from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.claims.verdicts import (
    MOST_DIGITS,
    Settled,
    about,
    agrees,
    all_of,
    approximate,
    at_most_order,
    decade,
    decimal,
    fraction_of,
    in_range,
    measured_text,
    misprint,
    readings,
    rounds_to,
    statement,
    untestable,
    verdict_of,
    within,
)
from tt_precise.runtime.values import Check

TRUE, FALSE = statement(True, "so", "so"), statement(False, "so", "not so")
ROUNDED = rounds_to("1.5", Fraction("1.46"))
ONES = Fraction("1." + "1" * 50)


@pytest.mark.parametrize(
    ("check", "verdict"),
    [
        (rounds_to("0.005106", Fraction("0.00510649")), "rounded"),
        (rounds_to("0.005106", Fraction("0.0051065")), "rounded"),
        (rounds_to("0.005106", Fraction("0.00510651")), "refuted"),
        (rounds_to("-6.667e-4", Fraction("-6.6674e-4")), "rounded"),
        (rounds_to("-6.667e-4", Fraction("6.667e-4")), "refuted"),
        (rounds_to("155", Fraction("155.4")), "rounded"),
        (rounds_to("155", Fraction("155.6")), "refuted"),
        (rounds_to("1.50", Fraction("1.504")), "rounded"),
        (rounds_to("1.50", Fraction("1.506")), "refuted"),
        (rounds_to("3.", Fraction("3.4")), "rounded"),
        (about("7.87", Fraction("7.874")), "rounded"),
        (about("7.87", Fraction("7.88")), "reproduced"),
        (about("7.87", Fraction("7.8801")), "refuted"),
        (about("80", Fraction("80.3")), "rounded"),
        (about("80", Fraction("89")), "reproduced"),
        (about("80", Fraction("91")), "refuted"),
        (about("0.34", Fraction("0.349")), "reproduced"),
        (within("1", Fraction("1.2"), "0.2"), "reproduced"),
        (within("1", Fraction("0.8"), "0.2"), "reproduced"),
        (within("1", Fraction("1.21"), "0.2"), "refuted"),
        (at_most_order("1e-6", 1e-15), "reproduced"),
        (at_most_order("1e-6", -3.16e-6), "reproduced"),
        (at_most_order("1e-6", 3.17e-6), "refuted"),
        (in_range("-0.3", "0.3", Fraction("-0.3")), "reproduced"),
        (in_range("-0.3", "0.3", Fraction("0.3")), "reproduced"),
        (in_range("-0.3", "0.3", Fraction("0.301")), "refuted"),
        (approximate("about", Fraction("0.1"), 1), "reproduced"),
        (approximate("about", Fraction("-0.1"), 1), "reproduced"),
        (approximate("about", Fraction("0.101"), 1), "refuted"),
        (agrees("f", ONES, ONES + Fraction(1, 10**42), 40), "reproduced"),
        (agrees("f", ONES, ONES + Fraction(1, 10**39), 40), "refuted"),
        (untestable("so"), "untestable"),
    ],
)
def test_a_check(check: Check, verdict: str) -> None:
    assert verdict_of(check) == verdict
    assert all_of(check, "A note.").verdict == verdict


@pytest.mark.parametrize(
    ("rule", "checks", "verdict", "note"),
    [
        (all_of, (TRUE, TRUE), "reproduced", ""),
        (all_of, (ROUNDED, ROUNDED), "rounded", ""),
        (all_of, (ROUNDED, TRUE), "reproduced", ""),
        (all_of, (TRUE, FALSE), "refuted", " Failing: b."),
        (readings, (TRUE, TRUE), "reproduced", ""),
        (readings, (FALSE, FALSE), "refuted", ""),
        (readings, (TRUE, FALSE), "reading", " Holds if read as: a. Fails as: b."),
    ],
)
def test_a_rule(rule: Any, checks: tuple[Check, Check], verdict: str, note: str) -> None:
    finding = rule(dict(zip("ab", checks, strict=True)), "A note.")
    assert (finding.verdict, finding.note) == (verdict, "A note." + note)
    assert [check.verdict for check in finding.checks] == [check.verdict for check in checks]
    if checks == (TRUE, FALSE):
        assert finding.measured == "a: so; b: not so"


@pytest.mark.parametrize(
    ("checks", "verdict"),
    [
        ((FALSE, TRUE), "misprint"),
        ((TRUE, TRUE), "reproduced"),
        ((TRUE, FALSE), "reproduced"),
        ((ROUNDED, TRUE), "rounded"),
        ((FALSE, FALSE), "refuted"),
    ],
)
def test_misprint_needs_the_printed_form_to_fail_and_the_corrected_to_hold(
    checks: tuple[Check, Check], verdict: str
) -> None:
    assert misprint(checks, "x", "A note.").verdict == verdict


@pytest.mark.parametrize("bad", ["", "1,5", "0x10", "nan", "1.5 s"])
def test_a_printed_number_is_a_number(bad: str) -> None:
    with pytest.raises(ValueError, match="printed number"):
        rounds_to(bad, 1)


def test_a_claim_needs_a_part() -> None:
    with pytest.raises(ValueError, match="expected one or more"):
        all_of({}, "A note.")


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        ("0", 5, "0"),
        ("1.5", 3, "1.50"),
        ("0.005106366", 4, "0.005106"),
        ("-82.86640856", 4, "-82.87"),
        ("9.996", 3, "10.0"),
        ("99999", 2, "1.0e5"),
        ("1.5e-33", 2, "1.5e-33"),
        ("0.00009", 1, "9e-5"),
        ("155", 3, "155"),
        ("155", 1, "2e2"),
    ],
)
def test_decimal(value: str, digits: int, text: str) -> None:
    assert decimal(Fraction(value), digits) == text


@pytest.mark.parametrize(
    ("other", "digits"), [("1.0001", 3), ("1.00004", 4), ("1.0000001", 6), ("2", 0), ("-1", 0)]
)
def test_settled_counts_agreeing_digits(other: str, digits: int) -> None:
    assert Settled.of(Fraction(1), Fraction(other)).digits == digits
    assert Settled.of(1, 1).digits == MOST_DIGITS
    assert Settled.of(Fraction(1), 1 + Fraction(1, 10**60), most=40).digits == 40


@pytest.mark.parametrize("number", [3, 0.1, Fraction(1, 3), mpmath.mpf("-0.3"), mpmath.mpf(0)])
def test_fraction_of_is_exact(number: Any) -> None:
    assert fraction_of(number) == fraction_of(Settled(number, 5))
    assert float(fraction_of(number)) == float(Settled(number, 5)) == float(number)


@pytest.mark.parametrize("bad", [mpmath.nan, mpmath.inf, float("nan")])
def test_no_number_is_no_measurement(bad: object) -> None:
    with pytest.raises(ValueError, match=r"finite|NaN"):
        fraction_of(bad)


def test_numbers_show_the_digits_they_have() -> None:
    assert rounds_to("1.5", Settled(Fraction("1.4649"), 3), "s").measured == "1.46 s"
    assert measured_text(2 / 3) == "0.666666666667"
    assert measured_text(Fraction(2, 3)) == "0.66666666666666666667"
    assert measured_text(350) == "350"


@pytest.mark.parametrize(
    ("value", "power"), [("1", 0), ("9.99", 0), ("10", 1), ("1e-40", -40), ("9.9e-41", -41)]
)
def test_decade(value: str, power: int) -> None:
    assert decade(Fraction(value)) == power
