"""The enclosed motion of a problem, step by step: its phases, samples and events.

``enclose`` continues to the horizon, or to the end of the motion. If the hypotheses, signs or zeros
of a step cannot be verified, the step is repeated with half the length from the states before it;
if shorter steps do not help either, nothing is proved.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import flint
from flint import arb, arb_poly

from tt_precise.certify.balls import NotProved, require_outward_rounding
from tt_precise.certify.kernel import LOW_BITS, KernelEquations, StateSet, Step, advance
from tt_precise.certify.models import Rates
from tt_precise.certify.problem import EventKind, Problem, ProblemPhase
from tt_precise.certify.propose import Proposer
from tt_precise.certify.start import Function
from tt_precise.certify.zeros import StepZeros

ORDER = 70  # Taylor order; 90 to 100 are some 15 % faster, and the models wider.
DOUBLE_ERROR = 2.0**-52  # Relative error of a double, doubled.
# A bound of a function is this near a value of it, or comes from this small a part of a step.
NARROW, SHORT = 1e-9, 2.0**-24
MOST_PARTS = 100_000  # Most parts of steps for a bound: with wide models it is not so close.


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


@dataclass(frozen=True)
class Enclosure:
    """The solution, until the horizon or the ``end`` of the motion.

    ``samples`` has the states at the problem's samples that the motion reaches, each with its
    phase; ``events`` has all events by kind, in order of time, including ends of phases.
    """

    problem: Problem
    bits: int
    steps: Sequence[VerifiedStep]
    samples: Sequence[tuple[ProblemPhase, Sequence[arb]]]
    events: Mapping[str, Sequence[EnclosedEvent]]
    end: EnclosedEvent | None

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
        """Return a lower bound of a function, close to its least value.

        Raises ``NotProved``: the function has no finite bound.
        """
        with flint.ctx.workprec(LOW_BITS):
            parts = list(self._intervals(function))
            least = min(part.value(part.b).upper() for part in parts)
            bounds = [(float(part.low), n) for n, part in enumerate(parts)]
            heapq.heapify(bounds)
            while True:
                low, n = bounds[0]
                if not (math.isfinite(low) and least.is_finite()):
                    raise NotProved("balls", "a function has no finite bound")
                short = parts[n].b - parts[n].a < SHORT or len(parts) > MOST_PARTS
                if low > least - NARROW or short:
                    # as a double it may be rounded up
                    return arb(low) - abs(arb(low)) * DOUBLE_ERROR
                least = min(least, parts[n].value(parts[n].middle).upper())
                heapq.heappop(bounds)
                for half in parts[n].halves:
                    heapq.heappush(bounds, (float(half.low), len(parts)))
                    parts.append(half)

    def _intervals(self, function: Function) -> Iterator[_Interval]:
        for verified in self.steps:
            step = verified.step
            end = min(step.length, ((verified.until - step.time) / step.unit).upper())
            value, slope = StepZeros(step, verified.phase.motion).with_slope(function)
            yield _Interval(value, slope, arb(0), end)


class _Interval(NamedTuple):
    """A function with its derivative between two local times of a step."""

    value: arb_poly
    slope: arb_poly
    a: arb
    b: arb

    @property
    def middle(self) -> arb:
        return ((self.a + self.b) / 2).mid()

    @property
    def low(self) -> arb:
        """A bound from the values, or from that in the middle and the slope."""
        part, middle = self.a.union(self.b), self.middle
        by_slope = self.value(middle) + self.slope(part) * (part - middle)
        lows = [x.lower() for x in (self.value(part), by_slope)]
        return max(lows) if all(x.is_finite() for x in lows) else arb("nan")

    @property
    def halves(self) -> tuple[_Interval, _Interval]:
        middle = self.middle
        return self._replace(b=middle), self._replace(a=middle)


def enclose(problem: Problem, bits: int, order: int = ORDER) -> Enclosure:
    """Enclose the motion of a problem, in the working precision of the moment.

    Raises ``NotProved``: a hypothesis, a sign or a zero could not be verified.
    """
    require_outward_rounding()
    return _Walk(problem, bits, order).through()


class _Walk:
    """A motion in progress: the enclosure up to the present time."""

    def __init__(self, problem: Problem, bits: int, order: int):
        self.problem, self.bits, self.order = problem, bits, order
        self.phases = list(problem.phases)
        self.steps: list[VerifiedStep] = []
        self.samples: list[tuple[ProblemPhase, Sequence[arb]]] = []
        self.events: dict[str, list[EnclosedEvent]] = {name: [] for name in problem.kinds}
        self.end: EnclosedEvent | None = None
        self._enter(arb(0), list(problem.start))

    def _enter(self, time: arb, state: Sequence[arb]) -> None:
        """Go on in the first of the phases."""
        phase = self.phases[0]
        if phase.positive and not phase.function(phase.motion(state)) > 0:
            what = f"the motion is not proved to begin before {phase.ends}"
            raise NotProved("contact", what)
        rates = Rates(phase.rates, len(state))
        self.equations = KernelEquations(rates, self.bits, self.order)
        self.states = StateSet.of(self.equations, time, state)
        self.proposer = Proposer(self.equations)
        self.entered = True

    def through(self) -> Enclosure:
        until = self.problem.until
        while self.end is None and not self.states.time > until:
            power, length = self.proposer.next(float(until - self.states.time))
            try:
                step = advance(self.equations, self.states, power, length)
                if not self.proposer.accepts(step):
                    continue
                ended = self._happened(step)
            except ArithmeticError as why:
                self.proposer.shorten(why)
                continue
            self.states, self.entered, self.proposer.failures = step.after, False, 0
            if ended is not None:
                self._switch(ended)
        return Enclosure(self.problem, self.bits, self.steps, self.samples, self.events, self.end)

    def _happened(self, step: Step) -> EnclosedEvent | None:
        """Record all that happens in a step, or nothing; return the end of its phase, if any."""
        phase, until = self.phases[0], self.problem.until
        zeros = StepZeros(step, phase.motion, self._order if self.entered else None)
        ended = _end_of(phase, zeros, step, until)
        end = until if ended is None else ended.time
        samples = []
        for time in self.problem.samples[len(self.samples) :]:
            if not time < step.finish or (ended is not None and time > ended.time):
                break
            if ended is not None and not time < ended.time:
                raise NotProved("time", f"whether a sample comes after {phase.ends} is undecided")
            samples.append((phase, step.state(time)))
        events = {
            name: _events(kind, zeros, phase, step, end)
            for name, kind in self.problem.kinds.items()
            if phase.glides or not kind.gliding
        }
        self.samples += samples
        for name, happened in events.items():
            self.events[name] += happened
        self.steps.append(VerifiedStep(phase, step, end if end < step.finish else step.finish))
        return ended

    def _switch(self, ended: EnclosedEvent) -> None:
        phase = self.phases[0]
        self.events.setdefault(phase.ends, []).append(ended)
        if phase.is_last:
            self.end = ended
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
    kind: EventKind, zeros: StepZeros, phase: ProblemPhase, step: Step, end: arb
) -> list[EnclosedEvent]:
    double: list[arb] = []
    if kind.double is not None:
        turn, way = kind.double
        double = [zero.time for zero in zeros.of(turn, end) if zero.direction == way]
    return [
        EnclosedEvent(zero.direction, zero.time, step.state(zero.time), phase)
        for zero in zeros.of(kind.function, end, double)
        if kind.direction in (0, zero.direction)
    ]
