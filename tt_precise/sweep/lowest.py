"""Where the normal force of a trajectory is smallest, from the Taylor series of its steps.

The height of the centre of mass is R (1 - alpha k.z), so g_n = m g - m R alpha (k.z)_ddot, gliding
or rolling: g_n is smallest where the second derivative of k.z is largest. (An event function for
that costs more than all other events of a sweep together.) A polynomial on a step lies below the
largest of its Bernstein coefficients: that excludes most steps at once, and halves of the rest
until rounding decides. So no peak inside a step is missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import comb
from typing import Any, NamedTuple

import numpy

HALVINGS = 26  # a parabola loses 2^-52 of its height so near to its peak
# A step is kept if its peak may come so close to the largest: the remainder of the series, and
# sums that are rounded otherwise in other company, move it by less. The states decide.
SLACK = 1e-9
ROUNDING = 2.0**-50
KEPT = 8  # of equal peaks, which a periodic motion has without end


class Step(NamedTuple):
    """The length of a step and its Taylor series, shape (entries, order + 1)."""

    width: float
    series: Any


def may_be_lowest(heights: Any, widths: Any, highest: Any) -> tuple[Any, Any, Any]:
    """The steps in which the second derivative of k.z may be the largest of its lane.

    Parameters
    ----------
    heights
        Taylor coefficients of k.z, shape (steps, order + 1, lanes).
    widths
        Lengths of the steps, shape (steps, lanes); 0 for a lane that took none.
    highest
        The largest second derivative of each lane so far, -inf at first, shape (lanes,). What is
        found at the ends of these steps is put in.

    Returns
    -------
    Step, lane, and what the second derivative stays below: three arrays.
    """
    steps, terms, lanes = heights.shape
    # a row for each power, so that all is done in long rows
    curvature = heights[:, 2:].transpose(1, 0, 2).copy().reshape(terms - 2, -1)
    power = numpy.ones(steps * lanes)
    with numpy.errstate(all="ignore"):
        curvature *= _twice_derived(terms - 2)[:, None]
        for row in curvature[1:]:
            power *= widths.ravel()
            row *= power
        bernstein = _to_bernstein(terms - 2).T @ curvature
    taken = (widths != 0) & numpy.isfinite(bernstein).all(axis=0).reshape(widths.shape)
    ceiling = bernstein.max(axis=0).reshape(widths.shape)
    ends = numpy.maximum(bernstein[0], bernstein[-1]).reshape(widths.shape)
    numpy.maximum(highest, numpy.where(taken, ends, -numpy.inf).max(axis=0), out=highest)
    step, lane = numpy.nonzero(taken & reaches(ceiling, highest))
    return step, lane, ceiling[step, lane]


def reaches(ceiling: Any, highest: Any) -> Any:
    """Whether what stays below ``ceiling`` may be as large as ``highest``."""
    return ceiling >= highest - SLACK * numpy.abs(highest)


def lowest_states(steps: Sequence[Step], owner: Any, height: int) -> tuple[Any, Any]:
    """The states where g_n is smallest within each step, of the ``KEPT`` lowest of each owner.

    ``height`` is the position of k.z among the entries. Returns states, shape (states, entries),
    and their owners; a state comes from its own step alone, to the last bit.
    """
    if not steps:
        return numpy.empty(0), owner
    series, since, chosen = _lowest(steps, owner, height)
    return states_in(series[chosen], since[chosen]), owner[chosen]


def lowest_steps(steps: Sequence[Step], height: int) -> list[Step]:
    """The ``KEPT`` of the steps in which g_n is smallest, in their order."""
    _, _, chosen = _lowest(steps, numpy.zeros(len(steps), dtype=int), height)
    return [steps[position] for position in chosen.tolist()]


def _lowest(steps: Sequence[Step], owner: Any, height: int) -> tuple[Any, Any, Any]:
    """Series of the steps, times of their peaks, and positions of the highest of each owner."""
    widths = numpy.array([one.width for one in steps])
    series = numpy.array([one.series for one in steps])
    size = series.shape[2] - 2
    curvature = series[:, height, 2:] * _twice_derived(size)
    curvature *= numpy.vander(widths, size, increasing=True)
    place, peak = _peaks(curvature)
    order = numpy.lexsort((-peak, owner))
    rank = numpy.arange(len(order)) - numpy.searchsorted(owner[order], owner[order])
    return series, place * widths, numpy.sort(order[rank < KEPT])


def states_in(series: Any, since: Any) -> Any:
    """States in steps, so long after their starts, from their Taylor series (Horner).

    ``series`` has the shape (steps, entries, order + 1), ``since`` (steps,), the result (steps,
    entries).
    """
    since = since[:, None]
    state = series[:, :, -1].copy()
    for power in range(series.shape[2] - 2, -1, -1):
        state *= since
        state += series[:, :, power]
    return state


def _peaks(polynomials: Any) -> tuple[Any, Any]:
    """Where on [0, 1] each polynomial (a row of coefficients) is largest, and how large."""
    count, size = polynomials.shape
    # sums of whole columns, because a matrix product rounds a row as the others' number suggests
    bernstein = numpy.zeros((count, size))
    for power, column in enumerate(_to_bernstein(size)):
        bernstein += polynomials[:, power, None] * column
    noise = ROUNDING * numpy.abs(bernstein).max(axis=1, initial=0.0)
    height, place = bernstein[:, 0].copy(), numpy.zeros(count)
    owner, left, width = numpy.arange(count), numpy.zeros(count), 1.0
    _raise(height, place, owner, bernstein[:, -1], left + width)
    for _ in range(HALVINGS):
        further = bernstein.max(axis=1, initial=-numpy.inf) > (height + noise)[owner]
        if not further.any():
            break
        owner, left, lower, upper = owner[further], left[further], *_halves(bernstein[further])
        width /= 2
        _raise(height, place, owner, upper[:, 0], left + width)
        owner, left = numpy.tile(owner, 2), numpy.concatenate((left, left + width))
        bernstein = numpy.concatenate((lower, upper))
    return place, height


def _raise(height: Any, place: Any, owner: Any, values: Any, places: Any) -> None:
    """Put in the largest of the values of each owner, and its place, where it is a new maximum."""
    order = numpy.lexsort((places, values))
    highest, where = numpy.full(len(height), -numpy.inf), numpy.zeros(len(height))
    highest[owner[order]], where[owner[order]] = values[order], places[order]  # the last one stays
    new = highest > height
    height[new], place[new] = highest[new], where[new]


def _halves(bernstein: Any) -> tuple[Any, Any]:
    """Bernstein coefficients on the lower and the upper half; de Casteljau's algorithm."""
    size = bernstein.shape[1]
    lower, upper, row = numpy.empty_like(bernstein), numpy.empty_like(bernstein), bernstein
    for i in range(size):
        lower[:, i], upper[:, size - 1 - i] = row[:, 0], row[:, -1]
        row = (row[:, 1:] + row[:, :-1]) / 2
    return lower, upper


def _twice_derived(size: int) -> Any:
    """Factors from the coefficients of a polynomial to those of its second derivative."""
    power = numpy.arange(size)
    return (power + 1.0) * (power + 2.0)


@cache
def _to_bernstein(size: int) -> Any:
    """Matrix from coefficients of 1, x, x^2, ... (a row) to those of the Bernstein polynomials."""
    last = size - 1
    return numpy.array(
        [[comb(j, i) / comb(last, i) if i <= j else 0.0 for j in range(size)] for i in range(size)]
    )
