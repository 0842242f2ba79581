"""Zeros and extrema of many functions at once, to the last bits of an arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy

from tt_precise.runtime.values import Array

RIGHT_BITS = 10  # Bits of a zero, relative to its bracket, that are right before the first secant.
# Length of the last secant, in 2^-bits of the position: the zero is nearer than that.
SETTLED = 2.0**8
# Distance of the three points of the first parabola through an extremum, in units of its interval;
# each further distance is the square of the one before, as the error of a vertex is.
FLATTEST = 2.0**-16


class Bracket(NamedTuple):
    """A position near a zero of a function, positions before and behind, and the derivative."""

    position: Array
    low: Array
    high: Array
    slope: Array
    direction: Array

    def of(self, rows: Array) -> Bracket:
        """Return some of the rows."""
        return Bracket(*(x[rows] for x in self))


def secants(bits: int) -> int:
    """Return the number of secants after which all ``bits`` of a zero are right.

    Each has 1.6 times as many right bits as the one before; two more end in noise.
    """
    return math.ceil(math.log(bits / RIGHT_BITS, 1.6)) + 2


def refine(function: Callable[..., Array], bracket: Bracket, bits: int) -> tuple[Array, Array]:
    """Return the zeros of a function, and the values at the zeros.

    By secants, which end when a move is shorter than ``SETTLED`` or longer than the one before.
    That is noise if the position has half its digits. Where it has not, as at a multiple zero, a
    bend or a jump, the bracket is halved.
    """
    settled = SETTLED * 2.0**-bits
    position, slope, bound = bracket.position, bracket.slope, bracket.high - bracket.low
    value, rows, last = function(position), numpy.arange(len(position)), bound.copy()
    for _ in range(secants(bits)):
        move = value[rows] / slope
        size = abs(move)
        near = (size <= bound).astype(bool)
        last[rows[near]] = move[near]
        going = near & (size > settled * abs(position[rows])).astype(bool)
        rows, move = rows[going], move[going]
        if not len(rows):
            break
        before, position[rows] = value[rows], position[rows] - move
        value[rows] = function(position[rows], rows)
        slope, bound = (before - value[rows]) / move, size[going]
    rows = numpy.flatnonzero((abs(last) > settled**0.5 * abs(position)).astype(bool))
    if len(rows):
        position[rows], value[rows] = bisect(partial(function, rows=rows), bracket.of(rows))
    return position, value


def bisect(function: Callable[..., Array], bracket: Bracket) -> tuple[Array, Array]:
    """Return the zeros of a function, by bisection down to rounding."""
    low, high = bracket.low, bracket.high
    while True:
        middle = (low + high) / 2
        value = function(middle)
        behind = (value * bracket.direction >= 0).astype(bool)
        inside = ((low < middle) & (middle < high)).astype(bool)
        if not inside.any():
            return middle, value
        low, high = numpy.where(behind, low, middle), numpy.where(behind, middle, high)


def vertex(
    function: Callable[[Array], Array],
    position: Array,
    bound: Array,
    low: Array,
    high: Array,
    bits: int,
) -> tuple[Array, Array]:
    """Return the extrema of a function near positions, between low and high, and the values.

    A parabola through three points gives the next position, if that is within ``bound``.
    """
    far = FLATTEST
    while True:
        aside = 0 * position + far * bound
        left, middle, right = map(function, (position - aside, position, position + aside))
        slope, bend = (right - left) / 2, left - 2 * middle + right
        move = -aside * slope / bend
        move = numpy.where((abs(move) <= bound).astype(bool), move, 0.0)
        position = numpy.minimum(numpy.maximum(position + move, low), high)
        if far**4 < 2.0**-bits:
            return position, function(position)
        far *= far
