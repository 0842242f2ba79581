"""SciPy's integrators, each with a Python and with a numba right-hand side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, registered
from tt_precise.tradeoff.problem import GoldenProblem
from tt_precise.tradeoff.right_hand_side import flat

LEAST = 2.3e-14  # solve_ivp takes no smaller relative tolerance
ODEINT_STEPS = 1_000_000  # at most between two outputs; its default, 500, does not reach 8 s


def right_hand_side(
    problem: GoldenProblem, settings: Settings, compiled: bool
) -> Callable[..., Array]:
    """``f(t, y)``: a flat Python function, or the same compiled by numba."""
    parameters = tuple(problem.parameters(settings.precision))
    if not compiled:
        return flat(problem.form, "list", parameters)
    return _jitted(problem.form, parameters)


@cache
def _jitted(form: Formulation, parameters: tuple[float, ...]) -> Callable[..., Array]:
    import numba
    import numpy

    function = numba.njit(flat(form, "array", parameters))
    function(0.0, numpy.zeros(len(form.columns)) + 0.5)
    return function


def solve_ivp(method: Any, compiled: bool, problem: GoldenProblem, settings: Settings) -> Solve:
    """``scipy.integrate.solve_ivp`` with one number as relative and absolute tolerance.

    Below ``LEAST`` only the absolute one becomes smaller.
    """
    import scipy.integrate

    function = right_hand_side(problem, settings, compiled)
    start, tolerance = problem.state(settings.precision), settings.tolerance

    def solve(times: Sequence[Scalar]) -> SolverResult:
        found = scipy.integrate.solve_ivp(
            function,
            (0.0, times[-1]),
            start,
            method,
            times,
            rtol=max(tolerance, LEAST),
            atol=tolerance,
        )
        if found.status != 0:
            raise ArithmeticError(f"{method}: {found.message}")
        # it does not report its steps; every accepted and rejected one costs the same evaluations
        stages = {"RK45": 6, "DOP853": 11}.get(method)
        return SolverResult(list(found.y.T), found.nfev // stages if stages else 0, found.nfev)

    return solve


def odeint(compiled: bool, problem: GoldenProblem, settings: Settings) -> Solve:
    """``scipy.integrate.odeint``; tolerance 0 stands for its own defaults, as the paper used it."""
    import scipy.integrate

    function = right_hand_side(problem, settings, compiled)
    start, tolerance = problem.state(settings.precision), settings.tolerance or None

    def solve(times: Sequence[Scalar]) -> SolverResult:
        rows, info = scipy.integrate.odeint(
            function, start, [0.0, *times], tfirst=True, rtol=tolerance, atol=tolerance,
            mxstep=ODEINT_STEPS, full_output=True,
        )  # fmt: skip
        if info["message"] != "Integration successful.":
            raise ArithmeticError(f"odeint: {info['message']}")
        return SolverResult(list(rows[1:]), int(info["nst"][-1]), int(info["nfe"][-1]))

    return solve


for _compiled, _how, _packages in (
    (False, "Python", ("scipy",)),
    (True, "numba", ("scipy", "numba")),
):
    for _method in ("RK45", "DOP853", "LSODA", "Radau"):
        registered(f"SciPy {_method}, {_how}", *_packages)(partial(solve_ivp, _method, _compiled))
    registered(f"SciPy odeint, {_how}", *_packages)(partial(odeint, _compiled))
