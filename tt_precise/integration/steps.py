"""The Taylor steps of a run, from either integrator, in the form that ``zeros`` reads.

Series are stored in double; in a wider arithmetic the integrator's dense output gives the
components at single positions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy

from tt_precise.integration.dense_output import long_double, shift_arrays
from tt_precise.integration.setup import Setup
from tt_precise.runtime.values import Array, ContinuousOutput, Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.taylor.machine import MOST_LIMBS
from tt_precise.taylor.system import StepBlock

Rows = Callable[[Array, Array], tuple[Array, Sequence[Array]]]
"""Function of steps and positions in them that gives times and components."""


class Wide(NamedTuple):
    """The series of steps in an arithmetic with more bits than a double.

    ``number`` converts mpmath numbers and floats to it, ``fn`` has its functions, ``back`` gives
    mpmath numbers with guard bits; ``rows(step, position)`` gives times and components, arrays of
    numbers, at positions in steps. With ``only``, doubles have no value here.
    """

    number: Callable[[Scalar], Scalar]
    fn: Functions
    back: Callable[[Scalar], Scalar]
    rows: Rows
    only: bool = False

    def array(self, values: Array) -> Array:
        """Return doubles as numbers of this arithmetic."""
        if self.fn is numpy:
            return values.astype(numpy.longdouble)
        return numpy.frompyfunc(self.number, 1, 1)(values)


class Sampled(NamedTuple):
    """Components at the same positions in all steps, and the sizes of their series.

    ``row`` has an array for each component, axes (position, step). ``size`` is the largest term of
    a series, ``last`` are its last two, in absolute value: axes (component, step). ``lost`` bounds
    what rounding loses of a component inside a step, in roundings.
    """

    row: Array
    size: Array
    last: tuple[Array, Array]
    lost: Array


@dataclass(frozen=True)
class Steps:
    """Consecutive Taylor steps: ``begin`` and ``length`` in double, and their ``series``.

    ``series`` has the axes (step, component, term), in powers of the time, of which a step takes
    ``span`` units. A position is time over the length of the step. ``wide`` is None in double.
    """

    begin: Array
    length: Array
    series: Array
    span: Array
    wide: Wide | None = None

    def __len__(self) -> int:
        return len(self.begin)

    def part(self, first: int, last: int) -> Steps:
        """Return some of the steps."""
        here, wide = slice(first, last), self.wide
        if wide:
            wide = wide._replace(rows=partial(_rows_from, wide.rows, first))
        return Steps(self.begin[here], self.length[here], self.series[here], self.span[here], wide)

    def sampled(self, positions: Array) -> Sampled:
        """Return the components at positions in every step."""
        steps, components, count = self.series.shape
        row = numpy.empty((components, len(positions), steps))
        size, last, before, lost = numpy.empty((4, components, steps))
        powers, span = powers_of(positions, count), powers_of(self.span, count).T
        weights = roundings(count)
        for i in range(components):  # one at a time, whose terms stay in the cache
            terms = self.series[:, i, ::-1].T * span
            row[i] = powers @ terms
            terms = numpy.abs(terms, out=terms)
            size[i], last[i], before[i] = terms.max(axis=0), terms[0], terms[1]
            lost[i] = weights @ terms
        return Sampled(row, size, (last, before), lost)

    def inside(self, step: Array, position: Array) -> Array:
        """Return the components at a position, or a row of positions, in each given step."""
        span = self.span[step].reshape(-1, *(1,) * (position.ndim - 1))
        powers = powers_of(position * span, self.series.shape[2])
        return numpy.einsum("sct,s...t->cs...", self.series[step][:, :, ::-1], powers)


def powers_of(x: Array, count: int) -> Array:
    """Return the powers ``count`` - 1 to 0 of numbers, along the last axis.

    Sums that begin with the highest powers, which are smallest, lose a third of what others lose.
    """
    powers = numpy.ones((count, *x.shape))
    powers[1:] = x
    return numpy.moveaxis(numpy.multiply.accumulate(powers, axis=0, out=powers)[::-1], 0, -1)


def roundings(count: int) -> Array:
    """Return the roundings of the terms ``count`` - 1 to 0 of a sum that begins with the highest.

    Of the term k: one of its coefficient, 2 k of the powers of two factors and the products with
    these, and k + 1 of the sum.
    """
    return 3.0 * numpy.arange(count)[::-1] + 2


def _rows_from(
    rows: Rows, first: int, step: Array, position: Array
) -> tuple[Array, Sequence[Array]]:
    return rows(first + step, position)


def of_dense_output(output: ContinuousOutput, setup: Setup, start: InitialState) -> Steps:
    """Return the Taylor steps of a dense output of heyoka."""
    times, series = output.times, output.tcs
    span = numpy.diff(times)
    if setup.precision.is_float:
        return Steps(times[:-1], span, series, span)
    length = span.astype(float)
    with numpy.errstate(over="ignore"):
        doubles = series.astype(float)
    if not numpy.isfinite(doubles).all():
        # beside a pole coefficients in powers of the time exceed doubles
        power = span
        for k in range(1, series.shape[2]):
            doubles[:, :, k] = (series[:, :, k] * power[:, None]).astype(float)
            power = power * span
        span = numpy.ones(len(length))
    wide = _wide(output, setup, start)
    return Steps(times[:-1].astype(float), length, doubles, span.astype(float), wide)


def _wide(output: ContinuousOutput, setup: Setup, start: InitialState) -> Wide:
    """Return the series of a dense output, read in the arithmetic of the run."""
    precision, context = setup.precision, setup.precision.context
    if precision.in_long_double:
        begin, length = output.times[:-1], numpy.diff(output.times)
        series = output.tcs.transpose(2, 1, 0)

        def in_long_double(step: Array, position: Array) -> tuple[Array, Sequence[Array]]:
            delay = position * length[step]
            return begin[step] + delay, list(horner(series[:, :, step], delay))

        def exact(value: Scalar) -> Scalar:
            high = float(value)
            return context.mpf(high) + context.mpf(float(value - high))

        return Wide(long_double, numpy, exact, in_long_double)

    mpfr, with_guard_bits, number = precision.mpfr, precision.with_guard_bits, precision.number
    times = mpfr.array(map(with_guard_bits, output.times))
    body = start.body.numbers(mpfr.number)

    def rows(step: Array, position: Array) -> tuple[Array, Sequence[Array]]:
        when = times[step] + position * (times[step + 1] - times[step])
        rounded = [number(mpfr.back(time)) for time in when]
        # the next evaluation overwrites the numbers of the one before
        read = [tuple(map(with_guard_bits, output(time))) for time in rounded]
        entries = tuple(map(mpfr.array, zip(*read, strict=True)))
        delay = when - mpfr.array(map(with_guard_bits, rounded))
        return when, shift_arrays(setup, body, entries, delay, mpfr)

    return Wide(mpfr.number, mpfr, mpfr.back, rows)


def of_block(piece: StepBlock, end: float, setup: Setup) -> Steps:
    """Return the Taylor steps of a block of several doubles, up to its ``end``."""
    size = len(setup.layout.columns)
    count = max(int((piece.begins[:, 0] < end).sum()), 1)
    begin, unit = piece.begins[:count, 0], piece.units[:count]
    lengths = numpy.minimum(piece.lengths[:count], (end - begin) / unit)
    series = piece.coefficients[:count, :, :size].transpose(0, 2, 1)
    mpfr = setup.precision.mpfr
    with mpfr.precision():
        begins = mpfr.from_limbs(piece.begins[:count])

    def rows(step: Array, position: Array) -> tuple[Array, Sequence[Array]]:
        times = begins[step] + position * (lengths * unit)[step]
        parts = piece.rows(step, mpfr.to_limbs(times, MOST_LIMBS))
        return times, [mpfr.from_limbs(parts[:, :, i]) for i in range(size)]

    wide = Wide(mpfr.number, mpfr, mpfr.back, rows)
    return Steps(begin, lengths * unit, series, lengths, wide)


def of_series(series: Sequence[Sequence[Scalar]], length: Scalar, setup: Setup) -> Steps:
    """Return one step from 0 to ``length``, from power series of the components in wide numbers.

    Only these are precise enough where functions vanish or are undefined at 0.
    """
    mpfr = setup.precision.mpfr
    terms = [[x * length**k for k, x in enumerate(c)] for c in series]

    def rows(step: Array, position: Array) -> tuple[Array, Sequence[Array]]:
        return position * length, [horner(c, position) for c in terms]

    wide = Wide(mpfr.number, mpfr, mpfr.back, rows, only=True)
    one = numpy.ones(1)
    return Steps(0 * one, float(length) * one, numpy.array(terms, float)[None], one, wide)


def horner(terms: Sequence[Scalar], position: Array) -> Array:
    """Return the sum of terms times powers of a position."""
    value = terms[-1] + 0 * position
    for term in terms[-2::-1]:
        value = value * position + term
    return value
