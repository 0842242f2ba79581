"""Digits of measured numbers, and the rules that make verdicts, at the edge of each."""

from fractions import Fraction

import mpmath
import pytest

from tt_precise.claims.verdicts import (
    MOST_DIGITS,
    Check,
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
    within,
)

NOTE = "A note."
TRUE = statement(True, "so", "so")
FALSE = statement(False, "so", "not so")
ROUNDED = rounds_to("1.5", Fraction("1.46"))


@pytest.mark.parametrize(
    ("printed", "measured", "holds"),
    [
        ("0.005106", "0.00510649", True),
        ("0.005106", "0.0051065", True),
        ("0.005106", "0.00510651", False),
        ("-6.667e-4", "-6.6674e-4", True),
        ("-6.667e-4", "6.667e-4", False),
        ("155", "155.4", True),
        ("155", "155.6", False),
        ("1.50", "1.504", True),
        ("1.50", "1.506", False),
        ("3.", "3.4", True),
    ],
)
def test_rounds_to(printed: str, measured: str, holds: bool) -> None:
    assert rounds_to(printed, Fraction(measured)).holds is holds


def test_what_rounds_is_rounded_not_reproduced() -> None:
    assert all_of(rounds_to("1.5", Fraction("1.46")), NOTE).verdict == "rounded"
    assert all_of(rounds_to("1.5", Fraction("1.44")), NOTE).verdict == "refuted"


@pytest.mark.parametrize(
    ("printed", "measured", "verdict"),
    [
        ("7.87", "7.874", "rounded"),
        ("7.87", "7.88", "reproduced"),
        ("7.87", "7.8801", "refuted"),
        ("80", "80.3", "rounded"),
        ("80", "89", "reproduced"),
        ("80", "91", "refuted"),
        ("0.34", "0.349", "reproduced"),
    ],
)
def test_about_is_one_unit_of_the_last_significant_digit(
    printed: str, measured: str, verdict: str
) -> None:
    assert all_of(about(printed, Fraction(measured)), NOTE).verdict == verdict


@pytest.mark.parametrize(("measured", "holds"), [("1.2", True), ("1.21", False), ("0.8", True)])
def test_within_a_stated_tolerance(measured: str, holds: bool) -> None:
    assert within("1", Fraction(measured), "0.2").holds is holds


@pytest.mark.parametrize(
    ("measured", "holds"), [(1e-15, True), (3.16e-6, True), (-3.16e-6, True), (3.17e-6, False)]
)
def test_at_most_half_a_decade_above_the_order(measured: float, holds: bool) -> None:
    assert at_most_order("1e-6", measured).holds is holds


@pytest.mark.parametrize(("measured", "holds"), [(-0.3, True), (0.3, True), (0.301, False)])
def test_in_range(measured: float, holds: bool) -> None:
    assert in_range("-0.3", "0.3", Fraction(str(measured))).holds is holds


@pytest.mark.parametrize(("error", "holds"), [("0.1", True), ("-0.1", True), ("0.101", False)])
def test_approximate_is_a_tenth(error: str, holds: bool) -> None:
    assert approximate("about", Fraction(error), 1).holds is holds


def test_agrees_counts_digits() -> None:
    value = Fraction("1." + "1" * 50)
    assert agrees("f", value, value + Fraction(1, 10**42), 40).holds
    assert not agrees("f", value, value + Fraction(1, 10**39), 40).holds


def test_all_of_names_what_fails() -> None:
    assert all_of({"a": TRUE, "b": TRUE}, NOTE).verdict == "reproduced"
    assert all_of({"a": ROUNDED, "b": ROUNDED}, NOTE).verdict == "rounded"
    assert all_of({"a": ROUNDED, "b": TRUE}, NOTE).verdict == "reproduced"
    found = all_of({"a": TRUE, "b": FALSE}, NOTE)
    assert found.verdict == "refuted"
    assert found.note == "A note. What fails: b."
    assert found.measured == "a: so; b: not so"


def test_readings() -> None:
    assert readings({"a": TRUE, "b": TRUE}, NOTE).verdict == "reproduced"
    assert readings({"a": FALSE, "b": FALSE}, NOTE).verdict == "refuted"
    found = readings({"a": TRUE, "b": FALSE}, NOTE)
    assert found.verdict == "reading"
    assert found.note == "A note. Holds read as: a. Not as: b."
    assert [(check.name, check.verdict) for check in found.checks] == [
        ("a", "reproduced"),
        ("b", "refuted"),
    ]


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
    printed: Check, corrected: Check, verdict: str
) -> None:
    assert misprint((printed, corrected), "x", NOTE).verdict == verdict


def test_wording_is_untestable() -> None:
    assert all_of(untestable("so"), NOTE).verdict == "untestable"


@pytest.mark.parametrize("bad", ["", "1,5", "0x10", "nan", "1.5 s"])
def test_a_printed_number_is_a_number(bad: str) -> None:
    with pytest.raises(ValueError, match="printed number"):
        rounds_to(bad, 1)


def test_settled_values_show_the_digits_they_have() -> None:
    assert rounds_to("1.5", Settled(Fraction("1.4649"), 3), "s").measured == "1.46 s"


def test_a_claim_of_no_parts_is_none() -> None:
    with pytest.raises(ValueError, match="expected one or more"):
        all_of({}, NOTE)


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


def test_settled_never_claims_more_than_the_most() -> None:
    assert Settled.of(1, 1).digits == MOST_DIGITS
    assert Settled.of(Fraction(1), 1 + Fraction(1, 10**60), most=40).digits == 40


@pytest.mark.parametrize("number", [3, 0.1, Fraction(1, 3), mpmath.mpf("-0.3"), mpmath.mpf(0)])
def test_fraction_of_is_exact(number: object) -> None:
    assert fraction_of(number) == fraction_of(Settled(number, 5))
    assert float(fraction_of(number)) == float(number)  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [mpmath.nan, mpmath.inf, float("nan")])
def test_no_number_is_no_measurement(bad: object) -> None:
    with pytest.raises(ValueError, match=r"finite|NaN"):
        fraction_of(bad)


def test_bare_numbers_show_twelve_digits_and_exact_ones_all() -> None:
    assert measured_text(2 / 3) == "0.666666666667"
    assert measured_text(Fraction(2, 3)) == "0.66666666666666666667"
    assert measured_text(350) == "350"


@pytest.mark.parametrize(
    ("value", "power"), [("1", 0), ("9.99", 0), ("10", 1), ("1e-40", -40), ("9.9e-41", -41)]
)
def test_decade(value: str, power: int) -> None:
    assert decade(Fraction(value)) == power
