"""Numbers as a report prints them."""

from __future__ import annotations

from typing import Any

import mpmath


def short(value: Any, digits: int = 2) -> str:
    """A number with few significant digits: 1.8e-15, 0.053, 12."""
    if value is None:
        return "-"
    return str(mpmath.nstr(_number(value), digits, min_fixed=-3, max_fixed=6)).removesuffix(".0")


def full(value: Any, digits: int) -> str:
    """A number with all the digits it is trusted to."""
    return str(mpmath.nstr(_number(value), digits, min_fixed=-4, max_fixed=12))


def _number(value: Any) -> Any:
    return value if hasattr(value, "_mpf_") else mpmath.mpf(value)
