"""The enclosed motion of a problem, step by step: its phases, samples, zeros and events.

``enclose`` continues to the horizon, or to the end of the motion. If the hypotheses, signs or zeros
of a step cannot be verified, the step is repeated with half the length from the states before it;
if shorter steps do not help either, nothing is proved.

``StepZeros`` proves that zeros exist and that there are no others. Taylor models enclose a function
F of the motion and its derivatives along the solution. If F excludes zero, there is no zero. If F'
excludes zero, F is monotone: exactly one zero if the signs at the two ends differ, none if they
agree. A part of the step where neither holds is halved. Interval Newton then refines a zero:
N = m - F(m)/F'(T) contains every zero in T (R. E. Moore, "Interval analysis", 1966).

At the start of a motion many functions vanish, to an order n that ``problem`` decides. If the n-th
derivative excludes zero on [0, b], F has no zero in (0, b], by Taylor's theorem. Likewise, if
F = F' = 0 at a known instant of a part where F'' excludes zero, this instant is the only zero of F
in the part, and F does not change sign there.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import flint
from flint import arb, arb_poly

from tt_precise.certify.balls import NotProved, require_outward_rounding
from tt_precise.certify.kernel import LOW_BITS, StateSet, Step, advance
from tt_precise.certify.models import PowerSeries, Rates, polynomial, solution
from tt_precise.certify.problem import Function, Problem, ProblemPhase
from tt_precise.certify.propose import Lengths
from tt_precise.integration.events import TERMINAL, Event

ORDER = 70  # Taylor order; 90 to 100 are some 15 % faster, and the models wider.
DOUBLE_ERROR = 2.0**-52  # Relative error of a double, doubled.
# A bound of a function is this near a value of it, or is that of a box as short as this.
NARROW, SHORT = 1e-9, 2.0**-24
MOST_BOXES = 100_000  # Most boxes for a bound: with wide models it is not so close.
CLOSEST = arb(2) ** -200  # Shortest part of a step, relative to it: the search ends there.
NEWTON = 100  # Steps of Newton's method at most; each doubles the digits.


class Zero(NamedTuple):
    """A simple zero: +1 where the function rises, -1 where it falls; a ball around its time."""

    direction: int
    time: arb


class StepZeros:
    """The zeros of functions in a step.

    ``motion`` turns a state into the argument of the functions. ``order`` says to which order a
    function vanishes at the start of the step; None in a step that continues another one. Where
    the step's ``tube`` leaves a sign undecided, its ``sharp`` models are used.
    """

    def __init__(
        self,
        step: Step,
        motion: Callable[[Sequence[Any]], Any],
        order: Callable[[Function], int] | None = None,
        *,
        sharp: bool = False,
    ):
        self.step, self.motion, self.order, self.is_sharp = step, motion, order, sharp
        models = step.sharp if sharp else step.tube
        self.along = motion(solution(step.rates, models))

    def of(self, function: Function, until: arb, double: Sequence[arb] = ()) -> list[Zero]:
        """Return all zeros after t = 0 of a function up to a time ``until``, in order.

        At the times ``double`` the function and its derivative are known to be zero.

        Raises ``NotProved``: whether there is a zero is undecided.
        """
        try:
            return self._of(function, until, double)
        except NotProved:
            if self.is_sharp:
                raise
        return self._sharper.of(function, until, double)

    def never_below(self, function: Function, until: arb) -> bool:
        """Return whether a function is proved to be positive up to a time, by its value alone."""
        value = polynomial(function(self.along))
        return bool(value(arb(0).union(self._end(until))) > 0)

    def with_slope(self, function: Function) -> tuple[arb_poly, arb_poly]:
        """Return polynomials with balls as coefficients that contain a function and its slope."""
        along = function(self.along)
        return polynomial(along), polynomial(along, 1)

    @cached_property
    def _sharper(self) -> StepZeros:
        return StepZeros(self.step, self.motion, self.order, sharp=True)

    def _end(self, until: arb) -> arb:
        """Return the local time of the end of the search."""
        return min((until - self.step.time).upper(), self.step.length)

    def _of(self, function: Function, until: arb, double: Sequence[arb]) -> list[Zero]:
        step, zeros, along = self.step, list[Zero](), function(self.along)
        value, slope = polynomial(along), polynomial(along, 1)
        if not value.length() or not slope.length():
            return []  # it is constant
        begin, end = self._past_the_start(function, along), self._end(until)
        waiting = [(begin, end)] if end > begin else []
        while waiting:
            a, b = waiting.pop()
            part = a.union(b)
            if not value(part).contains(0):
                continue
            if not slope(part).contains(0):
                before, after = (self._value(function, s) for s in (a, b))
                if before.contains(0) or after.contains(0):
                    raise self._undecided
                if (before > 0) != (after > 0):
                    time = step.time + self._refined(function, slope, part)
                    zeros.append(Zero(1 if after > 0 else -1, time))
                continue
            has_double_zero = any(a < t - step.time < b for t in double)
            if has_double_zero and not polynomial(along, 2)(part).contains(0):
                continue
            if not b - a > step.length * CLOSEST:
                raise self._undecided
            middle = ((a + b) / 2).mid()
            waiting += [(middle, b), (a, middle)]
        zeros = [zero for zero in zeros if not zero.time > until]
        if any(not zero.time < until for zero in zeros):
            raise self._undecided
        return zeros

    def _past_the_start(self, function: Function, along: PowerSeries) -> arb:
        """Return some b such that a function that vanishes at the start has no zero in (0, b].

        By Taylor's theorem its first derivative that does not vanish there would have one as well.
        Of others it is 0.
        """
        if self.order is None or not self._value(function, arb(0)).contains(0):
            return arb(0)
        b, order = self.step.length, self.order(function)
        if not order:
            return arb(0)
        derivative = polynomial(along, order)
        while derivative(arb(0).union(b)).contains(0):
            b = (b / 2).mid()
            if not b > self.step.length * CLOSEST:
                raise self._undecided
        return b

    @property
    def _undecided(self) -> NotProved:
        return NotProved("zeros", f"a sign near t = {float(self.step.time):.6g} is undecided")

    def _refined(self, function: Function, slope: arb_poly, zero: arb) -> arb:
        """Return a smaller ball around the only zero in a part, by interval Newton."""
        for _ in range(NEWTON):
            middle, before = zero.mid(), zero.rad()
            zero = zero.intersection(middle - self._value(function, middle) / slope(zero))
            if not zero.rad() < before / 2:
                break
        return zero

    def _value(self, function: Function, s: arb) -> arb:
        return arb(function(self.motion(self.step.at(s))))


@dataclass(frozen=True)
class EnclosedEvent:
    """An event in one ``phase``: direction, and balls around time and state."""

    direction: int
    time: arb
    state: Sequence[arb]
    phase: ProblemPhase


@dataclass(frozen=True)
class VerifiedStep:
    """A verified step of a phase, of which at most the part up to ``until`` is used."""

    phase: ProblemPhase
    step: Step
    until: arb


@dataclass
class Enclosure:
    """The solution, until the horizon or the ``end`` of the motion.

    ``samples`` has the states at the problem's samples that the motion reaches, each with its
    phase; ``events`` has all events by kind, in order of time, including ends of phases.
    """

    problem: Problem
    events: dict[str, list[EnclosedEvent]]
    steps: list[VerifiedStep] = field(default_factory=list)
    samples: list[tuple[ProblemPhase, Sequence[arb]]] = field(default_factory=list)
    end: EnclosedEvent | None = None

    def state(self, time: arb) -> tuple[ProblemPhase, list[arb]]:
        """Return phase and state at a time up to the horizon.

        Raises ``NotProved``: the time is not surely in one step.
        """
        for verified in self.steps:
            step, until = verified.step, verified.until
            before = time <= until or (until is self.problem.until and time <= step.finish)
            if before and time >= step.time:
                return verified.phase, step.state(time)
        raise NotProved("time", f"t = {float(time):.6g} is not enclosed")

    def least(self, function: Function) -> arb:
        """Return a lower bound of a function, close to its least value, by best-first search.

        Raises ``NotProved``: the function has no finite bound.
        """
        with flint.ctx.workprec(LOW_BITS):
            boxes = list[Box]()
            for verified in self.steps:
                step = verified.step
                value, slope = StepZeros(step, verified.phase.motion).with_slope(function)
                end = min(step.length, (verified.until - step.time).upper())
                boxes.append(Box(value, slope, arb(0), end))
            least = min(box.value(box.b).upper() for box in boxes)
            queue = [(box.bound(), n) for n, box in enumerate(boxes)]
            heapq.heapify(queue)
            while True:
                bound, n = queue[0]
                value, slope, a, b = boxes[n]
                if bound > least - NARROW or b - a < SHORT or len(boxes) > MOST_BOXES:
                    # as a double it may be rounded up
                    return arb(bound) - abs(arb(bound)) * DOUBLE_ERROR
                middle = ((a + b) / 2).mid()
                least = min(least, value(middle).upper())
                heapq.heappop(queue)
                for half in (Box(value, slope, a, middle), Box(value, slope, middle, b)):
                    heapq.heappush(queue, (half.bound(), len(boxes)))
                    boxes.append(half)


class Box(NamedTuple):
    """A function and its derivative between two local times of a step."""

    value: arb_poly
    slope: arb_poly
    a: arb
    b: arb

    def bound(self) -> float:
        """Return a lower bound, from the values or from the middle and the derivative.

        Raises ``NotProved``: there is no finite bound.
        """
        box, middle = self.a.union(self.b), ((self.a + self.b) / 2).mid()
        by_slope = self.value(middle) + self.slope(box) * (box - middle)
        lows = [x.lower() for x in (self.value(box), by_slope)]
        if not all(x.is_finite() for x in lows):
            raise NotProved("balls", "a function has no finite bound")
        return float(max(lows))


def enclose(problem: Problem, bits: int, order: int = ORDER) -> Enclosure:
    """Enclose the motion of a problem, in the working precision of the moment.

    Raises ``NotProved``: a hypothesis, a sign or a zero could not be verified.
    """
    require_outward_rounding()
    return _Walk(problem, bits, order).through()


class _Walk:
    """A motion in progress, with its enclosure up to the present time."""

    def __init__(self, problem: Problem, bits: int, order: int):
        self.problem, self.bits, self.order = problem, bits, order
        self.phases = list(problem.phases)
        self.enclosure = Enclosure(problem, {name: [] for name in problem.kinds})
        self._enter(arb(0), list(problem.start))

    def _enter(self, time: arb, state: Sequence[arb]) -> None:
        """Go on in the first of the phases."""
        phase = self.phases[0]
        if phase.positive and not phase.function(phase.motion(state)) > 0:
            what = f"the motion is not proved to begin before {phase.ends}"
            raise NotProved("contact", what)
        self.rates = Rates(phase.rates, len(state), self.bits, self.order)
        self.states = StateSet.of(self.rates, time, state)
        self.lengths = Lengths(self.rates)
        self.entered = True

    def through(self) -> Enclosure:
        until = self.problem.until
        while self.enclosure.end is None and not self.states.time > until:
            length = self.lengths.next(float(until - self.states.time))
            try:
                step = advance(self.rates, self.states, length)
                if not self.lengths.accepts(length, step.costs):
                    continue
                ended = self._happened(step)
            except ArithmeticError as why:
                self.lengths.shorten(why)
                continue
            self.states, self.entered, self.lengths.failures = step.after, False, 0
            if ended is not None:
                self._switch(ended)
        return self.enclosure

    def _happened(self, step: Step) -> EnclosedEvent | None:
        """Record all that happens in a step, or nothing; return the end of its phase, if any."""
        phase, until, samples = self.phases[0], self.problem.until, []
        enclosure = self.enclosure
        zeros = StepZeros(step, phase.motion, self._order if self.entered else None)
        ended = _end_of(phase, zeros, step, until)
        end = until if ended is None else ended.time
        for time in self.problem.samples[len(enclosure.samples) :]:
            if not time < step.finish or (ended is not None and time > ended.time):
                break
            if ended is not None and not time < ended.time:
                raise NotProved("time", f"whether a sample comes after {phase.ends} is undecided")
            samples.append((phase, step.state(time)))
        events = {
            name: _events(kind, zeros, phase, end, self.problem.doubles.get(name))
            for name, kind in self.problem.kinds.items()
            if phase.glides or not kind.gliding
        }
        enclosure.samples += samples
        for name, happened in events.items():
            enclosure.events[name] += happened
        end = end if end < step.finish else step.finish
        enclosure.steps.append(VerifiedStep(phase, step, end))
        return ended

    def _switch(self, ended: EnclosedEvent) -> None:
        ends = self.phases[0].ends
        self.enclosure.events.setdefault(ends, []).append(ended)
        if ends in TERMINAL:
            self.enclosure.end = ended
            return
        self.phases.append(self.phases.pop(0))
        self._enter(ended.time, ended.state)

    def _order(self, function: Function) -> int:
        """Return the order to which a function vanishes where the present phase began."""
        if self.states.time == 0:
            order: int = self.problem.onset.order(function)
            return order
        excluded = self.phases[0].excluded
        if excluded is None or function is not excluded[0]:
            where = f"t = {float(self.states.time):.6g}"
            raise NotProved("zeros", f"a sign at {where}, where a phase begins, is undecided")
        return 1


def _end_of(phase: ProblemPhase, zeros: StepZeros, step: Step, until: arb) -> EnclosedEvent | None:
    """Return the event that ends a phase in a step, up to a time ``until``.

    Raises ``NotProved``: whether there is one is undecided, or the equations may end otherwise.
    """
    falls = [] if zeros.never_below(phase.function, until) else zeros.of(phase.function, until)
    first = next((zero.time for zero in falls if zero.direction < 0), None)
    if phase.excluded is not None:
        function, positive = phase.excluded
        for zero in zeros.of(function, until):
            over = zero.direction > 0 or (first is not None and zero.time > first)
            if not (over or positive(phase.motion(step.state(zero.time))) > 0):
                what = f"the equations may end otherwise at t = {float(zero.time):.6g}"
                raise NotProved("contact", what)
    return None if first is None else EnclosedEvent(-1, first, step.state(first), phase)


def _events(
    kind: Event,
    zeros: StepZeros,
    phase: ProblemPhase,
    end: arb,
    double: tuple[Function, int] | None,
) -> list[EnclosedEvent]:
    turn, way = double or (None, 0)
    turns = [zero.time for zero in zeros.of(turn, end) if zero.direction == way] if turn else []
    return [
        EnclosedEvent(zero.direction, zero.time, zeros.step.state(zero.time), phase)
        for zero in zeros.of(kind.function, end, turns)
        if kind.direction in (0, zero.direction)
    ]
