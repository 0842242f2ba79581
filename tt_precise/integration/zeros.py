"""``Zeros``: the events of a run, found in the Taylor polynomials of its steps.

An event is a change of sign of a function along the solution. The sign of a value counts where the
value exceeds its error; elsewhere the value is undecided. Only the signs in order of time matter:
- 0 0 + is one event, + 0 + is a tangency, and a function that stays undecided between several
extrema is lost in noise.

Values at Chebyshev nodes give a polynomial of each function on each step. Bernstein coefficients of
one sign exclude a zero, and one change of sign proves one. Other steps are divided until the
polynomials have the shape of the function; there the extrema separate its zeros. Secants refine
zeros in double, and then in the arithmetic of the run, which also decides signs that double leaves
open. Where a function vanishes at the exact start, its value with guard bits decides.

The error of a function follows from the errors of the components (Wilkinson's running error
analysis). Each step adds to the relative error of a component a rounding and the terms that the
step leaves out; a component has at least the error that its rate makes of the errors of the others
in a step. This is a model, not a bound: the model ignores how the motion amplifies errors.

All functions share one axis of positions: the steps of the function i begin at i (steps + 1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.equations import event_value
from tt_precise.integration.events import MOST_EVENTS
from tt_precise.integration.precision import DOUBLES, Hardware, functions_of
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import Steps
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState
from tt_precise.taylor.interpolation import (
    Polynomials,
    extrema,
    nodes,
    sign_changes,
    through,
    zero_between,
)
from tt_precise.taylor.series import Rounded, Sized, SizedFunctions, TaylorSeries

NODES = 10  # Chebyshev nodes of a polynomial; where it leaves out too much, the step is divided.
ROUNDING = 2.0**-53  # Relative error of a rounding in double.
# Ratio of successive terms of a series at the end of a step: with the order 1 - log(tolerance)/2
# steps are e^-2 of the radius of convergence (Jorba and Zou 2005).
OMITTED = math.exp(-2)
MOST_STEPS_AT_ONCE = 4096  # bounds memory to 50 MB
# Largest distance of a polynomial from its function, relative to its largest value: extreme values
# are then off by the square of it, less than a rounding of the values they are decided among.
SHAPE = 2.0**-16
SINGLE = 2.0**-10  # The same where a polynomial has one zero, which only begins secants.
BISECTIONS = 30  # Halvings of a step, which leave 2^-30 of the step to a bend.
MOST_INTERVALS = 10_000  # Intervals of steps that are divided at once; bounds memory to 50 MB.
# Smallest value at a zero, relative to the values beside it, that shows a jump: halving ends at a
# value of rounding, 2^-53 of them, where a function is continuous, and at 1 beside a step.
JUMP = 2.0**-3
# Undecided points in a row that a tangency explains: an extremum, and the ends of its part.
TANGENCY = 3
GUARD = 2.0**-40  # Error of a value at the exact start, in errors of the run; 64 bits less 24.
# Largest number of secants to a zero, for each bit: at a triple zero each gains 0.4 bits.
SECANTS_PER_BIT = 3
# Relative error of a polynomial's slope over the error of its zero in a step: the square of the
# number of nodes bounds a derivative (Markov).
SLOPE = 2.0**7
# Distance of the points of the first parabola through an extremum, in units of its part; each
# further distance is the square of the one before, as the error of a vertex is.
FLATTEST = 2.0**-16


@dataclass(frozen=True, eq=False)
class Hits:
    """Events in columns: names, times, directions, and states, an array for each component.

    Numbers are dimensionless, in the arithmetic in which the run is read.
    """

    name: Array
    time: Array
    direction: Array
    state: tuple[Array, ...]

    def __len__(self) -> int:
        return len(self.name)

    def of(self, rows: Array | slice) -> Hits:
        """Return some of the events."""
        state = tuple(x[rows] for x in self.state)
        return Hits(self.name[rows], self.time[rows], self.direction[rows], state)


class FoundEvents(NamedTuple):
    """The events in order of time, and names of functions whose sign is undecided somewhere.

    Those that ``touches`` names are zero at a tangency, or everywhere, or ``unresolved``: below
    their error over several extrema, so that events may be missing there.
    """

    hits: Hits
    touches: frozenset[str] = frozenset()
    unresolved: frozenset[str] = frozenset()


def nothing_found(setup: Setup) -> FoundEvents:
    """Return an empty table of events."""
    none = setup.precision.numbers.array([])
    names, directions = numpy.empty(0, dtype=object), numpy.empty(0, dtype=int)
    return FoundEvents(Hits(names, none, directions, (none,) * len(setup.layout.columns)))


class Points(NamedTuple):
    """Values of functions at positions, in order, with their errors in double.

    ``reach`` is the width of the part around an extremum, 0 for other points.
    """

    position: Array
    value: Array
    error: Array
    reach: Array


class Intervals(NamedTuple):
    """Intervals of steps on which functions are polynomials of a variable from -1 to 1."""

    begin: Array
    width: Array
    monomials: Array


class SignChanges(NamedTuple):
    """Functions, and positions on both sides of their zeros with the values there."""

    which: Array
    low: Array
    high: Array
    before: Array
    behind: Array


class Zeros:
    """A search for the events of a set-up, from the steps of a run block by block.

    With ``continued`` functions may be undefined where the run begins.
    """

    def __init__(self, setup: Setup, start: InitialState, *, continued: bool = False):
        self.setup, self.start, self.events = setup, start, tuple(setup.watched.values())
        # others than those of the catalogue may bend or jump
        self._bent = numpy.array([not event.smooth for event in self.events], dtype=bool)
        self._names = numpy.array([event.name for event in self.events], dtype=object)
        self._direction = numpy.array([event.direction for event in self.events], dtype=int)
        self._numbers, self._rounding = setup.precision.numbers, 2.0**-setup.precision.bits
        self._wide = not setup.precision.is_float
        self._hits: list[Hits] = []
        self._lost: Any = 0.0  # relative errors of the components so far
        self._sign = 0 * self._direction  # the last sign of each function that counts
        self._undecided = 0 * self._direction  # points since then
        self._touches, self._unresolved = set[int](), set[int]()
        self._continued = continued or bool(start.row)

    def search(self, steps: Steps) -> None:
        """Find the events in the next steps.

        Raises ``InputError``: there are too many, or a function jumps or is undefined.
        """
        with numpy.errstate(all="ignore"), self.setup.precision.mpfr.precision():
            for first in range(0, len(steps), MOST_STEPS_AT_ONCE):
                self._search(steps.of(slice(first, first + MOST_STEPS_AT_ONCE)))

    def _search(self, steps: Steps) -> None:
        """Find and record the events in one block of steps."""
        self.steps, self.count = steps, len(steps)
        self._exact_start = not (self._continued or steps.begin[0])
        # the series of an onset, where the contact point was at rest
        self._after_rest = self._continued and self.count == 1 and not steps.begin[0]
        row = steps.sampled(nodes(NODES))
        table = numpy.empty((NODES, len(self.events), self.count))
        for i, value in enumerate(self.values(range(len(self.events)), row, numpy)):
            table[:, i] = value
        self._measure_errors(row)
        self._require_defined(table)
        points, intervals = self._separated(table)
        brackets = self._brackets(points)
        if len(brackets.which):
            self._refine(brackets, intervals)

    def collect(self) -> FoundEvents:
        """Return the events so far."""
        late = numpy.flatnonzero((self._sign != 0) & (self._undecided > TANGENCY))
        unresolved = self._unresolved.union(late.tolist())
        touches = self._touches.union(unresolved, numpy.flatnonzero(self._sign == 0).tolist())
        names = [frozenset(self._names[sorted(which)]) for which in (touches, unresolved)]
        hits = nothing_found(self.setup).hits
        if self._hits:
            columns = ((h.name, h.time, h.direction, *h.state) for h in self._hits)
            name, time, direction, *state = map(numpy.concatenate, zip(*columns, strict=True))
            hits = Hits(name, time, direction, tuple(state))
        return FoundEvents(hits.of(numpy.argsort(hits.time, kind="stable")), *names)

    def values(
        self, which: Sequence[int], row: Sequence[Scalar], fn: Functions, number: Any = float
    ) -> Iterator[Scalar]:
        """Evaluate some functions at rows of any arithmetic."""
        layout, form = self.setup.layout, self.setup.formulation
        body = self.start.once(
            ("parameters", number),
            lambda: form.body([number(x) for x in self.start.parameters(form)]),
        )
        q, moving = layout.motion(body, row, fn), None
        for event in (self.events[i] for i in which):
            if event.of_rate:
                moving = moving or layout.moving(body, row, fn)[1]
                value = event_value(event, moving)
                yield value[0] if isinstance(value, TaylorSeries) else value
            else:
                yield event_value(event, q)

    def of_each(self, which: Array, row: Sequence[Array], numbers: Any) -> Array:
        """Evaluate at each row the function that belongs to the row."""
        functions, values = numpy.unique(which).tolist(), 0 * row[0]
        fn = functions_of(numbers)
        if isinstance(numbers, Hardware):
            for i, value in zip(functions, self.values(functions, row, fn), strict=True):
                numpy.copyto(values, numpy.asarray(value, dtype=float), where=which == i)
            return values
        for i in functions:
            here = which == i
            (value,) = self.values([i], [x[here] for x in row], fn, numbers.number)
            values[here] = value
        return values

    @property
    def exact_start(self) -> Array:
        """The functions at the exact start, computed with guard bits, as doubles."""

        def compute() -> Array:
            mpfr, setup = self.setup.precision.mpfr, self.setup
            row = [mpfr.array([x]) for x in self.start.first_row(setup.formulation, setup.record)]
            values = self.values(range(len(self.events)), row, mpfr, mpfr.number)
            return numpy.array([float((value + 0 * row[0])[0]) for value in values])

        return self.start.once(("events at the start", self.setup), compute)

    def _settle(self, which: Array, value: Array, error: Array, extreme: Array) -> Array:
        """Return the points behind the changes of sign, and note what is undecided."""
        signs = numpy.where(abs(value) > error, numpy.sign(value), 0).astype(int)
        counted = numpy.flatnonzero(signs)
        mine, sign, functions = which[counted], signs[counted], numpy.arange(len(self.events))
        begin, end = numpy.searchsorted(which, [functions, functions + 1])
        before, gap = numpy.roll(sign, 1), numpy.diff(counted, prepend=0) - 1
        first = mine != numpy.roll(mine, 1)
        first[:1] = True
        before[first] = self._sign[mine[first]]
        gap[first] = (counted - begin[mine])[first] + self._undecided[mine[first]]
        new = before == 0
        if not self._continued:  # an undecided extremum since the exact start may hide two zeros
            early = numpy.cumsum(numpy.append(0, extreme & (signs == 0)))
            lost = early[counted] > early[begin[mine]]
            self._unresolved |= set(mine[new & lost].tolist())
        self._touches |= set(mine[~new & (gap > 0) & (before == sign)].tolist())
        self._unresolved |= set(mine[~new & (gap > TANGENCY)].tolist())
        last = numpy.searchsorted(mine, functions, side="right") - 1
        decided = numpy.isin(functions, mine)
        self._undecided = self._undecided + end - begin
        self._undecided[decided] = end[decided] - 1 - counted[last[decided]]
        self._sign[decided] = sign[last[decided]]
        change = before * sign < 0
        change &= (self._direction[mine] == 0) | (self._direction[mine] == sign)
        high = counted[change]
        for k in numpy.flatnonzero(gap[change]):  # the change of sign among undecided values
            while high[k] > begin[which[high[k]]] and value[high[k] - 1] * value[high[k]] > 0:
                high[k] -= 1
        return high

    def broken(self, which: Sequence[int], time: float) -> InputError:
        """Return the refusal of functions that jump or are undefined at a dimensionless time."""
        names = ", ".join(self._names[sorted(which)])
        seconds = time * float(self.start.units.time)
        return InputError(
            f"events: got {names}, which jumps or is undefined at t = {seconds:.6g} s, expected a "
            "continuous function that is defined everywhere, such as theta_max or phi_dot_zero, or "
            "extremum:gliding_speed"
        )

    # ---- positions ------------------------------------------------------------------------------

    def _located(self, position: Array) -> tuple[Array, Array, Array]:
        """Return function, step and position in the step of positions of all functions."""
        which = (position // (self.count + 1)).astype(int)
        along = position - which * (self.count + 1.0)
        step = numpy.minimum(along.astype(int), self.count - 1)
        return which, step, along - step

    # ---- values and errors ----------------------------------------------------------------------

    def _values(self, which: Array, step: Array, inside: Array) -> Array:
        """Evaluate functions in double, at a position or a row of positions in each step."""
        row = self.steps.inside(step, inside)
        return self.of_each(which.reshape(-1, *(1,) * (inside.ndim - 1)), row, DOUBLES)

    def _exact_values(self, which: Array, step: Array, inside: Array) -> Array:
        """Evaluate functions in the arithmetic of the run; return doubles."""
        numbers, count = self._numbers, inside.size // max(len(inside), 1)
        which, step = numpy.repeat(which, count), numpy.repeat(step, count)
        times = self.steps.times(step, numbers.array(inside.ravel().tolist()))
        value = self.of_each(which, self.steps.evaluate(step, times, numbers), numbers)
        return value.astype(float).reshape(inside.shape)

    def _at_nodes(
        self, evaluate: Callable[[Array, Array, Array], Array], begin: Array, width: Array
    ) -> Array:
        """Evaluate functions at the nodes of intervals: axes (node, interval)."""
        if len(begin) > MOST_INTERVALS:
            parts = (slice(0, MOST_INTERVALS), slice(MOST_INTERVALS, None))
            return numpy.concatenate(
                [self._at_nodes(evaluate, begin[part], width[part]) for part in parts], axis=1
            )
        which, step, inside = self._located(begin)
        return evaluate(which, step, inside[:, None] + width[:, None] * nodes(NODES)).T

    def _measure_errors(self, row: Array) -> None:
        """Compute the errors of the components on each step, and ``doubt``, of functions in double.

        The size of a component on a step is its largest value or change. Where a component is
        small, the errors of the others are more.
        """
        rounding, terms = self._rounding, self.steps.terms
        size = numpy.maximum(abs(row).max(axis=1), abs(terms[:, :, 1]).T)
        left = OMITTED * (abs(terms[:, :, -1]) + OMITTED * abs(terms[:, :, -2])).T
        added = numpy.where(size > 0, left / size, 0) + rounding
        lost = numpy.cumsum(added, axis=1) + numpy.reshape(self._lost, (-1, 1))
        self._lost = lost[:, -1]
        roundings = 2 * terms.shape[2] * size  # of a value of a series
        errors = size * lost + roundings * rounding
        layout, form = self.setup.layout, self.setup.formulation
        body = form.body([float(x) for x in self.start.parameters(form)])
        sized = list(map(Sized, row[:, 0], errors / rounding))
        for i, rate in enumerate(layout.rates(body, sized, SizedFunctions())):
            coupled = getattr(rate, "size", 0.0) * rounding * self.steps.length
            errors[i] = numpy.fmax(errors[i], coupled)  # undefined where gliding begins
        self._errors = {rounding: errors}
        self._errors[ROUNDING] = numpy.fmax(errors, roundings * ROUNDING)
        self._ends = numpy.append(row[:, 0], row[:, -1, -1:], axis=1)
        self._of_steps = dict[float, Array]()
        self.doubt = self._error(ROUNDING)

    def _error(self, rounding: float) -> Array:
        """Return the larger error of the functions at both ends of each step."""
        if rounding not in self._of_steps:
            errors = self._errors[rounding]
            at_ends = numpy.append(errors, errors[:, -1:], axis=1)
            at_ends[:, 1:-1] = numpy.fmax(at_ends[:, 1:-1], at_ends[:, :-2])
            table = numpy.zeros((len(self.events), self.count + 1))
            for i, size in enumerate(self._sizes(range(len(table)), self._ends, at_ends, rounding)):
                table[i] = size
            self._of_steps[rounding] = numpy.fmax(table[:, :-1], table[:, 1:])
        return self._of_steps[rounding]

    def _errors_inside(self, position: Array, rounding: float = ROUNDING) -> Array:
        """Return errors, by default in double, at positions inside of steps.

        They exceed those at both ends where the axis passes a pole.
        """
        which, step, inside = self._located(position)
        functions, sizes = numpy.unique(which).tolist(), 0 * position
        row, errors = self.steps.inside(step, inside), self._errors[rounding][:, step]
        of_functions = self._sizes(functions, row, errors, rounding)
        for i, size in zip(functions, of_functions, strict=True):
            size = numpy.asarray(size + 0 * position, dtype=float)
            numpy.copyto(sizes, size, where=(which == i) & numpy.isfinite(size))
        return sizes

    def _sizes(
        self, which: Sequence[int], row: Sequence[Array], errors: Array, rounding: float
    ) -> Iterator[Array]:
        """Give the errors of functions that follow from the errors of the components."""
        rows = list(map(Rounded, row, errors / rounding))
        for value in self.values(which, rows, SizedFunctions()):
            yield getattr(value, "size", 0.0) * rounding

    def _require_defined(self, table: Array) -> None:
        """Refuse functions that are undefined; where a segment begins or ends they may be."""
        undefined = ~numpy.isfinite(table)
        if self._continued and not self.steps.begin[0]:
            undefined[0, :, 0] = False
        undefined[-1, :, -1] = False
        which = numpy.flatnonzero(undefined.any(axis=(0, 2)))
        for i in which.tolist():
            node, step = numpy.argwhere(undefined[:, i])[0]
            at = numpy.array([i]), numpy.array([step]), nodes(NODES)[[node]]
            if not (self._wide and numpy.isfinite(self._exact_values(*at)).all()):
                raise self.broken(which.tolist(), float(self.steps.begin[step]))

    # ---- points between which signs are compared ------------------------------------------------

    def _separated(self, table: Array) -> tuple[Points, Intervals]:
        """Return points that separate the zeros of all functions, and polynomials between them."""
        shape, ends = table.shape[1:], numpy.concatenate([table[0], table[-1, :, -1:]], axis=1)
        bent, largest = numpy.repeat(self._bent, self.count), abs(table).max(axis=0).ravel()
        polynomials = through(table.reshape(NODES, -1), bent)
        most = polynomials.tail + self.doubt.ravel()
        changes, certain = sign_changes(polynomials.bernstein, most)
        certain &= numpy.isfinite(most)
        single = certain & (changes == 1) & (polynomials.tail <= SINGLE * largest)
        unclear = (~(certain & (changes == 0)) & ~single).reshape(shape)
        either = single.reshape(shape) | unclear
        marked = numpy.ones((len(ends), self.count + 1), dtype=bool)
        marked[:, 1:-1] = either[:, 1:] | either[:, :-1]
        at_ends = numpy.flatnonzero(marked).astype(float)
        errors = numpy.append(self.doubt, self.doubt[:, -1:], axis=1)
        points = [Points(at_ends, ends[marked], errors[marked], 0 * at_ends)]
        begin = (numpy.arange(len(ends))[:, None] * (self.count + 1.0)) + numpy.arange(self.count)
        lone = begin[single.reshape(shape)]
        intervals = [Intervals(lone, 0 * lone + 1, polynomials.monomials[:, single])]
        begin, values, width = begin[unclear], table[:, unclear], numpy.ones(unclear.sum())
        error, total = self.doubt[unclear], 0
        if self._wide and self._exact_start:
            begin, width, error, values = self._towards_start(begin, error)
        for halving in range(BISECTIONS + 1):
            if not len(begin):
                break
            begin, values, width, error = self._divide(
                begin, values, width, error, points, intervals, halving == BISECTIONS
            )
            total += len(begin)
            require_few(total)
        return _in_order(points), _in_order(intervals)

    def _towards_start(self, begin: Array, error: Array) -> tuple[Array, Array, Array, Array]:
        """Return intervals, of which those from the exact start on shrink towards the start.

        There functions that vanish at the start may cross zero in a millionth of a step. At the
        last bound the fourth power of the position is a rounding.
        """
        _, step, inside = self._located(begin)
        last = min(BISECTIONS, self.setup.precision.bits // 4 - 2)
        bounds = numpy.append(0.0, 2.0 ** -numpy.arange(float(last), -1.0, -1.0))
        count = numpy.where((step == 0) & (inside == 0), last + 1, 1)
        number = numpy.concatenate([numpy.arange(n) for n in count]) if len(count) else count
        begin, error, split = (numpy.repeat(x, count) for x in (begin, error, count > 1))
        width = numpy.where(split, bounds[number + 1] - bounds[number], 1.0)
        begin = begin + numpy.where(split, bounds[number], 0.0)
        return begin, width, error, self._at_nodes(self._values, begin, width)

    def _divide(
        self, begin: Array, values: Array, width: Array, error: Array, points: list[Points],
        intervals: list[Intervals], last: bool,
    ) -> tuple[Array, Array, Array, Array]:  # fmt: skip
        """Add the intervals whose polynomials have their function's shape; return halves of others.

        The points are the extrema, and the bounds between the intervals of a step.
        """
        which, step, inside = self._located(begin)
        doubt, largest = error.copy(), numpy.fmax.reduce(abs(values), initial=0)
        small = numpy.flatnonzero(~(largest > error / SHAPE))
        if self._wide and len(small):
            values[:, small] = self._at_nodes(self._exact_values, begin[small], width[small])
            error[small] = self._error(self._rounding)[which[small], step[small]]
            largest = numpy.fmax.reduce(abs(values), initial=0)
        polynomials = through(values, self._bent[which])
        # where noise exceeds the function there is nothing to divide
        shaped = (polynomials.tail <= numpy.fmax(SHAPE * largest, error)) | last
        shaped |= ~numpy.isfinite(values).any(axis=0)
        kept = Polynomials(*(x[..., shaped] for x in polynomials))
        intervals.append(Intervals(begin[shaped], width[shaped], kept.monomials))
        inner = shaped & (inside > 0)
        points.append(Points(begin[inner], values[0, inner], doubt[inner], 0 * begin[inner]))
        # a polynomial below its error everywhere has no extrema to decide
        open_ = numpy.flatnonzero(abs(kept.bernstein).max(axis=0, initial=0) > error[shaped])
        of, at = extrema(Polynomials(*(x[..., open_] for x in kept)))
        if len(of):
            of = numpy.flatnonzero(shaped)[open_[of]]
            position = begin[of] + at * width[of]
            reach = width[of]
            if self._wide and self._exact_start:  # below the resolution, see _towards_start
                reach = numpy.where(begin[of] % (self.count + 1), reach, 0.0)
            value = self._values(*self._located(position))
            points.append(Points(position, value, doubt[of], reach))
        begin, width, error, largest = (x[~shaped] for x in (begin, width / 2, doubt, largest))
        middle = self._errors_inside(begin + width)
        # where errors exceed the function it may be undefined, which is asked later
        resolved = (middle <= largest) | self._after_rest
        error = numpy.where(resolved, numpy.fmax(error, middle), error)
        begin, width = numpy.concatenate([begin, begin + width]), numpy.tile(width, 2)
        values = self._at_nodes(self._values, begin, width)
        return begin, values, width, numpy.tile(error, 2)

    def _brackets(self, points: Points) -> SignChanges:
        """Return the brackets of zeros between points, with decided signs."""
        position, value, error, reach = points
        which, step, inside = self._located(position)
        unsure = numpy.flatnonzero(~(abs(value) > error))
        if self._wide and len(unsure):
            still, turning = unsure[reach[unsure] == 0], unsure[reach[unsure] > 0]
            if len(still):
                value[still] = self._exact_values(which[still], step[still], inside[still])
            if len(turning):
                self._turn(points, which, turning)
            within = self._errors_inside(position[unsure], self._rounding)
            at_ends = self._error(self._rounding)[which[unsure], step[unsure]]
            error[unsure] = numpy.fmax(at_ends, within)
            position, value, error, reach = _in_order([points])
            which, _, _ = self._located(position)
        if self._exact_start:
            first = numpy.flatnonzero(position % (self.count + 1) == 0)
            first = first[~(abs(value[first]) > error[first])]
            if len(first):
                value[first], error[first] = self.exact_start[which[first]], error[first] * GUARD
        error = numpy.where(numpy.isfinite(error), error, 0)
        high = self._settle(which, value, error, reach > 0)
        low = numpy.maximum(high - 1, 0)
        low = numpy.where(which[low] == which[high], low, high)
        return SignChanges(which[high], position[low], position[high], value[low], value[high])

    def _turn(self, points: Points, which: Array, turning: Array) -> None:
        """Move extrema to the vertices of parabolas, in the arithmetic of the run."""
        numbers, mine = self._numbers, which[turning]
        _, step, inside = self._located(points.position[turning])
        position, reach = numbers.array(inside.tolist()), points.reach[turning]

        def function(at: Array) -> Array:
            row = self.steps.evaluate(step, self.steps.times(step, at), numbers)
            return self.of_each(mine, row, numbers)

        far = FLATTEST
        while far**2 >= self._rounding:
            aside = far * reach
            left, middle, right = (function(position + d) for d in (-aside, 0 * aside, aside))
            move = aside * (left - right) / 2 / (left - 2 * middle + right)
            position = position + numpy.where((abs(move) <= reach).astype(bool), move, 0.0)
            position = numpy.minimum(numpy.maximum(position, 0 * position), 0 * position + 1)
            far *= far
        points.value[turning] = function(position).astype(float)
        points.position[turning] += position.astype(float) - inside

    # ---- refinement -----------------------------------------------------------------------------

    def _refine(self, b: SignChanges, intervals: Intervals) -> None:
        """Refine the zeros in double, then in the arithmetic of the run, and record them.

        Raises ``InputError``: a function jumps there, or there are too many zeros.
        """
        steps, numbers, direction = self.steps, self._numbers, numpy.sign(b.behind)
        _, step, low = self._located(b.low)
        high: Array = low + (b.high - b.low)
        position, slope = _from_polynomials(b, intervals, direction, b.low - low)
        series = steps.of(step)  # the step of each zero

        def in_double(position: Array) -> tuple[Array, Sequence[Array]]:
            row = series.inside(slice(None), position)
            return self.of_each(b.which, row, DOUBLES), row

        def exactly(position: Array) -> tuple[Array, Sequence[Array]]:
            row = steps.evaluate(step, steps.times(step, position), numbers)
            return self.of_each(b.which, row, numbers), row

        position, value, row, slope = secants(
            in_double, position, slope, low, high, direction, ROUNDING
        )
        beside = numpy.abs(numpy.where(value * direction < 0, b.before, b.behind))
        jumps = abs(value) > numpy.maximum(JUMP * beside, self.doubt[b.which, step])
        broken = numpy.flatnonzero(jumps & (b.high > b.low) & self._bent[b.which])
        times: Array = steps.times(step, position.astype(numpy.longdouble))
        if self._wide:
            position, low, high = (numbers.array(x.tolist()) for x in (position, low, high))
            position, _, row, _ = secants(
                exactly, position, slope, low, high, direction, self._rounding
            )
            times = steps.times(step, position)
        noise = self._errors_inside(b.high[broken], self._rounding)
        noise = numpy.where((step[broken] == 0) & (steps.begin[0] == 0), noise, 0)
        for k in broken[~(abs(b.behind[broken]) <= noise)].tolist():
            raise self.broken([b.which[k]], float(times[k]))
        self._unresolved |= set(b.which[broken].tolist())  # lost in noise beside the start
        kept = numpy.setdiff1d(numpy.arange(len(times)), broken)
        directions, state = direction[kept].astype(int), tuple(x[kept] for x in row)
        self._hits.append(Hits(self._names[b.which[kept]], times[kept], directions, state))
        require_few(sum(map(len, self._hits)))


def _in_order(columns: Sequence[Any]) -> Any:
    """Join tables whose first column is a position, in order of the position."""
    joined = [numpy.concatenate(x, axis=-1) for x in zip(*columns, strict=True)]
    order = numpy.argsort(joined[0], kind="stable")
    return type(columns[0])(*(x[..., order] for x in joined))


def _from_polynomials(
    b: SignChanges, intervals: Intervals, direction: Array, begin: Array
) -> tuple[Array, Array]:
    """Return the zeros of polynomials in brackets, and their slopes; chords outside the intervals.

    Positions are those in steps, which begin at ``begin``.
    """
    low, high, same = b.low - begin, b.high - begin, b.behind == b.before
    width = numpy.where(high > low, high - low, 1.0)
    rise = numpy.where(same, direction, b.behind - b.before)
    position, slope = low - width * b.before / rise, rise / width
    if len(intervals.begin):
        of: Array = numpy.searchsorted(intervals.begin, b.low, side="right") - 1
        overlapping: Array = (of >= 0) & (b.low < intervals.begin[of] + intervals.width[of])
        inside = numpy.flatnonzero(overlapping)
        of, wide = of[inside], intervals.width[of[inside]]
        left, right = (
            numpy.clip(2 * (x[inside] - intervals.begin[of]) / wide - 1, -1, 1)
            for x in (b.low, b.high)
        )
        root, rate = zero_between(intervals.monomials[:, of], left, right, direction[inside])
        position[inside] = intervals.begin[of] - begin[inside] + wide * (1 + root) / 2
        slope[inside] = 2 * rate / wide
    return numpy.clip(position, low, high), slope


def secants(
    function: Callable[[Array], tuple[Array, Sequence[Array]]],
    position: Array, slope: Array, low: Array, high: Array, direction: Array, rounding: float,
) -> tuple[Array, Array, Sequence[Array], Array]:  # fmt: skip
    """Return the zeros of functions in brackets, the values and states there, and the slopes.

    A secant is wrong by its length times the relative error of the slope, which is about the length
    before, relative to the bracket. A secant that leaves the bracket is replaced by a halving.
    """
    value, row = function(position)
    last, width = numpy.ones(len(position)), (high - low).astype(float)
    width = numpy.where(width > 0, width, 1.0)
    for _ in range(round(SECANTS_PER_BIT * -math.log2(rounding))):
        behind = (value * direction > 0).astype(bool)
        low, high = numpy.where(behind, low, position), numpy.where(behind, position, high)
        nearer = position - value / slope
        inside = ((low <= nearer) & (nearer <= high)).astype(bool)
        nearer = numpy.where(inside, nearer, (low + high) / 2)
        move, before, position = nearer - position, value, nearer
        value, row = function(position)
        length = abs(move.astype(float)) / width
        error = length * numpy.minimum(last, SLOPE * length) * width
        if not (error > rounding * abs(position.astype(float))).any():
            break
        last = numpy.where(inside, length, 1.0)
        rise = (value - before) / numpy.where(move == 0, 1, move)
        slope = numpy.where((rise * direction > 0).astype(bool), rise, slope)
    return position, value, row, slope


def require_few(count: int) -> None:
    """Refuse too many events.

    Raises ``InputError``: there are more than ``MOST_EVENTS``.
    """
    if count > MOST_EVENTS:
        raise InputError(
            f"events: got more than {MOST_EVENTS}, or functions with as many bends, expected "
            "fewer: ask for a shorter time or for fewer kinds of them"
        )
