"""Sign changes of many polynomials between 0 and 1; and zeros along a run.

In Bernstein's basis a polynomial has at most as many zeros as its coefficients have sign changes,
and the two counts differ by an even number. So counts of none and one are exact; for other counts
the interval is halved.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy

from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.taylor.machine import MOST_LIMBS

if TYPE_CHECKING:
    from tt_precise.taylor.system import StepBlock

MOST_HALVINGS = 40  # beyond, two zeros are one touching: no change of sign
MOST_STEPS = 100  # Bisections and secants to one zero at most.
MOST_NEWTONS = 8  # Newton steps in several doubles; each adds up to 15 digits.


class Crossings(NamedTuple):
    """Arrays of crossings: polynomial, position (0 to 1), and direction (+1 rises, -1 falls)."""

    which: Array
    position: Array
    direction: Array


def crossings(polynomials: Array, first: Array) -> Crossings:
    """Changes of sign of polynomials, rows of coefficients of 1, x, x^2 ..., for 0 <= x <= 1.

    ``first`` replaces their values at 0: with the end values of the previous polynomials, no zero
    is lost or counted twice between two pieces. Zero counts as positive.
    """
    bernstein = bernstein_of(polynomials)
    bernstein[:, 0] = first
    which, low, high, rising = isolated(bernstein, MOST_HALVINGS)
    direction = numpy.where(rising, 1, -1)
    position = _refined(polynomials[which], low, high, direction)
    order = numpy.lexsort((position, which))
    return Crossings(which[order], position[order], direction[order])


def _refined(polynomials: Array, low: Array, high: Array, direction: Array) -> Array:
    """The zero between ``low`` and ``high``, by Newton's steps, by bisection if these leave."""
    slopes = polynomials[:, 1:] * numpy.arange(1, polynomials.shape[1])
    position = (low + high) / 2
    with numpy.errstate(all="ignore"):
        for _ in range(MOST_STEPS):
            value = values(polynomials, position)
            behind = value * direction >= 0
            low, high = numpy.where(behind, low, position), numpy.where(behind, position, high)
            nearer = position - value / values(slopes, position)
            nearer = numpy.where((nearer >= low) & (nearer <= high), nearer, (low + high) / 2)
            near = abs(nearer - position) <= 4e-16 * position
            position = nearer
            if near.all():
                break
    return position


def values(polynomials: Array, positions: Array) -> Array:
    """The value of each polynomial at its position, by Horner's rule."""
    value = polynomials[:, -1]
    for k in range(polynomials.shape[1] - 2, -1, -1):
        value = value * positions + polynomials[:, k]
    return value


def isolated(bernstein: Array, halvings: int) -> tuple[Array, Array, Array, Array]:
    """Intervals with one zero each, of polynomials in Bernstein coefficients on [0, 1].

    Returns which polynomial, the two ends, and whether it rises there, in the order of positions.
    After the last halving two zeros count as none, and three as one.
    """
    which, low = numpy.arange(len(bernstein)), numpy.zeros(len(bernstein))
    width, intervals = 1.0, []
    for halving in range(halvings + 1):
        negative = bernstein < 0
        changes = numpy.count_nonzero(negative[:, 1:] != negative[:, :-1], axis=1)
        single = changes % 2 == 1 if halving == halvings else changes == 1
        intervals.append((which[single], low[single], low[single] + width, negative[single, 0]))
        several = changes > 1
        if not several.any():
            break
        which, low, (lower, upper) = which[several], low[several], halves(bernstein[several])
        width /= 2
        which, low = numpy.tile(which, 2), numpy.concatenate((low, low + width))
        bernstein = numpy.concatenate((lower, upper))
    which, low, high, rising = (numpy.concatenate(limb) for limb in zip(*intervals, strict=True))
    order = numpy.lexsort((low, which))
    return which[order], low[order], high[order], rising[order]


def bernstein_of(polynomials: Array) -> Array:
    """Bernstein's coefficients on [0, 1] of polynomials, rows of coefficients of 1, x, x^2 ...

    Unlike a matrix product, sums of whole columns round a row whatever the others are.
    """
    bernstein = numpy.zeros(polynomials.shape)
    for column, row in zip(polynomials.T, _to_bernstein(polynomials.shape[1]), strict=True):
        bernstein += column[:, None] * row
    return bernstein


