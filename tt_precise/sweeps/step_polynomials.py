"""Taylor polynomials of steps: states inside them, and the zeros of their rates.

A polynomial on a step lies between the smallest and the largest of its Bernstein coefficients,
and has at most as many zeros there as these have changes of sign. What that leaves open is
decided by halving. What is evaluated for every step of a sweep is compiled by heyoka: for one step
that comes to the same, to the last bit, whatever stands beside it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import cache, reduce
from math import comb

import heyoka
import numpy

from tt_precise.runtime.arithmetic import Array, Scalar

HALVINGS = 26  # a parabola loses 2^-52 of its height so near to its peak
NEWTON_STEPS = 6  # at a time, from a secant: enough for all but a few turning points in 1,000
SETTLED = 2.0**-30  # of a step: after so small a step of Newton's a zero is known
ALONE = {"batch_parallel": False}  # the other cores have sweeps of their own
WIDTH, START, END = -3, -2, -1  # the last rows of columns that describe a polynomial
ITERATIONS = 10  # of so many steps: bisections alone would take 52


def horner(coefficients: Sequence[Scalar], at: Scalar) -> Scalar:
    """Value of a polynomial, from its coefficients of 1, x, x^2, ..."""
    return reduce(lambda value, one: value * at + one, coefficients[-2::-1], coefficients[-1])


def states_in(series: Array, entries: int) -> Array:
    """States in steps, from Taylor series of their entries and how long since the start.

    ``series`` has a column for each step: coefficients of the first entry, of the second one and so
    on, and the time since. The result has the shape (steps, entries).
    """
    given = numpy.ascontiguousarray(series)
    return _states(entries, len(given) // entries)(given, **ALONE).T


def bernstein_of(polynomials: Array) -> Array:
    """Bernstein coefficients on [0, 1] of polynomials, a row of coefficients of 1, x, x^2 ... each.

    Unlike a matrix product, sums of whole columns round a row whatever the others are.
    """
    found = numpy.zeros(polynomials.shape)
    for power, column in enumerate(to_bernstein(polynomials.shape[1])):
        found += polynomials[:, power, None] * column
    return found


def zeros(columns: Array, changes: Array) -> tuple[Array, Array, Array]:
    """All changes of sign of the rate of a polynomial in each step; 0 counts as positive.

    Parameters
    ----------
    columns
        Taylor coefficients but the first, length of the step, and the rates at its start and end,
        whose signs decide; shape (order + 3, steps).
    changes
        How many changes of sign there are at most, shape (steps,); none is 0.

    Returns
    -------
    Which step, time since its start, whether the rate rises: three arrays, in order of time for
    each step. What is found in one does not depend on the others, to the last bit.
    """
    count = columns.shape[1]
    owner, first, last = numpy.arange(count), columns[START], columns[END]
    rising, left, right = first < 0, numpy.zeros(count), numpy.ones(count)
    with numpy.errstate(all="ignore"):
        start = first / (first - last)
    several = changes > 1
    if several.any():
        single, hard = numpy.flatnonzero(~several), numpy.flatnonzero(several)
        which, begin, end, up = _brackets(columns[:, hard])
        owner = numpy.concatenate((single, hard[which]))
        order = numpy.argsort(owner, kind="stable")
        left, right, start, rising = (
            numpy.concatenate((one[single], other))[order]
            for one, other in (
                (left, begin), (right, end), (start, (begin + end) / 2), (rising, up)
            )
        )  # fmt: skip
        owner = owner[order]
        columns = columns[:, owner]
    place = _between(columns[:START], 2.0 * rising - 1, left, right, start)
    return owner, place * columns[WIDTH], rising


def _brackets(columns: Array) -> tuple[Array, Array, Array, Array]:
    """Parts of steps with one zero of the rate each: which, from, to, whether it rises."""
    power = numpy.arange(len(columns[:WIDTH]))[:, None]
    bernstein = bernstein_of((columns[:WIDTH] * (power + 1.0) * columns[WIDTH] ** power).T)
    bernstein[:, 0], bernstein[:, -1] = columns[START], columns[END]
    owner, left, width = numpy.arange(len(bernstein)), numpy.zeros(len(bernstein)), 1.0
    found = []
    for halving in range(HALVINGS + 1):
        negative = bernstein < 0
        changes = numpy.count_nonzero(negative[:, 1:] != negative[:, :-1], axis=1)
        # so close together, two zeros are as good as none, and three as one
        single = changes % 2 == 1 if halving == HALVINGS else changes == 1
        begin = left[single]
        found.append((owner[single], begin, begin + width, bernstein[single, 0] < 0))
        several = changes > 1
        if not several.any():
            break
        owner, left, (lower, upper) = owner[several], left[several], halves(bernstein[several])
        width /= 2
        owner, left = numpy.tile(owner, 2), numpy.concatenate((left, left + width))
        bernstein = numpy.concatenate((lower, upper))
    owner, left, right, rising = (numpy.concatenate(one) for one in zip(*found, strict=True))
    order = numpy.lexsort((left, owner))
    return owner[order], left[order], right[order], rising[order]


def _between(polynomials: Array, *given: Array) -> Array:
    """The only zero of the rate between two places of each step; see ``_nearer``."""
    inputs = numpy.concatenate((polynomials, given))
    nearer = _nearer(len(inputs) - 4)
    place, at = numpy.empty(inputs.shape[1]), numpy.arange(inputs.shape[1])
    for _ in range(ITERATIONS):
        found = nearer(numpy.ascontiguousarray(inputs), **ALONE)
        place[at] = found[2]
        moving = ~(numpy.abs(found[3]) <= SETTLED)
        if not moving.any():
            break
        at, inputs = at[moving], inputs[:, moving]
        inputs[-3:] = found[:3, moving]
    return place


def halves(bernstein: Array) -> tuple[Array, Array]:
    """Bernstein coefficients on the lower and the upper half, of polynomials in rows."""
    size = bernstein.shape[1]
    found = _halves(size)(bernstein.T.copy(), **ALONE)
    return found[:size].T, found[size:].T


@cache
def to_bernstein(size: int) -> Array:
    """Matrix from coefficients of 1, x, x^2, ... (a row) to those of the Bernstein polynomials."""
    last = size - 1
    return numpy.array(
        [[comb(j, i) / comb(last, i) if i <= j else 0.0 for j in range(size)] for i in range(size)]
    )


# ---- compiled ------------------------------------------------------------------------------


@cache
def _halves(size: int) -> Array:
    """De Casteljau's algorithm."""
    given = row = variables("c", size)
    lower: list[Array] = []
    upper: list[Array] = []
    for _ in range(size):
        lower.append(row[0])
        upper.insert(0, row[-1])
        row = [(one + other) * 0.5 for one, other in itertools.pairwise(row)]
    return heyoka.cfunc([*lower, *upper], vars=given)


