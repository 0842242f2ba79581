"""Integrators that solve the same problem at a tolerance, each prepared by one function."""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, NamedTuple

import mpmath
import numpy

from benchmarks.work_precision.problem import GoldenProblem
from tt_precise.integration.precision import Precision
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array, Json, Scalar

# arguments, and what is done with the rates; without a p the parameters are constants of the text
SHAPES = {
    "list": ("t, y", "return [{}]"), "array": ("t, y", "return array([{}])"),
    "filling": ("t, y, dy", ""), "callback": ("dy, t, y, p", ""),
}  # fmt: skip


def flat(form: Formulation, shape: str, parameters: Sequence[float] = ()) -> Callable[..., Array]:
    """A flat Python function of the formulation's rates, of one of the ``SHAPES``.

    ``parameters`` are the values of ``form.parameters``, for the shapes that have no ``p``.
    """
    names: dict[str, Json] = {"math": math, "array": numpy.array}
    exec(source(form, shape, tuple(parameters)), names)
    rates: Callable[..., Array] = names["rates"]
    return rates


@cache
def source(form: Formulation, shape: str, parameters: tuple[float, ...] = ()) -> str:
    """The text of ``flat``."""
    from sympy.printing.pycode import pycode

    arguments, ending = SHAPES[shape]
    given = [f"p[{i}]" for i in range(len(form.parameters))]
    if "p" not in arguments:
        given = [repr(value) for value in parameters]
    shared, results = _shared(form)
    lines = [f"{name} = y[{i}]" for i, name in enumerate(form.columns)]
    lines += [f"{name} = {text}" for name, text in zip(form.parameters, given, strict=True)]
    lines += [f"{name} = {pycode(value)}" for name, value in shared]
    texts = [pycode(value) for value in results]
    if ending:
        lines.append(ending.format(", ".join(texts)))
    else:
        lines += [f"dy[{i}] = {text}" for i, text in enumerate(texts)]
    return f"def rates({arguments}):\n    " + "\n    ".join(lines) + "\n"


@cache
def _shared(form: Formulation) -> tuple[list[tuple[Scalar, Scalar]], list[Scalar]]:
    import sympy

    parameters = dict(zip(form.parameters, sympy.symbols(form.parameters), strict=True))
    body = Parameters(**{"m": 1, "R": 1, "g": 1, "mu": 0} | parameters)
    rates = form.rates(body, form.State(*sympy.symbols(form.columns)), sympy)
    return sympy.cse(list(rates))


class SolverResult(NamedTuple):
    """The result of a solver: a state for each requested time, and its cost.

    ``work`` counts evaluations of the right-hand side, of a Taylor method the coefficients of
    each state entry (steps times order). ``lanes`` trajectories were made at once.
    ``published`` says that the states are those that users get: of the published formulation, at
    the exact times and not at the rounded ones that were handed over.
    """

    states: Sequence[Sequence[Scalar]]
    steps: int
    work: int
    order: int | None = None
    lanes: int = 1
    published: bool = False


Solve = Callable[
    [Sequence[Scalar]], SolverResult
]  # from dimensionless times, in the method's numbers


class Settings(NamedTuple):
    """The request to a method: its tolerance (0: its best), and its arithmetic."""

    tolerance: float
    precision: Precision


Prepare = Callable[[GoldenProblem, Settings], Solve]


@dataclass(frozen=True)
class Method:
    """A registered method: its name, who made it, what has to be installed for it."""

    name: str
    packages: tuple[str, ...]
    prepare: Prepare
    peer: bool = True

    @property
    def missing(self) -> tuple[str, ...]:
        """Packages that it needs and that are not installed."""
        return tuple(name for name in self.packages if importlib.util.find_spec(name) is None)


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
        solution = scipy.integrate.solve_ivp(
            function,
            (0.0, times[-1]),
            start,
            method,
            times,
            rtol=max(tolerance, LEAST),
            atol=tolerance,
        )
        if solution.status != 0:
            raise ArithmeticError(f"{method}: {solution.message}")
        # it does not report its steps; every accepted and rejected one costs the same evaluations
        stages = {"RK45": 6, "DOP853": 11}.get(method)
        return SolverResult(
            list(solution.y.T), solution.nfev // stages if stages else 0, solution.nfev
        )

    return solve


