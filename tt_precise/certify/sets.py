"""A set of solutions followed as one: pieces that are polynomials in time and in the start.

p(s, u) = sum of p_k(s) u^k over monomials of at most ``DEGREE``, for |u_i| <= 1. heyoka integrates
the equations of all p_k at once; again nothing is assumed about them. What is verified for one
solution is verified for each u (``step.cross_widely``): the defect is bounded by series over bands,
whose products lose nothing (``series.Fan``). So only what the polynomials miss is carried as a set
of errors, and it may grow by what the width of the whole set bends the flow.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

import flint
from flint import arb, arb_poly

from tt_precise.certify.approximation import Piece
from tt_precise.certify.balls import between
from tt_precise.certify.bands import Band, Frame
from tt_precise.certify.error_set import ErrorSet
from tt_precise.certify.invariant import without
from tt_precise.certify.problem import Problem, problem_of
from tt_precise.certify.series import Fan, StartSeries, monomials
from tt_precise.certify.step import Crossing, Prepared, cross, cross_widely
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.runtime.workers import Inline, Pool
from tt_precise.scene.scene import Scene


class One:
    """The solution of ``problem`` without the components ``zeros``; a pool's workers help."""

    def __init__(self, problem: Problem, zeros: frozenset[int], pool: Pool):
        self.problem = self.stepped = without(problem, zeros)
        self._zeros, self._executor = zeros, pool.executor
        self._scene = problem.scene if pool.size() > 1 else None
        self.ahead = 2 * pool.size() if self._scene else 1

    def middle(self, piece: Piece) -> Piece:
        """Itself."""
        return piece

    def gaps(self, reached: Sequence[arb], piece: Piece) -> list[arb]:
        """What the end of one piece and the beginning of the next differ by."""
        return [x - y for x, y in zip(reached, piece.first, strict=True)]

    def begin(self, piece: Piece) -> Callable[[ErrorSet], Crossing]:
        """One step of the theorem, but for the errors at its start; it raises ``NotProved``."""
        if self._scene is None:
            return lambda errors: cross(self.problem, piece, errors)
        bits = flint.ctx.prec
        future = self._executor.submit(_prepared, self._scene, self._zeros, bits, piece)
        return lambda errors: future.result().crossing(errors)


@lru_cache(maxsize=2)
def _problem(scene: Scene, zeros: frozenset[int]) -> Problem:
    return without(problem_of(scene), zeros)


def _prepared(scene: Scene, zeros: frozenset[int], bits: int, piece: Piece) -> Prepared:
    """For another process."""
    with flint.ctx.workprec(bits):
        return Prepared.of(_problem(scene, zeros), piece)


class SetOfStarts(One):
    """All solutions of ``problem`` that begin at ``fans``, one for each component."""

    def __init__(self, problem: Problem, fans: Sequence[Fan], variables: int):
        super().__init__(problem, frozenset(), Pool(Inline(), lambda: 1))
        self.degree = fans[0].degree
        self.keys = monomials(variables, self.degree)
        names = ["".join(f"_{i}" for i in key) for key in self.keys]

        def rates(
            parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
        ) -> Sequence[Scalar]:
            given = [StartSeries({(): one}, self.degree) for one in parameters]
            series = [StartSeries(terms, self.degree) for terms in self._folded(state)]
            found = problem.tape(given, series)
            return [one.terms.get(key, state[0] * 0) for one in found for key in self.keys]

        self.stepped = replace(
            problem,
            columns=tuple(column + name for column in problem.columns for name in names),
            rates=rates,
            start=lambda: [arb(fan.terms.get(key, 0)) for fan in fans for key in self.keys],
        )

    def _folded(self, values: Sequence[Scalar]) -> list[dict[tuple[int, ...], Scalar]]:
        """For each component its terms."""
        size = len(self.keys)
        parts = (values[i : i + size] for i in range(0, len(values), size))
        return [dict(zip(self.keys, part, strict=True)) for part in parts]

    def middle(self, piece: Piece) -> Piece:
        """The piece of the solution from the middle."""
        return replace(piece, polynomials=piece.polynomials[:: len(self.keys)])

    def gaps(self, reached: Sequence[arb], piece: Piece) -> list[arb]:
        """What the end of one piece and the beginning of the next differ by, for any u."""
        apart = super().gaps(reached, piece)
        return [Fan(terms, self.degree).range for terms in self._folded(apart)]

    def begin(self, piece: Piece) -> Callable[[ErrorSet], Crossing]:
        """One step of the theorem for each u, but for the errors at its start."""
        return lambda errors: self._cross(piece, errors)

    def _cross(self, piece: Piece, errors: ErrorSet) -> Crossing:
        time = between(arb(0), piece.end)
        spread = [
            sum((p(time).abs_upper() for key, p in terms.items() if key), start=arb(0)).upper()
            for terms in self._folded(piece.polynomials)
        ]
        return cross_widely(self.problem, self.middle(piece), errors, self._defects(piece), spread)

    def _defects(self, piece: Piece) -> list[arb]:
        """S1: bounds of |unit f(p) - dp/ds| on the step for all u."""
        frame = Frame(piece.end, max(1, *(p.degree() for p in piece.polynomials)))
        nothing = arb_poly([])
        polynomials = self._folded(piece.polynomials)
        fans = [
            Fan({key: Band(p, frame) for key, p in terms.items()}, self.degree)
            for terms in polynomials
        ]
        given = [Fan({(): one}, self.degree) for one in self.problem.parameters()]
        found = []
        for rate, terms in zip(self.problem.tape(given, fans), polynomials, strict=True):
            total = arb(0)
            for key in self.keys:
                moves = Band.of(rate.terms.get(key, nothing), frame).polynomial * piece.unit
                total += (moves - terms[key].derivative())(frame.interval).abs_upper()
            if not total.is_finite():
                raise NotProved("S1", "the defect could not be bounded")
            found.append(total.upper())
        return found
