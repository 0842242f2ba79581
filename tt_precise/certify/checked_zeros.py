"""Zeros of functions in a piece that ``checker`` has verified; whether contact is kept there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

from flint import arb, arb_poly

from tt_precise.certify.checker import Checker, Dual, Poly, Room
from tt_precise.certify.pieces import Refused
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.arithmetic import Scalar

Function = Callable[[Motion], Scalar]
EARLY, CLOSEST = arb(2) ** -30, arb(2) ** -60  # of a piece
NEWTON = 100  # steps, at most


class CheckedZeros:
    """The zeros in the present piece of a checker.

    In the first piece from ``EARLY`` of it on: at t = 0 many functions vanish. There, and where
    the checker's tube leaves a sign undecided, a ``sharp`` one is used.
    """

    def __init__(self, checker: Checker, sharp: bool = False):
        self.piece, self.sharp = checker, sharp or checker.time == 0
        self.begin = (checker.length * EARLY).mid() if checker.time == 0 else arb(0)
        self.tube = checker.tube
        if self.sharp:
            room = Room(checker.length, checker.order)
            self.tube = checker.near([Poly(p, room) for p in checker.p], checker.reach)
        self.motion = checker.motion(self.tube)

    def lost(self) -> arb | None:
        """When the contact force ceases to be positive, if it does, or raise ``Refused``."""
        force, checker = QUANTITIES["g_n"].evaluate, self.piece
        if force(self.motion).p(checker.low.interval) > 0:
            return None
        if checker.time == 0 or not self._value(force, arb(0)) > 0:
            raise Refused(f"the contact force may vanish near t = {float(checker.time):.6g}")
        found = self.of(force, checker.finish)
        return found[0][1] if found else None

    def of(
        self, function: Function, until: arb, touches: Sequence[arb] = ()
    ) -> list[tuple[int, arb]]:
        """Direction and time of each zero of a function, in order, up to ``until``.

        Or raise ``Refused``, where a sign is undecided.

        At the times ``touches`` the function and its derivative are known to be zero: where its
        second derivative has a sign it does not change its own, and has no other zero.
        """
        try:
            return self._of(function, until, touches)
        except Refused:
            if self.sharp:
                raise
        return self._sharper.of(function, until, touches)

    @cached_property
    def _sharper(self) -> CheckedZeros:
        return CheckedZeros(self.piece, sharp=True)

    def _of(self, function: Function, until: arb, touches: Sequence[arb]) -> list[tuple[int, arb]]:
        checker, slope = self.piece, arb_poly([])
        end = min(checker.length, ((until - checker.time) / checker.unit).upper())
        value = function(self.motion).p
        some = bool(value.length()) and end > self.begin
        waiting, found = [(self.begin, end)] if some else [], []
        while waiting:
            a, b = waiting.pop()
            where = a.union(b)
            if not value(where).contains(0):
                continue
            if not slope.length():
                slope = self._slope(function)
                if not slope.length():
                    return []  # constant
            if not slope(where).contains(0):
                before, after = (self._value(function, s) for s in (a, b))
                if before.contains(0) or after.contains(0):
                    raise self._undecided
                if (before > 0) != (after > 0):
                    zero = self._refined(function, slope, where)
                    found.append((1 if after > 0 else -1, checker.time + zero * checker.unit))
                continue
            within = any(a < (t - checker.time) / checker.unit < b for t in touches)
            if within and not self._bend(function)(where).contains(0):
                continue
            if not b - a > checker.length * CLOSEST:
                raise self._undecided
            middle = ((a + b) / 2).mid()
            waiting += [(middle, b), (a, middle)]
        if any(not time < until for _, time in found):
            raise self._undecided
        return found

    @property
    def _undecided(self) -> Refused:
        return Refused(f"a sign near t = {float(self.piece.time):.6g} is undecided")

    def _refined(self, function: Function, slope: arb_poly, zero: arb) -> arb:
        """The only zero in a part, by interval Newton."""
        for _ in range(NEWTON):
            middle, before = zero.mid(), zero.rad()
            zero = zero.intersection(middle - self._value(function, middle) / slope(zero))
            if not zero.rad() < before / 2:
                break
        return zero

    def _value(self, function: Function, s: arb) -> arb:
        return arb(function(self.piece.motion(self.piece.at(s))))

    def _slope(self, function: Function) -> arb_poly:
        """The function's derivative by s."""
        return function(self.piece.motion(self._moving)).by[0].p

    def _bend(self, function: Function) -> arb_poly:
        """Its second derivative by s."""
        rates = [f * self.piece.unit for f in self.piece.rates(self._moving)]
        pairs = zip(self._moving, rates, strict=True)
        return function(self.piece.motion([Dual(y, [f]) for y, f in pairs])).by[0].by[0].p

    @cached_property
    def _moving(self) -> list[Dual]:
        pairs = zip(self.tube, self.piece.rates(self.tube), strict=True)
        return [Dual(y, [f * self.piece.unit]) for y, f in pairs]
