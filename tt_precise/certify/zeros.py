"""Zeros of functions within a verified step: proofs of existence and of completeness.

Taylor models enclose a function F of the motion and its derivatives along the solution. If F
excludes zero, there is no zero. If F' excludes zero, F is monotone: exactly one zero if the signs
at the two ends differ, none if they agree. A part of the step where neither holds is halved.
Interval Newton then refines a zero: N = m - F(m)/F'(T) contains every zero in T (R. E. Moore,
"Interval analysis", 1966).

At the start of a motion many functions vanish, to an order n that ``start`` decides. If the n-th
derivative excludes zero on [0, b], F has no zero in (0, b], by Taylor's theorem. Likewise, if
F = F' = 0 at a known instant of a part where F'' excludes zero, this instant is the only zero of F
in the part, and F does not change sign there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from flint import arb, arb_poly

from tt_precise.certify.balls import NotProved
from tt_precise.certify.kernel import Step
from tt_precise.certify.models import PowerSeries, polynomial, solution
from tt_precise.certify.start import Function

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
