"""Zeros of many functions at once, each in its bracket, to the last bits of an arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy

from tt_precise.runtime.values import Array


class Bracket(NamedTuple):
    """A place near a zero of a function, places before and behind it, and its slope."""

    place: Array
    low: Array
    high: Array
    slope: Array
    direction: Array

    def of(self, rows: Array) -> Bracket:
        """Return some of the rows."""
        return Bracket(*(x[rows] for x in self))


def refined(
    function: Callable[..., Array], bracket: Bracket, most: int, settled: float
) -> tuple[Array, Array]:
    """Return the zeros of a function, and its values there.

    By at most ``most`` secants, which end when a move is shorter than ``settled`` times the place,
    or longer than the one before. That is noise if the place has half its digits. Where it has
    not, as at a multiple zero, a kink or a jump, the bracket is halved.
    """
    place, slope, reach = bracket.place, bracket.slope, bracket.high - bracket.low
    value, rows, last = function(place), numpy.arange(len(place)), reach.copy()
    for _ in range(most):
        move = value[rows] / slope
        size = abs(move)
        near = (size <= reach).astype(bool)
        last[rows[near]] = move[near]
        going = near & (size > settled * abs(place[rows])).astype(bool)
        rows, move = rows[going], move[going]
        if not len(rows):
            break
        before, place[rows] = value[rows], place[rows] - move
        value[rows] = function(place[rows], rows)
        slope, reach = (before - value[rows]) / move, size[going]
    rows = numpy.flatnonzero((abs(last) > settled**0.5 * abs(place)).astype(bool))
    if len(rows):
        place[rows], value[rows] = halved(partial(function, rows=rows), bracket.of(rows))
    return place, value


def halved(function: Callable[..., Array], bracket: Bracket) -> tuple[Array, Array]:
    """Return the zeros of a function by halving brackets until rounding ends it."""
    low, high = bracket.low, bracket.high
    while True:
        middle = (low + high) / 2
        value = function(middle)
        behind = (value * bracket.direction >= 0).astype(bool)
        inside = ((low < middle) & (middle < high)).astype(bool)
        if not inside.any():
            return middle, value
        low, high = numpy.where(behind, low, middle), numpy.where(behind, middle, high)
