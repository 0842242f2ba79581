"""The entry of a column with the fewest correct digits: found in double, measured in decimals.

Differences are exact. What they are divided by, and which one is the largest, is taken in double
for all of them at once; those that may be the largest are then measured in decimals.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from functools import lru_cache
from typing import NamedTuple

from tt_precise.golden.digits import EXACT
from tt_precise.golden.distance import as_decimal, relative_error
from tt_precise.runtime.arithmetic import Array

# Digits of a fresh computation count relative to the size of the component at that time, its
# largest golden entry within so many rows: a zero passed on the way does not decide, and a
# component that decays is still measured by its own size. One that has decayed further than to
# 1e-10 of its largest is measured as if it had not.
NEIGHBOURS = 20
DECAYED = Decimal("1e-10")

READABLE = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?", re.ASCII)
NEARLY = 1 - 1e-6  # of the largest error; in double they are right to some 1e-15 of themselves
LEAST_SCALE = 1e-200  # below, errors and sizes in double would lose digits


class Largest(NamedTuple):
    """The row of a column with the largest error, and that, in terms of the entry's size."""

    row: int
    error: Decimal


def largest_error(
    cells: Sequence[str], fresh: Sequence[str], scale: Decimal | None
) -> Largest | None:
    """Where ``fresh`` entries are farthest from the golden ``cells``; the first such row.

    ``scale`` is that of the column; without one, as of times, each entry counts by itself. None
    where no cell is filled.
    """
    rows = min(len(cells), len(fresh))
    filled = [row for row in range(rows) if cells[row]]
    errors = {
        row: relative_error(as_decimal(fresh[row]), Decimal(cells[row]), size(cells, row, scale))
        for row in _suspects(tuple(cells), fresh, scale, filled)
    }
    if not errors:
        return None
    row = max(errors, key=errors.__getitem__)
    return Largest(row, errors[row])


def size(cells: Sequence[str], row: int, scale: Decimal | None) -> Decimal:
    """What the error of an entry is divided by: its component's size at the time, or its own."""
    if scale is None:
        return abs(Decimal(cells[row]))
    around = cells[max(0, row - NEIGHBOURS) : row + NEIGHBOURS + 1]
    largest = max(abs(Decimal(cell or 0)) for cell in around)
    if not largest and not any(Decimal(cell or 0) for cell in cells):
        return scale
    return max(largest, scale * DECAYED)


def _suspects(
    cells: tuple[str, ...], fresh: Sequence[str], scale: Decimal | None, filled: list[int]
) -> list[int]:
    """Of the ``filled`` rows those where the largest error may be; all where doubles do not do."""
    import numpy

    known = _numbers(cells)
    too_small = scale is not None and scale < LEAST_SCALE
    if known is None or too_small or not filled or not all(fresh[row] for row in filled):
        return filled
    golden, near = known
    differences = (EXACT.subtract(Decimal(fresh[row]), golden[row]) for row in filled)
    apart = numpy.abs(list(map(float, differences)))
    sizes = near if scale is None else _sizes(near, float(scale))
    with numpy.errstate(all="ignore"):
        errors = numpy.where(apart == 0, 0.0, apart / sizes[filled])
    if not numpy.isfinite(errors).all():
        return filled
    largest = errors.max()
    if not largest:
        return filled[:1]
    found: list[int] = numpy.array(filled)[errors >= NEARLY * largest].tolist()
    return found


def _sizes(near: Array, scale: float) -> Array:
    import numpy

    if not near.any():
        return numpy.full(len(near), scale)
    padded = numpy.pad(near, NEIGHBOURS)
    windows = numpy.lib.stride_tricks.sliding_window_view(padded, 2 * NEIGHBOURS + 1)
    return numpy.maximum(windows.max(axis=1), scale * float(DECAYED))


@lru_cache(maxsize=128)
def _numbers(cells: tuple[str, ...]) -> tuple[list[Decimal], Array] | None:
    """Numbers of a column, and their magnitudes in double; an empty cell is zero in both.

    None where one is not written as golden data are, or is too large or too small for a double.
    """
    import numpy

    plain = [cell or "0" for cell in cells]
    if not all(map(READABLE.fullmatch, plain)):
        return None
    exact, near = list(map(Decimal, plain)), numpy.abs(list(map(float, plain)))
    lost = any(one for one, magnitude in zip(exact, near.tolist(), strict=True) if not magnitude)
    return None if lost or not numpy.isfinite(near).all() else (exact, near)
