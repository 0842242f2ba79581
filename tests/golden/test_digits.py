"""What is printed of an entry is what all computed values round to."""

import math
import random
from decimal import Decimal, localcontext

import mpmath
import pytest

import tt_precise as tt
from tt_precise.golden.digits import (
    EXACTLY,
    ColumnDigits,
    agreement,
    as_decimal,
    column_digits,
    common_text,
    correct_digits,
    digits_left,
    is_near_zero,
    scale_of,
)

ONE = Decimal(1)
TWO_THIRDS = Decimal("0." + "6" * 60)
TIE, STEP = Decimal("1." + "0" * 33 + "5"), Decimal("1e-40")


@pytest.mark.parametrize(
    ("values", "text"),
    [
        # all 34 digits, correctly rounded; fewer where values differ
        ([TWO_THIRDS, EXACTLY.add(TWO_THIRDS, Decimal("1e-45"))], "6." + "6" * 32 + "7e-1"),
        ([TWO_THIRDS, EXACTLY.add(TWO_THIRDS, Decimal("4e-20"))], "6." + "6" * 17 + "7e-1"),
        # a rounding that is undecided: 33 digits are common
        (
            [EXACTLY.subtract(TIE, STEP), EXACTLY.add(TIE, STEP)],
            "1." + "0" * 32 + "e+0",
        ),
        # not even the sign is common
        ([Decimal("1e-3"), Decimal("-1e-3")], ""),
        # 0 below 1e-34 of the scale, and not above
        ([Decimal("9e-35"), Decimal("-3e-40")], "0"),
        ([Decimal("1.1e-34"), Decimal("-3e-40")], ""),
    ],
)
def test_what_is_printed_is_common_to_all_values(values: list[Decimal], text: str) -> None:
    assert common_text(values, ONE) == text


def test_agreement_is_relative_to_the_entry() -> None:
    assert agreement(Decimal("1e-10"), Decimal("1.001e-10")) == pytest.approx(3)
    assert agreement(ONE, ONE) == math.inf
    assert agreement(Decimal(0), ONE) == -math.inf


def test_near_a_zero_digits_count_relative_to_the_scale() -> None:
    assert is_near_zero("0", ONE)
    assert is_near_zero("1.23456789012e-23", ONE)  # last digit at 1e-34
    assert not is_near_zero("1.23456789012e-21", ONE)  # last digit at 1e-32
    assert not is_near_zero("1." + "0" * 33 + "e-9", ONE)  # has all its digits


def test_column_claims_its_weakest_entry() -> None:
    full = "1." + "0" * 33 + "e+0"
    entries = [full, "1.5e+0", "0", ""]
    assert column_digits(entries, scale_of(entries)) == ColumnDigits(2, "1.50e+0", 1, 1)


def test_a_scale_is_that_of_decimals_alone() -> None:
    seed = random.Random(3)
    for power in (-400, -320, -308, -30, 0, 30, 308, 400):
        for spread in (1e-33, 1e-17, 1e-15, 1e-3, 1.0):
            entries = [
                f"{seed.choice('-+')}{1 + spread * seed.random()!r}e{power + seed.randrange(2)}"
                for _ in range(9)
            ]
            expected = max(abs(Decimal(one)) for one in entries)
            with localcontext(prec=3):
                assert scale_of(["", *entries]) == +expected
    assert scale_of(["", ""]) == scale_of(["0", "-0.0"]) == 0


@pytest.mark.parametrize("text", ["1", "10", "9.999999999999999999999999", "3e-400", "7.25e+500"])
def test_digits_of_errors_of_any_size(text: str) -> None:
    with mpmath.workdps(60):
        exact = -mpmath.log10(mpmath.mpf(text))
        # two roundings, of the mantissa and of the sum
        assert abs(digits_left(Decimal(text)) - exact) <= 2**-52 * max(1, abs(exact))


def test_digits_lie_between_none_and_those_of_golden_data() -> None:
    assert correct_digits(0.0) == correct_digits(1e-60) == 34
    assert correct_digits(1e-12) == pytest.approx(12)
    assert correct_digits(7.0) == correct_digits(math.inf) == 0


def test_what_is_no_number_is_missing_and_what_cannot_be_one_is_refused() -> None:
    for value in ("", "nan", "-inf", None, float("nan")):
        assert as_decimal(value) is None
    for refused in ("1_0", "one", 1j, [1, 2]):
        with pytest.raises(tt.InputError, match="expected a number"):
            as_decimal(refused)
