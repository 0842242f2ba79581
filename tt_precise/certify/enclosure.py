"""Step after step: an enclosure of the exact solution over a span of time.

The approximate solution is heyoka's Taylor polynomials in ``mp``. Nothing is assumed about them; a
wrong one makes the proof fail, or the enclosure wide.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property

import flint
from flint import arb, arb_poly

from tt_precise.certify.balls import NotProved, between, require_outward_rounding
from tt_precise.certify.error_set import LohnerSet
from tt_precise.certify.prover_problem import Problem, exact_zeros, restored, without
from tt_precise.certify.step import Crossing, Piece, cross
from tt_precise.certify.taylor_model import Frame, TaylorModel
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Adaptive, Scalar

# Time is counted in units of a power of two near this many steps: about where the series stops
# converging (heyoka steps radius/e^2). Coefficients are then of one size, which arb multiplies
# twice as fast.
UNIT_STEPS = 6
SHORTEST = 1e-9  # step; before a point where the equations end they would get shorter for ever


class Steps:
    """heyoka's adaptive Taylor steps for a ``Problem``, one ``Piece`` after the other.

    ``length`` is that of the latest.
    """

    def __init__(self, problem: Problem, bits: int):
        import heyoka

        parameters = [_decimal(p) for p in problem.parameters()]
        self._real: Callable[[str], Scalar] = lambda text: heyoka.real(text, bits)
        self._adaptive = _lent(problem, bits)
        self._adaptive.time = self._real("0")
        for i, x in enumerate(problem.start()):
            self._adaptive.state[i] = self._real(_decimal(x))
        # heyoka counts the parameters that the equations contain up to the last one
        for i in range(len(self._adaptive.pars)):
            self._adaptive.pars[i] = self._real(parameters[i])
        self.length = arb("inf")

    def step(self, limit: arb | None = None) -> Piece:
        """The next piece, no longer than ``limit``.

        Raises ``NotProved``: heyoka found no way forward.
        """
        adaptive = self._adaptive
        limits = {} if limit is None else {"max_delta_t": self._real(_decimal(limit))}
        adaptive.step(write_tc=True, **limits)
        rows = [[arb(str(c)).mid() for c in row] for row in adaptive.tc]
        length = arb(str(adaptive.last_h)).mid()
        if not (length.is_finite() and length > SHORTEST):
            raise NotProved("approximation", f"heyoka made a step of {adaptive.last_h}")
        self.length = length
        unit = _power_of_two(UNIT_STEPS * float(length))
        return Piece(tuple(_scaled(row, unit) for row in rows), unit, length / unit)

    @property
    def state(self) -> list[Scalar]:
        """Where it is, for ``back``."""
        return [x + 0 for x in self._adaptive.state]

    def back(self, state: list[Scalar]) -> None:
        """Return to a state, to continue from there with a shorter limit."""
        for i, value in enumerate(state):
            self._adaptive.state[i] = value


_compiled: dict[Hashable, Adaptive] = {}


def _lent(problem: Problem, bits: int) -> Adaptive:
    """heyoka's integrator for these equations, compiled once; one proof at a time may use it."""
    import heyoka

    # where nothing can be cached it would say so, once a file
    heyoka.set_logger_level_critical()
    variables = heyoka.make_vars(*problem.columns)
    variables = [variables] if len(problem.columns) == 1 else list(variables)
    open_ones = [heyoka.par[i] for i in range(len(problem.parameters()))]
    rates = tuple(problem.rates(open_ones, variables, heyoka))
    key = (problem.columns, rates, bits)
    if key not in _compiled:
        _compiled[key] = heyoka.taylor_adaptive(
            list(zip(variables, rates, strict=True)),
            [heyoka.real("0", bits) for _ in variables],
            fp_type=heyoka.real,
            prec=bits,
            compact_mode=True,
            opt_level=0,  # MPFR's functions do the work
        )
    return _compiled[key]


def _decimal(number: arb) -> str:
    return str(number.mid().str(int(flint.ctx.prec * 0.30103) + 5, radius=False))


def _power_of_two(size: float) -> arb:
    return arb(2) ** round(math.log2(size))


def _scaled(coefficients: list[arb], unit: arb) -> arb_poly:
    powers, power = [], arb(1)
    for coefficient in coefficients:
        powers.append(coefficient * power)
        power *= unit
    return arb_poly(powers)


GUARD_BITS = 16  # balls are this much finer than heyoka's numbers
MOST_HALVINGS = 12  # of a step that does not verify, before the proof ends there
NEARLY, FORGETTING = 0.9, 1.01  # of the length of a step that failed; by which each step raises it