@cache
def _to_bernstein(terms: int) -> Array:
    """Row j has C(i, j)/C(terms - 1, j), the share of x^j in the i-th coefficient."""
    last = terms - 1
    return numpy.array(
        [[math.comb(i, j) / math.comb(last, j) for i in range(terms)] for j in range(terms)]
    )


def halves(bernstein: Array) -> tuple[Array, Array]:
    """Bernstein's coefficients between 0 and 1/2, and between 1/2 and 1; de Casteljau."""
    lower, upper, row = numpy.empty_like(bernstein), numpy.empty_like(bernstein), bernstein
    for k in range(bernstein.shape[1]):
        lower[:, k], upper[:, -1 - k] = row[:, 0], row[:, -1]
        row = (row[:, 1:] + row[:, :-1]) / 2
    return lower, upper


class SignChange(NamedTuple):
    """A sign change of the function with this index: time, direction (+1 rising, -1), state.

    ``row`` holds all columns in limbs, (limb, column).
    """

    function: int
    time: Scalar
    direction: int
    row: Array


class Watch:
    """Finds the zeros of a run's outputs piece by piece, each in its direction (0: both)."""

    def __init__(self, first_column: int, directions: Sequence[int], fn: Functions):
        self._columns = slice(first_column, first_column + len(directions))
        self._directions, self._fn = directions, fn
        self._before: StepBlock | None = None

    def zeros(self, piece: StepBlock, until: Scalar) -> list[SignChange]:
        """Zeros in the steps of ``piece`` that are numbers, before ``until``, in order of time."""
        fn, steps = self._fn, piece.suspect
        before, self._before = self._before, piece
        if not len(steps):
            return []
        left = (float(until) - piece.begins[steps, 0]) / piece.units[steps]
        lengths = numpy.minimum(piece.lengths[steps], left)
        series, powers = self._series(piece, steps, lengths)  # axes (function, step, order)
        first = series[:, :, 0].copy()
        # where one begins is where the step before it ends
        inner = steps > 0
        first[:, inner] = self._ends(piece, steps[inner] - 1)
        if before and not inner[0]:
            first[:, :1] = self._ends(before, numpy.array([len(before.lengths) - 1]))
        function, step = numpy.indices(first.shape).reshape(2, -1)
        polynomials = (series * powers).reshape(len(step), -1)
        changes = crossings(polynomials, first.reshape(-1))
        allowed = numpy.array(self._directions)[function[changes.which]]
        wanted = (allowed == 0) | (allowed == changes.direction)
        which, position, direction = (limb[wanted] for limb in changes)
        function, step = function[which], step[which]
        if not len(step):
            return []
        rates = polynomials[which][:, 1:] * numpy.arange(1, polynomials.shape[1])
        steps, lengths = steps[step], lengths[step]
        units = piece.units[steps]
        slopes = values(rates, position) / (lengths * units)
        wide = mpfr_of(fn)
        near = 2.0 ** (8 - 52 * piece.system.limbs)
        with wide.precision():
            times = wide.from_limbs(piece.begins[steps]) + position * lengths * units
            for _ in range(MOST_NEWTONS):
                there = piece.rows(steps, wide.to_limbs(times, MOST_LIMBS))
                here = there[numpy.arange(len(steps)), :, self._columns.start + function]
                off = wide.from_limbs(here) / numpy.where(slopes, slopes, numpy.inf)
                # out of the step leads only what rounding alone makes a zero
                off = numpy.where(abs(off) <= lengths * units, off, 0 * times)
                times = times - off
                if (abs(off) <= near * times).all():
                    break
            rows = piece.rows(steps, wide.to_limbs(times, MOST_LIMBS))
        exact = [wide.back(time) for time in times]
        zeros = map(SignChange, function.tolist(), exact, direction.tolist(), rows)
        return sorted(zeros, key=lambda zero: zero.time)

    def _series(self, piece: StepBlock, steps: Array, lengths: Array) -> tuple[Array, Array]:
        series = piece.coefficients[steps][:, :, self._columns].transpose(2, 0, 1)
        return series, numpy.vander(lengths, piece.order + 1, increasing=True)

    def _ends(self, piece: StepBlock, steps: Array) -> Array:
        return numpy.einsum("fsn,sn->fs", *self._series(piece, steps, piece.lengths[steps]))
