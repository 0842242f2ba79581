"""Zeros of event functions along many trajectories, from the Taylor series of the steps.

A cubic through value and derivative at both ends of a step decides whether the function may vanish
in the step. Among the steps with a possible zero, only those that affect the times of the climb are
examined. The Taylor series of the function, composed from that of the state, gives the zeros
between Bernstein bounds. The bits of a zero do not depend on other rows.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import cache, reduce
from typing import NamedTuple

import numpy

from tt_precise.integration.equations import Equations, along
from tt_precise.integration.events import MOST_EVENTS
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.sweeps.columns import Detector
from tt_precise.taylor.interpolation import bernstein_of, isolated, zero_between
from tt_precise.taylor.series import SeriesFunctions, Sized, Truncated

heyoka = import_heyoka()

ALONE = {"batch_parallel": False}  # the other cores have their own chunks
EARLY = 2.0**-26.5  # dimensionless; closer to t = 0 an event may be the start itself
# The cubic through values and rates at both ends is off by h^4/384 of the fourth derivative at
# most. A step is 0.13 of the radius of convergence, which makes that 2e-5 of the function's size.
FLOOR = 2.0**-11  # Part of the size of its terms, 25 times the error of the cubic.
CANCELLATION = 2.0**-3  # Part of the cubic's largest coefficient, where its terms cancel.
KNOWN = 2.0**-30  # Part of the size of its terms; rounding decides smaller signs.
MAYBE, SURE = 1, 2  # may have zeros in a step; has one
SUBDIVISIONS = 26  # two zeros closer than this count as none, three as one
EVENTS_OF_A_ROW = 1000  # a hundred bytes each; a climb has hundreds


class BatchSteps(NamedTuple):
    """Steps of a batch integrator; arrays of the shape (steps, lanes).

    Rows (-1: none), times at the start and at the end, lengths (0: no step); the Taylor series of
    the state, shape (steps, components, order + 1, lanes); and ``last``, the positions (step,
    lane) of the steps that no recorded step of the same row follows, with the states where they
    end, shape (components, positions).
    """

    row: Array
    begin: Array
    end: Array
    width: Array
    series: Array
    last: tuple[Array, Array]
    ends: Array

    @property
    def belongs(self) -> Array:
        """Mask of the steps that belong to a row."""
        return (self.width != 0) & (self.row >= 0) & numpy.isfinite(self.width)

    def all_series(self, *components: int) -> Array:
        """Taylor coefficients of all steps, shape (components, order + 1, steps times lanes)."""
        chosen = self.series[:, list(components)] if components else self.series
        moved = numpy.ascontiguousarray(chosen.transpose(1, 2, 0, 3))
        return moved.reshape(*moved.shape[:2], -1)

    def columns(self, step: Array, lane: Array, *components: int) -> Array:
        """Taylor coefficients of some steps, shape (components, order + 1, positions)."""
        numbers = components or range(len(self.ends))
        chosen = [self.series[step, n, :, lane] for n in numbers]
        return numpy.ascontiguousarray(numpy.swapaxes(chosen, 1, 2))


class Events(NamedTuple):
    """Events as columns: arrays with one entry for each event.

    ``row`` and ``detector`` are positions, ``direction`` is +1 where the function rises and -1
    where it falls, ``time`` is dimensionless as is ``state``, shape (events, components), NaN where
    the detector is not ``turning``.
    """

    row: Array
    detector: Array
    direction: Array
    time: Array
    state: Array


class BatchZeros:
    """A finder of the zeros of the ``detectors``, for one buffer of steps at a time.

    The first detector is that of the climb.
    """

    def __init__(self, form: Formulation, detectors: tuple[Detector, ...]):
        self._form, self._detectors = form, detectors
        self._height = form.columns.index("kz")
        self._values = _values(form, detectors)

    def open(self, bodies: Array, signs: Array) -> None:
        """Begin with rows of bodies with these parameters, shape (parameters, rows).

        ``signs`` of the functions at the exact starts, shape (detectors, rows), are -1, 0 or 1.
        """
        rows = bodies.shape[1]
        self._bodies = bodies
        self._start_signs = numpy.where(signs < 0, -1.0, 1.0)  # 0 counts as positive
        # the last one of these is for empty lanes
        self.climb = numpy.full(rows + 1, numpy.inf)  # theta first rises through pi/2
        self._past = numpy.zeros((len(self._detectors), rows + 1), dtype=bool)  # no more is wanted
        none = numpy.empty(0, dtype=int)
        self._found = [self._events(0, none, none, numpy.empty(0))]
        self._most = self._room = MOST_EVENTS + EVENTS_OF_A_ROW * rows

    def search(self, steps: BatchSteps) -> None:
        """Find the zeros in some steps.

        Raises ``InputError``: there are more events than fit into memory.
        """
        signs, values = self._signs(steps)
        for number in range(len(self._detectors)):
            lane, step = numpy.nonzero(signs[number].T)  # each row's steps follow each other
            ends = values[:, number, step, lane]
            sure = signs[number, step, lane] == SURE
            if number == 0:
                climb = self.climb[steps.row[step, lane]]
                wanted = (climb < EARLY) | numpy.isinf(climb)
            else:
                wanted = self._chosen(number, steps, step, lane, sure, rising=ends[0] < 0)
            chosen = step[wanted], lane[wanted], ends[:, wanted], sure[wanted]
            events = self._zeros(number, steps, *chosen)
            if number == 0:
                numpy.minimum.at(self.climb, events.row, events.time)
            self._found.append(events)
            self._room -= len(events.row)
        if self._room < 0:
            raise InputError(
                f"until: got a time in which {len(self.climb) - 1} rows have more than "
                f"{self._most} events, expected a shorter one"
            )

    def events(self) -> Events:
        """All events by row, each kind in order of time."""
        events = Events(*(numpy.concatenate(column) for column in zip(*self._found, strict=True)))
        order = numpy.lexsort((events.time, events.row))
        return Events(*(column[order] for column in events))

    def _signs(self, steps: BatchSteps) -> tuple[Array, Array]:
        """``MAYBE``, ``SURE`` or 0 for each detector, step and lane; the values at both ends."""
        count, shape = len(self._detectors), steps.row.shape
        starts = self._evaluated(numpy.moveaxis(steps.series[:, :, 0], 1, 0), steps.row)
        inputs = numpy.empty((7, count, *shape))
        inputs[:3] = starts.reshape(3, count, *shape)
        at_start = steps.belongs & (steps.begin == 0)
        exact = self._start_signs[:, steps.row[at_start]]
        inputs[0][:, at_start] = numpy.copysign(inputs[0][:, at_start], exact)
        # a step begins where the previous one ends, so that no zero is lost or counted twice
        inputs[3:6, :, :-1] = inputs[:3, :, 1:]
        last = self._evaluated(steps.ends, steps.row[steps.last])
        inputs[3:6][:, :, *steps.last] = last.reshape(3, count, -1)
        inputs[6] = steps.width
        signs = _sign()(inputs.reshape(7, -1), **ALONE).reshape(count, *shape)
        signs[:, ~steps.belongs] = 0
        return signs, inputs[[0, 3]]

    def _evaluated(self, states: Array, rows: Array) -> Array:
        """Values, rates and sizes of all functions in states, shape (components, ...), of rows."""
        parameters = self._bodies.take(rows.ravel(), axis=1)
        inputs = numpy.ascontiguousarray(states).reshape(len(states), -1)
        return self._values(inputs, pars=parameters, **ALONE).reshape(-1, *rows.shape)

    def _chosen(
        self, number: int, steps: BatchSteps, step: Array, lane: Array, sure: Array, rising: Array
    ) -> Array:
        """Mask of the steps that may have a wanted zero, by the position of the climb."""
        detector = self._detectors[number]
        row, climb = steps.row[step, lane], self.climb[steps.row[step, lane]]
        begin, end = steps.begin[step, lane], steps.end[step, lane]
        every = detector.every | (climb < EARLY)  # which crossing is the climb is decided later
        # a step in which the sign changes the other way has none, or several
        before = (
            begin <= climb if detector.before is not None else numpy.zeros(len(row), dtype=bool)
        )
        after = end >= climb if detector.after is not None else numpy.zeros(len(row), dtype=bool)
        if detector.before:
            before &= ~sure | (rising == (detector.before > 0))
        if detector.after:
            after &= ~sure | (rising == (detector.after > 0))
        if not detector.turning:
            # of several zeros before the climb only the last one counts, after it the first one
            place = numpy.arange(len(row))
            last, first = numpy.full((2, len(self.climb)), -1)
            certain = numpy.flatnonzero(before & sure & (end < climb))
            last[row[certain]] = certain
            before &= place >= last[row]
            certain = numpy.flatnonzero(after & sure & (begin > climb))[::-1]
            first[row[certain]] = certain
            after &= ~self._past[number, row] & ((first[row] < 0) | (place <= first[row]))
            self._past[number, row[certain]] = True
        return every | before | after

    def _zeros(
        self, number: int, steps: BatchSteps, step: Array, lane: Array, ends: Array, sure: Array
    ) -> Events:
        detector = self._detectors[number]
        row, width = steps.row[step, lane], steps.width[step, lane]
        polynomials = self._series(detector, steps, step, lane)
        polynomials = polynomials * numpy.vander(width, len(polynomials), increasing=True).T
        first, last = ends
        which, place, rising = zeros(polynomials, first, last, sure)
        since = place * width[which]
        row, direction, time = row[which], 2 * rising - 1, steps.begin[step, lane][which] + since
        if number == 0:
            wanted = direction < 0
        elif detector.turning:
            # minima before the climb, and maxima after it
            climb = self.climb[row]
            wanted = detector.every | (climb < EARLY) | ((time > climb) == rising)
        else:
            return self._events(number, row, direction, time)
        which, row, direction = which[wanted], row[wanted], direction[wanted]
        time, since = time[wanted], since[wanted]
        events = self._events(number, row, direction, time)
        series = steps.columns(step[which], lane[which], *range(6))  # axis and momentum
        events.state[:, :6] = states_in(series, since)
        return events

    def _events(self, number: int, row: Array, direction: Array, time: Array) -> Events:
        state = numpy.full((len(row), len(self._form.columns)), numpy.nan)
        return Events(row, numpy.full(len(row), number), direction, time, state)

    def _series(self, detector: Detector, steps: BatchSteps, step: Array, lane: Array) -> Array:
        """Taylor coefficients of the function in some steps, shape (order + 1, positions)."""
        if detector.turning:  # theta turns where the rate of kz = cos theta vanishes
            return Truncated(steps.columns(step, lane, self._height)[0]).rate
        body = self._form.body(self._bodies[:, steps.row[step, lane]])
        if detector.event.gliding:
            state = self._form.State(*map(Truncated, steps.columns(step, lane)))
            q = self._form.motion(body, state, SeriesFunctions(numpy))
        else:  # a function of axis and momentum, the first six components
            kx, ky, kz, Lx, Ly, Lz = map(Truncated, steps.columns(step, lane, *range(6)))
            q = Motion(body, NewtonState(kx, ky, kz, Lx, Ly, Lz, 0, 0), SeriesFunctions(numpy))
        order = steps.series.shape[2] - 1
        return numpy.array(detector.event.function(q).upto(order))


def exactly(number: Scalar) -> Sized:
    """A number or array without error."""
    return Sized(number, 0.0 * number)


# ---- polynomials ---------------------------------------------------------------------------


def zeros(
    polynomials: Array, first: Array, last: Array, single: Array
) -> tuple[Array, Array, Array]:
    """All sign changes of polynomials between 0 and 1; 0 counts as positive.

    ``polynomials`` are coefficients of 1, x, x^2 ..., shape (terms, polynomials); the signs of
    ``first`` and ``last``, the values at 0 and 1, decide; those of ``single`` are known to have one
    zero. Three arrays, in order for each polynomial: which one, where, whether it rises there.
    """
    known, others = numpy.flatnonzero(single), numpy.flatnonzero(~single)
    bernstein = bernstein_of(polynomials[:, others].T)
    bernstein[:, 0], bernstein[:, -1] = first[others], last[others]
    which, left, right, rising = isolated(bernstein, SUBDIVISIONS)
    owner = numpy.concatenate((known, others[which]))
    left = numpy.concatenate((numpy.zeros(len(known)), left))
    right = numpy.concatenate((numpy.ones(len(known)), right))
    rising = numpy.concatenate((first[known] < 0, rising))
    order = numpy.lexsort((left, owner))
    owner, left, right, rising = (column[order] for column in (owner, left, right, rising))
    secant = first / (first - last)
    whole = (right - left == 1) & numpy.isfinite(secant[owner])
    start = numpy.where(whole, secant[owner], (left + right) / 2)
    place, _ = zero_between(polynomials[:, owner], left, right, 2.0 * rising - 1, start)
    return owner, place, rising


def states_in(series: Array, *since: Array) -> Array:
    """States in steps, from their Taylor series, shape (components, order + 1, steps).

    ``since`` are times after the start of the steps, shape (steps,) each. The result has the shape
    (steps, components), with an axis in front for several times.
    """
    components, terms, count = series.shape
    inputs = numpy.concatenate((series.reshape(components * terms, count), since))
    flat = _states(components, terms, len(since))(numpy.ascontiguousarray(inputs), **ALONE)
    states = flat.reshape(len(since), components, count).swapaxes(1, 2)
    return states[0] if len(since) == 1 else states


# ---- compiled ------------------------------------------------------------------------------


def horner(coefficients: Sequence[Scalar], at: Scalar) -> Scalar:
    """Value of a polynomial, from its coefficients of 1, x, x^2, ..."""
    return reduce(
        lambda value, coefficient: value * at + coefficient, coefficients[-2::-1], coefficients[-1]
    )


def variables(letter: str, count: int) -> list[Scalar]:
    """Symbols of heyoka's: the letter with 0, 1, 2, ..."""
    return list(heyoka.make_vars(*(f"{letter}{n}" for n in range(count))))


