"""Proved zeros and signs of functions along an enclosed solution.

A function F of the state is followed with its derivative along the solution, F' = DF f, as
Taylor models in each step. Where that of F excludes zero there is none. Where that of F' excludes
zero, F is monotone: exactly one zero if its signs at the two ends differ, none if they agree. A
part of a step where neither holds is halved; where that does not help, sharper models may. A
zero is then refined by interval Newton, N = m - F(m)/F'(T): it contains every zero in T (R. E.
Moore, "Interval analysis", 1966).

At t = 0 the order n to which F vanishes and the sign next to it are exact (``onset``). Where the
model of the n-th derivative excludes zero on [0, b], F has no zero in (0, b], by Taylor's theorem.
Likewise F has no other zero than an instant of which it is known that F = F' = 0 there, in a part
where the model of F'' excludes zero; and it does not change sign there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import flint
from flint import arb

from tt_precise.certify.balls import NotProved, between, fraction, largest
from tt_precise.certify.enclosure import VerifiedStep
from tt_precise.certify.onset import Onset
from tt_precise.certify.prover_problem import FUNCTIONS, Function
from tt_precise.certify.taylor_model import DualNumber, TaylorModel
from tt_precise.taylor.series import Series, solution

MOST_HALVINGS = 30  # of a part, in the search for one where F or F' has a sign
MOST_HALVINGS_AT_START = 200  # of the first step, for [0, b]; each costs two evaluations
NEWTON_STEPS = 100  # each adds about 15 digits, or a few where the slope is known roughly


@dataclass(frozen=True)
class Zero:
    """A simple zero that exists and is the only one in its part of the solution.

    ``direction`` is +1 where the function rises; ``time`` and ``state`` are balls.
    """

    time: arb
    direction: int
    state: tuple[arb, ...]


def zeros(
    steps: Iterable[VerifiedStep],
    function: Function,
    *,
    begins: Onset | None = None,
    touches: Sequence[arb] = (),
) -> Iterator[Zero]:
    """All zeros after t = 0 in the steps, in the order of these, as they are proved.

    ``reversed(enclosure.steps)`` gives the last one first. ``begins`` is how F begins in the first
    of the steps, where that is known; it needs it unless F has a sign there.
    ``touches`` are balls around instants at which F and its derivative are known to be zero; where
    F does not change sign there is no event. A function that vanishes identically has none.

    Raises
    ------
    NotProved
        Whether there is a zero could not be decided.
    """
    for step in steps:
        near = [t for t in touches if not (t < step.begin or t > step.finish)]
        with flint.ctx.workprec(step.bits):
            try:
                new_zeros = _Part.of(step, function, begins, near).zeros()
            except NotProved:
                # the function may be tiny relative to its components
                new_zeros = _Part.of(step, function, begins, near, sharp=True).zeros()
        begins = None
        yield from new_zeros


def lower_bound(
    step: VerifiedStep, function: Function, pieces: int = 8, until: arb | None = None
) -> arb:
    """A number that the function is nowhere below on the step, up to a time ``until``.

    Raises ``NotProved``: the function could not be bounded.
    """
    with flint.ctx.workprec(step.bits):
        model = function(step.tube)
        end = step.piece.end
        if until is not None and until < step.finish:
            end = min(end, ((until - step.begin) / step.piece.unit).upper())
        part = end / pieces
        parts = (model.polynomial(between(i * part, (i + 1) * part)) for i in range(pieces))
        return -largest(-part for part in parts)


@dataclass(frozen=True)
class _Part:
    step: VerifiedStep
    function: Function
    value: TaylorModel
    slope: TaylorModel
    sharp: bool

    begins: Onset | None
    touches: Sequence[arb]  # as local times

    @classmethod
    def of(
        cls,
        step: VerifiedStep,
        function: Function,
        begins: Onset | None,
        touches: Sequence[arb],
        *,
        sharp: bool = False,
    ) -> _Part:
        tube, rates = step.sharp if sharp else (step.tube, step.rates)
        moving = [DualNumber(y, {0: rate}) for y, rate in zip(tube, rates, strict=True)]
        along = function(moving)
        local = [(t - step.begin) / step.piece.unit for t in touches]
        return cls(step, function, along.value, along.partials[0], sharp, begins, local)

    def zeros(self) -> list[Zero]:
        """All zeros in the step but one at t = 0, in order of time."""
        if not self.value.polynomial.length() or not self.slope.polynomial.length():
            return []  # constant
        places = sorted(self._isolated(), key=lambda where: fraction(where[0]))
        return [self._zero(*where) for where in places]

    def _isolated(self) -> Iterator[tuple[arb, arb, int]]:
        """Parts [a, b] of local time with exactly one zero each, and its direction."""
        end = self.step.piece.end
        a = arb(0)
        if self.begins is not None:
            a = self._first_part(self.begins)
            # the sign just after t = 0 is exact; an F of order 1 or more has no zero in (0, a]
            if not self.begins.order and self.begins.sign != (after := self._sign(a)):
                yield arb(0), a, after
        while a < end:
            b = min(2 * a, end) if a > 0 else end
            yield from self._within(a, b)
            a = b

    def _first_part(self, begins: Onset) -> arb:
        """Some b > 0 such that F has no zero in (0, b], or one at most if F(0) is not zero."""
        end = self.step.piece.end
        models = [self.value, self.slope] if not begins.order else [self.derivative(begins.order)]
        for _ in range(MOST_HALVINGS_AT_START):
            ranges = [model.polynomial(between(arb(0), end)) for model in models]
            if not all(value.contains(0) for value in ranges):
                return end
            end = (end / 2).mid()
        raise NotProved("zeros", "a sign just after t = 0 is undecided")

    def _within(self, a: arb, b: arb) -> Iterator[tuple[arb, arb, int]]:
        waiting = [(a, b, MOST_HALVINGS)]
        while waiting:
            a, b, halvings = waiting.pop()
            where = between(a, b)
            if not self.value.polynomial(where).contains(0):
                continue
            if not self.slope.polynomial(where).contains(0):
                if self._sign(a) != (after := self._sign(b)):
                    yield a, b, after
                continue
            if any(a < touch < b for touch in self.touches):
                bend = self.second.polynomial(where)
                if not bend.contains(0):
                    continue
            if not halvings:
                raise NotProved(
                    "zeros", f"a sign near t = {float(self.step.begin):.6g} is undecided"
                )
            middle = self._middle(a, b)
            waiting += [(a, middle, halvings - 1), (middle, b, halvings - 1)]

    @cached_property
    def second(self) -> TaylorModel:
        """Half the model of F''."""
        return self.derivative(2)

    def derivative(self, order: int) -> TaylorModel:
        """The model of the derivative of this order divided by its factorial, in problem time."""
        tube = self.step.sharp[0] if self.sharp else self.step.tube
        problem = self.step.problem
        parameters = problem.parameters()
        series = solution(lambda y: problem.rates(parameters, y, FUNCTIONS), tube)
        values = self.function(series)
        assert isinstance(values, Series)  # a function of the state
        return TaylorModel.of(values[order], tube[0].frame)

    def _zero(self, a: arb, b: arb, direction: int) -> Zero:
        """The zero in [a, b], refined as far as the enclosure allows."""
        where = between(a, b)
        for _ in range(NEWTON_STEPS):
            middle = self._middle(where.lower(), where.upper())
            image = middle - self._sharp(middle) / self.slope.polynomial(where)
            narrower = where.intersection(image) if image.is_finite() else where
            if not narrower.rad() < where.rad() / 2:
                break
            where = narrower
        inside = where.intersection(between(a, b))
        time = self.step.begin + inside * self.step.piece.unit
        return Zero(time, direction, tuple(self.step.state(inside)))

    def _middle(self, a: arb, b: arb) -> arb:
        """An exact number between a and b, and within the step, however they are rounded."""
        middle = ((a + b) / 2).mid()
        return max(arb(0), a, min(middle, b, self.step.piece.end))

    def _sharp(self, s: arb) -> arb:
        return arb(self.function(self.step.state(s)))

    def _sign(self, s: arb) -> int:
        value = self._sharp(s)
        if value.contains(0):
            where = float(self.step.begin + s * self.step.piece.unit)
            raise NotProved("zeros", f"the sign at t = {where:.6g} is undecided")
        return 1 if value > 0 else -1


class ProvedEvents(NamedTuple):
    """All zeros of one event after t = 0 in the steps that were searched, or why none is proved."""

    zeros: list[Zero]
    failure: NotProved | None = None