@cache
def _states(entries: int, terms: int) -> Callable[..., Array]:
    """From the series of all entries and the time since: the state."""
    series = [variables(f"c{entry}_", terms) for entry in range(entries)]
    since = heyoka.make_vars("since")
    return heyoka.cfunc(
        [horner(one, since) for one in series], vars=[*itertools.chain(*series), since]
    )


@cache
def _nearer(terms: int) -> Callable[..., Array]:
    """Some steps of Newton's to a zero of the rate, and bisections where they lead away.

    From its coefficients but the first, length of the step, whether the rate rises (1) or falls
    (-1), and three places in the step, from 0 to 1: two that have the zero between them, and where
    to begin. To the three places nearer to it, and how far Newton last went, more than 1 if
    nowhere.
    """
    heights = variables("c", terms - 1)
    width, sign, left, right, place = heyoka.make_vars("width", "sign", "left", "right", "place")
    power, rate = heyoka.expression(1.0), []
    for j, one in enumerate(heights):
        rate.append((j + 1.0) * one * power)
        power = power * width
    slope = [(j + 1.0) * one for j, one in enumerate(rate[1:])]
    inputs, move = [*heights, width, sign, left, right, place], heyoka.expression(0.0)
    for _ in range(NEWTON_STEPS):
        value = horner(rate, place)
        newton = place - value / horner(slope, place)
        before = heyoka.lt(value * sign, 0.0)
        left, right = heyoka.select(before, place, left), heyoka.select(before, right, place)
        inside = heyoka.logical_and(
            [heyoka.gte(newton, left - SETTLED), heyoka.lte(newton, right + SETTLED)]
        )
        clipped = heyoka.select(heyoka.lt(newton, left), left, newton)
        clipped = heyoka.select(heyoka.gt(clipped, right), right, clipped)
        move = heyoka.select(inside, newton - place, 2.0)
        place = heyoka.select(inside, clipped, (left + right) / 2.0)
    return heyoka.cfunc([left, right, place, move], vars=inputs)


def variables(letter: str, count: int) -> list[Scalar]:
    """Symbols of heyoka's: the letter with 0, 1, 2, ..."""
    return list(heyoka.make_vars(*(f"{letter}{n}" for n in range(count))))