@cache
def _states(components: int, terms: int, times: int) -> Callable[..., Array]:
    """Return a function: states from the series of all components and times since the start."""
    series = [variables(f"c{n}_", terms) for n in range(components)]
    since = [heyoka.make_vars(f"since{n}") for n in range(times)]
    return heyoka.cfunc(
        [horner(coefficients, at) for at in since for coefficients in series],
        vars=[*itertools.chain(*series), *since],
    )


@cache
def _values(form: Formulation, detectors: tuple[Detector, ...]) -> Callable[..., Array]:
    """Values of the functions, their derivatives, and sizes of their terms, from states.

    The size is what a relative change of all components by 1 changes a function by at most, so that
    its rounding errors are some eps of that.
    """
    equations = Equations.of(form)
    functions = [detector.event.function(equations.motion) for detector in detectors]
    sizes = [
        sum(_size(heyoka.diff(function, entry) * entry) for entry in equations.variables)
        for function in functions
    ]
    rates = [along(function, equations) for function in functions]
    return heyoka.cfunc([*functions, *rates, *sizes], vars=list(equations.variables))


@cache
def _sign() -> Callable[..., Array]:
    """The changes of sign, from value, derivative and size at both ends, and the length."""
    inputs = first, slope, size, last, last_slope, last_size, width = variables("x", 7)
    bernstein = [first, first + slope * width / 3.0, last - last_slope * width / 3.0, last]
    negative = heyoka.lt(first, 0.0)
    upright = [heyoka.select(negative, -coefficient, coefficient) for coefficient in bernstein]
    least = -reduce(_larger, [-value for value in upright])
    largest = reduce(_larger, map(_size, bernstein))
    terms = _larger(size, last_size)
    never = heyoka.logical_and(
        [heyoka.gt(least, CANCELLATION * largest), heyoka.gt(least, FLOOR * terms)]
    )
    signs = [heyoka.lt(coefficient, 0.0) for coefficient in bernstein]
    single = heyoka.logical_and(
        [
            heyoka.eq(sum(heyoka.neq(*pair) for pair in itertools.pairwise(signs)), 1.0),
            heyoka.gt(_size(first), KNOWN * terms),
            heyoka.gt(_size(last), KNOWN * terms),
        ]
    )
    sign = heyoka.select(never, 0.0, heyoka.select(single, float(SURE), float(MAYBE)))
    return heyoka.cfunc([sign], vars=inputs)


def _size(value: Scalar) -> Scalar:
    return _larger(value, -value)


def _larger(first: Scalar, second: Scalar) -> Scalar:
    return heyoka.select(heyoka.gt(first, second), first, second)
