"""Events next to the climb, found without looking for all of their kind.

Initiation and ending times depend on the first time that theta rises through pi/2, and on zeros of
phi_dot and L.k -+ L.z next to it: two of 175 zeros of phi_dot on the reference scene. Values and
rates of these functions at both ends of each step tell which steps may hold them, and only those
are taken again with heyoka's own events, which are then what they were on the way, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, reduce
from typing import NamedTuple, TypeVar

import heyoka
import numpy

from tt_precise.integration.equations import Equations
from tt_precise.integration.system import along, event_expression
from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.sweeps.columns import ClimbSide, Detector
from tt_precise.sweeps.step_polynomials import ALONE, variables
from tt_precise.sweeps.steps_again import Begun, Hits, StepsAgain, noted

EARLY = 2.0**-26.5  # dimensionless; nearer to t = 0 an event may be the start itself
# The cubic through values and rates at both ends is off by h^4/384 of the fourth derivative at
# most. A step is 0.13 of the radius of convergence, which makes that 2e-5 of the function's size.
FLOOR = 2.0**-11  # of the size of its terms: 25 times as much
MARGIN = 2.0**-3  # of the cubic's largest coefficient, where its terms cancel all along a step
KNOWN = 2.0**-30  # of the size of its terms; rounding decides about the sign of what is smaller
Columns = TypeVar("Columns", Begun, Hits)

MAYBE, SURE = 1, 2  # may have a zero in a step; changes sign in it
WAITING = 64  # steps of a row; more are taken again before it is known whether it climbs
AT_ONCE = 2048  # steps that are taken again


class Taken(NamedTuple):
    """Recorded steps; arrays of the shape (steps, lanes).

    Rows (-1: none), lengths (0: not taken), times at the end, and at the start in two parts; and
    states at the start, shape (entries, steps, lanes).
    """

    row: Array
    width: Array
    end: Array
    high: Array
    low: Array
    state: Array


class ClimbZeros:
    """Finds the events of all rows of a batch integrator, a buffer of steps at a time.

    ``detectors``, with their numbers, are all that there are; those with a ``side`` are found here.
    """

    def __init__(
        self, form: Formulation, detectors: Sequence[tuple[int, Detector]], again: StepsAgain
    ):
        self._again = again
        mine = [(number, one, one.side) for number, one in detectors if one.side is not None]
        # that of the climb itself comes first
        mine.sort(key=lambda one: one[2] is not ClimbSide.FIRST)
        self._numbers, ours, self._sides = zip(*mine, strict=True)
        self._entries = len(form.columns)
        self._values = _values(form, ours)

    def open(self, rows: int) -> None:
        """Begin with so many rows."""
        # the last one of these is for empty lanes
        self.climb = numpy.full(rows + 1, numpy.inf)  # theta first rises through pi/2
        self._past = numpy.zeros((len(self._sides), rows + 1), dtype=bool)  # no more is wanted
        self._waiting = [self._no_steps() for _ in self._sides]
        self._wanted: list[Begun] = []
        self._count = 0
        self._found: list[Hits] = []

    def read(self, taken: Taken, last: tuple[Array, Array], states: Array) -> None:
        """Read some steps.

        ``last`` are the positions (step, lane) of those which no recorded step of the same row
        follows, and ``states``, of shape (entries, steps), where they end.
        """
        signs = self._signs(taken, last, states)
        signs[:, (taken.width == 0) | (taken.row < 0)] = 0
        self._find_climbs(taken, signs[0])
        for which in range(1, len(self._sides)):
            self._choose(which, taken, signs[which])
        if self._count > AT_ONCE:
            self._take_again()

    def hits(self) -> Hits:
        """All that was found; ``place`` is the row."""
        self._take_again()
        return _joined(self._found) if self._found else noted([])

    def _signs(self, taken: Taken, last: tuple[Array, Array], states: Array) -> Array:
        """For each detector, step and lane: ``MAYBE``, ``SURE``, or 0 where it cannot vanish."""
        steps, lanes = taken.row.shape
        starts = self._evaluated(taken.state, taken.row)
        ends = numpy.empty_like(starts)
        ends[:, :-1] = starts[:, 1:]
        ends[:, *last] = self._evaluated(states, taken.row[last])
        count = len(self._sides)
        inputs = numpy.empty((7, count, steps, lanes))
        inputs[:3], inputs[3:6] = (one.reshape(3, count, steps, lanes) for one in (starts, ends))
        inputs[6] = taken.width
        return _sign()(inputs.reshape(7, -1), **ALONE).reshape(count, steps, lanes)

    def _evaluated(self, states: Array, rows: Array) -> Array:
        """Values, rates and sizes of all functions in states, shape (entries, ...), of rows."""
        parameters = self._again.parameters.take(rows.ravel(), axis=1)
        inputs = numpy.ascontiguousarray(states.reshape(self._entries, -1))
        return self._values(inputs, pars=parameters, **ALONE).reshape(-1, *rows.shape)

    def _find_climbs(self, taken: Taken, signs: Array) -> None:
        """The first crossing of pi/2; all of a row with one so early that it may be its start."""
        open_ = (self.climb < EARLY) | numpy.isinf(self.climb)
        step, lane = numpy.nonzero((signs != 0) & open_[taken.row])
        if not len(step):
            return
        found = self._zeros(_begun(taken, step, lane), [self._numbers[0]])
        numpy.minimum.at(self.climb, found.place, found.time)

    def _choose(self, which: int, taken: Taken, signs: Array) -> None:
        """Choose the steps in which the zeros of a detector next to the climb are."""
        side, past = self._sides[which], self._past[which]
        waiting = self._waiting[which]
        # lane by lane, so that each row's steps follow each other
        lane, step = numpy.nonzero(signs.T != 0)
        row = taken.row[step, lane]
        if past.any():
            lane, step, row = (one[~past[row]] for one in (lane, step, row))
        end, sure = taken.end[step, lane], signs[step, lane] == SURE
        climb, begun = self.climb[row], taken.high[step, lane]
        place, rows = numpy.arange(len(row)), len(past)
        every = climb < EARLY  # which crossing is the climb is decided later
        wanted = every.copy()
        if side is not ClimbSide.AFTER:
            # of several zeros before the climb only the last one counts
            earlier = numpy.full(rows, -1)
            certain = numpy.flatnonzero(sure & (end < climb) & ~every)
            earlier[row[certain]] = certain  # the last one stays
            waiting = waiting.only(earlier[waiting.row] < 0)
            wanted |= (begun <= climb) & (place >= earlier[row])
        if side is not ClimbSide.BEFORE:
            later = numpy.full(rows, len(row))
            certain = numpy.flatnonzero(sure & (begun > climb) & ~every)[::-1]
            later[row[certain]] = certain  # the first one stays
            wanted |= (end >= climb) & (place <= later[row])
            past[row[certain]] = True
        chosen = numpy.flatnonzero(wanted)
        waiting = _joined([waiting, _begun(taken, step[chosen], lane[chosen])])
        many = numpy.bincount(waiting.row, minlength=rows) > WAITING
        now = (numpy.isfinite(self.climb) | many)[waiting.row]
        self._wanted.append(waiting.only(now))
        self._count += int(numpy.count_nonzero(now))
        self._waiting[which] = waiting.only(~now)

    def _take_again(self) -> None:
        steps = _joined([self._no_steps(), *self._wanted])
        self._wanted, self._count = [], 0
        # what several detectors want is taken once
        _, first = numpy.unique(numpy.stack([steps.row, steps.high]), axis=1, return_index=True)
        self._zeros(steps.only(numpy.sort(first)), self._numbers[1:])

    def _zeros(self, steps: Begun, numbers: Sequence[int]) -> Hits:
        """What the detectors with these numbers find; it is stored, too."""
        hits = self._again.zeros(steps)
        hits = hits.only(numpy.isin(hits.detector, numbers))
        found = hits._replace(place=steps.row[hits.place])
        self._found.append(found)
        return found

    def _no_steps(self) -> Begun:
        none = numpy.empty(0)
        return Begun(none.astype(int), none, none, numpy.empty((self._entries, 0)))


def _begun(taken: Taken, step: Array, lane: Array) -> Begun:
    places = step, lane
    return Begun(
        taken.row[places], taken.high[places], taken.low[places], taken.state[:, step, lane]
    )


def _joined(parts: Sequence[Columns]) -> Columns:
    """All of some parts of one kind, which are at least one."""
    return type(parts[0])(*(numpy.concatenate(one, axis=-1) for one in zip(*parts, strict=True)))


# ---- compiled ------------------------------------------------------------------------------


@cache
def _values(form: Formulation, detectors: tuple[Detector, ...]) -> Callable[..., Array]:
    """From states: values of the functions, their rates, and sizes of their terms.

    The size is what a relative change of all entries by 1 changes a function by at most, so that
    its rounding errors are some eps of that.
    """
    equations = Equations.of(form)
    functions = [event_expression(one.event, equations) for one in detectors]
    sizes = [
        sum(_size(heyoka.diff(one, entry) * entry) for entry in equations.variables)
        for one in functions
    ]
    rates = [along(one, equations) for one in functions]
    return heyoka.cfunc([*functions, *rates, *sizes], vars=list(equations.variables))


@cache
def _sign() -> Callable[..., Array]:
    """From value, rate and size at the start, those at the end, and length: the sign's changes."""
    inputs = first, slope, size, last, last_slope, last_size, width = variables("x", 7)
    bernstein = [first, first + slope * width / 3.0, last - last_slope * width / 3.0, last]
    negative = heyoka.lt(first, 0.0)
    upright = [heyoka.select(negative, -one, one) for one in bernstein]
    least = -reduce(_larger, [-one for one in upright])
    largest = reduce(_larger, map(_size, bernstein))
    terms = _larger(size, last_size)
    never = heyoka.logical_and(
        [heyoka.gt(least, MARGIN * largest), heyoka.gt(least, FLOOR * terms)]
    )
    changes = heyoka.logical_and(
        [
            heyoka.neq(negative, heyoka.lt(last, 0.0)),
            heyoka.gt(_size(first), KNOWN * terms),
            heyoka.gt(_size(last), KNOWN * terms),
        ]
    )
    sign = heyoka.select(never, 0.0, heyoka.select(changes, float(SURE), float(MAYBE)))
    return heyoka.cfunc([sign], vars=inputs)


def _size(one: Scalar) -> Scalar:
    return _larger(one, -one)


def _larger(first: Scalar, second: Scalar) -> Scalar:
    return heyoka.select(heyoka.gt(first, second), first, second)
