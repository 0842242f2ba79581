"""Proved zeros and signs of functions along an enclosed solution.

A function F of the state is followed with its derivative along the solution, F' = DF f, as bands
in each stretch. Where the band of F excludes zero there is none. Where the band of F' excludes
zero, F is monotone: exactly one zero if its signs at the two ends differ, none if they agree. A
part of a stretch where neither holds is halved; where that does not help, sharper bands may. A
zero is then refined by interval Newton, N = m - F(m)/F'(T): it contains every zero in T (R. E.
Moore, "Interval analysis", 1966).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb

from tt_precise.certify.balls import between, largest
from tt_precise.certify.bands import Band
from tt_precise.certify.enclosure import Stretch
from tt_precise.certify.slopes import Slope
from tt_precise.certify.verdict import NotProved

Function = Callable[[Sequence[Any]], Any]
MOST_HALVINGS = 30  # of a stretch, in the search for a part where F or F' has a sign
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
    stretches: Iterable[Stretch],
    function: Function,
    *,
    zero_at_start: bool = False,
    since: arb | int = 0,
) -> Iterator[Zero]:
    """All zeros in the stretches, in the order of these, as they are proved.

    ``reversed(enclosure.stretches)`` gives the last one first. ``zero_at_start`` says that F is
    exactly zero at t = 0, which is then not reported and must be simple; ``since`` is the local
    time at which the search of the first stretch begins. A function that vanishes identically
    has none.

    Raises
    ------
    NotProved
        Whether there is a zero could not be decided.
    """
    for stretch in stretches:
        with flint.ctx.workprec(stretch.bits):
            try:
                part = _Part.of(stretch, function, zero_at_start)
                found = [part.zero(*where) for where in part.isolated(since)]
            except NotProved:
                # the function may be tiny beside the components that it is made of
                part = _Part.of(stretch, function, zero_at_start, sharp=True)
                found = [part.zero(*where) for where in part.isolated(since)]
        yield from sorted(found, key=lambda zero: float(zero.time))


def start_slope(stretch: Stretch, function: Function) -> arb:
    """A ball around the derivative of the function at the start of the stretch."""
    with flint.ctx.workprec(stretch.bits):
        return _Part.of(stretch, function, False, sharp=True).slope.polynomial(arb(0))


def lower_bound(stretch: Stretch, function: Function, pieces: int = 8) -> arb:
    """A number that the function is nowhere below on the stretch.

    Raises
    ------
    NotProved
        There is none to be found.
    """
    with flint.ctx.workprec(stretch.bits):
        band = function(stretch.tube)
        step = stretch.piece.end / pieces
        parts = (band.polynomial(between(i * step, (i + 1) * step)) for i in range(pieces))
        return -largest(-part for part in parts)


@dataclass(frozen=True)
class _Part:
    stretch: Stretch
    function: Function
    value: Band
    slope: Band

    zero_at_start: bool

    @classmethod
    def of(
        cls, stretch: Stretch, function: Function, zero_at_start: bool, *, sharp: bool = False
    ) -> _Part:
        tube, rates = stretch.sharp if sharp else (stretch.tube, stretch.rates)
        moving = [Slope(y, {0: rate}) for y, rate in zip(tube, rates, strict=True)]
        along = function(moving)
        starts = zero_at_start and stretch.begin == 0
        return cls(stretch, function, along.value, along.partials[0], starts)

    def isolated(self, since: arb | int) -> Iterator[tuple[arb, arb, int]]:
        """Parts [a, b] of local time with exactly one zero each, and its direction."""
        first = arb(since) if self.stretch.begin == 0 else arb(0)
        if not self.value.polynomial.length():
            return
        waiting = [(first, self.stretch.piece.end, MOST_HALVINGS)]
        while waiting:
            a, b, halvings = waiting.pop()
            where = between(a, b)
            if not self.value.polynomial(where).contains(0):
                continue
            slope = self.slope.polynomial(where)
            if not slope.contains(0):
                # monotone from zero, it meets no other zero
                passed = a == 0 and self.zero_at_start
                if not passed and self._sign(a) != self._sign(b):
                    yield a, b, 1 if slope > 0 else -1
                continue
            if not halvings:
                raise NotProved(
                    "zeros", f"a sign near t = {float(self.stretch.begin):.6g} is undecided"
                )
            middle = ((a + b) / 2).mid()
            waiting += [(a, middle, halvings - 1), (middle, b, halvings - 1)]

    def zero(self, a: arb, b: arb, direction: int) -> Zero:
        """The zero in [a, b], refined as far as the enclosure allows."""
        where = between(a, b)
        for _ in range(NEWTON_STEPS):
            middle = where.mid()
            image = middle - self._sharp(middle) / self.slope.polynomial(where)
            narrower = where.intersection(image) if image.is_finite() else where
            if not narrower.rad() < where.rad() / 2:
                break
            where = narrower
        inside = where.intersection(between(a, b))
        time = self.stretch.begin + inside * self.stretch.piece.unit
        return Zero(time, direction, tuple(self.stretch.state(inside)))

    def _sharp(self, s: arb) -> arb:
        return arb(self.function(self.stretch.state(s)))

    def _sign(self, s: arb) -> int:
        value = self._sharp(s)
        if value.contains(0):
            where = float(self.stretch.begin + s * self.stretch.piece.unit)
            raise NotProved("zeros", f"the sign at t = {where:.6g} is undecided")
        return 1 if value > 0 else -1
