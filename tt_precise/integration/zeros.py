"""``Zeros``: the events of a run, found in the Taylor series of its steps.

An event is a change of sign of a function along the solution. The sign of a value counts where the
value exceeds its error; elsewhere the value is undecided. Only the signs in order of time matter:
- 0 0 + is one event, + 0 + is a tangency, and a function that stays undecided between several
extrema is lost in noise.

The errors of the state determine the error of a function. Each step adds to the relative error of a
component a rounding and the terms that the step leaves out; a component has at least the error that
its rate makes of the errors of the others in a step. This is a model, not a bound: the model
ignores how the motion amplifies errors.

Values at Chebyshev nodes give a polynomial on each step, so that a function only needs to be
evaluated. Most polynomials have evidently no zero, or one. Other polynomials are divided until
their extrema are known, and the function itself decides there. In an arithmetic wider than double,
doubles find the positions, and the arithmetic of the run decides where doubles cannot. Near an
exact start, where functions may vanish, the series of the start with guard bits decides, on
intervals that shrink towards t = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.dense_output import NO_HITS, FoundEvents, Hits
from tt_precise.integration.equations import event_value
from tt_precise.integration.events import EVENTS, EXTREMUM, MOST_EVENTS, TERMINAL
from tt_precise.integration.roots import RIGHT_BITS, Bracket, refine, vertex
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import Sampled, Steps, Wide, of_series
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.taylor.interpolation import (
    Polynomials,
    extrema,
    nodes,
    sign_changes,
    through,
    zero_between,
)
from tt_precise.taylor.series import Rounded, Sized, SizedFunctions, TaylorSeries

ROUNDING = 2.0**-53  # Relative error of a rounding in double.
# Ratio of successive terms of a series at the end of a step: with the order 1 - log(tolerance)/2
# steps are e^-2 of the radius of convergence (Jorba and Zou 2005).
OMITTED = math.exp(-2)
# Largest number of products in a product of matrices, which limits the steps of a block: for more
# OpenBLAS starts threads. With one thread all events cost the same up to 2^21, below 2^18 more.
MOST_PRODUCTS = 2**18
# Nodes of a whole step, and of each interval of a step that has several zeros. They set the cost:
# where a polynomial leaves out too much, the interval is divided.
COARSE, FINE = 8, 14
# Largest distances of a polynomial from its function, relative to the largest value. From SINGLE on
# secants start at its zero, with so many right bits. From SHAPE on its extrema are those of the
# function: their values are off by the square of SHAPE, and below ROUNDING/SHAPE, 2^7 times that,
# the function itself decides.
SINGLE, SHAPE = 2.0**-RIGHT_BITS, 2.0**-20
# Halvings of a step, which leave 2^-30 of the step to a bend.
BISECTIONS = 30
MOST_INTERVALS = 1000  # Parts of steps that are read at once: bounds memory to some MB.
# Smallest value at a zero, relative to the values beside it, that shows a jump: halving ends at a
# value of rounding, 2^-53 of them, where a function is continuous, and at 1 beside a step.
JUMP = 2.0**-3
# Weight of undecided points between two signs that count: an extremum has 2, the end of a step 1.
# A tangency has an extremum, and perhaps the end of a step; more is noise.
TANGENCY = 3
# Series of the start have GUARD bits more than the run, of the 64 of its numbers: 24 are left to
# roundings. They have FIRST_ORDER terms, one more for 20 bits, and are read up to FIRST_PART of the
# first step. The terms that they omit count as errors, so both set what is decided, not if it is
# right.
FIRST_ORDER, GUARD = 8, 40
FIRST_PART = 2.0**-8


def shrinking(bits: int) -> Array:
    """Return bounds of intervals in the first step, from a rounding of the step to FIRST_PART."""
    return 2.0 ** -numpy.arange(float(bits - (bits - 8) % 10), 0.0, -10.0)


class Points(NamedTuple):
    """Values of functions at positions (step + position), in order of position.

    ``error`` is that of the run, ``doubt`` that of a value in double; an extremum may be off by
    ``reach``.
    """

    which: Array
    position: Array
    value: Array
    error: Array
    doubt: Array
    reach: Array


class Intervals(NamedTuple):
    """Parts of steps on which a function is a polynomial of a variable from -1 to 1."""

    which: Array
    position: Array
    width: Array
    monomials: Array


ErrorsInside = Callable[[Steps, Array, Array, Array], tuple[Array, Array]]
"""The errors of functions at positions in steps: in the run, and in double."""


class Zeros:
    """The events of a run, from its steps block by block."""

    def __init__(self, setup: Setup, start: InitialState):
        self.setup, self.start = setup, start
        self.events = tuple(setup.watched.values())
        # Functions of the catalogue are smooth, also at the poles; others may bend or jump.
        smooth = {*EVENTS, *TERMINAL}
        self._smooth = numpy.array([event.name in smooth for event in self.events], dtype=bool)
        self._mpfr = setup.precision.mpfr
        self._body = self._body_of(float)
        self._hits: list[Hits] = []  # of each block
        self._lost: Array = None  # errors of the components so far, relative to their sizes
        self._direction = numpy.array([event.direction for event in self.events], dtype=int)
        # the last sign of each function that counts
        self._sign = numpy.zeros(len(self.events), dtype=int)
        self._weight = numpy.zeros(len(self.events), dtype=int)  # of undecided points after that
        self._undecided = numpy.zeros(len(self.events), dtype=bool)
        self._touches, self._unresolved = set[int](), set[int]()
        # functions of the last block's events, -1 if another sign than that at the end is behind
        self._last: Array = None

    def search(self, steps: Steps) -> None:
        """Find the events in the next steps.

        Raises ``InputError``: there are too many, or a function jumps or is undefined.
        """
        with numpy.errstate(all="ignore"), self._mpfr.precision():
            count = max(MOST_PRODUCTS // (COARSE * steps.series.shape[2]), 1)
            for first in range(0, len(steps), count):
                self._search(steps.part(first, min(first + count, len(steps))))

    def collect(self, end: Sequence[Scalar] | None = None) -> FoundEvents:
        """Return the events so far.

        ``end`` is the state, in mpmath numbers, where the model ended before the horizon. What
        vanishes there within the error of the state does not change its sign.
        """
        if end is not None and self._last is not None and (self._last >= 0).any():
            kept = ~numpy.isin(self._last, list(self._vanishing(end)))
            self._hits[-1], self._last = self._hits[-1].of(kept), self._last[kept]
        never = numpy.flatnonzero(self._sign == 0).tolist()
        late = numpy.flatnonzero((self._sign != 0) & (self._weight > TANGENCY)).tolist()
        unresolved = self._unresolved.union(late)
        touches = self._touches.union(never, unresolved)
        names = [frozenset(self.events[i].name for i in which) for which in (touches, unresolved)]
        return FoundEvents(Hits.of_blocks(self._hits) if self._hits else NO_HITS, *names)

    def _vanishing(self, end: Sequence[Scalar]) -> set[int]:
        """Return the functions that the errors of the components carry through zero at a state.

        To every order: where contact ends, functions vanish with the third power of a component.
        """
        mpfr, count = self._mpfr, range(len(self.events))
        with mpfr.precision():
            components = []
            for k, (x, error) in enumerate(zip(end, self._error.tolist(), strict=True)):
                column = [x] * (2 * len(end) + 1)
                column[2 * k + 1 : 2 * k + 3] = x - error, x + error
                components.append(mpfr.array(column))
            table = self._along(count, self._body_of(mpfr.number), components, mpfr)
        found = set()
        for i, value in zip(count, table, strict=True):
            f = value + 0 * components[0]
            if not abs(f[0]) > sum(abs(f[1:] - f[0])):
                found.add(i)
        return found

    # ---- steps ----------------------------------------------------------------------------------

    def _search(self, steps: Steps) -> None:
        from_exact = self._lost is None and not self.start.row
        self._last = None
        sampled = steps.sampled(nodes(COARSE))
        error, doubt = self._errors(steps, sampled)
        # undefined where a segment begins or ends
        own, rough = (numpy.fmax(x[:, :-1], x[:, 1:]) for x in (error, doubt))
        value = numpy.empty(error.shape)
        single, unclear = numpy.empty((2, *own.shape), dtype=bool)
        monomials = []
        # one function at a time, whose arrays stay in the cache
        for i, f in enumerate(self._along(range(len(value)), self._body, sampled.row, numpy)):
            table = numpy.empty(sampled.row.shape[1:])
            table[...] = f
            table[-1, :-1] = table[0, 1:]
            value[i] = numpy.append(table[0], table[-1, -1:])
            polynomials = through(table, ~self._smooth[i])
            most = polynomials.tail + rough[i]
            changes, certain = sign_changes(polynomials.bernstein, most)
            certain &= numpy.isfinite(most)
            single[i] = certain & (changes == 1)
            single[i] &= polynomials.tail <= SINGLE * abs(table).max(axis=0)
            unclear[i] = ~certain | ((changes == 1) & ~single[i])
            monomials.append(polynomials.monomials[:, single[i]])
        low = numpy.zeros_like(value[:, :-1])
        if from_exact:
            self._require_defined(value[:, 0], sampled.row)
            near = numpy.flatnonzero(abs(value[:, 0]) <= doubt[:, 0])  # their first step is unclear
            if len(near):
                self._read_start(steps, near)
                low[near, 0], value[near, 0] = FIRST_PART, self._sign[near]
        which, step = numpy.nonzero(single)
        powers = numpy.zeros((FINE, len(which)))
        powers[:COARSE] = numpy.concatenate(monomials, axis=1)
        whole = Intervals(which, step.astype(float), 0.0 * step + 1, powers)
        which, step = numpy.nonzero(unclear)
        begin = low[which, step]
        parts, inner = self._divided(
            steps, which, step, begin, 1 - begin, own[which, step], rough[which, step],
            self._errors_inside,
        )  # fmt: skip
        # the ends of all steps, and of those that may have zeros
        ends = numpy.ones(value.shape, dtype=bool)
        ends[:, 1:-1] = (unclear | single)[:, 1:] | (unclear | single)[:, :-1]
        functions, position = numpy.nonzero(ends)
        begin = numpy.append(low, low[:, :1] * 0, axis=1)[ends]
        columns = value[ends], error[ends], doubt[ends], 0 * begin
        self._settle(
            steps, _concatenate(Points(functions, position + begin, *columns), inner),
            _concatenate(whole, parts),
        )  # fmt: skip

    def _read_start(self, steps: Steps, near: Array) -> None:
        """Take over the events of functions that vanish at the start, up to a part of a step."""
        key = "events at the start", self.setup, float(steps.length[0])
        first = self.start.once(key, lambda: self._at_start(steps, near))
        self._hits += first._hits
        self._touches |= first._touches
        self._unresolved |= first._unresolved
        self._sign[near] = first._sign[near]
        self._weight[near] = first._weight[near]
        self._undecided[near] = first._undecided[near]

    def _at_start(self, steps: Steps, near: Array) -> Zeros:
        """Return the events of functions that vanish at the start, on shrinking intervals."""
        found = Zeros(self.setup, self.start)
        layout, number, bits = self.setup.layout, self._mpfr.number, self.setup.precision.bits
        row = [number(x) for x in self.start.first_row(self.setup.formulation, self.setup.record)]
        body, order = self._body_of(number), FIRST_ORDER + bits // 20
        entries = layout.moving(body, row, self._mpfr)[0]
        series = [entry.upto(order)[: order + 1] for entry in entries]
        first = of_series(series, number(float(steps.length[0])), self.setup)
        sizes = steps.part(0, 1).sampled(numpy.zeros(1)).size
        left = abs(first.series[0, :, -1:]) * OMITTED
        rounding = 2.0 ** -(bits + GUARD)
        bounds = shrinking(bits)
        relative = rounding + numpy.where(sizes > 0, left / sizes, 0.0) * bounds[1:] ** order
        ends = [x.ravel() for x in first.sampled(numpy.array([0.0, 1.0])).row]
        errors = [
            (self._sizes(ends, sizes * x[:, None] / rounding) * rounding)[near].max(axis=1)
            for x in relative.T
        ]
        low, width, count = bounds[:-1], numpy.diff(bounds), len(near)
        which, error = numpy.tile(near, len(low)), numpy.concatenate(errors)
        parts, inner = self._divided(
            first, which, 0 * which, numpy.repeat(low, count), numpy.repeat(width, count), error,
            error,
        )  # fmt: skip
        at, last = numpy.full(count, FIRST_PART), errors[-1]
        end = self._values(first, near, 0 * near, at, last)
        found._settle(first, _concatenate(Points(near, at, end, last, last, 0 * at), inner), parts)
        return found

    # ---- values and errors ----------------------------------------------------------------------

    def _body_of(self, number: Callable[[Scalar], Scalar]) -> Any:
        form = self.setup.formulation
        return form.body([number(x) for x in self.start.parameters(form)])

    def _along(
        self, which: Sequence[int], body: Any, row: Sequence[Scalar], fn: Functions
    ) -> Iterator[Scalar]:
        """Give some functions at rows in any arithmetic."""
        layout = self.setup.layout
        q = layout.motion(body, row, fn)
        moving = None
        for event in (self.events[i] for i in which):
            if event.of_rate:
                moving = moving or layout.moving(body, row, fn)[1]
                value = event_value(event, moving)
                yield value[0] if isinstance(value, TaylorSeries) else value
            else:
                yield event_value(event, q)

    def _table(self, row: Sequence[Array]) -> Array:
        """Return all functions at rows of doubles."""
        table = numpy.empty((len(self.events), *row[0].shape))
        for i, value in enumerate(self._along(range(len(table)), self._body, row, numpy)):
            table[i] = value
        return table

    def _values(
        self, steps: Steps, which: Array, step: Array, position: Array, doubt: Array
    ) -> Array:
        """Return functions at positions in steps, in the run's arithmetic where doubles fail."""
        if steps.wide and steps.wide.only:
            return self._wide_values(steps.wide, which, step, position)
        table = self._table(steps.inside(step, position))
        f: Array = table[which, numpy.arange(len(which))]
        if steps.wide:
            largest = abs(f).max(axis=tuple(range(1, f.ndim)), initial=0)
            lost = numpy.flatnonzero(~(largest > doubt / SHAPE))
            if len(lost):
                f[lost] = self._wide_values(steps.wide, which[lost], step[lost], position[lost])
        return f

    def _wide_values(self, wide: Wide, which: Array, step: Array, position: Array) -> Array:
        """Return functions at positions, evaluated in the wide arithmetic, as doubles."""
        shape = (-1, *(1,) * (position.ndim - 1))
        mine, at = (x.reshape(shape) + 0 * position for x in (which, step))
        there, index = numpy.unique(at + 1j * position, return_inverse=True)
        _, row = wide.rows(there.real.astype(int), wide.array(there.imag))
        functions = sorted(set(which.tolist()))
        table = self._along(functions, self._body_of(wide.number), row, wide.fn)
        index, f = index.reshape(mine.shape), numpy.empty(mine.shape)
        for i, value in zip(functions, table, strict=True):
            here = mine == i
            f[here] = (value + 0 * row[0])[index[here]]
        return f

    def _of_wide(self, wide: Wide, i: int, row: Sequence[Array]) -> Array:
        """Return one function at rows of wide numbers."""
        (value,) = self._along([i], self._body_of(wide.number), row, wide.fn)
        return value + 0 * row[0]

    def _errors(self, steps: Steps, sampled: Sampled) -> tuple[Array, Array]:
        """Return errors of the functions at the ends of the steps: in the run, and in double.

        The size of a component in a step is its largest term. A step adds a rounding and the terms
        that it omits, and a value has the roundings of its series. Where a component is small, the
        errors of the others are more: at least those that its rate makes of them in one step.
        """
        row, size, (last, before), rounded = sampled
        left = OMITTED * (last + OMITTED * before)
        rounding = 2.0**-self.setup.precision.bits
        if self._lost is None:
            self._lost = numpy.zeros((len(size), 1))
        lost = self._lost + numpy.cumsum(numpy.where(size > 0, left / size, 0) + rounding, axis=1)
        errors = size * lost + rounded * rounding
        coupled = self._errors_of_rates(row[:, 0], errors / rounding) * rounding * steps.length
        errors = numpy.fmax(errors, coupled)  # rates are undefined where gliding begins
        self._lost, self._error = lost[:, -1:], errors[:, -1]
        ends = [*numpy.append(row[:, 0], row[:, -1, -1:], axis=1)]
        self._of_steps = rounded, errors
        errors, rounded = (numpy.append(x, x[:, -1:], axis=1) for x in (errors, rounded))
        for x in (errors, rounded):
            x[:, 1:-1] = numpy.fmax(x[:, 1:-1], x[:, :-2])
        return self._propagated(ends, rounded, errors)[::-1]

    def _errors_inside(
        self, steps: Steps, which: Array, step: Array, position: Array
    ) -> tuple[Array, Array]:
        """Return errors of functions at positions in steps: in the run, and in double.

        They may exceed those at both ends of a step, within which the axis passes a pole.
        """
        rounded, errors = (x[:, step] for x in self._of_steps)
        both = self._propagated([*steps.inside(step, position)], rounded, errors)
        doubt, error = (x[which, numpy.arange(len(which))] for x in both)
        return error, doubt

    def _errors_of_rates(self, states: Array, errors: Array) -> Array:
        """Return the errors of the rates at ``states``, from their ``errors``, in roundings."""
        row = list(map(Sized, states, errors))
        rates = self.setup.layout.rates(self._body, row, SizedFunctions())
        of_rates = numpy.zeros_like(errors)
        for i, rate in enumerate(rates):
            of_rates[i] = getattr(rate, "size", 0.0)
        return of_rates

    def _propagated(
        self, rows: Sequence[Array], rounded: Array, errors: Array
    ) -> tuple[Array, Array]:
        """Return the errors of the functions from errors of components: in double, and in the run.

        ``rows`` are arrays of one axis; ``errors`` are those of the run, ``rounded`` the roundings
        of a value in double.
        """
        error = self._sizes(rows, numpy.maximum(errors / ROUNDING, rounded)) * ROUNDING
        if self.setup.precision.is_float:
            return error, error
        rounding = 2.0**-self.setup.precision.bits
        return error, self._sizes(rows, errors / rounding) * rounding

    def _sizes(self, rows: Sequence[Array], errors: Array) -> Array:
        """Return the errors of the functions, from errors of components, both in roundings."""
        row = [Rounded(x, size + 0 * x) for x, size in zip(rows, errors, strict=True)]
        table = numpy.zeros((len(self.events), len(rows[0])))
        values = self._along(range(len(table)), self._body, row, SizedFunctions())
        for i, value in enumerate(values):
            table[i] = getattr(value, "size", 0.0)
        return table

    def _require_defined(self, f: Array, row: Sequence[Array]) -> None:
        undefined = [e for e, x in zip(self.events, f, strict=True) if not numpy.isfinite(x)]
        if not undefined:
            return
        q = self.setup.layout.motion(self._body, row, numpy)
        bent = [
            e.name for e in undefined if e.of_rate and numpy.isfinite(numpy.ravel(e.function(q))[0])
        ]
        advice = (
            f"; of {', '.join(bent)} only the rate is undefined there, as of a root where v_A = 0: "
            f"use the square, or {EXTREMUM}gliding_speed"
        )
        raise InputError(
            f"events: got {', '.join(e.name for e in undefined)}, undefined at the start, expected "
            "a function that is defined there, such as theta_max, phi_dot_zero or nu_x_zero"
            + (advice if bent else "")
        )

    # ---- parts of steps -------------------------------------------------------------------------

    def _divided(
        self, steps: Steps, which: Array, step: Array, low: Array, width: Array, error: Array,
        doubt: Array, inside: ErrorsInside | None = None,
    ) -> tuple[Intervals, Points]:  # fmt: skip
        """Return parts of steps with polynomials of the functions' shape, and points inside.

        The points are the extrema, and the bounds between the parts of a step. ``inside`` gives the
        errors in the middle of a part that is halved, which count in both halves.

        Raises ``InputError``: a function is undefined inside, or there are too many parts.
        """
        done, parts = [], 0
        waiting: list[tuple[int, Sequence[Array]]]
        waiting = [(0, (which, step, low, width, error, doubt))]
        while waiting:
            halving, columns = waiting.pop()
            if len(columns[0]) > MOST_INTERVALS:
                halves = slice(MOST_INTERVALS), slice(MOST_INTERVALS, None)
                waiting += [(halving, [x[half] for x in columns]) for half in halves]
                continue
            which, step, low, width, error, doubt = columns
            positions = low[:, None] + width[:, None] * nodes(FINE)
            f = self._values(steps, which, step, positions, doubt).T
            polynomials, largest = through(f, ~self._smooth[which]), abs(f).max(axis=0, initial=0)
            shaped = polynomials.tail <= numpy.maximum(SHAPE * largest, doubt)
            last = halving == BISECTIONS
            self._require_defined_inside(steps, which, step, low, width, f, last)
            shaped |= last & numpy.isfinite(polynomials.tail)
            kept = [x[shaped] for x in (*columns, f[0], largest, polynomials.tail)]
            done.append((*kept, polynomials.bernstein[:, shaped], polynomials.monomials[:, shaped]))
            parts += len(kept[0])
            _require_few(parts)
            if last or shaped.all():
                continue
            columns = [x[~shaped] for x in columns]
            which, step, low, width, error, doubt = columns
            if inside:
                middle = inside(steps, which, step, low + width / 2)
                # where errors exceed the function it may be undefined, which is asked later
                known = middle[1] <= largest[~shaped]
                columns[4:] = (
                    numpy.where(known, numpy.fmax(before, there), before)
                    for before, there in zip((error, doubt), middle, strict=True)
                )
            which, step, low, width, error, doubt = (numpy.tile(x, 2) for x in columns)
            width = width / 2
            low[len(low) // 2 :] += width[len(low) // 2 :]
            waiting.append((halving + 1, (which, step, low, width, error, doubt)))
        which, step, low, width, error, doubt, first, largest, tail, bernstein, monomials = (
            numpy.concatenate(part, axis=-1) for part in zip(*done, strict=True)
        )
        _, certain = sign_changes(bernstein, tail + doubt)
        # an interval that is below its error everywhere has nothing to decide
        open_ = numpy.flatnonzero(~certain & (abs(bernstein).max(axis=0, initial=0) > error))
        of, inside = extrema(Polynomials(bernstein[:, open_], tail[open_], monomials[:, open_]))
        of = open_[of]
        position = low[of] + width[of] * inside
        value = self._values(steps, which[of], step[of], position, doubt[of])
        flat = numpy.maximum(doubt, largest * ROUNDING / SHAPE)
        turning = Points(which[of], step[of] + position, value, error[of], flat[of], width[of])
        bounds = Points(which, step + low, first, error, flat, 0 * low)
        inner = Points(*(x[low > 0] for x in bounds))
        return Intervals(which, step + low, width, monomials), _concatenate(turning, inner)

    def _require_defined_inside(
        self, steps: Steps, which: Array, step: Array, low: Array, width: Array, f: Array,
        last: bool,
    ) -> None:  # fmt: skip
        """Refuse parts of steps in which all values are undefined, and in the last parts one value.

        A function may be undefined where a segment begins or ends.
        """
        finite = numpy.isfinite(f)
        undefined = ~(finite.all(axis=0) if last else finite.any(axis=0))
        undefined &= (step + low > 0) & (step + low + width < len(steps))
        for i, position in zip(which[undefined], (step + low)[undefined], strict=True):
            raise self._broken(int(i), steps, float(position))

    def _broken(self, i: int, steps: Steps, position: float) -> InputError:
        step = min(int(position), len(steps) - 1)
        t = steps.begin[step] + (position - step) * steps.length[step]
        t = float(t) * float(self.start.units.time)
        return InputError(
            f"events: got {self.events[i].name}, which jumps or is undefined at t = {t:.6g} s, "
            "expected a continuous function that is always defined, such as theta_max or "
            "phi_dot_zero"
        )

    # ---- signs ----------------------------------------------------------------------------------

    def _settle(self, steps: Steps, points: Points, intervals: Intervals) -> None:
        """Record the changes of sign between points, and the functions that are undecided."""
        unsure = numpy.flatnonzero(abs(points.value) <= points.doubt)
        if steps.wide and len(unsure):
            self._decide(steps, steps.wide, points, unsure)
        order = numpy.lexsort((points.position, points.which))
        points = Points(*(x[order] for x in points))
        low, high, direction = self._changes(points)
        if len(low):
            self._record(steps, points, low, high, direction, intervals)

    def _changes(self, points: Points) -> tuple[Array, Array, Array]:
        """Return the points before and behind the events between points, and the directions.

        Before the points of a function stand its last sign that counts and, if points are undecided
        after that, one with their weight.
        """
        functions = numpy.arange(len(self.events))
        later = numpy.flatnonzero(self._undecided)
        order = numpy.argsort(numpy.concatenate([functions, later, points.which]), kind="stable")
        # an undecided extremum, and an undecided end of a step
        own = numpy.where(points.reach > 0, 2, points.position == numpy.floor(points.position))
        which, signs, weights, counts = (
            numpy.concatenate(parts)[order]
            for parts in (
                (functions, later, points.which),
                (self._sign, 0 * later, numpy.sign(points.value).astype(int)),
                (0 * functions, self._weight[later], own),
                (functions >= 0, later < 0, abs(points.value) > points.error),
            )
        )
        undecided = numpy.cumsum(weights * ~counts)
        seen = numpy.flatnonzero(counts)
        previous, here = seen[:-1], seen[1:]
        within = which[previous] == which[here]
        previous, here = previous[within], here[within]
        before, counted, of = signs[previous], signs[here], which[here]
        lost = undecided[here] - undecided[previous] > TANGENCY
        gap = (here - previous > 1) & (before != 0)
        self._touches.update(of[gap & (before == counted)].tolist())
        self._unresolved.update(of[gap & lost].tolist())
        wanted = (before * counted < 0) & (
            (self._direction[of] == 0) | (self._direction[of] == counted)
        )
        high = here.copy()
        for k in numpy.flatnonzero(wanted & (here - previous > 1)).tolist():
            while signs[high[k] - 1] == counted[k]:
                high[k] -= 1
        last = seen[numpy.searchsorted(which[seen], functions, side="right") - 1]
        end = numpy.searchsorted(which, functions, side="right") - 1
        self._sign, self._weight = signs[last], undecided[end] - undecided[last]
        self._undecided = last < end
        number = order - len(order) + len(points.which)  # of a point, below 0 for those before all
        high, low = number[high[wanted]], number[high[wanted] - 1]
        return numpy.where(low < 0, high, low), high, counted[wanted]

    def _decide(self, steps: Steps, wide: Wide, points: Points, unsure: Array) -> None:
        """Replace values by the wide arithmetic's, at extrema by those of the nearby vertex."""
        still = unsure[points.reach[unsure] == 0]
        step = numpy.minimum(points.position[still].astype(int), len(steps) - 1)
        position = points.position[still] - step
        if len(still):
            points.value[still] = self._wide_values(wide, points.which[still], step, position)
        turning = unsure[points.reach[unsure] > 0]
        for i in set(points.which[turning].tolist()):
            here = turning[points.which[turning] == i]
            step = numpy.minimum(points.position[here].astype(int), len(steps) - 1)
            value = partial(self._in_wide, wide, i, step)
            position, reach = wide.array(points.position[here] - step), points.reach[here]
            # Beyond the steps the function may be another one.
            low, high = -step.astype(float), (len(steps) - step).astype(float)
            position, extreme = vertex(value, position, reach, low, high, self.setup.precision.bits)
            points.value[here] = extreme
            points.position[here] = step + position.astype(float)

    def _record(
        self, steps: Steps, points: Points, low: Array, high: Array, direction: Array,
        intervals: Intervals,
    ) -> None:  # fmt: skip
        """Record the zeros between neighbouring points, of which ``high`` is behind the zero.

        Raises ``InputError``: a function jumps there.
        """
        which, begin, end = points.which[high], points.position[low], points.position[high]
        error = numpy.maximum(points.error[low], points.error[high])
        step = numpy.minimum(begin, len(steps) - 1).astype(int)
        position, slope, reach = begin - step, 0 * begin + numpy.inf, end - begin
        if len(intervals.which):
            mine = _last_before(intervals, which, begin)
            origin, width = intervals.position[mine], intervals.width[mine]
            inside = (intervals.which[mine] == which) & (begin >= origin) & (begin < origin + width)
            left, right = (2 * numpy.clip((x - origin) / width, 0, 1) - 1 for x in (begin, end))
            root, rate = zero_between(intervals.monomials[:, mine], left, right, direction)
            position = numpy.where(inside, origin - step + width * (1 + root) / 2, position)
            slope = numpy.where(inside, 2 * rate / width, slope)
        zeros = self._zeros(
            steps, which, step, Bracket(position, begin - step, end - step, slope, direction)
        )
        # against the value on the same side of the zero
        before = zeros.value * direction < 0
        beside = abs(numpy.where(before, points.value[low], points.value[high]))
        broken = (abs(zeros.value) > JUMP * beside) & (abs(zeros.value) > error) & (reach > 0)
        for k in numpy.flatnonzero(broken & ~self._smooth[which]).tolist():
            raise self._broken(int(which[k]), steps, float(begin[k]))
        names = numpy.array([event.name for event in self.events], dtype=object)
        self._hits.append(Hits(names[which], zeros.times, direction, zeros.states))
        self._last = numpy.where(points.position[high] == len(steps), which, -1)
        _require_few(sum(map(len, self._hits)))

    def _zeros(self, steps: Steps, which: Array, step: Array, bracket: Bracket) -> _Zero:
        """Return the zeros of functions in steps, to the last bits of the run."""
        wide = steps.wide
        if not wide:
            states = numpy.empty((steps.series.shape[1], len(which)))
            function = partial(self._in_double, steps, which, step, states)
            position, left = refine(function, bracket, 53)
            times = steps.begin[step] + position * steps.length[step]
            return _Zero(times, states.T, left)
        position, low, high = map(wide.array, bracket[:3])
        bracket = bracket._replace(position=position, low=low, high=high)
        left, bits = numpy.zeros(len(which)), self.setup.precision.bits
        for i in set(which.tolist()):
            here = which == i
            function, part = partial(self._in_wide, wide, i, step[here]), bracket.of(here)
            position[here], left[here] = refine(function, part, bits)
        when, row = wide.rows(step, position)
        back = numpy.frompyfunc(wide.back, 1, 1)
        kind = float if self.setup.precision.is_float else object
        return _Zero(back(when).astype(kind), back(numpy.array(row)).T.astype(kind), left)

    def _in_double(
        self, steps: Steps, which: Array, step: Array, states: Array, position: Array,
        rows: Any = slice(None),
    ) -> Array:  # fmt: skip
        """Return functions at positions in steps, and keep the states there."""
        states[:, rows] = row = steps.inside(step[rows], position)
        f: Array = self._table(row)[which[rows], numpy.arange(len(position))]
        return f

    def _in_wide(
        self, wide: Wide, i: int, step: Array, position: Array, rows: Any = slice(None)
    ) -> Array:
        return self._of_wide(wide, i, wide.rows(step[rows], position)[1])


class _Zero(NamedTuple):
    """Times and states of zeros, and the values of the functions at the zeros."""

    times: Array
    states: Array
    value: Array


def _require_few(count: int) -> None:
    if count > MOST_EVENTS:
        raise InputError(
            f"events: got more than {MOST_EVENTS}, or functions with as many bends, expected "
            "fewer: ask for a shorter time or for fewer kinds of them"
        )


def _last_before(intervals: Intervals, which: Array, position: Array) -> Array:
    """Return for each position of a function the interval of that function that begins last."""
    count = len(intervals.which)
    functions = numpy.concatenate([intervals.which, which])
    positions = numpy.concatenate([intervals.position, position])
    # a stable order: an interval that begins at a position comes first
    order = numpy.lexsort((positions, functions))
    asked = order >= count
    before = numpy.maximum(numpy.cumsum(~asked) - 1, 0)
    last = numpy.empty(len(which), dtype=int)
    last[order[asked] - count] = order[~asked][before[asked]]
    return last


def _concatenate(first: Any, second: Any) -> Any:
    return type(first)(
        *(numpy.concatenate(pair, axis=-1) for pair in zip(first, second, strict=True))
    )
