"""The check that the table never pulls: the contact force in the rows and between the rows.

Where the force is small and the rows follow the equations, each row is propagated to eight points
before the next row, and to the minimum of the parabola through the three smallest values: a pull
may last a tenth of the spacing.
"""

from __future__ import annotations

import math

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.equations import APART, differences
from tt_precise.check.flow import EPS, flow
from tt_precise.check.result import Residual
from tt_precise.golden.solution import ending
from tt_precise.mechanics import quantities
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Array

# The last row of a motion that leaves the table has g_n = 0, which rounding makes +- some eps.
LIFT_OFF = -1e-12
# Of the weight: below it the least force is shown to more than the rows have. No verdict depends on
# it, because the flow bounds the force between rows from below.
LOW = 0.2
POINTS = 8
WANTED = 4 * EPS  # Error of the states between the rows.
BRACKETS = 64  # Into which the interval with a loss of contact is divided, three times.
AT_ONCE = 2048  # Rows that are carried to ``POINTS`` points at once.


def contact(rows: Samples, limit: float) -> Residual:
    """Return g_n over the weight, at and between the rows, with a note where g_n vanishes."""
    body = rows.setup.body
    weight = body.m * body.g
    values: Array = quantities.g_n(rows.q) / weight + numpy.zeros(len(rows.t))
    usual = numpy.minimum(values[1:], values[:-1])
    least = differences(rows).least / weight
    low = (least < max(LOW, limit)) & (usual >= limit) & _follow(rows)
    low = numpy.flatnonzero(low)
    for first in range(0, len(low), AT_ONCE):
        at = low[first : first + AT_ONCE]
        values[at + 1] = numpy.minimum(values[at + 1], _least_between(rows, at) / weight)
    pulls = numpy.flatnonzero(values < limit)
    if not len(pulls):
        return Residual(values)
    left = _loss_of_contact(rows, int(pulls[0]))
    return Residual(values, note=ending("contact_lost", left) if left < math.inf else "")


def _follow(rows: Samples) -> Array:
    """Test, for each interval, that the rows so far are those of one solution.

    An interval too wide for the flow says nothing of the next ones.
    """
    found = differences(rows)
    carried = numpy.isfinite(found.bound)
    apart = abs(numpy.cumsum(numpy.where(carried, found.state, 0.0), axis=1)).max(axis=0)
    follow: Array = (apart <= APART) & carried
    return follow


def force_after(rows: Samples, at: Array, spans: Array) -> Array:
    """Return the contact force at ``spans`` (s) after the rows ``at``; NaN beyond the flow."""
    setup = rows.setup
    here = type(rows.state)(*(entry[at] for entry in rows.state))
    sizes = numpy.array([float(abs(entry).max()) or 1.0 for entry in rows.state])
    there = flow(setup.scene, setup.body, here, spans, sizes, numpy.full(len(at), WANTED))
    q = Motion(setup.body, type(here)(*there.state), numpy, setup.scene.model)
    force: Array = quantities.g_n(q) + numpy.zeros(len(at))
    return numpy.where(numpy.isfinite(there.error), force, numpy.nan)


def _least_between(rows: Samples, at: Array) -> Array:
    """The least contact force between each of the rows ``at`` and the next row."""
    steps = numpy.diff(rows.t)[at]
    parts = numpy.arange(1, POINTS)[:, None] / POINTS
    force = force_after(rows, numpy.tile(at, POINTS - 1), (parts * steps).ravel())
    ends = quantities.g_n(rows.q) + numpy.zeros(len(rows.t))
    force = numpy.vstack((ends[at], force.reshape(POINTS - 1, -1), ends[at + 1]))
    force = numpy.where(numpy.isnan(force), numpy.inf, force)
    place = numpy.clip(force.argmin(axis=0), 1, POINTS - 1)
    before, here, after = (force[place + shift, numpy.arange(len(at))] for shift in (-1, 0, 1))
    with numpy.errstate(all="ignore"):
        lowest = (before - after) / (before - 2 * here + after) / 2
        lowest = numpy.clip(numpy.nan_to_num(lowest), -1, 1)
    there = force_after(rows, at, (place + lowest) / POINTS * steps)
    return numpy.fmin(force.min(axis=0), there)


def _loss_of_contact(rows: Samples, pulled: int) -> float:
    """The time (s) at which the solution through a row leaves the table, or infinity.

    Row ``pulled`` may be wrong, and only the solution to it leave the table: the solutions
    through the row before and through it are asked.
    """
    follow = _follow(rows)
    for row in (pulled - 1, pulled):
        if not 0 <= row < len(follow) or not follow[row]:
            continue
        begin, end = 0.0, float(rows.t[row + 1] - rows.t[row])
        for _ in range(3):
            spans = numpy.linspace(begin, end, BRACKETS + 1)
            force = force_after(rows, numpy.full(len(spans), row), spans)
            below = numpy.flatnonzero(force <= 0)
            if not len(below) or below[0] == 0:
                break
            begin, end = spans[below[0] - 1], spans[below[0]]
        else:
            return float(rows.t[row] + (begin + end) / 2)
    return math.inf
