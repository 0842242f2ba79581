"""Proved zeros and signs of functions along an enclosed solution.

A function F of the state is followed with its derivative along the solution, F' = DF f, as bands
in each stretch. Where the band of F excludes zero there is none. Where the band of F' excludes
zero, F is monotone: exactly one zero if its signs at the two ends differ, none if they agree. A
part of a stretch where neither holds is halved; where that does not help, sharper bands may. A
zero is then refined by interval Newton, N = m - F(m)/F'(T): it contains every zero in T (R. E.
Moore, "Interval analysis", 1966).

At t = 0 the order n to which F vanishes and the sign beside it are exact (``onset``). Where the
band of the n-th derivative excludes zero on [0, b], F has no zero in (0, b], by Taylor's theorem.
Likewise F has no other zero than an instant of which it is known that F = F' = 0 there, in a part
where the band of F'' excludes zero; and it does not change sign there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import flint
from flint import arb

from tt_precise.certify.balls import Balls, between, fraction, largest
from tt_precise.certify.bands import Band
from tt_precise.certify.enclosure import Stretch
from tt_precise.certify.jets import Jet, taylor
from tt_precise.certify.onset import Onset
from tt_precise.certify.slopes import Slope
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar

Function = Callable[[Sequence[Scalar]], Scalar]
MOST_HALVINGS = 30  # of a part, in the search for one where F or F' has a sign
MOST_HALVINGS_AT_START = 200  # of the first stretch, for [0, b]; each costs two evaluations
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
    begins: Onset | None = None,
    touches: Sequence[arb] = (),
) -> Iterator[Zero]:
    """All zeros after t = 0 in the stretches, in the order of these, as they are proved.

    ``reversed(enclosure.stretches)`` gives the last one first. ``begins`` is how F begins at
    t = 0, where that is known; a stretch that begins there needs it unless F has a sign there.
    ``touches`` are balls around instants at which F and its derivative are known to be zero; where
    F does not change sign there is no event. A function that vanishes identically has none.

    Raises
    ------
    NotProved
        Whether there is a zero could not be decided.
    """
    for stretch in stretches:
        near = [t for t in touches if not (t < stretch.begin or t > stretch.finish)]
        with flint.ctx.workprec(stretch.bits):
            try:
                found = _Part.of(stretch, function, begins, near).zeros()
            except NotProved:
                # the function may be tiny beside the components that it is made of
                found = _Part.of(stretch, function, begins, near, sharp=True).zeros()
        yield from found


def lower_bound(
    stretch: Stretch, function: Function, pieces: int = 8, until: arb | None = None
) -> arb:
    """A number that the function is nowhere below on the stretch, up to a time ``until``.

    Raises
    ------
    NotProved
        There is none to be found.
    """
    with flint.ctx.workprec(stretch.bits):
        band = function(stretch.tube)
        end = stretch.piece.end
        if until is not None and until < stretch.finish:
            end = min(end, ((until - stretch.begin) / stretch.piece.unit).upper())
        step = end / pieces
        parts = (band.polynomial(between(i * step, (i + 1) * step)) for i in range(pieces))
        return -largest(-part for part in parts)


@lru_cache(maxsize=2)
def _moving(stretch: Stretch, sharp: bool) -> tuple[Slope, ...]:
    """The state in a stretch with its derivative; the next function is mostly about the same."""
    tube, rates = stretch.sharp if sharp else (stretch.tube, stretch.rates)
    return tuple(Slope(y, {0: rate}) for y, rate in zip(tube, rates, strict=True))


@dataclass(frozen=True)
class _Part:
    stretch: Stretch
    function: Function
    value: Band
    slope: Band
    sharp: bool

    begins: Onset | None
    touches: Sequence[arb]  # as local times

    @classmethod
    def of(
        cls,
        stretch: Stretch,
        function: Function,
        begins: Onset | None,
        touches: Sequence[arb],
        *,
        sharp: bool = False,
    ) -> _Part:
        along = function(_moving(stretch, sharp))
        local = [(t - stretch.begin) / stretch.piece.unit for t in touches]
        first = begins if stretch.begin == 0 else None
        return cls(stretch, function, along.value, along.partials[0], sharp, first, local)

    def zeros(self) -> list[Zero]:
        """All zeros in the stretch but one at t = 0, in order of time."""
        if not self.value.polynomial.length():
            return []
        found = sorted(self._isolated(), key=lambda where: fraction(where[0]))
        return [self._zero(*where) for where in found]

    def _isolated(self) -> Iterator[tuple[arb, arb, int]]:
        """Parts [a, b] of local time with exactly one zero each, and its direction."""
        end = self.stretch.piece.end
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
        end = self.stretch.piece.end
        bands = [self.value, self.slope] if not begins.order else [self.derivative(begins.order)]
        for _ in range(MOST_HALVINGS_AT_START):
            ranges = [band.polynomial(between(arb(0), end)) for band in bands]
            if not all(found.contains(0) for found in ranges):
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
                    "zeros", f"a sign near t = {float(self.stretch.begin):.6g} is undecided"
                )
            middle = self._middle(a, b)
            waiting += [(a, middle, halvings - 1), (middle, b, halvings - 1)]

    @cached_property
    def second(self) -> Band:
        """Half the band of F''."""
        return self.derivative(2)

    def derivative(self, order: int) -> Band:
        """The band of the derivative of this order divided by its factorial, in problem time."""
        problem = self.stretch.problem
        tube = self.stretch.sharp[0] if self.sharp else self.stretch.tube
        parameters = problem.parameters()
        series = taylor(lambda y: problem.rates(parameters, y, Balls), list(tube), order)
        found = self.function(series)
        assert isinstance(found, Jet)  # a function of the state
        return Band.of(found.coefficients[order], tube[0].frame)

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
        time = self.stretch.begin + inside * self.stretch.piece.unit
        return Zero(time, direction, tuple(self.stretch.state(inside)))

    def _middle(self, a: arb, b: arb) -> arb:
        """An exact number between a and b, and within the stretch, however they are rounded."""
        middle = ((a + b) / 2).mid()
        return max(arb(0), a, min(middle, b, self.stretch.piece.end))

    def _sharp(self, s: arb) -> arb:
        return arb(self.function(self.stretch.state(s)))

    def _sign(self, s: arb) -> int:
        value = self._sharp(s)
        if value.contains(0):
            where = float(self.stretch.begin + s * self.stretch.piece.unit)
            raise NotProved("zeros", f"the sign at t = {where:.6g} is undecided")
        return 1 if value > 0 else -1