def odeint(compiled: bool, problem: GoldenProblem, settings: Settings) -> Solve:
    """``scipy.integrate.odeint``; tolerance 0 means its defaults, as in the paper."""
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

    start = numpy.array(problem.state(settings.precision))
    parameters = numpy.array(problem.parameters(settings.precision))
    address, tolerance = _callback(problem.form).address, settings.tolerance
    stages = {"DOP853": 11, "VERN8": 13, "TSIT5": 6}.get(method, 0)

    def solve(times: Sequence[Scalar]) -> SolverResult:
        wanted = numpy.array(times)
        solution = CyRK.nbsolve2_ivp(
            address, (0.0, float(wanted[-1])), start, method, wanted, False, parameters,
            tolerance, tolerance,
        )  # fmt: skip
        try:
            if not solution.success:
                raise ArithmeticError(f"CyRK {method}: {solution.message}")
            steps = int(solution.steps_taken)
            return SolverResult(list(solution.y.T.copy()), steps, steps * stages)
        finally:
            solution.free()

    solve([1e-3])
    return solve


def cvode(method: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """SUNDIALS' CVODE, from the wheel of scikit-sundae."""
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
        solution = solver.solve(numpy.array([0.0, *times]), numpy.array(start))
        if not solution.success:
            raise ArithmeticError(f"CVODE: {solution.message}")
        states = numpy.asarray(solution.y)[1 if len(times) > 1 else -1 :]
        return SolverResult(list(states), 0, int(solution.nfev))

    solve([1e-3])
    return solve


MOST_STEPS = 4_000_000


def diffrax_solver(solver: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """``diffrax.diffeqsolve`` with one number as relative and absolute tolerance, jitted."""
    start = numpy.array(problem.state(settings.precision))
    parameters = numpy.array(problem.parameters(settings.precision))
    at_end, at_times = (_diffrax_jitted(solver, problem.form, between) for between in (False, True))

    def solve(times: Sequence[Scalar]) -> SolverResult:
        chosen = at_end if len(times) == 1 else at_times
        states, steps, evaluations = chosen(
            start, numpy.array(times), settings.tolerance, parameters
        )
        return SolverResult(list(numpy.asarray(states)), int(steps), int(evaluations))

    solve([1e-3])
    return solve


@cache
def _diffrax_jitted(solver: str, form: Formulation, between: bool) -> Callable[..., Array]:
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
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), method, 0.0, times[-1], None, start, parameters,
            saveat=diffrax.SaveAt(ts=times) if between else diffrax.SaveAt(t1=True),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=MOST_STEPS,
        )  # fmt: skip
        return solution.ys, solution.stats["num_steps"], solution.stats["num_steps"] * stages

    return solve


MARGIN_BITS = 16  # odefun asks for a tolerance above the eps that it works with


def odefun(problem: GoldenProblem, settings: Settings) -> Solve:
    """``mpmath.odefun`` on the generic equations; it reports no steps."""
    precision, form = settings.precision, problem.form
    start = problem.start(precision)
    # numbers of mpmath's own context: odefun raises its precision, and theirs has to follow
    own = mpmath.mp.convert
    state = [own(x) for x in start.state(form)]
    body = start.body.numbers(own)

    def solve(times: Sequence[Scalar]) -> SolverResult:
        evaluations = 0

        def rates(t: Scalar, y: Sequence[Scalar]) -> list[Scalar]:
            nonlocal evaluations
            evaluations += 1
            return list(form.rates(body, form.State(*y), mpmath))

        with mpmath.workprec(precision.bits):
            tolerance = mpmath.ldexp(1, MARGIN_BITS - precision.bits)
            follow = mpmath.odefun(rates, 0, list(state), tolerance)
            states = [follow(own(precision.with_guard_bits(t))) for t in times]
        return SolverResult(states, 0, evaluations)

    return solve


PEERS = (
    *(
        Method(f"SciPy {name}, {how}", packages, partial(solve_ivp, name, how == "numba"))
        for how, packages in (("Python", ("scipy",)), ("numba", ("scipy", "numba")))
        for name in ("RK45", "DOP853", "LSODA", "Radau")
    ),
    Method("SciPy odeint, Python", ("scipy",), partial(odeint, False)),
    Method("SciPy odeint, numba", ("scipy", "numba"), partial(odeint, True)),
    *(
        Method(f"CyRK {name}", ("CyRK", "numba"), partial(cyrk, name))
        for name in ("DOP853", "VERN8", "TSIT5", "LSODA")
    ),
    *(
        Method(f"SUNDIALS CVODE {name}", ("sksundae", "numba"), partial(cvode, name))
        for name in ("Adams", "BDF")
    ),
    *(
        Method(f"diffrax {name}", ("diffrax", "jax"), partial(diffrax_solver, name))
        for name in ("Dopri8", "Tsit5")
    ),
    Method("mpmath odefun", ("mpmath",), odefun),
)
