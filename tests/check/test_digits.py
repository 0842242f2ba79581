"""Correct digits of columns."""

from decimal import Decimal

import mpmath
import pytest

from tt_precise.check.digits import log10


@pytest.mark.parametrize("text", ["1", "10", "9.999999999999999999999999", "3e-400", "7.25e+500"])
def test_logarithms_of_any_size(text: str) -> None:
    with mpmath.workdps(60):
        exact = mpmath.log10(mpmath.mpf(text))
        # two roundings, of the mantissa and of the sum
        assert abs(log10(Decimal(text)) - exact) <= 2**-52 * max(1, abs(exact))