@dataclass(frozen=True, eq=False)
class VerifiedStep:
    """One verified step: |y(t) - p(s)| <= radius for t = begin + unit s, 0 <= s <= end.

    ``tube`` and ``rates`` are Taylor models of y and dy/ds, good to about 17 digits of the largest
    component; ``bits`` is the precision that the rest deserves. ``until`` is the time at which
    other equations take over, if they do in it.
    """

    problem: Problem

    begin: arb
    piece: Piece
    radius: tuple[arb, ...]
    tube: tuple[TaylorModel, ...]
    rates: tuple[TaylorModel, ...]
    bits: int
    until: arb | None = None

    @property
    def finish(self) -> arb:
        return (
            self.until if self.until is not None else self.begin + self.piece.end * self.piece.unit
        )

    @cached_property
    def sharp(self) -> tuple[tuple[TaylorModel, ...], tuple[TaylorModel, ...]]:
        """``tube`` and ``rates`` as good as the enclosure is, at many times their price."""
        with flint.ctx.workprec(self.bits):
            frame = Frame(self.piece.end, max(p.degree() for p in self.piece.polynomials))
            radii = zip(self.piece.polynomials, self.radius, strict=True)
            tube = [TaylorModel(p, frame).widened(radius) for p, radius in radii]
            rates = self.problem.rates_at(tube)
            return tuple(tube), tuple(
                TaylorModel.of(rate, frame) * self.piece.unit for rate in rates
            )

    def state(self, s: arb) -> list[arb]:
        """Balls around the exact state at every local time in ``s``, within [0, end]."""
        radii = zip(self.piece.polynomials, self.radius, strict=True)
        return [p(s) + arb(0, radius) for p, radius in radii]


@dataclass(frozen=True)
class Enclosure:
    """What was proved: the solution exists, is unique and lies in the steps, until ``finish``.

    ``failure`` says why the proof ends before ``problem.until()``, if it does.
    """

    problem: Problem
    bits: int
    steps: tuple[VerifiedStep, ...]
    failure: NotProved | None

    @cached_property
    def finish(self) -> arb:
        """The time up to which the enclosure is proved."""
        return self.steps[-1].finish if self.steps else arb(0)

    @property
    def working_bits(self) -> int:
        return self.bits + GUARD_BITS

    def at(self, time: arb) -> list[arb]:
        """Balls around the exact state at a time (a ball, in the problem's unit).

        Raises
        ------
        NotProved
            The time reaches beyond what was proved.
        """
        with flint.ctx.workprec(self.working_bits):
            if not (self.steps and time >= 0 and time <= self.finish):
                raise NotProved("time", f"the proof ends at {float(self.finish):.6g}")
            # all steps that the ball may reach into
            first = bisect.bisect_left(
                self.steps, time.lower(), key=lambda verified: verified.finish
            )
            last = bisect.bisect_right(
                self.steps, time.upper(), key=lambda verified: verified.begin
            )
            hull: list[arb] = []
            for step in self.steps[first:last]:
                s = (time - step.begin) / step.piece.unit
                inside = s.intersection(between(arb(0), step.piece.end))
                state = step.state(inside)
                pairs = zip(hull, state, strict=True)
                hull = [between(a, b) for a, b in pairs] if hull else state
            return hull


def enclose(
    problem: Problem,
    bits: int,
    *,
    begin: arb | None = None,
    ends: Callable[[VerifiedStep], bool] | None = None,
    progress: Progress = silent,
) -> Enclosure:
    """Enclose the solution to ``problem.until()``, or through the step where it ``ends``.

    It is at the problem's start at the time ``begin``, which is 0 unless given. A step that does
    not verify is made again, half as long; those to come are much alike, so its length stays in
    mind for a while.

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
        approximation, until, time = (
            Steps(stepped, bits),
            problem.until(),
            arb(0) if begin is None else begin,
        )
        longest = ceiling = limit = (until + 1).upper()
        reached = stepped.start()
        errors = LohnerSet.of([arb(0)] * len(stepped.columns))
        steps: list[VerifiedStep] = []
        halvings, failure = 0, None
        while not time > until:
            before = approximation.state
            try:
                piece = approximation.step(limit)
                gaps = [x - y for x, y in zip(reached, piece.first, strict=True)]
                crossing = cross(stepped, piece, errors.shifted(gaps))
            except NotProved as why:
                halvings += 1
                if halvings > MOST_HALVINGS:
                    failure = why
                    break
                approximation.back(before)
                ceiling = min(ceiling, approximation.length) * NEARLY
                limit = min(limit, approximation.length) / 2
                continue
            halvings, ceiling = 0, min(ceiling * FORGETTING, longest)
            limit = min(limit * 5 / 4, ceiling)
            step = _whole(problem, time, piece, crossing, zeros)
            try:
                ended = ends is not None and ends(step)
            except NotProved as why:
                # whether the model holds throughout this step is undecided: it proves nothing
                failure = why
                break
            steps.append(step)
            if ended:
                break
            errors, reached, time = crossing.after, piece.last, step.finish
            progress(min(1.0, float(time / until)))
        return Enclosure(problem, bits, tuple(steps), failure)


def _whole(
    problem: Problem, begin: arb, piece: Piece, crossing: Crossing, zeros: frozenset[int]
) -> VerifiedStep:
    """The step in all components, those included that are exactly zero."""
    nothing, size = arb_poly([]), len(problem.columns)
    still = TaylorModel(nothing, crossing.tube[0].frame)
    return VerifiedStep(
        problem,
        begin,
        replace(piece, polynomials=tuple(restored(piece.polynomials, zeros, size, nothing))),
        tuple(restored(crossing.radius, zeros, size, arb(0))),
        tuple(restored(crossing.tube, zeros, size, still)),
        tuple(restored(crossing.rates, zeros, size, still)),
        flint.ctx.prec,
    )
