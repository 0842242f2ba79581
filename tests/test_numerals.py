"""Exact numbers: what is read, what is refused, and that mpmath gets them unrounded."""

from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.errors import InputError
from tt_precise.numerals import LONGEST, exact, to_mpmath


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ("0.02", Fraction(1, 50)),
        ("131/350", Fraction(131, 350)),
        ("1e-9", Fraction(1, 10**9)),
        ("-2.5E+3", Fraction(-2500)),
        ("+.5", Fraction(1, 2)),
        ("7.", Fraction(7)),
        (" 9.82 ", Fraction(491, 50)),
        ("1e-999", Fraction(1, 10**999)),
        (3, Fraction(3)),
        (Fraction(2, 3), Fraction(2, 3)),
    ],
)
def test_reads_exactly(given: Any, value: Fraction) -> None:
    assert exact(given) == value


@pytest.mark.parametrize(
    "given",
    [
        "0,1", "nan", "NaN", "inf", "-Infinity", "", " ", "1 2", "1/0", "1/2/3", "0.5/2", "1e9999",
        "1_000", "0x10", "1e", "e5", "--1", "\u0661", "\uff11", "pi", "1\n2", "9" * (LONGEST + 1),
        0.1, float("nan"), True, None, b"1", [1], 1j,
    ],
)  # fmt: skip
def test_refuses_with_one_line(given: Any) -> None:
    with pytest.raises(InputError) as refusal:
        exact(given, "alpha")
    message = str(refusal.value)
    assert message.startswith("alpha: got ")
    assert "expected" in message
    assert "\n" not in message
    assert len(message) < 200


@pytest.mark.parametrize("digits", [15, 50, 71, 200])
@pytest.mark.parametrize("text", ["9.82", "131/350", "1e-30", "-123456789.987654321e40"])
def test_rounds_once_into_mpmath(text: str, digits: int) -> None:
    context = mpmath.MPContext()
    context.dps = digits
    rounded = to_mpmath(exact(text), context)
    sign, mantissa, exponent, bits = rounded._mpf_
    value = (-1) ** sign * mantissa * Fraction(2) ** exponent
    assert bits <= context.prec
    half_ulp = abs(exact(text)) * Fraction(1, 2**context.prec)
    assert abs(value - exact(text)) <= half_ulp


def test_a_float_on_the_way_would_show() -> None:
    context = mpmath.MPContext()
    context.dps = 50
    good, spoiled = to_mpmath(exact("9.82"), context), context.mpf(9.82)
    assert 1e-17 < abs(good - spoiled) < 1e-15


def test_leaves_the_precision_of_the_context_alone() -> None:
    context = mpmath.MPContext()
    context.prec = 77
    to_mpmath(Fraction(1, 3), context)
    assert context.prec == 77
