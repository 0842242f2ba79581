"""mpmath's odefun: a Taylor method in any precision, in Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import mpmath

from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.body import Parameters
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, registered
from tt_precise.tradeoff.problem import GoldenProblem

MARGIN_BITS = 16  # odefun asks for a tolerance above the eps that it works with


@registered("mpmath odefun", "mpmath")
def odefun(problem: GoldenProblem, settings: Settings) -> Solve:
    """``mpmath.odefun`` on the generic equations; it reports no steps."""
    precision, form = settings.precision, problem.form
    start = problem.start(precision)
    # numbers of mpmath's own context: odefun raises its precision, and theirs has to follow
    own = mpmath.mp.convert
    state = [own(x) for x in form.start(start.body, start.vectors, start.euler)]
    body = Parameters(**{f.name: own(getattr(start.body, f.name)) for f in fields(start.body)})

    def solve(times: Sequence[Scalar]) -> SolverResult:
        evaluations = 0

        def rates(t: Scalar, y: Sequence[Scalar]) -> list[Scalar]:
            nonlocal evaluations
            evaluations += 1
            return list(form.rates(body, form.State(*y), mpmath))

        with mpmath.workprec(precision.bits):
            tolerance = mpmath.ldexp(1, MARGIN_BITS - precision.bits)
            follow = mpmath.odefun(rates, 0, list(state), tolerance)
            states = [follow(own(precision.guarded(t))) for t in times]
        return SolverResult(states, 0, evaluations)

    return solve
