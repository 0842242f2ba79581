"""C and C++ integrators with a right-hand side compiled by numba: CyRK, SUNDIALS' CVODE."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from typing import Any

from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, registered
from tt_precise.tradeoff.problem import GoldenProblem
from tt_precise.tradeoff.right_hand_side import flat

CVODE_STEPS = 10_000_000


@cache
def _callback(form: Formulation) -> Any:
    # cached, because its address is all that CyRK holds of it
    from CyRK.nb.numba_solver import cyjit

    return cyjit(flat(form, "callback"))


@cache
def _compiled(form: Formulation, parameters: tuple[float, ...]) -> Any:
    import numba

    return numba.njit(flat(form, "filling", parameters))


def cyrk(method: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """CyRK's C++ solvers through numba, with one number as relative and absolute tolerance."""
    import CyRK
    import numpy

    start = numpy.array(problem.state(settings.precision))
    parameters = numpy.array(problem.parameters(settings.precision))
    address, tolerance = _callback(problem.form).address, settings.tolerance
    stages = {"DOP853": 11, "VERN8": 13, "TSIT5": 6}.get(method, 0)

    def solve(times: Sequence[Scalar]) -> SolverResult:
        wanted = numpy.array(times)
        found = CyRK.nbsolve2_ivp(
            address, (0.0, float(wanted[-1])), start, method, wanted, False, parameters,
            tolerance, tolerance,
        )  # fmt: skip
        try:
            if not found.success:
                raise ArithmeticError(f"CyRK {method}: {found.message}")
            steps = int(found.steps_taken)
            return SolverResult(list(found.y.T.copy()), steps, steps * stages)
        finally:
            found.free()

    solve([1e-3])
    return solve


def cvode(method: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """SUNDIALS' CVODE, from the wheel of scikit-sundae."""
    import numpy
    from sksundae.cvode import CVODE

    function = _compiled(problem.form, tuple(problem.parameters(settings.precision)))

    # it looks at the signature, which a compiled function does not show
    def filling(t: float, y: Array, dy: Array) -> None:
        function(t, y, dy)

    start, tolerance = problem.state(settings.precision), settings.tolerance
    solver = CVODE(
        filling, method=method, rtol=tolerance, atol=tolerance, max_num_steps=CVODE_STEPS
    )

    def solve(times: Sequence[Scalar]) -> SolverResult:
        found = solver.solve(numpy.array([0.0, *times]), numpy.array(start))
        if not found.success:
            raise ArithmeticError(f"CVODE: {found.message}")
        states = numpy.asarray(found.y)[1 if len(times) > 1 else -1 :]
        return SolverResult(list(states), 0, int(found.nfev))

    solve([1e-3])
    return solve


for _method in ("DOP853", "VERN8", "TSIT5", "LSODA"):
    registered(f"CyRK {_method}", "CyRK", "numba")(partial(cyrk, _method))
for _method in ("Adams", "BDF"):
    registered(f"SUNDIALS CVODE {_method}", "sksundae", "numba")(partial(cvode, _method))
