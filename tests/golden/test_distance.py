"""One rule for correct digits."""

from __future__ import annotations

from decimal import Decimal

import mpmath
import pytest

import tt_precise as tt
from tt_precise.golden.digits import digits_left
from tt_precise.golden.distance import as_decimal, correct_digits, relative_error


@pytest.mark.parametrize("text", ["1", "10", "9.999999999999999999999999", "3e-400", "7.25e+500"])
def test_digits_of_errors_of_any_size(text: str) -> None:
    with mpmath.workdps(60):
        exact = -mpmath.log10(mpmath.mpf(text))
        # two roundings, of the mantissa and of the sum
        assert abs(digits_left(Decimal(text)) - exact) <= 2**-52 * max(1, abs(exact))


def test_digits_lie_between_none_and_those_of_golden_data() -> None:
    assert correct_digits(Decimal(0)) == 34
    assert correct_digits(Decimal("1e-60")) == 34
    assert correct_digits(Decimal("1e-12")) == pytest.approx(12)
    assert correct_digits(Decimal(7)) == 0
    assert correct_digits(relative_error(None, Decimal(1), Decimal(1))) == 0


@pytest.mark.parametrize("value", ["", "nan", "-inf", None, float("nan")])
def test_what_is_no_number_is_missing(value: object) -> None:
    assert as_decimal(value) is None


@pytest.mark.parametrize("value", ["1_0", "one", 1j, [1, 2]])
def test_what_cannot_be_a_number_is_refused(value: object) -> None:
    with pytest.raises(tt.InputError, match="expected a number"):
        as_decimal(value)
