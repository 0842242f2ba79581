"""Where the normal force of a trajectory is smallest, from the Taylor series of its steps.

It is smallest where the second derivative of k.z is largest (``axis_height``). (An event function
for that costs more than all other events of a sweep together.) Bernstein bounds exclude most steps
at once, and halves of the rest until rounding decides. So no peak inside a step is missed.
"""

from __future__ import annotations

import numpy

from tt_precise.runtime.arithmetic import Array
from tt_precise.sweeps.axis_height import Heights
from tt_precise.sweeps.step_polynomials import HALVINGS, bernstein_of, halves, states_in

# A step counts if its peak may come so close to the largest: the remainder of the series moves
# it by less. The states decide.
SLACK = 1e-9
ROUNDING = 2.0**-50
EQUAL_PEAKS = 8  # of equal peaks, which a periodic motion has without end


def may_be_lowest(
    read: Heights, widths: Array, owner: Array, highest: Array
) -> tuple[Array, Array, Array]:
    """The steps in which the second derivative of k.z may be the largest of a trajectory.

    Parameters
    ----------
    read, widths, owner
        What is known of k.z in the steps, their lengths, 0 for one that was not taken, and whose
        they are; shape (steps, lanes).
    highest
        The largest second derivative of each owner so far, -inf at first. What is found at the
        ends of these steps is put in.

    Returns
    -------
    Step, lane, and what the second derivative stays below: three arrays.
    """
    taken = (widths != 0) & read.finite
    numpy.maximum.at(highest, owner[taken], read.at_ends[taken])
    step, lane = numpy.nonzero(taken & reaches(read.curvature, highest[owner]))
    return step, lane, read.curvature[step, lane]


def reaches(ceiling: Array, highest: Array) -> Array:
    """Whether what stays below ``ceiling`` may be as large as ``highest``."""
    return ceiling >= highest - SLACK * numpy.abs(highest)


def lowest_states(series: Array, widths: Array, owner: Array, height: int) -> tuple[Array, Array]:
    """States where g_n is smallest within each step, of the ``EQUAL_PEAKS`` lowest of each owner.

    Parameters
    ----------
    series, widths
        Taylor series of the steps, shape (entries, order + 1, steps), and their lengths.
    owner, height
        Whose the steps are, and the position of k.z among the entries.

    Returns
    -------
    States, shape (states, entries), and their owners; a state comes from its own step alone, to the
    last bit.
    """
    since, chosen = _lowest(series, widths, owner, height)
    entries, terms, steps = series.shape
    flat = series.reshape(entries * terms, steps)[:, chosen]
    return states_in(numpy.vstack((flat, since[chosen])), entries), owner[chosen]


def lowest_steps(series: Array, widths: Array, height: int) -> Array:
    """Positions of the ``EQUAL_PEAKS`` of the steps in which g_n is smallest, in their order."""
    _, chosen = _lowest(series, widths, numpy.zeros(len(widths), dtype=int), height)
    return chosen


def _lowest(series: Array, widths: Array, owner: Array, height: int) -> tuple[Array, Array]:
    """Times of the steps' peaks, and positions of the highest of each owner."""
    power = numpy.arange(2, series.shape[1])
    curvature = series[height, 2:].T * (power * (power - 1.0))
    curvature *= numpy.vander(widths, len(power), increasing=True)
    place, peak = _peaks(curvature)
    order = numpy.lexsort((-peak, owner))
    rank = numpy.arange(len(order)) - numpy.searchsorted(owner[order], owner[order])
    return place * widths, numpy.sort(order[rank < EQUAL_PEAKS])


def _peaks(polynomials: Array) -> tuple[Array, Array]:
    """Where on [0, 1] each polynomial (a row of coefficients) is largest, and how large."""
    count = len(polynomials)
    bernstein = bernstein_of(polynomials)
    noise = ROUNDING * numpy.abs(bernstein).max(axis=1, initial=0.0)
    height, place = bernstein[:, 0].copy(), numpy.zeros(count)
    owner, left, width = numpy.arange(count), numpy.zeros(count), 1.0
    _raise(height, place, owner, bernstein[:, -1], left + width)
    for _ in range(HALVINGS):
        further = bernstein.max(axis=1, initial=-numpy.inf) > (height + noise)[owner]
        if not further.any():
            break
        owner, left, lower, upper = owner[further], left[further], *halves(bernstein[further])
        width /= 2
        _raise(height, place, owner, upper[:, 0], left + width)
        owner, left = numpy.tile(owner, 2), numpy.concatenate((left, left + width))
        bernstein = numpy.concatenate((lower, upper))
    return place, height


def _raise(height: Array, place: Array, owner: Array, values: Array, places: Array) -> None:
    """Put in the largest of the values of each owner, and its place, where it is a new maximum."""
    order = numpy.lexsort((places, values))
    highest, where = numpy.full(len(height), -numpy.inf), numpy.zeros(len(height))
    highest[owner[order]], where[owner[order]] = values[order], places[order]  # the last one stays
    new = highest > height
    height[new], place[new] = highest[new], where[new]
