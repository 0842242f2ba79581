"""diffrax: Runge-Kutta methods compiled as a whole by JAX, in double."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

from tt_precise.mechanics.formulations import Formulation
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, registered
from tt_precise.tradeoff.problem import GoldenProblem

MOST_STEPS = 4_000_000


def diffrax_solver(solver: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """``diffrax.diffeqsolve`` with one number as relative and absolute tolerance, jitted."""
    import numpy

    start = numpy.array(problem.state(settings.precision))
    parameters = numpy.array(problem.parameters(settings.precision))
    at_end, at_times = _jitted(solver, problem.form, False), _jitted(solver, problem.form, True)

    def solve(times: Sequence[Scalar]) -> SolverResult:
        chosen = at_end if len(times) == 1 else at_times
        states, steps, evaluations = chosen(
            start, numpy.array(times), settings.tolerance, parameters
        )
        return SolverResult(list(numpy.asarray(states)), int(steps), int(evaluations))

    solve([1e-3])
    return solve


@cache
def _jitted(solver: str, form: Formulation, between: bool) -> Callable[..., Array]:
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    method = getattr(diffrax, solver)()
    # first same as last: the last stage of a step is the first one of the next
    stages = method.tableau.num_stages - 1

    def rates(t: Array, y: Array, parameters: Array) -> Array:
        given = dict(zip(form.parameters, parameters, strict=True))
        body = Parameters(**{"m": 1, "R": 1, "g": 1, "mu": 0} | given)
        return jax.numpy.stack(form.rates(body, form.State(*y), jax.numpy))

    @jax.jit
    def solve(start: Array, times: Array, tolerance: Array, parameters: Array) -> Array:
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), method, 0.0, times[-1], None, start, parameters,
            saveat=diffrax.SaveAt(ts=times) if between else diffrax.SaveAt(t1=True),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=MOST_STEPS,
        )  # fmt: skip
        return found.ys, found.stats["num_steps"], found.stats["num_steps"] * stages

    return solve


for _solver in ("Dopri8", "Tsit5"):
    registered(f"diffrax {_solver}", "diffrax", "jax")(partial(diffrax_solver, _solver))
