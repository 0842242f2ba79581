"""The precision of a file's numbers, from their values alone: decimals, digits, 32-bit floats.

A printed number has an error of at most half a unit of its last place. Components of a vector are
printed alike and examined together, because a component that stays 0 does not show its precision.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

import numpy

from tt_precise.runtime.values import Array

EPS = float(numpy.finfo(float).eps)
ROUNDED = 8 * EPS  # Relative error of a decimal number that was read into a double.
MOST_DECIMALS, MOST_DIGITS = 11, 10  # More of them are as good as a double here.
# Values that differ from 0, and values that differ from each other, from which a precision is
# recognised. By chance a double has 10 decimals with a probability of 4e-5; but starts are round.
FEWEST, DIFFERENT = 8, 4
LOOKED_AT = 4096  # Rows from which the precision is taken.

VECTORS = (
    ("t",),
    ("kx", "ky", "kz"), ("Lx", "Ly", "Lz"), ("vx", "vy"),
    ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz"), ("vcx", "vcy", "vcz"), ("x", "y", "z"),
    ("theta",), ("theta_dot", "phi_dot", "omega_3"), ("nu_x", "nu_y"), ("phi", "psi"),
    ("height",), ("rise",),
)  # fmt: skip


class ColumnRounding(NamedTuple):
    """Half a unit of the last place of the largest number, in its unit, and its description."""

    half_unit: float
    words: str


FULL = ColumnRounding(0.0, "")


def precision_of(values: Array) -> ColumnRounding:
    """Return the precision of numbers that are printed alike."""
    numbers = values[numpy.isfinite(values) & (values != 0)]
    if len(numbers) < FEWEST:
        return FULL
    found = _kinds(numbers)
    if not found or len(set(numbers.tolist())) < DIFFERENT:
        return FULL
    # The coarser of several: a short decimal may be a 32-bit float by chance.
    return max(found, key=lambda one: one.half_unit)


def _kinds(numbers: Array) -> list[ColumnRounding]:
    size = abs(numbers)
    largest = float(size.max())
    top = math.floor(math.log10(largest))
    found: list[ColumnRounding] = []
    for decimals in range(1, MOST_DECIMALS - top):
        scaled = numbers * 10.0**decimals
        if (abs(scaled - numpy.rint(scaled)) < ROUNDED * (1 + abs(scaled))).all():
            found.append(ColumnRounding(0.5 * 10.0**-decimals, f"{decimals} decimals"))
            break
    exponents = numpy.floor(numpy.log10(size))
    for digits in range(2, MOST_DIGITS + 1):
        scaled = numbers * 10.0 ** (digits - 1 - exponents)
        if (abs(scaled - numpy.rint(scaled)) < ROUNDED * 10.0**digits).all():
            half = 0.5 * 10.0 ** (top - digits + 1)
            found.append(ColumnRounding(half, f"{digits} significant digits"))
            break
    with numpy.errstate(over="ignore"):
        if (abs(numbers - numbers.astype(numpy.float32)) < 1e-9 * size).all():
            found.append(ColumnRounding(6e-8 * largest, "32-bit floats"))
    return found


def precisions(given: Mapping[str, Array]) -> dict[str, ColumnRounding]:
    """Return the precision of every known column."""
    found: dict[str, ColumnRounding] = {}
    for names in VECTORS:
        there = [name for name in names if name in given]
        if there:
            stride = max(1, len(given[there[0]]) // LOOKED_AT)
            together = numpy.concatenate([numpy.asarray(given[n])[::stride] for n in there])
            found |= dict.fromkeys(there, precision_of(together))
    return found


def described(found: Mapping[str, ColumnRounding]) -> str:
    """Return words for the columns that are not full doubles, such as "kx ky kz: 6 decimals"."""
    by_words: dict[str, list[str]] = {}
    for name, one in found.items():
        if one.words:
            by_words.setdefault(one.words, []).append(name)
    return "; ".join(f"{' '.join(names)}: {words}" for words, names in by_words.items())


class RoundedTimes(NamedTuple):
    """Times (s) with their rounding (s); evenly spaced times without rounding, and ``words``.

    ``drifts`` says that they are even up to rounding, with a spacing that is not known exactly.
    """

    t: Array
    rounding: float
    words: str
    drifts: bool = False


def times_of(t: Array) -> RoundedTimes:
    """Return times; those of one known grid, up to their rounding, are made exactly even.

    On another grid, or where several fit, the clock's rate is known no better than the times are.
    """
    count = len(t)
    if count < 3:
        return RoundedTimes(t, 0.0, "")
    steps, step = numpy.diff(t), (t[-1] - t[0]) / (count - 1)
    noise = 8 * EPS * float(abs(t).max())
    if float(abs(_off(t, step)).max()) < 1e-9 * step + noise:
        return RoundedTimes(t, noise, "")
    found = precision_of(t[:: max(1, count // LOOKED_AT)])
    if not found.words or math.isnan(step):
        return RoundedTimes(t, noise, "")
    usual = float(numpy.sort(steps)[len(steps) // 2])
    if float(abs(steps - usual * numpy.rint(steps / usual)).max()) < 1e-9 * usual + noise:
        return RoundedTimes(t, found.half_unit, found.words)  # an even grid but for missing rows
    grids = [grid for grid in _grids(step) if _fits(t, float(grid), found.half_unit + noise)]
    # a grid that is written without rounding is even, or a row is off
    places = [float(grid) / (2 * found.half_unit) for grid in grids]
    written = [one for one in places if abs(one - round(one)) < 1e-6]
    if len(grids) == 1 and not written:
        off = _off(t, float(grids[0]))
        return RoundedTimes(
            t - off, EPS * float(abs(t).max()), f"{found.words}, evenly spaced but for that"
        )
    # the spacing that the ends give is as wrong as they are
    drifts = not written and _fits(t, step, 2 * found.half_unit + noise)
    return RoundedTimes(t, found.half_unit, found.words, drifts)


def _grids(step: float) -> set[Fraction]:
    """Spacings (s) near ``step`` of a whole number of rows in a second, or of tenths of ms."""
    second, tenths = (int(numpy.clip(count, 0, 1e12)) for count in (1 / step, 1e4 * step))
    near = {Fraction(1, n) for n in range(max(second - 1, 1), second + 3)}
    return near | {Fraction(n, 10_000) for n in range(max(tenths - 1, 1), tenths + 3)}


def _off(t: Array, step: float) -> Array:
    """The distances (s) of times from a grid, the largest on either side alike."""
    off = t - step * numpy.arange(len(t))
    off -= (off.max() + off.min()) / 2
    return off


def _fits(t: Array, step: float, rounding: float) -> bool:
    return float(abs(_off(t, step)).max()) <= rounding
