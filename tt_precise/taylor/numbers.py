"""Numbers of several doubles: in and out of mpmath, and sums of many at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from mpmath.libmp import from_float, fzero, mpf_add, mpf_sub, to_float

from tt_precise.runtime.values import Array, Functions, Scalar

MOST_PARTS = 3


def split(value: Scalar, parts: int) -> tuple[float, ...]:
    """An mpmath number as so many doubles, each the nearest to what those before leave."""
    left, doubles = value._mpf_, []
    for _ in range(parts):
        part = to_float(left, rnd="n")
        doubles.append(part)
        left = mpf_sub(left, from_float(part)) if math.isfinite(part) else fzero
    return tuple(doubles)


def moments(times: Iterable[Scalar]) -> Array:
    """Times as ``StepBlock`` takes them: axes (time, part), whatever has fewer parts."""
    import numpy

    return numpy.array([split(time, MOST_PARTS) for time in times])


def number(parts: Sequence[float], fn: Functions) -> Scalar:
    """The mpmath number of its parts."""
    total = from_float(parts[0])
    for part in parts[1:]:
        total = mpf_add(total, from_float(part))
    return fn.make_mpf(total)


def numbers_of(row: Array, fn: Functions) -> tuple[Scalar, ...]:
    """Those of a row (part, column)."""
    return tuple(number(parts, fn) for parts in row.T.tolist())


def multiples(step: Scalar, counts: Array) -> Array:
    """An mpmath number times whole numbers up to 2^22, as ``moments``."""
    terms, left = [], step
    for _ in range(2 * MOST_PARTS):
        # 30 bits each, so that the products are exact
        coarse = float(left)
        exponent = 30 - math.frexp(coarse)[1]
        coarse = math.ldexp(math.trunc(math.ldexp(coarse, exponent)), -exponent)
        terms.append(counts * coarse)
        left = left - coarse
    return added(terms, MOST_PARTS)


def added(terms: Sequence[Array], parts: int) -> Array:
    """Arrays of doubles added up in parts: axes (entry, part); Ogita, Rump and Oishi's sums."""
    import numpy

    left, sums = list(terms), []
    for _ in range(parts):
        for _ in range(parts):
            for i in range(1, len(left)):
                a, b = left[i], left[i - 1]
                s = a + b
                t = s - a
                left[i - 1], left[i] = (a - (s - t)) + (b - t), s
        sums.append(left[-1])
        left[-1] = numpy.zeros_like(left[-1])
    return numpy.stack(sums, axis=1)
