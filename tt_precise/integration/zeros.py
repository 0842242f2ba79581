"""``Zeros``: the events of a run, found in the Taylor polynomials of its steps.

The sign of a value counts where the value exceeds its error; elsewhere the value is undecided. Only
the signs in order of time matter: - 0 0 + is one event, + 0 + is a tangency, and a function that
stays undecided between several extrema is lost in noise.

Values at Chebyshev nodes give a polynomial of each function on each step. Bernstein coefficients of
one sign exclude a zero, and one change of sign proves one. Other steps are divided until the
polynomials have the shape of the function; there the extrema separate its zeros. Secants refine
zeros in double, and then in the arithmetic of the run, which also decides signs that double leaves
open. Where a function vanishes at the exact start, its value with guard bits decides.

The error of a function follows from the errors of the components (Wilkinson's running error
analysis). Each step adds to the relative error of a component a rounding and the terms that the
step leaves out; a component has at least the error that its rate makes of the errors of the others
in a step. This model, no bound, ignores how the motion amplifies errors.

All functions share one axis of positions: the steps of the function i begin at i (steps + 1).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.equations import event_value
from tt_precise.integration.events import MOST_EVENTS
from tt_precise.integration.precision import DOUBLES
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import Steps, horner
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState
from tt_precise.taylor import interpolation
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
JUMP = 2.0**-3  # Smallest value at a zero, relative to the values beside it, that shows a jump.
TANGENCY = 3  # Undecided points in a row: an extremum, and the ends of its part.
GUARD = 2.0**-40  # Error of a value at the exact start, in errors of the run; 64 bits less 24.
SECANTS_PER_BIT = 3  # At most so many for each bit: at a triple zero each secant gains 0.4 bits.
SLOPE = 2.0**7  # Relative error of a slope over that of a zero: the nodes' number squared (Markov).
# Distance of the points of the first parabola through an extremum, in units of its part; each
# further distance is the square of the one before, as the error of a vertex is.
FLATTEST = 2.0**-16


@dataclass(frozen=True, eq=False)
class Hits:
    """Events in columns: names, times, directions, and states, an array for each component."""

    name: Array
    time: Array
    direction: Array
    state: tuple[Array, ...]

    def __len__(self) -> int:
        return len(self.name)


class FoundEvents(NamedTuple):
    """The events in order of time, and names of functions whose sign is undecided somewhere.

    ``touches`` are at a tangency, or everywhere, or ``unresolved``: over several extrema.
    """

    hits: Hits
    touches: frozenset[str] = frozenset()
    unresolved: frozenset[str] = frozenset()


def nothing_found(setup: Setup) -> FoundEvents:
    """Return an empty table of events."""
    none = setup.precision.numbers.array([])
    names, directions = numpy.empty(0, dtype=object), numpy.empty(0, dtype=int)
    return FoundEvents(Hits(names, none, directions, (none,) * len(setup.layout.columns)))


class Zeros:
    """A search for events block by block; ``continued`` runs may begin with undefined functions.

    Raises ``InputError``: there are too many events, or a function jumps or is undefined.
    """

    def __init__(self, setup: Setup, start: InitialState, *, continued: bool = False):
        self.setup, self.start, self.events = setup, start, tuple(setup.watched.values())
        # others than those of the catalogue may bend or jump
        self._bent = numpy.array([not event.smooth for event in self.events], dtype=bool)
        self._names = numpy.array([event.name for event in self.events], dtype=object)
        self._numbers, self._rounding = setup.precision.numbers, 2.0**-setup.precision.bits
        self._wide = not setup.precision.is_float
        self._hits: list[Hits] = []
        self._lost: Any = 0.0  # relative errors of the components so far
        self._sign = [0] * len(self.events)  # the last sign of each function that counts
        self._undecided = [0] * len(self.events)  # points since then
        self._touches, self._unresolved = set[int](), set[int]()
        self._continued = continued or bool(start.row)

    def search(self, steps: Steps) -> None:
        """Find the events in the next steps."""
        with numpy.errstate(all="ignore"), self.setup.precision.mpfr.precision():
            for first in range(0, len(steps) if self.events else 0, MOST_STEPS_AT_ONCE):
                self._search(steps.of(slice(first, first + MOST_STEPS_AT_ONCE)))

    def _search(self, steps: Steps) -> None:
        """Find and record the events in one block of steps."""
        self.steps, self.count = steps, len(steps)
        self._exact_start = not (self._continued or steps.begin[0])
        # the series of an onset, where the contact point was at rest
        self._after_rest = self._continued and self.count == 1 and not steps.begin[0]
        row = steps.sampled(interpolation.nodes(NODES))
        table = numpy.empty((NODES, len(self.events), self.count))
        for i, value in enumerate(self._values(range(len(self.events)), row, numpy)):
            table[:, i] = value
        self._measure_errors(row)
        self._require_defined(table)
        points, intervals = self._separated(table)
        points = self._decided(points)
        high = self._changes_of_sign(*points)
        if len(high):
            self._refine(points, high, intervals)

    def collect(self) -> FoundEvents:
        """Return the events so far."""
        pairs = list(enumerate(zip(self._sign, self._undecided, strict=True)))
        unresolved = self._unresolved | {i for i, (sign, n) in pairs if sign and n > TANGENCY}
        touches = self._touches | unresolved | {i for i, (sign, _) in pairs if not sign}
        names = [frozenset(self._names[sorted(which)]) for which in (touches, unresolved)]
        hits = nothing_found(self.setup).hits
        if self._hits:
            columns = ((h.name, h.time, h.direction, *h.state) for h in self._hits)
            every = list(map(numpy.concatenate, zip(*columns, strict=True)))
            order = numpy.argsort(every[1], kind="stable")
            name, time, direction, *state = (column[order] for column in every)
            hits = Hits(name, time, direction, tuple(state))
        return FoundEvents(hits, *names)

    def broken(self, which: Sequence[int], time: float) -> InputError:
        """Return the refusal of functions that jump or are undefined at a dimensionless time."""
        names = ", ".join(self._names[sorted(which)])
        seconds = time * float(self.start.units.time)
        return InputError(
            f"events: got {names}, which jumps or is undefined at t = {seconds:.6g} s, expected a "
            "continuous function that is defined everywhere, such as theta_max"
        )

    def _body(self, number: Any) -> Parameters:
        """Return the body of the equations, with its numbers converted once."""
        form, given = self.setup.formulation, self.start.parameters
        return self.start.once(
            ("parameters", number), lambda: form.body(list(map(number, given(form))))
        )

    def _values(
        self, which: Sequence[int], row: Sequence[Scalar], fn: Functions, number: Any = float
    ) -> Iterator[Scalar]:
        """Evaluate some functions at rows of any arithmetic."""
        layout, body = self.setup.layout, self._body(number)
        q, moving = layout.motion(body, row, fn), None
        for event in (self.events[i] for i in which):
            if event.of_rate:
                moving = moving or layout.moving(body, row, fn)[1]
                value = event_value(event, moving)
                yield value[0] if isinstance(value, TaylorSeries) else value
            else:
                yield event_value(event, q)

    def _of_each(self, which: Array, row: Sequence[Array], numbers: Any) -> Array:
        """Evaluate at each row the function that belongs to the row."""
        functions, values = numpy.unique(which).tolist(), 0 * row[0]
        if numbers is DOUBLES:  # functions share much, and rows cost little
            which = which.reshape(-1, *(1,) * (values.ndim - 1))
            return _chosen(which, functions, self._values(functions, row, numpy), values)
        for i in functions:
            here = which == i
            rows = [x[here] for x in row]
            (values[here],) = self._values([i], rows, numbers, numbers.number)
        return values

    def _located(self, position: Array) -> tuple[Array, Array, Array]:
        """Return function, step and position in the step of positions of all functions."""
        which = (position // (self.count + 1)).astype(int)
        along = position - which * (self.count + 1.0)
        step = numpy.minimum(along.astype(int), self.count - 1)
        return which, step, along - step

    def _evaluate(
        self, numbers: Any, which: Array, step: Array, inside: Array
    ) -> tuple[Array, Sequence[Array]]:
        """Evaluate functions, and components, at a position (in double, several) in each step."""
        if numbers is DOUBLES:
            row = self.steps.inside(step, inside)
        else:
            row = self.steps.evaluate(step, self.steps.times(step, inside), numbers)
        return self._of_each(which, row, numbers), row

    def _at(self, position: Array, numbers: Any = DOUBLES) -> Array:
        """Evaluate functions at positions of all functions; return doubles."""
        which, step, inside = self._located(position)
        if numbers is not DOUBLES:
            inside = numbers.array(inside.tolist())
        return self._evaluate(numbers, which, step, inside)[0].astype(float)

    def _at_nodes(self, begin: Array, width: Array, numbers: Any = DOUBLES) -> Array:
        """Evaluate functions at the nodes of intervals: axes (node, interval)."""
        which, step, inside = self._located(begin)
        inside = inside[:, None] + width[:, None] * interpolation.nodes(NODES)
        if numbers is DOUBLES:
            return self._evaluate(numbers, which, step, inside)[0].T
        which, step = numpy.repeat(which, NODES), numpy.repeat(step, NODES)
        values, _ = self._evaluate(numbers, which, step, numbers.array(inside.ravel().tolist()))
        return values.astype(float).reshape(-1, NODES).T

    def _measure_errors(self, row: Array) -> None:
        """Compute the errors of the components on each step, and ``doubt``, of functions in double.

        The size of a component on a step is its largest value or change.
        """
        rounding, terms = self._rounding, self.steps.terms
        size = numpy.maximum(abs(row).max(axis=1), abs(terms[:, :, 1]).T)
        left = OMITTED * (abs(terms[:, :, -1]) + OMITTED * abs(terms[:, :, -2])).T
        added = numpy.where(size > 0, left / size, 0) + rounding
        lost = numpy.cumsum(added, axis=1) + numpy.reshape(self._lost, (-1, 1))
        self._lost = lost[:, -1]
        roundings = 2 * terms.shape[2] * size  # of a value of a series
        errors = size * lost + roundings * rounding
        sized = list(map(Sized, row[:, 0], errors / rounding))
        rates = self.setup.layout.rates(self._body(float), sized, SizedFunctions())
        for i, rate in enumerate(rates):
            coupled = getattr(rate, "size", 0.0) * rounding * self.steps.length
            errors[i] = numpy.fmax(errors[i], coupled)  # undefined where gliding begins
        in_double = numpy.fmax(errors, roundings * ROUNDING)
        self._errors = {rounding: errors, ROUNDING: in_double}
        ends = numpy.append(row[:, 0], row[:, -1, -1:], axis=1)
        self._of_steps = {}
        for unit, errors in self._errors.items():
            at_ends = numpy.append(errors, errors[:, -1:], axis=1)
            at_ends[:, 1:-1] = numpy.fmax(at_ends[:, 1:-1], at_ends[:, :-2])
            table = numpy.zeros((len(self.events), self.count + 1))
            for i, error in enumerate(self._sizes(range(len(table)), ends, at_ends, unit)):
                table[i] = error
            self._of_steps[unit] = numpy.fmax(table[:, :-1], table[:, 1:])
        self.doubt = self._of_steps[ROUNDING]

    def _errors_at(self, position: Array, rounding: float = ROUNDING) -> Array:
        """Return errors at positions in steps; at a pole they exceed those at both ends."""
        which, step, inside = self._located(position)
        row, errors = self.steps.inside(step, inside), self._errors[rounding][:, step]
        functions = numpy.unique(which).tolist()
        sizes = self._sizes(functions, row, errors, rounding)
        sizes = _chosen(which, functions, sizes, 0 * position)
        return numpy.where(numpy.isfinite(sizes), sizes, 0.0)

    def _sizes(
        self, which: Sequence[int], row: Array, errors: Array, rounding: float
    ) -> Iterator[Array]:
        """Give the errors of functions that follow from the errors of the components."""
        rows = list(map(Rounded, row, errors / rounding))
        for value in self._values(which, rows, SizedFunctions()):
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
            at = numpy.array([i * (self.count + 1) + step + interpolation.nodes(NODES)[node]])
            if not (self._wide and numpy.isfinite(self._at(at, self._numbers)).all()):
                raise self.broken(which.tolist(), float(self.steps.begin[step]))

    def _separated(self, table: Array) -> tuple[Array, Array]:
        """Return points that separate the zeros of all functions, and polynomials between them.

        A point is a column: position, value, error in double, and the width of the part around an
        extremum, else 0. A polynomial is a column: begin and width of its interval, coefficients of
        powers of u from -1 to 1.
        """
        shape, values, doubt = table.shape[1:], table.reshape(NODES, -1), self.doubt.ravel()
        begin = numpy.arange(shape[0])[:, None] * (self.count + 1.0) + numpy.arange(self.count)
        polynomials = interpolation.through(values, numpy.repeat(self._bent, self.count))
        most = polynomials.tail + doubt
        changes, certain = interpolation.sign_changes(polynomials.bernstein, most)
        certain &= numpy.isfinite(most)
        single = certain & (changes == 1) & (polynomials.tail <= SINGLE * abs(values).max(axis=0))
        unclear = ~single & ~(certain & (changes == 0))
        divided = (single | unclear).reshape(shape)
        marked = numpy.ones((shape[0], self.count + 1), dtype=bool)
        marked[:, 1:-1] = divided[:, 1:] | divided[:, :-1]
        ends = numpy.concatenate([table[0], table[-1, :, -1:]], axis=1)[marked]
        errors = numpy.append(self.doubt, self.doubt[:, -1:], axis=1)[marked]
        position = numpy.flatnonzero(marked)
        points = [numpy.stack([position, ends, errors, 0 * position])]
        lone = begin.ravel()[single]
        intervals = [numpy.vstack([lone, 0 * lone + 1, polynomials.monomials[:, single]])]
        self._divide(begin.ravel()[unclear], values[:, unclear], doubt[unclear], points, intervals)
        return _in_order(points), _in_order(intervals)

    def _divide(
        self, begin: Array, values: Array, error: Array, points: list[Array], intervals: list[Array]
    ) -> None:
        """Divide steps until the polynomials have their function's shape, and add these.

        Functions that vanish at the exact start may cross zero in a millionth of a step; the
        intervals from there shrink until the fourth power of the position is a rounding.
        """
        width, total, exact_start = numpy.ones(len(begin)), 0, self._wide and self._exact_start
        if exact_start and len(begin):
            last = min(BISECTIONS, self.setup.precision.bits // 4 - 2)
            bounds = numpy.append(0.0, 2.0 ** -numpy.arange(float(last), -1.0, -1.0))
            count = numpy.where(begin % (self.count + 1), 1, last + 1)
            number = numpy.concatenate([numpy.arange(n) for n in count])
            begin, error, split = (numpy.repeat(x, count) for x in (begin, error, count > 1))
            width = numpy.where(split, numpy.diff(bounds)[number], 1.0)
            begin = begin + numpy.where(split, bounds[number], 0.0)
            values = self._at_nodes(begin, width)
        for halving in range(BISECTIONS + 1 if len(begin) else 0):
            which, step, inside = self._located(begin)
            at_start = exact_start & (step == 0) & (inside == 0)
            doubt, largest = error.copy(), numpy.fmax.reduce(abs(values), initial=0)
            small = numpy.flatnonzero(~(largest > error / SHAPE))
            if self._wide and len(small):
                values[:, small] = self._at_nodes(begin[small], width[small], self._numbers)
                error[small] = self._of_steps[self._rounding][which[small], step[small]]
                largest = numpy.fmax.reduce(abs(values), initial=0)
            polynomials = interpolation.through(values, self._bent[which])
            # where noise exceeds the function there is nothing to divide
            shaped = polynomials.tail <= numpy.fmax(SHAPE * largest, error)
            shaped |= ~numpy.isfinite(values).any(axis=0) | (halving == BISECTIONS)
            kept = interpolation.Polynomials(*(x[..., shaped] for x in polynomials))
            intervals.append(numpy.vstack([begin[shaped], width[shaped], kept.monomials]))
            inner = shaped & (inside > 0)
            bounds = begin[inner]
            points.append(numpy.stack([bounds, values[0, inner], doubt[inner], 0 * bounds]))
            # a polynomial below its error everywhere has no extrema to decide
            open_ = numpy.flatnonzero(abs(kept.bernstein).max(axis=0, initial=0) > error[shaped])
            of, at = interpolation.extrema(
                interpolation.Polynomials(*(x[..., open_] for x in kept))
            )
            if len(of):
                of = numpy.flatnonzero(shaped)[open_[of]]
                position, extent = begin[of] + at * width[of], width[of] * ~at_start[of]
                points.append(numpy.stack([position, self._at(position), doubt[of], extent]))
            if shaped.all():
                break
            begin, width, error, largest = (x[~shaped] for x in (begin, width / 2, doubt, largest))
            middle = self._errors_at(begin + width)
            # where errors exceed the function it may be undefined, which is asked later
            resolved = (middle <= largest) | self._after_rest
            error = numpy.tile(numpy.where(resolved, numpy.fmax(error, middle), error), 2)
            begin, width = numpy.concatenate([begin, begin + width]), numpy.tile(width, 2)
            values = self._at_nodes(begin, width)
            total += len(begin)
            require_few(total)

    def _decided(self, points: Array) -> Array:
        """Return points whose signs are decided in the arithmetic of the run, or at the start."""
        position, value, error, extent = points
        unsure = numpy.flatnonzero(~(abs(value) > error))
        if self._wide and len(unsure):
            still, turning = unsure[extent[unsure] == 0], unsure[extent[unsure] > 0]
            if len(still):
                value[still] = self._at(position[still], self._numbers)
            if len(turning):
                self._turn(points, turning)
            error[unsure] = self._errors_at(position[unsure], self._rounding)
            position, value, error, _ = points = _in_order([points])
        if self._exact_start:
            unsure = numpy.flatnonzero(~(abs(value) > error))
            first = unsure[position[unsure] % (self.count + 1) == 0]
            if len(first):
                values = self.start.once(("events at the start", self.setup), self._with_guard_bits)
                which, _, _ = self._located(position[first])
                value[first], error[first] = values[which], error[first] * GUARD
        return points

    def _with_guard_bits(self) -> Array:
        """Return the functions at the exact start, computed with guard bits, as doubles."""
        mpfr, setup = self.setup.precision.mpfr, self.setup
        row = [mpfr.array([x]) for x in self.start.first_row(setup.formulation, setup.record)]
        values = self._values(range(len(self.events)), row, mpfr, mpfr.number)
        return numpy.array([float((value + 0 * row[0])[0]) for value in values])

    def _turn(self, points: Array, turning: Array) -> None:
        """Move extrema to the vertices of parabolas, in the arithmetic of the run."""
        numbers, (place, _, _, extent) = self._numbers, points[:, turning]
        which, step, inside = self._located(place)
        position = numbers.array(inside.tolist())

        def function(at: Array) -> Array:
            return self._evaluate(numbers, which, step, at)[0]

        far = FLATTEST
        while far**2 >= self._rounding:
            aside = far * extent
            left, middle, right = (function(position + d) for d in (-aside, 0 * aside, aside))
            move = aside * (left - right) / 2 / (left - 2 * middle + right)
            position = position + numpy.where((abs(move) <= extent).astype(bool), move, 0.0)
            position = numpy.minimum(numpy.maximum(position, 0 * position), 0 * position + 1)
            far *= far
        points[1, turning] = function(position).astype(float)
        points[0, turning] += position.astype(float) - inside

    def _changes_of_sign(self, position: Array, value: Array, error: Array, extent: Array) -> Array:
        """Return the points behind the changes of sign, and note what is undecided."""
        error = numpy.where(numpy.isfinite(error), error, 0)
        signs = numpy.where(abs(value) > error, numpy.sign(value), 0).astype(int)
        bounds = numpy.arange(len(self.events) + 1) * (self.count + 1)
        begins = numpy.searchsorted(position, bounds).tolist()
        changes = []
        for i, (begin, end) in enumerate(itertools.pairwise(begins)):
            mine = slice(begin, end)
            counted = numpy.flatnonzero(signs[mine])
            sign, last = signs[mine][counted], self._sign[i]
            # undecided points before each of those
            gap = numpy.diff(counted, prepend=-1 - self._undecided[i]) - 1
            self._undecided[i] += end - begin
            if not len(counted):
                continue
            self._undecided[i], self._sign[i] = end - begin - 1 - int(counted[-1]), int(sign[-1])
            before = numpy.append(last, sign[:-1])
            if not last:
                # an undecided extremum since the exact start may hide two zeros
                if not self._continued and extent[mine][: counted[0]].any():
                    self._unresolved.add(i)
                gap[0] = 0
            if (gap > TANGENCY).any():
                self._unresolved.add(i)
            if ((gap > 0) & (before == sign)).any():
                self._touches.add(i)
            change = before * sign < 0
            if way := self.events[i].direction:
                change &= sign == way
            behind, gap = counted[change] + begin, gap[change]
            for k in numpy.flatnonzero(gap):
                # the change of sign among undecided values
                while behind[k] > begin and value[behind[k] - 1] * value[behind[k]] > 0:
                    behind[k] -= 1
            changes.append(behind)
        return numpy.concatenate(changes) if changes else numpy.zeros(0, dtype=int)

    def _refine(self, points: Array, behind: Array, intervals: Array) -> None:
        """Refine the zeros in double, then in the arithmetic of the run, and record them."""
        steps, numbers, (position, value, _, _) = self.steps, self._numbers, points
        which, _, _ = self._located(position)
        before = numpy.maximum(behind - 1, 0)
        before = numpy.where(which[before] == which[behind], before, behind)
        which, step, low = self._located(position[before])
        high: Array = low + (position[behind] - position[before])
        direction = numpy.sign(value[behind])
        # the polynomials between the points, or chords
        origin, width = low.copy(), numpy.where(high > low, high - low, 1.0)
        polynomials = numpy.zeros((NODES, len(behind)))
        polynomials[0] = (value[before] + value[behind]) / 2
        polynomials[1] = (value[behind] - value[before]) / 2
        of: Array = numpy.searchsorted(intervals[0], position[before], side="right") - 1
        apart = position[before] - intervals[0, of]
        inside = numpy.flatnonzero((of >= 0) & (apart < intervals[1, of]))
        of, origin[inside] = of[inside], (low - apart)[inside]
        width[inside], polynomials[:, inside] = intervals[1, of], intervals[2:, of]
        left, right = (numpy.clip(2 * (x - origin) / width - 1, -1, 1) for x in (low, high))
        root, slope = interpolation.zero_between(polynomials, left, right, direction)
        zero, slope = numpy.clip(origin + width * (1 + root) / 2, low, high), 2 * slope / width
        terms = numpy.ascontiguousarray(steps.terms[step].T)

        def in_double(position: Array) -> tuple[Array, Sequence[Array]]:
            row = horner(terms, position)
            return self._of_each(which, row, DOUBLES), row

        zero, end, row, slope = secants(in_double, zero, slope, low, high, direction, ROUNDING)
        beside = abs(numpy.where(end * direction < 0, value[before], value[behind]))
        jumps = abs(end) > numpy.maximum(JUMP * beside, self.doubt[which, step])
        broken = numpy.flatnonzero(jumps & (high > low) & self._bent[which])
        times: Array = steps.times(step, zero.astype(numpy.longdouble))
        if self._wide:
            evaluate = partial(self._evaluate, numbers, which, step)
            zero, low, high = (numbers.array(x.tolist()) for x in (zero, low, high))
            zero, _, row, _ = secants(evaluate, zero, slope, low, high, direction, self._rounding)
            times = steps.times(step, zero)
        kept = numpy.ones(len(times), dtype=bool)
        for k in broken.tolist():
            at_start = not (steps.begin[0] or step[k])
            noise = self._errors_at(position[behind[[k]]], self._rounding) if at_start else 0
            if not abs(value[behind[k]]) <= noise:
                raise self.broken([which[k]], float(times[k]))
            kept[k] = False
            self._unresolved.add(int(which[k]))  # lost in noise beside the start
        directions, state = direction[kept].astype(int), tuple(x[kept] for x in row)
        self._hits.append(Hits(self._names[which[kept]], times[kept], directions, state))
        require_few(sum(map(len, self._hits)))


def _chosen(which: Array, functions: list[int], values: Iterable[Scalar], chosen: Array) -> Array:
    """Write into ``chosen`` the value of the function that belongs to each place."""
    for i, value in zip(functions, values, strict=True):
        numpy.copyto(chosen, numpy.asarray(value, dtype=float), where=which == i)
    return chosen


def _in_order(tables: Sequence[Array]) -> Array:
    """Join tables whose first row is a position, in order of the position."""
    joined = numpy.concatenate(tables, axis=1)
    return joined[:, numpy.argsort(joined[0], kind="stable")]


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
    """Raise ``InputError`` for more events than ``MOST_EVENTS``."""
    if count > MOST_EVENTS:
        raise InputError(
            f"events: got more than {MOST_EVENTS}, or functions with as many bends, expected "
            "fewer: ask for a shorter time or for fewer kinds of them"
        )
