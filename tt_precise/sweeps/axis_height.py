"""What the height k.z of the symmetry axis says of a step: where theta turns, and the normal force.

k.z = cos theta, so theta turns where the rate of k.z changes sign. The centre of mass is at the
height R (1 - alpha k.z), so g_n = m g - m R alpha (k.z)_ddot, gliding or rolling: the normal force
is smallest where the second derivative of k.z is largest. Both are read off the Taylor polynomial
of k.z in each step, between Bernstein bounds, so that nothing inside a step is missed.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cache, reduce
from typing import NamedTuple

import heyoka
import numpy

from tt_precise.mechanics import newton
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.sweeps.step_polynomials import (
    ALONE,
    END,
    START,
    WIDTH,
    to_bernstein,
    variables,
    zeros,
)


class Heights(NamedTuple):
    """k.z in each step; arrays of the shape (steps, lanes).

    ``columns`` describe it (see ``read_heights``), ``curvature`` is what its second derivative
    stays below, ``at_ends`` the larger one of those at both ends, ``changes`` how many changes of
    sign its rate has at most (and by an even number fewer in fact); ``finite`` says whether these
    mean anything.
    """

    columns: Array
    curvature: Array
    at_ends: Array
    changes: Array
    finite: Array


def height_rates(form: Formulation, parameters: Array, states: Array) -> Array:
    """The rate of k.z, eq (1), in states of ``form`` whose first entries are axis and momentum."""
    kx, ky, kz, Lx, Ly, Lz = states[:6]
    q = Motion(form.body(parameters), NewtonState(kx, ky, kz, Lx, Ly, Lz, 0, 0), numpy)
    return newton.axis_rate(q.body, q.state)[2]


def read_heights(columns: Array, before: Array, last: tuple[Array, Array], rates: Array) -> Heights:
    """Bounds of k.z and its derivatives in the steps.

    Parameters
    ----------
    columns
        k.z in each step, shape (order + 3, steps, lanes): its Taylor coefficients but the first,
        the length of the step, and two rows that are filled in here: its rates at the start and at
        the end, whose signs decide about zeros.
    before
        Rates of k.z where the first steps begin, NaN where a trajectory starts there; shape
        (lanes,).
    last, rates
        The steps (and lanes) that are not followed by another one of their trajectory here, and the
        rates where they end.
    """
    columns[START] = columns[0]
    first, end = columns[START], columns[END]
    # where one step ends the next begins, so that no turn between them is lost or found twice
    first[0] = numpy.where(numpy.isnan(before), first[0], before)
    end[:-1] = first[1:]
    end[last] = rates
    return bounds(columns)


def turning_points(
    read: Heights, ends: Array, climb: Array, every: Array
) -> tuple[Array, Array, Array, Array]:
    """The turning points of theta.

    Parameters
    ----------
    ends, climb
        When the steps end, and when theta first rises through pi/2; shape (steps, lanes).
    every
        Whether all are wanted; else only minima before the climb and maxima after it.

    Returns
    -------
    Which step (a position in the flat arrays), the time since its start, the time, and whether
    k.z begins to rise there: four arrays.
    """
    columns = read.columns
    at = numpy.flatnonzero((read.changes > 0) & (columns[WIDTH] != 0) & read.finite)
    flat = columns.reshape(len(columns), -1)
    end, climb, every, changes = (one.ravel()[at] for one in (ends, climb, every, read.changes))
    begun = end - flat[WIDTH, at]
    # before the zeros are looked for; a step with several ones is decided by these
    may = every | (changes > 1) | numpy.where(flat[START, at] < 0, end > climb, begun < climb)
    at, begun, climb, every, changes = (one[may] for one in (at, begun, climb, every, changes))
    owner, since, rising = zeros(flat.take(at, axis=1), changes)
    time = begun[owner] + since
    # where k.z begins to fall theta begins to rise: a minimum
    wanted = every[owner] | ((time > climb[owner]) == rising)
    return at[owner[wanted]], since[wanted], time[wanted], rising[wanted]


def bounds(columns: Array) -> Heights:
    """Bounds from the columns of ``read_heights``."""
    rows, steps, lanes = columns.shape
    inputs = numpy.ascontiguousarray(columns.reshape(rows, -1))
    found = _bounds(rows - 2)(inputs, **ALONE).reshape(-1, steps, lanes)
    curvature, at_ends, changes, total = found
    return Heights(columns, curvature, at_ends, changes, numpy.isfinite(total))


@cache
def _bounds(terms: int) -> Callable[..., Array]:
    """From a column of ``read_heights``: three bounds and a sum.

    The sum is finite only if the others mean anything.
    """
    heights = variables("c", terms - 1)
    width, first, last = heyoka.make_vars("width", "first", "last")
    power, curvature = heyoka.expression(1.0), []
    for j, one in enumerate(heights[1:]):
        curvature.append((j + 1.0) * (j + 2.0) * one * power)
        power = power * width
    matrix = to_bernstein(len(curvature)).tolist()
    curvature = [
        sum((row[i] * one for row, one in zip(matrix[: i + 1], curvature, strict=False)))
        for i in range(len(curvature))
    ]
    # the integral: from one coefficient of the rate to the next
    rise = [one * (width / len(curvature)) for one in curvature]
    rate = list(itertools.accumulate(rise, initial=heights[0]))
    signs = [first, *rate[1:-1], last]
    negative = [heyoka.lt(one, 0.0) for one in signs]
    changes = sum(heyoka.neq(*pair) for pair in itertools.pairwise(negative))
    results = (
        reduce(_larger, curvature),
        _larger(curvature[0], curvature[-1]),
        changes,
        sum(curvature) + sum(rate),
    )
    return heyoka.cfunc(results, vars=[*heights, width, first, last])


def _larger(first: Scalar, second: Scalar) -> Scalar:
    return heyoka.select(heyoka.gt(first, second), first, second)
