"""The flow of a scene's equations: many states, each propagated over its own span of time.

The explicit midpoint rule in 2, 4, 6, ... steps is extrapolated to steps of length zero (Gragg's
method; Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.9). Each column of
the scheme raises the order by two: dense rows need few evaluations, coarse rows more. A row is done
when a column changes its result by less than the tolerance; this change is the error of the column
before, and bounds the error of the last column. If twelve columns do not suffice, the span is
halved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy

from tt_precise.mechanics import compliant
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import Formulation, formulation
from tt_precise.mechanics.friction import cone_margin
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Array
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
ON_TABLE = 1e-9  # Part of R up to which the lowest point touches a rigid table.
COLUMNS = 12  # Most columns of the extrapolation: beyond, rounding grows faster than errors fall.
# The column at whose eight midpoint steps a neighbour is carried along and a function is watched.
WATCHED = 4
MOST_STEPS = 32  # Steps to the end of a span: what the widest rows may cost.
# Part of a span; a row that needs smaller steps does not follow the equations.
SMALLEST = 2.0**-16
# Rows whose reach is sought where ``MOST_STEPS`` of their steps do not reach the end: only the
# spacing that would do depends on them.
FEW = 8
WIDEST = 1e-6  # Error from which on a row is not carried further: no usual limit is above it.
# Of the size, by which a neighbour is aside: rounding is 2e-9 of it, and what is not linear 1e-7.
NUDGE = 1e-7
AT_ONCE = 2048  # Rows whose arrays stay in the processor's cache.
State = NewtonState | LiftedState
Rates = Callable[[Array], Sequence[Array]]
Watch = Callable[[Array], Array]


class FlowEnd(NamedTuple):
    """Rows after their spans.

    ``state`` (entries, rows) is where they are. ``error`` (rows,) bounds what the method leaves,
    relative to the sizes, infinite where the end was not reached. ``growth`` (rows,) is the number
    of times, to a quarter, that a small difference of two states has become, 1 where it shrinks.
    ``reached`` is the part of the span to which the error stayed below ``WIDEST``, NaN where nobody
    asked, as the end is out of reach; ``least`` is a lower bound of what was watched on the way.
    """

    state: Array
    error: Array
    growth: Array
    reached: Array
    least: Array


def propagate(
    rates: Rates,
    start: Array,
    spans: Array,
    sizes: Array,
    wanted: Array,
    watch: Watch | None = None,
    most: int = MOST_STEPS,
) -> FlowEnd:
    """Carry the columns of ``start`` over their ``spans`` (s, of either sign) under ``rates``.

    ``sizes`` (entries,) is what a difference of each entry is measured in, ``wanted`` (rows,) the
    error that may be left, ``watch`` a function of states whose least value is asked for.
    Rows whose end ``most`` steps do not reach stay behind.
    """
    count, scale = len(spans), (NUDGE * sizes)[:, None]
    change, (error, reached, steps) = numpy.zeros_like(start), numpy.zeros((3, count))
    growth, part, left = *numpy.ones((2, count)), numpy.arange(count)
    least, every = numpy.full(count, numpy.inf), max(1, count // FEW)
    aside = scale * numpy.where(numpy.arange(len(start)) % 2, -1.0, 1.0)[:, None]
    aside = numpy.repeat(aside, count, axis=1)
    with numpy.errstate(all="ignore"):
        while len(left):
            step = _Extrapolation(rates, start[:, left] + change[:, left], part[left] * spans[left])
            step.run(aside[:, left], sizes, wanted[left], watch)
            moved = numpy.maximum((abs(aside[:, left] + step.moved) / scale).max(axis=0), 1.0)
            # what the steps before have left grows with the distance of the neighbour
            total = error[left] * numpy.maximum(moved / growth[left], 1.0) + step.error
            good = total <= WIDEST
            on = left[good]
            change[:, on] += step.change[:, good]
            aside[:, on] += step.moved[:, good]
            growth[on] = moved[good]
            error[on] = total[good]
            least[on] = numpy.fmin(least[on], step.least[good])
            reached[on] += part[on]
            steps[on] += 1
            part[left[~good]] /= 2
            ends = reached[left] + (most - steps[left]) * part[left] >= 1
            # the end is out of reach: a first step of a few rows says how far they would come
            first, lost = left[good & ~ends], left[~good & ~ends]
            allowed = numpy.minimum(WIDEST / error[first], MOST_STEPS)
            reached[first] = numpy.where(steps[first] == 1, part[first] * allowed, reached[first])
            lost = lost[steps[lost] == 0]
            sought = (lost % every == 0) & (most == MOST_STEPS)
            reached[lost[~sought]] = numpy.nan
            searched = lost[sought & (part[lost] >= SMALLEST)]
            left = numpy.concatenate((left[ends & (reached[left] < 1)], searched))
    error[~(reached == 1)] = numpy.inf
    return FlowEnd(start + change, error, growth, reached, least)


class _Extrapolation:
    """One step of each row.

    ``change`` is the best result, ``error`` its bound, infinite where more columns do not help;
    ``moved`` is the change of the distance of a neighbour.
    """

    def __init__(self, rates: Rates, start: Array, spans: Array):
        self._rates, self._start, self._spans = rates, start, spans
        self.change, self.moved = numpy.zeros((2, *start.shape))
        self.error, self.least = numpy.full((2, len(spans)), numpy.inf)

    def run(self, aside: Array, sizes: Array, wanted: Array, watch: Watch | None) -> None:
        """Add columns until every row is done, or does not come nearer any more."""
        size, left = sizes[:, None], numpy.arange(len(self._spans))
        start, spans = self._start, self._spans
        slope = self._slope(start)
        row: list[Array] = []
        weights: list[float] = []
        before = numpy.full(len(left), numpy.inf)
        for column in range(1, COLUMNS + 1):
            watched: list[Array] | None = [] if watch and column == WATCHED else None
            last, row, old = row, [self._midpoint(start, slope, spans, column, watched)], weights
            if watch and watched:
                self.least[left] = _least(numpy.array([watch(y) for y in watched]))
            weights = [1.0]
            for j, (coarse, heavy) in enumerate(zip(last, old, strict=True)):
                share = 1 / ((column / (column - 1 - j)) ** 2 - 1)
                row.append(row[j] + share * (row[j] - coarse))
                weights.append(weights[j] * (1 + share) + heavy * share)
            if column == 1:
                continue
            if column == WATCHED:
                beside = start + aside[:, left]
                moved = self._midpoint(beside, self._slope(beside), spans, column, None)
                self.moved[:, left] = moved - row[0]
            error = (abs(row[-1] - last[-1]) / size).max(axis=0)
            # two roundings: those of the slopes, and of the sums
            rounding = 2 * EPS * weights[-1] * (abs(row[-1]) / size).max(axis=0)
            enough = error <= numpy.maximum(wanted[left], rounding)
            done = enough & (column >= WATCHED)
            at = left[done]
            self.change[:, at], self.error[at] = row[-1][:, done], (error + rounding)[done]
            more = ~done & (enough | (error < before))  # false where a state is NaN
            if not more.any():
                return
            if more.all():
                before = error
                continue
            left, before = left[more], error[more]
            start, slope, spans = start[:, more], slope[:, more], spans[more]
            row = [entries[:, more] for entries in row]

    def _slope(self, state: Array) -> Array:
        slope = numpy.empty_like(state)
        for entry, rate in zip(slope, self._rates(state), strict=True):
            entry[:] = rate
        return slope

    def _midpoint(
        self, start: Array, slope: Array, spans: Array, column: int, watched: list[Array] | None
    ) -> Array:
        """The change by 2 ``column`` steps; their states are appended to ``watched``."""
        h = spans / (2 * column)
        before, change = numpy.zeros_like(start), h * slope
        for _ in range(2 * column - 1):
            here = start + change
            if watched is not None:
                watched.append(here)
            before, change = change, before + 2 * h * self._slope(here)
        return change


def _least(values: Array) -> Array:
    """A lower bound of a function with these values (points, rows) at even distances.

    Between points it dips below them by an eighth of its second difference at most; the states of
    a midpoint rule deserve all of it.
    """
    bent = abs(numpy.diff(values, n=2, axis=0)).max(axis=0)
    least: Array = values.min(axis=0) - bent
    return least


class RowsUnder(NamedTuple):
    """Rows (a mask, or all) that obey one formulation, in vectors."""

    rows: Array | slice
    form: Formulation


def rows_under(scene: Scene, body: Parameters, state: State) -> list[RowsUnder]:
    """The rows of ``state`` grouped by their equations, without empty groups."""
    gliding = formulation(scene.model, "newton", scene.body.friction)
    on_table = numpy.ones(len(state.kx), bool)
    candidates: list[tuple[Array, Formulation]] = []
    if isinstance(state, LiftedState):
        from tt_precise.nonsmooth.phases import elastic_in_time, raised  # with mpmath

        if scene.model == "flight":
            return [RowsUnder(slice(None), raised())]
        if body.spring:
            on_table = (state.height < 0) & (compliant.pull(body, state.height, state.rise) < 0)
            gliding = elastic_in_time(body.spring, body.friction)
        else:
            on_table = state.height <= ON_TABLE * body.R
        candidates = [(~on_table, raised())]
    rests = numpy.zeros(len(on_table), bool)
    if scene.may_stick:
        rests = on_table & (state.vx == 0) & (state.vy == 0)
    candidates += [(on_table & ~rests, gliding), (rests, formulation("rolling", "newton"))]
    there = [(rows, form) for rows, form in candidates if rows.any()]
    if len(there) == 1:  # all rows
        return [RowsUnder(slice(None), there[0][1])]
    return [RowsUnder(*pair) for pair in there]


def margin(scene: Scene, body: Parameters, form: Formulation, state: State) -> Array:
    """The function that is positive until the equations of ``form`` change.

    The contact force, the distance from the cone where the contact rests, the height in flight.
    """
    if form.model == "flight":
        return state.height if isinstance(state, LiftedState) else numpy.ones(len(state.kx))
    if form.model == "rolling" and scene.may_stick:
        distance: Array = cone_margin(body, NewtonState(*state[:8]))
        return distance
    force: Array = Motion(body, state, numpy, form.model).force[2]
    return force


def flow(
    scene: Scene,
    body: Parameters,
    state: State,
    spans: Array,
    sizes: Array,
    wanted: Array,
    *,
    watched: bool = False,
    most: int = MOST_STEPS,
) -> FlowEnd:
    """Carry rows over ``spans`` (s) under the equations that each obeys; see ``propagate``.

    ``sizes`` belong to the entries of ``state``. With ``watched``, ``least`` bounds the ``margin``
    of each row on the way.
    """
    entries = numpy.array(numpy.broadcast_arrays(*state), float)
    found = FlowEnd(entries.copy(), *numpy.full((4, len(spans)), numpy.inf))
    for rows, form in rows_under(scene, body, state):
        width = len(form.columns)
        still = (len(entries) - width) * (0.0,)

        def rates(y: Array, form: Formulation = form) -> Sequence[Array]:
            slopes: Sequence[Array] = form.rates(body, form.State(*y), numpy)
            return slopes

        def watch(y: Array, form: Formulation = form, still: tuple[float, ...] = still) -> Array:
            return margin(scene, body, form, type(state)(*y, *still))

        every = numpy.arange(len(spans))[rows]
        for first in range(0, len(every), AT_ONCE):
            at = every[first : first + AT_ONCE]
            one = propagate(
                rates, entries[:width, at], spans[at], sizes[:width], wanted[at],
                watch if watched else None, most,
            )  # fmt: skip
            found.state[:width, at] = one.state
            for all_, values in zip(found[1:], one[1:], strict=True):
                all_[at] = values
    return found
