"""Numbers as a report prints them."""

from __future__ import annotations

import mpmath

from tt_precise.runtime.values import Scalar


def short(value: Scalar, digits: int = 2) -> str:
    """A number with few significant digits: 1.8e-15, 0.053, 12."""
    if value is None:
        return "-"
    return str(mpmath.nstr(_number(value), digits, min_fixed=-3, max_fixed=6)).removesuffix(".0")


def full(value: Scalar, digits: int) -> str:
    """A number with all the digits it is trusted to."""
    return str(mpmath.nstr(_number(value), digits, min_fixed=-4, max_fixed=12))


def _number(value: Scalar) -> Scalar:
    return value if hasattr(value, "_mpf_") else mpmath.mpf(value)
