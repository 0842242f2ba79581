"""Components that are exactly zero for all time, and the problem without them.

Balls around zero cannot prove a zero. But if f_i = 0 for each i of a set Z wherever all y_j, j in
Z, are zero, then a solution that starts there stays there (it solves the problem without them, and
solutions are unique). f_i is evaluated with exact zeros in Z and balls of positive radius
elsewhere: an exactly zero result means that f_i vanishes on that box, hence, being analytic,
wherever the y_j are zero. Upright and inverted spin, and rocking in a plane, are such solutions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from flint import arb

from tt_precise.certify.balls import Balls
from tt_precise.certify.problem import Problem
from tt_precise.runtime.arithmetic import Functions, Scalar

BOX = arb(2) ** -20  # half an edge; any positive number will do


def exact_zeros(problem: Problem) -> frozenset[int]:
    """Positions of components that are zero at the start and stay so."""
    start = problem.start()
    found = frozenset(i for i, value in enumerate(start) if value == 0)
    while found:
        state = [arb(0) if i in found else value + arb(0, BOX) for i, value in enumerate(start)]
        rates = problem.rates(problem.parameters(), state, Balls)
        staying = frozenset(i for i in found if arb(rates[i]) == 0)
        if staying == found:
            break
        found = staying
    return found


def without(problem: Problem, zeros: frozenset[int]) -> Problem:
    """The problem in the remaining components."""
    size = len(problem.columns)
    free = [i for i in range(size) if i not in zeros]

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        whole = restored(state, zeros, size, 0)
        found = problem.rates(parameters, whole, fn)
        return [found[i] for i in free]

    def start() -> Sequence[arb]:
        values = problem.start()
        return [values[i] for i in free]

    return replace(
        problem, columns=tuple(problem.columns[i] for i in free), rates=rates, start=start
    )


def restored(
    values: Sequence[Scalar], zeros: frozenset[int], size: int, zero: Scalar
) -> list[Scalar]:
    """The values with ``zero`` in the places that were left out."""
    remaining = iter(values)
    return [zero if i in zeros else next(remaining) for i in range(size)]
