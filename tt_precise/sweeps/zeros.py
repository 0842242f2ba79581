"""Find zeros of event functions, and extreme values of quantities, along Taylor steps.

The cubic through value and rate at both ends of an interval decides: the function has no zero
there, or one, or it is unclear, and the interval is halved. Newton's method on the function itself
follows.

For extreme values a step is sampled at 16 Chebyshev nodes. Where the last coefficients of the
polynomial through the samples are small, the polynomial represents the quantity, and its extrema
are extrema of the quantity; elsewhere the step is halved.

The bits of a zero or an extreme value do not depend on other motions, so that sums over nodes are
taken column by column: a matrix product rounds as its shape asks.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy

from tt_precise.integration.equations import Equations
from tt_precise.integration.events import Event
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.terminal import import_heyoka
from tt_precise.runtime.values import Array
from tt_precise.sweeps.batch import LaneSteps, states_in
from tt_precise.sweeps.columns import SMALLEST_FORCE, Statistic
from tt_precise.taylor.interpolation import nodes, zero_between
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
    zero, system = heyoka.expression(0.0), equations.system
    rates = [sum((heyoka.diff(f, x) * rate for x, rate in system), start=zero) for f in functions]
    return heyoka.cfunc([*functions, *rates], vars=list(equations.variables))


# ---- extreme values -----------------------------------------------------------------------------

NODES = nodes(16)  # Positions x in a step, from 0 to 1; u = 2 x - 1.
# Part of the range of the samples up to which the last three coefficients count as small.
REPRESENTED = 1e-7
LAST = 3
# Between two of 16 nodes a smooth function exceeds the samples by less than this part of their
# range: an eighth would hold for four nodes.
OVERSHOOT = 1 / 32
# Roundings of a quantity, as a part of the size of its terms, and of the samples themselves.
ROUNDING = 2.0**-45
SMALLEST_PART = 2.0**-30  # Part of a step, halved no more: a spike of a microsecond has 2^-12.
LEADING = 6  # Terms of the series of kz'' whose bounds are sharp: the others sum to 1e-5 of it.


class PeakSearch:
    """A search for the extreme values of ``statistics`` along motions of tops with ``bodies``."""

    def __init__(self, form: Formulation, bodies: Array, statistics: Sequence[Statistic]):
        self._form, self._bodies, self._statistics = form, bodies, tuple(statistics)
        self._signs = numpy.array([-1.0 if each.kind == "min" else 1.0 for each in statistics])
        self._peaks = numpy.full((len(statistics), bodies.shape[1]), -numpy.inf)

    def values(self) -> dict[Statistic, Array]:
        """Return the extreme values of each statistic inside the steps, dimensionless."""
        signed = self._signs[:, None] * self._peaks
        return dict(zip(self._statistics, signed, strict=True))

    def search(self, steps: LaneSteps) -> None:
        """Search a block of steps."""
        alone = self._statistics == (SMALLEST_FORCE,)
        step = self._low_force(steps) if alone else numpy.arange(len(steps.row))
        series, low, size = steps.series(step), numpy.zeros(len(step)), 1.0
        while len(step) and size > SMALLEST_PART:
            row, width = steps.row[step], steps.width[step]
            samples = self._sampled(series, row, (low + size * NODES[:, None]) * width)
            for peaks, highest in zip(self._peaks, samples.max(axis=1), strict=True):
                numpy.fmax.at(peaks, row, highest)
            coarse = self._halve(samples, series, row, (low + size / 2) * width)
            self._read_polynomials(samples, coarse, series, row, low * width, size * width)
            halved = numpy.flatnonzero(coarse.any(axis=0))
            size /= 2
            low = numpy.concatenate((low[halved], low[halved] + size))
            halved = numpy.tile(halved, 2)
            step, series = step[halved], series.take(halved, axis=2)

    def _halve(self, samples: Array, series: Array, row: Array, since: Array) -> Array:
        """Return where the polynomials through the samples do not represent the quantities.

        Samples that differ by rounding errors only have no further extrema.
        """
        tail = sum(abs(_summed(weights, samples)) for weights in chebyshev()[-LAST:])
        bound = REPRESENTED * numpy.ptp(samples, axis=1) + ROUNDING * abs(samples).max(axis=1)
        coarse = tail > bound
        some = numpy.flatnonzero(coarse.any(axis=0))
        if len(some):  # terms may cancel, and the sum of their roundings be larger than the samples
            states = states_in(series.take(some, axis=2), since[some])
            state = self._form.State(*(Sized(x, abs(x)) for x in states))
            body = self._form.body(self._bodies[:, row[some]])
            exact = body.numbers(lambda number: Sized(number, 0.0 * number))
            values = self._evaluate(self._form.motion(exact, state, SizedFunctions()))
            for kind, value in enumerate(values):
                size = getattr(value, "size", 0.0)
                coarse[kind, some] &= tail[kind, some] > ROUNDING * size
        return coarse

    def _read_polynomials(
        self, samples: Array, coarse: Array, series: Array, row: Array, begin: Array, width: Array
    ) -> None:
        """Raise the peaks to the local maxima of polynomials that represent their quantities."""
        highest = samples.max(axis=1) + OVERSHOOT * numpy.ptp(samples, axis=1)
        kind, part = numpy.nonzero(~coarse & (highest >= self._peaks[:, row]))
        samples = samples[kind, :, part].T
        powers = numpy.array([_summed(weights, samples) for weights in monomials()])
        rates = powers[1:] * numpy.arange(1, len(powers))[:, None]
        u = 2 * NODES - 1
        slopes = numpy.array([_horner(rates, each) for each in u])
        left, which = numpy.nonzero((slopes[:-1] > 0) & (slopes[1:] <= 0))
        falling = numpy.full(len(which), -1)
        peak, _ = zero_between(rates[:, which], u[left], u[left + 1], falling)
        kind, part = kind[which], part[which]
        since = begin[part] + (1 + peak) / 2 * width[part]
        peaks = self._sampled(series.take(part, axis=2), row[part], since[None])
        numpy.fmax.at(self._peaks, (kind, row[part]), peaks[kind, 0, numpy.arange(len(kind))])

    def _low_force(self, steps: LaneSteps) -> Array:
        """Return the steps in which the normal force may be the smallest of the motion.

        The centre of mass is at the height R (1 - alpha kz), so that g_n = m g - m R alpha kz''.
        The leading terms of the series of kz'' lie between their coefficients in Bernstein's basis,
        and the others below the sum of their sizes.
        """
        height = self._form.columns.index("kz")
        series = steps.series(numpy.arange(len(steps.row)), height)[2:]
        terms, power = [], 1.0
        for number, coefficient in enumerate(series):
            terms.append((number + 1) * (number + 2) * coefficient * power)
            power = power * steps.width
        rest = sum(map(abs, terms[LEADING:]), start=0.0)
        leading = terms[:LEADING]
        bounds = [sum(map(operator.mul, shares, leading), start=0.0) for shares in bernstein()]
        alpha = self._bodies[self._form.parameters.index("alpha"), steps.row]
        first, end = terms[0], sum(terms, start=0.0)
        weight = alpha * numpy.maximum(first, end)
        numpy.fmax.at(self._peaks[0], steps.row, weight - 1 - ROUNDING * (1 + abs(weight)))
        most = alpha * (numpy.max(bounds, axis=0) + rest) - 1
        return numpy.flatnonzero(most >= self._peaks[0, steps.row])

    def _sampled(self, series: Array, row: Array, since: Array) -> Array:
        """Return all quantities (minima with changed sign), shape (statistics, times, parts)."""
        state = self._form.State(*states_in(series, since))
        q = self._form.motion(self._form.body(self._bodies[:, row]), state, numpy)
        values = [value + numpy.zeros(since.shape) for value in self._evaluate(q)]
        return self._signs[:, None, None] * values

    def _evaluate(self, q: Motion) -> list[Array]:
        return [QUANTITIES[each.quantity].evaluate(q) for each in self._statistics]


@cache
def chebyshev() -> Array:
    """Return the matrix from samples at the nodes to coefficients of Chebyshev's polynomials."""
    return numpy.linalg.inv(numpy.polynomial.chebyshev.chebvander(2 * NODES - 1, len(NODES) - 1))


@cache
def monomials() -> Array:
    """Return the matrix from samples at the nodes to coefficients of 1, u, u^2 ..."""
    return numpy.linalg.inv(numpy.vander(2 * NODES - 1, increasing=True))


@cache
def bernstein() -> Array:
    """Return the matrix from the leading coefficients of 1, x, x^2 ... to those of Bernstein."""
    last, numbers = LEADING - 1, range(LEADING)
    return numpy.array([[math.comb(i, j) / math.comb(last, j) for j in numbers] for i in numbers])


def _summed(weights: Array, samples: Array) -> Array:
    """Return a weighted sum over the nodes, which are the last axis but one."""
    total = weights[0] * samples[..., 0, :]
    for node in range(1, len(weights)):
        total = total + weights[node] * samples[..., node, :]
    return total


def _horner(coefficients: Array, u: Array) -> Array:
    """Return the values of polynomials, from their coefficients of 1, u, u^2 ..."""
    value = coefficients[-1] + 0 * u
    for coefficient in coefficients[-2::-1]:
        value = value * u + coefficient
    return value
