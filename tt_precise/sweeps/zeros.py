"""Find zeros of event functions along the Taylor steps of many motions.

The cubic through value and rate at both ends of an interval decides: the function has no zero
there, or one, or it is unclear, and the interval is halved. Newton's method on the function itself
follows. The bits of a zero do not depend on other motions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy

from tt_precise.integration.equations import Equations, along
from tt_precise.integration.events import Event
from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.terminal import import_heyoka
from tt_precise.runtime.values import Array
from tt_precise.sweeps.batch import LaneSteps, states_in
from tt_precise.taylor.interpolation import zero_between
from tt_precise.taylor.series import Sized, SizedFunctions

heyoka = import_heyoka()
concatenate = partial(numpy.concatenate, axis=-1)

# A step is a seventh of the radius of convergence, in which the nutation turns by 2 rad at most.
# The cubic of such a cosine is off by 2^4/384 = 1/24 of the amplitude, and its largest coefficient
# is a third of the amplitude or more.
MARGIN = 1 / 8  # Part of the largest coefficient of a cubic that may hide two zeros.
BISECTIONS = 26  # Halvings of a step, after which two zeros count as none, and three as one.
# A function whose value at the start is below 30 roundings of its terms vanishes there.
VANISHING = 2.0**-48
FIRST_MOMENT = 2.0**-6  # Part of its first step after which such a function is read.
# Corrections by Newton's method are squared from one to the next, relative to the distance on which
# the rate changes; the first omitted correction is below this part of the time in the step.
SETTLED = 2.0**-53
MOST_CORRECTIONS = 60  # Most are halvings, where Newton's method leaves the bracket.
CLIMB, TURN = "equator", "theta_min"  # Events.


class RowZeros(NamedTuple):
    """Zeros of functions: numbers of function and motion, time, whether it rises, and state.

    Times and states are dimensionless; ``state`` has the shape (components, zeros).
    """

    event: Array
    row: Array
    time: Array
    rising: Array
    state: Array


class Brackets(NamedTuple):
    """Parts of steps in which functions may vanish.

    ``low`` and ``size`` are in units of the step; ``ends`` are value and rate (per interval) at the
    beginning, and at the end, shape (4, intervals).
    """

    event: Array
    step: Array
    low: Array
    size: Array
    ends: Array


class ZeroSearch:
    """A search for the zeros of ``events`` along motions of tops with ``bodies``.

    ``bodies`` has the shape (parameters, motions), and ``starts``, the states at t = 0, the shape
    (components, motions).
    """

    def __init__(self, form: Formulation, bodies: Array, starts: Array, events: Sequence[Event]):
        self._form, self._bodies = form, bodies
        self._names = [event.name for event in events]
        self._functions = _compiled(form, tuple(events))
        self._vanish = vanishing(form, bodies, starts, events)
        none = numpy.zeros(0, dtype=int)
        nothing = numpy.empty((len(form.columns), 0))
        self._zeros = [RowZeros(none, none, numpy.zeros(0), none > 0, nothing)]

    def search(self, steps: LaneSteps) -> None:
        """Search a block of steps."""
        begin = self._values(steps.states, steps.row)
        end = steps.at_ends(begin, self._values(steps.ends, steps.row[steps.last]))
        ends = numpy.array((begin[0], begin[1] * steps.width, end[0], end[1] * steps.width))
        event, step = numpy.nonzero(classified(ends)[0])
        whole = numpy.ones(len(step))
        brackets = Brackets(event, step, 0 * whole, whole, ends[:, event, step])
        isolated = self._isolated(steps, self._without_start(steps, brackets))
        self._zeros.append(self._refined(steps, isolated))

    def zeros(self, name: str) -> RowZeros:
        """Return the zeros of an event function, ordered by motion and time."""
        self._zeros = [RowZeros(*map(concatenate, zip(*self._zeros, strict=True)))]
        (zeros,) = self._zeros
        chosen = numpy.flatnonzero(zeros.event == self._names.index(name))
        order = chosen[numpy.lexsort((zeros.time[chosen], zeros.row[chosen]))]
        return RowZeros(*(column[..., order] for column in zeros))

    def _without_start(self, steps: LaneSteps, brackets: Brackets) -> Brackets:
        """Let functions that vanish at the start begin a moment later."""
        vanish = self._vanish[brackets.event, steps.row[brackets.step]]
        at_start = (steps.begin[brackets.step] == 0) & vanish
        starts = _only(brackets, at_start)
        low = numpy.full(len(starts.step), FIRST_MOMENT)
        value, rate = self._at(steps, starts, low)
        shorter = numpy.array([[1], [1 - FIRST_MOMENT]] * 2)
        ends = shorter * (value, rate, *starts.ends[2:])
        return _join(_only(brackets, ~at_start), starts._replace(low=low, size=1 - low, ends=ends))

    def _isolated(self, steps: LaneSteps, brackets: Brackets) -> Brackets:
        """Halve intervals until each has one zero."""
        isolated = []
        for _ in range(BISECTIONS):
            may, single = classified(brackets.ends)
            isolated.append(_only(brackets, may & single))
            brackets = _only(brackets, may & ~single)
            if not len(brackets.step):
                break
            half = brackets.size / 2
            value, rate = self._at(steps, brackets, brackets.low + half)
            first, slope, last, last_slope = brackets.ends * [[1], [0.5], [1], [0.5]]
            middle = value, rate / 2
            lower = brackets._replace(size=half, ends=numpy.array((first, slope, *middle)))
            upper = numpy.array((*middle, last, last_slope))
            brackets = _join(lower, lower._replace(low=brackets.low + half, ends=upper))
        changing = (brackets.ends[0] < 0) != (brackets.ends[2] < 0)
        return _join(*isolated, _only(brackets, changing))

    def _refined(self, steps: LaneSteps, brackets: Brackets) -> RowZeros:
        """Return the zero in each interval."""
        first, slope, last, last_slope = brackets.ends
        rising, gap = first < 0, last - first
        quadratic, cubic = 3 * gap - 2 * slope - last_slope, slope + last_slope - 2 * gap
        cubics = numpy.array((first, slope, quadratic, cubic))
        direction = numpy.where(rising, 1, -1)
        start, _ = zero_between(cubics, 0 * gap, 0 * gap + 1, direction, -first / gap)
        series = steps.series(brackets.step)

        def of_function(at: Array, chosen: Array) -> tuple[Array, Array]:
            mine = series if len(chosen) == len(gap) else series.take(chosen, axis=2)
            value, rate = self._at(steps, _only(brackets, chosen), at, mine)
            return value, rate / brackets.size[chosen]

        # the rate may vanish at an end of the interval, and then changes on the way from there
        distance = brackets.size * numpy.minimum(start, 1 - start)
        bracket = brackets.low, brackets.low + brackets.size
        first_guess = brackets.low + brackets.size * start
        at = refined(of_function, bracket, first_guess, rising, distance)
        row, since = steps.row[brackets.step], at * steps.width[brackets.step]
        time, state = steps.begin[brackets.step] + since, states_in(series, since)
        return RowZeros(brackets.event, row, time, rising, state)

    def _at(
        self, steps: LaneSteps, brackets: Brackets, at: Array, series: Array | None = None
    ) -> tuple[Array, Array]:
        """Return values and rates (per interval) of functions at positions in units of steps."""
        series = steps.series(brackets.step) if series is None else series
        width, mine = steps.width[brackets.step], (brackets.event, numpy.arange(len(at)))
        values, rates = self._values(states_in(series, at * width), steps.row[brackets.step])
        return values[mine], rates[mine] * (width * brackets.size)

    def _values(self, states: Array, row: Array) -> Array:
        """Return values and rates of all functions, shape (2, functions, states)."""
        bodies = numpy.take(self._bodies, row, axis=1)
        values = self._functions(states, pars=bodies, batch_parallel=False)
        return values.reshape(2, len(self._names), -1)


def refined(
    function: Callable[[Array, Array], tuple[Array, Array]],
    ends: tuple[Array, Array],
    start: Array,
    rising: Array,
    distance: Array,
) -> Array:
    """Return the zero between two positions, by Newton's method, and halvings outside the bracket.

    ``function`` returns values and rates at positions of the chosen zeros. Rates change within
    ``distance`` of the ``start``.
    """
    low, high, at, previous = (each.copy() for each in (*ends, start, distance))
    chosen = numpy.arange(len(at))
    for _ in range(MOST_CORRECTIONS):
        here, (value, rate) = at[chosen], function(at[chosen], chosen)
        behind = (value >= 0) == rising[chosen]
        low[chosen] = numpy.where(behind, low[chosen], here)
        high[chosen] = numpy.where(behind, here, high[chosen])
        nearer = here - value / rate
        inside = (nearer >= low[chosen]) & (nearer <= high[chosen])
        nearer = numpy.where(inside, nearer, (low[chosen] + high[chosen]) / 2)
        length = abs(nearer - here)
        moving = length * (length / previous[chosen]) ** 2 > SETTLED * nearer
        at[chosen], previous[chosen] = nearer, length
        chosen = chosen[moving]
        if not len(chosen):
            break
    return at


def classified(ends: Array) -> tuple[Array, Array]:
    """Return whether functions may vanish in intervals, and whether they have a single zero there.

    ``ends`` are value and rate (per interval) at the beginning and at the end; 0 counts as
    positive, and NaN, where a motion failed, is no zero. The coefficients of the cubic in
    Bernstein's basis enclose its values.
    """
    first, slope, last, last_slope = ends
    coefficients = numpy.array((first, first + slope / 3, last - last_slope / 3, last))
    negative, sizes = coefficients < 0, abs(coefficients)
    changes = numpy.add.reduce(negative[1:] != negative[:-1], axis=0, dtype=numpy.int8)
    unclear = sizes.min(axis=0) < MARGIN * sizes.max(axis=0)
    return ((changes > 0) | unclear) & numpy.isfinite(sizes.sum(axis=0)), changes == 1


def vanishing(form: Formulation, bodies: Array, states: Array, events: Sequence[Event]) -> Array:
    """Return which functions vanish in states up to the rounding of their terms."""
    state = form.State(*(Sized(component, abs(component)) for component in states))
    body = form.body(bodies).numbers(lambda number: Sized(number, 0.0 * number))
    q = form.motion(body, state, SizedFunctions())
    values = [event.function(q) for event in events]
    return numpy.array([abs(each.value) <= VANISHING * each.size for each in values])


def _only(brackets: Brackets, chosen: Array) -> Brackets:
    return Brackets(*(column[..., chosen] for column in brackets))


def _join(*brackets: Brackets) -> Brackets:
    return Brackets(*map(concatenate, zip(*brackets, strict=True)))


@cache
def _compiled(form: Formulation, events: tuple[Event, ...]) -> Callable[..., Array]:
    """Compile the values of the functions and their rates, from states."""
    equations = Equations.of(form)
    functions = [event.function(equations.motion) for event in events]
    rates = [along(function, equations) for function in functions]
    return heyoka.cfunc([*functions, *rates], vars=list(equations.variables))
