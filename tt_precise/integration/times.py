"""``Times``: many times at once in double, with what rounding them cuts off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.mpfr import Mpfr
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene
from tt_precise.taylor.numbers import MOST_PARTS, moments, multiples

EXACT = 2**53  # integers up to here are doubles, so that a quotient of two is rounded once


class Times(NamedTuple):
    """Times as float64 arrays of one shape.

    ``seconds`` are the doubles nearest to the exact times in s. ``rounded`` + ``delay`` is the
    dimensionless time with the 64 bits of a long double: heyoka takes ``rounded``.
    """

    seconds: Array
    rounded: Array
    delay: Array

    @classmethod
    def of(cls, times: Sequence[Fraction], unit: Scalar) -> Times:
        """Exact ``times`` in s; ``unit`` is the unit of time in s, an mpmath number."""
        import numpy

        above, below = [t.numerator for t in times], [t.denominator for t in times]
        if max(map(abs, above + below), default=0) < EXACT:
            numerator, denominator = (numpy.array(part, dtype=float) for part in (above, below))
            seconds = numerator / denominator
            exact = numerator.astype(numpy.longdouble) / denominator
        else:
            seconds = numpy.array([float(t) for t in times])
            low = [float(t - Fraction(s)) for t, s in zip(times, seconds.tolist(), strict=True)]
            exact = seconds + numpy.array(low, dtype=numpy.longdouble)
        inner = exact / long_double(unit)
        rounded = inner.astype(float)
        return cls(seconds, rounded, (inner - rounded).astype(float))


@dataclass(frozen=True, eq=False)
class SampleTimes:
    """The sample times of a scene: exact, in s, and as doubles."""

    exact: tuple[Fraction, ...]
    doubles: Times
    start: InitialState

    @cached_property
    def parts(self) -> Array:
        """The dimensionless times, each as three doubles: axes (time, part)."""
        import numpy

        until = self.start.until
        step = to_mpmath(self.exact[1], until.context) / self.start.units.time
        inner = multiples(step, numpy.arange(len(self.exact) - 1))
        return numpy.concatenate([inner, moments([until])])

    @classmethod
    def of(cls, scene: Scene, start: InitialState) -> SampleTimes:
        """The doubles end with the horizon of ``start``, to the last bit."""
        times = Times.of(scene.sample_times, start.units.time)
        horizon = float(start.until)
        times.rounded[-1], times.delay[-1] = horizon, float(start.until - horizon)
        return cls(scene.sample_times, times, start)


def in_parts(times: Sequence[Fraction], unit: Scalar, wide: Mpfr) -> Array:
    """Exact times in s as dimensionless ones, each as three doubles: axes (time, part)."""
    with wide.precision():
        return wide.in_parts(wide.of_fractions(times) / wide.number(unit), MOST_PARTS)


def long_double(value: Scalar) -> Scalar:
    """An mpmath number as NumPy's long double."""
    import numpy

    high = float(value)
    if math.isinf(high):  # ln v at rest
        return numpy.longdouble(high)
    return numpy.longdouble(high) + numpy.longdouble(float(value - high))


def has_long_double() -> bool:
    """Whether NumPy's long double has at least the 64 bits of an extended number here."""
    import numpy

    return bool(numpy.finfo(numpy.longdouble).nmant >= 63)
