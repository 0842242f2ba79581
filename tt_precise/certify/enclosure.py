"""Step after step: an enclosure of the exact solution over a span of time."""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import flint
from flint import arb, arb_poly

from tt_precise.certify.approximation import Piece, Steps
from tt_precise.certify.balls import between, require_outward_rounding
from tt_precise.certify.bands import Band, Frame
from tt_precise.certify.error_set import ErrorSet
from tt_precise.certify.invariant import exact_zeros, restored, without
from tt_precise.certify.problem import Problem
from tt_precise.certify.step import Crossing, cross
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.progress import Progress, silent

GUARD_BITS = 16  # balls are this much finer than heyoka's numbers
MOST_HALVINGS = 12  # of a step that does not verify, before the proof ends there
NEARLY, FORGETTING = 0.9, 1.01  # of the length of a step that failed; by which each step raises it


@dataclass(frozen=True, eq=False)
class Stretch:
    """One verified step: |y(t) - p(s)| <= radius for t = begin + unit s, 0 <= s <= end.

    ``tube`` and ``rates`` are bands of y and dy/ds in s, good to about 17 digits of the largest
    component; ``bits`` is the precision that the rest deserves.
    """

    problem: Problem

    begin: arb
    piece: Piece
    radius: tuple[arb, ...]
    tube: tuple[Band, ...]
    rates: tuple[Band, ...]
    bits: int

    @property
    def finish(self) -> arb:
        """The time at its end."""
        return self.begin + self.piece.end * self.piece.unit

    @cached_property
    def sharp(self) -> tuple[tuple[Band, ...], tuple[Band, ...]]:
        """``tube`` and ``rates`` as good as the enclosure is, at many times their price."""
        with flint.ctx.workprec(self.bits):
            frame = Frame(self.piece.end, max(p.degree() for p in self.piece.polynomials))
            radii = zip(self.piece.polynomials, self.radius, strict=True)
            tube = [Band(p, frame).widened(radius) for p, radius in radii]
            rates = self.problem.tape(self.problem.parameters(), tube)
            return tuple(tube), tuple(Band.of(rate, frame) * self.piece.unit for rate in rates)

    def state(self, s: arb) -> list[arb]:
        """Balls around the exact state at every local time in ``s``, within [0, end]."""
        radii = zip(self.piece.polynomials, self.radius, strict=True)
        return [p(s) + arb(0, radius) for p, radius in radii]


@dataclass(frozen=True)
class Enclosure:
    """What was proved: the solution exists, is unique and lies in the stretches, until ``finish``.

    ``failure`` says why the proof ends before ``problem.until()``, if it does.
    """

    problem: Problem
    bits: int
    stretches: tuple[Stretch, ...]
    failure: NotProved | None

    @cached_property
    def finish(self) -> arb:
        """The time up to which the enclosure is proved."""
        return self.stretches[-1].finish if self.stretches else arb(0)

    @property
    def working_bits(self) -> int:
        """Bits of the balls."""
        return self.bits + GUARD_BITS

    def at(self, time: arb) -> list[arb]:
        """Balls around the exact state at a time (a ball, in the problem's unit).

        Raises
        ------
        NotProved
            The time reaches beyond what was proved.
        """
        with flint.ctx.workprec(self.working_bits):
            if not (self.stretches and time >= 0 and time <= self.finish):
                raise NotProved("time", f"the proof ends at {float(self.finish):.6g}")
            # all stretches that the ball may reach into
            first = bisect.bisect_left(self.stretches, time.lower(), key=lambda one: one.finish)
            last = bisect.bisect_right(self.stretches, time.upper(), key=lambda one: one.begin)
            found: list[arb] = []
            for stretch in self.stretches[first:last]:
                s = (time - stretch.begin) / stretch.piece.unit
                inside = s.intersection(between(arb(0), stretch.piece.end))
                state = stretch.state(inside)
                pairs = zip(found, state, strict=True)
                found = [between(a, b) for a, b in pairs] if found else state
            return found


def enclose(
    problem: Problem,
    bits: int,
    *,
    ends: Callable[[Stretch], bool] | None = None,
    progress: Progress = silent,
) -> Enclosure:
    """Enclose the solution from 0 to ``problem.until()``, or through the stretch where it ``ends``.

    A step that does not verify is made again, half as long; those to come are much alike, so its
    length stays in mind for a while.

    Raises
    ------
    NotProved
        The arithmetic itself cannot be trusted (hypothesis B). Everything else that fails to
        verify ends the enclosure early and is stated in its ``failure``.
    """
    with flint.ctx.workprec(bits + GUARD_BITS):
        require_outward_rounding()
        zeros = exact_zeros(problem)
        stepped = without(problem, zeros)
        steps, until, time = Steps(stepped, bits), problem.until(), arb(0)
        longest = ceiling = limit = (until + 1).upper()
        reached = stepped.start()
        errors = ErrorSet.of([arb(0)] * len(stepped.columns))
        stretches: list[Stretch] = []
        halvings, failure = 0, None
        while not time > until:
            before = steps.state
            try:
                piece = steps.step(limit)
                gaps = [x - y for x, y in zip(reached, piece.first, strict=True)]
                crossing = cross(stepped, piece, errors.shifted(gaps))
            except NotProved as why:
                halvings += 1
                if halvings > MOST_HALVINGS:
                    failure = why
                    break
                steps.back(before)
                ceiling = min(ceiling, steps.length) * NEARLY
                limit = min(limit, steps.length) / 2
                continue
            halvings, ceiling = 0, min(ceiling * FORGETTING, longest)
            limit = min(limit * 5 / 4, ceiling)
            stretch = _stretch(problem, time, piece, crossing, zeros)
            try:
                ended = ends is not None and ends(stretch)
            except NotProved as why:
                # whether the model holds throughout this stretch is undecided: it proves nothing
                failure = why
                break
            stretches.append(stretch)
            if ended:
                break
            errors, reached, time = crossing.after, piece.last, stretch.finish
            progress(min(1.0, float(time / until)))
        return Enclosure(problem, bits, tuple(stretches), failure)


def _stretch(
    problem: Problem, begin: arb, piece: Piece, crossing: Crossing, zeros: frozenset[int]
) -> Stretch:
    """The stretch in all components, those included that are exactly zero."""
    nothing, size = arb_poly([]), len(problem.columns)
    still = Band(nothing, crossing.tube[0].frame)
    return Stretch(
        problem,
        begin,
        replace(piece, polynomials=tuple(restored(piece.polynomials, zeros, size, nothing))),
        tuple(restored(crossing.radius, zeros, size, arb(0))),
        tuple(restored(crossing.tube, zeros, size, still)),
        tuple(restored(crossing.rates, zeros, size, still)),
        flint.ctx.prec,
    )
