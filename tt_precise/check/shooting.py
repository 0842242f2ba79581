"""Every row followed to the next one by the scene's own equations: where a quadrature fails.

Rates at both ends of an interval say what lies between them only if the ends belong to nearly the
same motion. A trajectory of other equations has no such motion, and its wide intervals would stay
open. The solution through the row alone is always there: it is followed in Taylor steps, all rows
at once, together with a neighbour, which says how far a difference at the row has grown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy

from tt_precise.mechanics.taylor import solution
from tt_precise.runtime.arithmetic import Scalar

EPS = float(numpy.finfo(float).eps)
TERMS = 20  # Taylor coefficients: for eps, half its digits in base e, and two
STEP = math.exp(-2)  # of the radius of convergence: the last of TERMS coefficients is then eps
MOST_STEPS = 32
NUDGE = 1e-7  # of the size: far above rounding, far below what is not linear any more
ROUNDED = 4.0  # eps: a row is rounded in two numbers of either end
A_STEP = 2.0  # eps that a Taylor step adds


class Followed(NamedTuple):
    """Where the solutions through rows are after their spans.

    ``state`` has shape (entries, rows). ``error`` bounds what rounding, of the rows and of the
    steps, has made of it, relative to the sizes; infinite where the end was not reached.
    ``reached`` is the time in s up to which the error stayed below what was wanted.
    """

    state: numpy.ndarray
    error: numpy.ndarray
    reached: numpy.ndarray


def follow(
    rates: Callable[[tuple[Scalar, ...]], Sequence[Scalar]],
    start: numpy.ndarray,
    spans: numpy.ndarray,
    sizes: numpy.ndarray,
    wanted: float,
) -> Followed:
    """The solutions that start at the columns of ``start``, each after its span (s).

    ``sizes`` (entries,) is what a difference of each entry is measured in; a solution whose error
    has come above ``wanted`` is given up.
    """
    size = sizes[:, None]
    signs = numpy.where(numpy.arange(len(start)) % 2, -1.0, 1.0)[:, None]
    here = numpy.stack((start, start + NUDGE * signs * size), axis=2)
    t, error = numpy.zeros(len(spans)), numpy.full(len(spans), ROUNDED * EPS)
    open_ = numpy.arange(len(spans))
    for count in range(1, MOST_STEPS + 1):
        both = here[:, open_].reshape(len(start), -1)
        c = numpy.array([entry.c for entry in solution(rates, list(both), TERMS)])
        c = c.reshape(len(start), TERMS + 1, len(open_), 2)
        h = numpy.minimum(_step(abs(c[:, :, :, 0]) / sizes[:, None, None]), spans[open_] - t[open_])
        ahead = _at(c, h)
        growth = (abs(ahead[:, :, 1] - ahead[:, :, 0]) / size).max(axis=0) / NUDGE
        found = EPS * (ROUNDED + A_STEP * count) * numpy.maximum(growth, 1.0)
        good = (found <= wanted) & (h > 0)  # neither where a state is no number
        open_, h = open_[good], h[good]
        here[:, open_], error[open_] = ahead[:, good], found[good]
        t[open_] += h
        open_ = open_[t[open_] < spans[open_]]
        if not len(open_):
            break
    error[t < spans] = numpy.inf
    return Followed(here[:, :, 0], error, t)


def _step(sizes: numpy.ndarray) -> numpy.ndarray:
    """Length of the step (s) of each row, from the sizes of its coefficients; NaN if there is none.

    The last two coefficients stand for the radius of convergence, as in Jorba and Zou, Experimental
    Mathematics 14 (2005) 99.
    """
    last, before = sizes[:, -1].max(axis=0), sizes[:, -2].max(axis=0)
    return STEP * numpy.minimum(last ** (-1 / TERMS), before ** (-1 / (TERMS - 1)))


def _at(c: numpy.ndarray, h: numpy.ndarray) -> numpy.ndarray:
    total = c[:, -1]
    for k in range(c.shape[1] - 2, -1, -1):
        total = total * h[:, None] + c[:, k]
    return total
