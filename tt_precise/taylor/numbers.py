"""Numbers of several doubles, in and out of mpmath."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tt_precise.arithmetic import Array, Functions, Scalar


def split(value: Scalar, parts: int) -> tuple[float, ...]:
    """An mpmath number as so many doubles, each the nearest to what those before leave."""
    found = []
    for _ in range(parts):
        part = float(value)
        found.append(part)
        value = value - part if math.isfinite(part) else 0
    return tuple(found)


def number(parts: Sequence[float], fn: Functions) -> Scalar:
    """The mpmath number of its parts."""
    return sum((fn.mpf(float(part)) for part in parts[1:]), fn.mpf(float(parts[0])))


def numbers_of(row: Array, fn: Functions) -> tuple[Scalar, ...]:
    """Those of a row (part, column)."""
    return tuple(number(parts, fn) for parts in row.T.tolist())
