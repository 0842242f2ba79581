"""Smallest and largest values of quantities along many trajectories.

A quantity is evaluated at a few times of each step. Steps whose largest value may exceed the
largest value of the row, judged by the spread of the values, are kept. In these steps the times
converge to the extreme value, so no peak inside a step is missed. The centre of mass is at the
height R (1 - alpha k.z), so g_n = m g - m R alpha (k.z)_ddot, gliding or rolling. Therefore the
smallest normal force, a column of every row, follows from the polynomial of k.z alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy

from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.values import Array
from tt_precise.sweeps.columns import SMALLEST_FORCE, Statistic
from tt_precise.sweeps.events import ALONE, BatchSteps, exactly, horner, states_in, variables
from tt_precise.taylor.series import Sized, SizedFunctions

heyoka = import_heyoka()

NODES = numpy.linspace(0, 1, 5)
FINER = numpy.linspace(0, 1, 9)
OVERSHOOT = 1 / 8  # Part of the spread of the values by which values between them may be larger.
RESOLVED = 2.0**-6  # Part of the spread that a parabola through every other value may be off.
ROUNDING = 2.0**-45  # Part of the size of a quantity's terms below which values are rounding.
LARGEST_ROTATION = (
    0.5  # rad; where the axis' azimuth turns more between places, a peak may lie between them
)
CLOSE = 2.0**-27  # Part of a step: so near to its peak a parabola loses 2^-54 of its height.
MOST_HELD = 20_000  # Steps kept in memory; each takes 1.5 kB.


class _Candidates(NamedTuple):
    """Steps that may contain an extreme value: rows, upper bounds, times, lengths, series."""

    row: Array
    ceiling: Array
    begin: Array
    width: Array
    series: Array

    def only(self, chosen: Array) -> _Candidates:
        """The steps at some positions, or where a mask is True."""
        return _Candidates(*(column[..., chosen] for column in self))


class Extreme:
    """A finder of the smallest or largest value of one quantity in each row."""

    def __init__(self, form: Formulation, statistic: Statistic):
        self.statistic, self._form = statistic, form
        self._force = statistic == SMALLEST_FORCE
        self._sign = -1.0 if statistic.kind == "min" else 1.0
        self._quantity = QUANTITIES[statistic.quantity]
        self._components = (form.columns.index("kz"),) if self._force else ()
        # near a pole it may have peaks far narrower than a step
        self._nodes = NODES if self._quantity.pole else FINER

    def open(self, bodies: Array) -> None:
        """Begin with rows whose bodies have these parameters, shape (parameters, rows)."""
        self._bodies, rows = bodies, bodies.shape[1]
        # the last one of these is for empty lanes
        self._best = numpy.full(rows + 1, -numpy.inf)  # of the values so far
        self._highest = numpy.full(rows + 1, -numpy.inf)  # of those that were closed in on
        self._when = numpy.full(rows + 1, numpy.inf)
        self._states = numpy.full((rows + 1, len(self._form.columns)), numpy.nan)
        self._held: list[_Candidates] = []

    def search(self, steps: BatchSteps) -> None:
        """Search some steps."""
        row, width = steps.row.ravel(), steps.width.ravel()
        series = steps.all_series(*self._components)
        values, turns = self._sampled(row, series, width * self._nodes[:, None])
        ceiling, largest = peak_bound(values, turns)
        belongs = numpy.flatnonzero(steps.belongs)
        numpy.fmax.at(self._best, row[belongs], largest[belongs])
        may = belongs[ceiling[belongs] >= self._best[row[belongs]]]
        step, lane = numpy.divmod(may, steps.row.shape[1])
        series = steps.columns(step, lane)
        self._held.append(
            _Candidates(row[may], ceiling[may], steps.begin[step, lane], width[may], series)
        )
        if sum(len(steps.row) for steps in self._held) > MOST_HELD:
            self._close_in()

    def states(self) -> tuple[Array, Array]:
        """Rows, and the states in which the quantity is extreme, if defined."""
        self._close_in()
        rows = numpy.flatnonzero(numpy.isfinite(self._when[:-1]))
        return rows, self._states[rows]

    def _close_in(self) -> None:
        if not self._held:
            return
        parts = [steps.only(steps.ceiling >= self._best[steps.row]) for steps in self._held]
        held = _Candidates(*(numpy.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))
        self._held = []
        series = held.series[list(self._components)] if self._components else held.series
        highest, place = numpy.full(len(held.row), -numpy.inf), numpy.zeros(len(held.row))
        owner = numpy.arange(len(held.row))
        low, size = numpy.zeros(len(owner)), numpy.ones(len(owner))
        apart = 1 / (len(self._nodes) - 1)
        while len(owner):
            at = low + size * self._nodes[:, None]
            row = held.row[owner]
            values, turns = self._sampled(row, series[:, :, owner], held.width[owner] * at)
            ceiling, largest = peak_bound(values, turns)
            gain = numpy.zeros(len(owner))  # a smaller difference is rounding
            unresolved = numpy.flatnonzero(numpy.isinf(ceiling))
            if len(unresolved):
                some = owner[unresolved]
                since = held.width[some] * at[:, unresolved]
                gain[unresolved] = self._rounding(row[unresolved], series[:, :, some], since)
                ceiling[unresolved], _ = peak_bound(
                    values[:, unresolved], turns[unresolved], gain[unresolved]
                )
            best = values.argmax(axis=0)
            order = numpy.lexsort((-at[best, numpy.arange(len(owner))], largest))
            order = order[largest[order] > highest[owner[order]]]  # the last one stays
            highest[owner[order]] = largest[order]
            place[owner[order]] = at[best[order], order]
            numpy.fmax.at(self._best, row, largest)
            further = (ceiling >= self._best[row]) & (ceiling > largest + gain) & (size > CLOSE)
            single = further & numpy.isfinite(ceiling)
            halved = further & ~single
            # between the neighbours of the highest node
            around = low + size * apart * numpy.clip(best - 1, 0, len(self._nodes) - 3)
            owner = numpy.concatenate((owner[single], owner[halved], owner[halved]))
            low = numpy.concatenate((around[single], low[halved], (low + size / 2)[halved]))
            size = numpy.concatenate((2 * apart * size[single], *[size[halved] / 2] * 2))
        self._keep(held, highest, place)

    def _keep(self, peaks: _Candidates, highest: Array, position: Array) -> None:
        """Keep the state of the highest value of each row, the first among equal values."""
        when = peaks.begin + position * peaks.width
        order = numpy.lexsort((when, -highest, peaks.row))
        first = order[numpy.unique(peaks.row[order], return_index=True)[1]]
        row, before = peaks.row[first], self._highest[peaks.row[first]]
        new = (highest[first] > before) | (
            (highest[first] == before) & (when[first] < self._when[row])
        )
        first, row = first[new], row[new]
        self._highest[row], self._when[row] = highest[first], when[first]
        since = position[first] * peaks.width[first]
        self._states[row] = states_in(peaks.series[:, :, first], since)

    def _sampled(self, row: Array, series: Array, since: Array) -> tuple[Array, Array]:
        """The quantity, upside down for a smallest value, at times after the start of steps.

        Also whether the axis' azimuth changes by more than ``LARGEST_ROTATION`` between two times.
        """
        turns = numpy.zeros(since.shape[1], dtype=bool)
        if self._force:
            inputs = numpy.concatenate((series[0, 2:], since))
            curvature = _curvature(len(series[0]) - 2, len(since))
            return curvature(numpy.ascontiguousarray(inputs), **ALONE), turns
        body, state = self._states_at(row, series, since)
        q = self._form.motion(body, state, numpy)
        values: Array = self._sign * self._quantity.evaluate(q) * numpy.ones(since.shape)
        if not self._quantity.pole:
            across = state.kx[:-1] * state.ky[1:] - state.ky[:-1] * state.kx[1:]
            along = state.kx[:-1] * state.kx[1:] + state.ky[:-1] * state.ky[1:]
            turns = (numpy.abs(across) > math.tan(LARGEST_ROTATION) * along).any(axis=0)
        return values, turns

    def _rounding(self, row: Array, series: Array, since: Array) -> Array:
        """Bounds of the rounding errors of ``_sampled`` values, shape (steps,)."""
        body, state = self._states_at(row, series, since)
        sized = self._form.State(*(Sized(x, numpy.abs(x)) for x in state))
        q = self._form.motion(body.numbers(exactly), sized, SizedFunctions())
        found = self._quantity.evaluate(q)
        size = getattr(found, "size", 0.0) * numpy.ones(since.shape)
        bounds: Array = ROUNDING * size.max(axis=0)
        return bounds

    def _states_at(self, row: Array, series: Array, since: Array) -> tuple[Parameters, Any]:
        states = states_in(series, *since)
        body = self._form.body(self._bodies[:, row])
        return body, self._form.State(*numpy.moveaxis(states, -1, 0))


def peak_bound(
    values: Array, turns: Array | bool = False, rounding: Array | float = 0.0
) -> tuple[Array, Array]:
    """An upper bound of a quantity between nodes, and its largest value at a node.

    Infinite where the values, which have errors of ``rounding``, or ``turns`` of the axis do not
    resolve it.
    """
    largest, smallest = values.max(axis=0), values.min(axis=0)
    spread = largest - smallest
    ceiling = largest + OVERSHOOT * spread
    if len(values) == len(FINER):
        even, odd = values[::2], values[1::2]
        middle = (9 * (even[1:3] + even[2:4]) - even[:2] - even[3:]) / 16
        first = (5 * even[0] + 15 * even[1] - 5 * even[2] + even[3]) / 16
        last = (5 * even[4] + 15 * even[3] - 5 * even[2] + even[1]) / 16
        off = numpy.abs(numpy.stack((first, *middle, last)) - odd).max(axis=0)
        known = numpy.maximum(rounding, ROUNDING * numpy.abs(largest))
        rough = turns | (off > RESOLVED * spread + known)
        ceiling = numpy.where(rough, numpy.inf, ceiling)
    return ceiling, largest


@cache
def _curvature(terms: int, times: int) -> Callable[..., Array]:
    """The second derivative of a series at times, from the coefficients of h^2, h^3, ..."""
    series = variables("c", terms)
    second = [(j + 1.0) * (j + 2.0) * coefficient for j, coefficient in enumerate(series)]
    since = variables("since", times)
    return heyoka.cfunc([horner(second, at) for at in since], vars=[*series, *since])
