"""heyoka's Taylor method: bare, with its options, with events and quadratures, in SIMD lanes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

from tt_precise.integration.equations import Equations
from tt_precise.integration.events import catalogue
from tt_precise.integration.heyoka_backend import Integrator, build, numeric_options
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.untyped import Adaptive
from tt_precise.scene.scene import Scene
from tt_precise.tradeoff.methods import Method, Prepare, Settings, Solve, SolverResult
from tt_precise.tradeoff.problem import GoldenProblem


def bare_adaptive(setup: Setup, state: Sequence[Scalar], parameters: Sequence[Scalar]) -> Adaptive:
    """The equations as a ``taylor_adaptive``: no events, not even the end of contact."""
    import heyoka

    return heyoka.taylor_adaptive(
        Equations.of(setup.formulation).system,
        list(state),
        pars=list(parameters),
        fp_type=setup.precision.fp_type,
        **numeric_options(setup),
    )


def bare_batch(setup: Setup, state: Array, parameters: Array) -> Adaptive:
    """The same in SIMD lanes: a column of ``state`` and of ``parameters`` for each."""
    import heyoka

    return heyoka.taylor_adaptive_batch(
        Equations.of(setup.formulation).system,
        state.copy(),
        pars=parameters,
        **numeric_options(setup),
    )


@cache
def _compiled(setup: Setup) -> Adaptive:
    form, number = setup.formulation, setup.precision.number
    zero = setup.precision.context.mpf(0)
    return bare_adaptive(
        setup, [number(zero) for _ in form.columns], [number(zero + 1) for _ in form.parameters]
    )


def bare_loop(scene: Scene, tolerance: float = 0.0, precision: str = "double") -> Callable[[], int]:
    """A function that propagates the Newton form of ``scene`` to its horizon; returns the steps.

    ``tolerance`` 0 stands for full accuracy. It knows no contact: also where the table would have
    to pull it goes on.
    """
    working = precision_named(precision)
    form = integrated(scene.model, "newton", scene.body.friction)
    setup = Setup(formulation=form, precision=working, tolerance=tolerance)
    adaptive, number = _compiled(setup), working.number
    start = InitialState.of(scene, working.arithmetic)
    state = list(map(number, start.state(form)))
    parameters = list(map(number, start.parameters(form)))
    until, zero = number(start.until), number(working.context.mpf(0))

    def loop() -> int:
        for i, value in enumerate(state):
            adaptive.state[i] = value
        for i, value in enumerate(parameters):
            adaptive.pars[i] = value
        adaptive.time = zero
        return int(adaptive.propagate_until(until)[3])

    return loop


LANES = (4, 8)
SPREAD = 1e-6  # of the starts in a batch: lanes that all take the same steps would flatter it


def setup_of(
    problem: GoldenProblem,
    settings: Settings,
    events: Sequence[str] = (),
    record: Sequence[str] = (),
    **options: Any,
) -> Setup:
    """What ``integrate`` would compile for these settings."""
    return Setup(
        formulation=problem.form,
        precision=settings.precision,
        events=tuple(events),
        record=tuple(record),
        tolerance=settings.tolerance,
        options=tuple(sorted(options.items())),
    )


def bare(problem: GoldenProblem, settings: Settings, **options: Any) -> Solve:
    """The equations and nothing else: no events, not even the end of contact."""
    adaptive = bare_adaptive(
        setup_of(problem, settings, **options),
        problem.state(settings.precision),
        problem.parameters(settings.precision),
    )
    return _solver(adaptive, problem, settings)


def supplied(
    problem: GoldenProblem,
    settings: Settings,
    events: Sequence[str] = (),
    record: Sequence[str] = (),
) -> Solve:
    """What ``integrate`` runs: the end of contact watched, and the events and records given."""
    made = build(setup_of(problem, settings, events, record))
    return _solver(made.adaptive, problem, settings, made)


def _solver(
    adaptive: Adaptive,
    problem: GoldenProblem,
    settings: Settings,
    made: Integrator | None = None,
) -> Solve:
    import heyoka
    import numpy

    precision = settings.precision
    number = precision.number
    zero = number(precision.context.mpf(0))
    entries = len(problem.form.columns)
    start = problem.state(precision)
    start += [zero] * (len(adaptive.state) - entries)  # of quadratures
    for i, value in enumerate(problem.parameters(precision)):
        adaptive.pars[i] = value

    def solve(times: Sequence[Scalar]) -> SolverResult:
        for i, value in enumerate(start):
            adaptive.state[i] = value
        adaptive.time = zero
        if made:
            adaptive.reset_cooldowns()
            made.hits.clear()
        if len(times) == 1:
            outcome, _, _, steps, _, _ = adaptive.propagate_until(times[0])
            states = [[adaptive.state[i] for i in range(entries)]]
        else:
            grid: Array = [zero, *times]
            if precision.name in ("double", "extended"):
                grid = numpy.array(grid, dtype=precision.fp_type)
            outcome, _, _, steps, _, rows = adaptive.propagate_grid(grid)
            states = [[rows[i, j] for j in range(entries)] for i in range(1, len(rows))]
        if outcome != heyoka.taylor_outcome.time_limit:
            raise ArithmeticError(f"heyoka stopped with {outcome}")
        return SolverResult(states, steps, steps * adaptive.order, adaptive.order)

    return solve


def lanes(width: int, problem: GoldenProblem, settings: Settings) -> Solve:
    """``width`` slightly different starts at once in SIMD lanes; the first is the problem's."""
    import numpy

    precision = settings.precision
    spread = 1 + SPREAD * numpy.arange(width)
    start = numpy.outer(problem.state(precision), spread)
    batch = bare_batch(
        setup_of(problem, settings),
        start,
        numpy.outer(problem.parameters(precision), numpy.ones(width)),
    )

    def solve(times: Sequence[Scalar]) -> SolverResult:
        batch.state[:] = start
        batch.set_time(0.0)
        states, steps = [], numpy.zeros(width, dtype=int)
        for time in times:
            batch.propagate_until([time] * width)
            steps += [result[3] for result in batch.propagate_res]
            states.append(batch.state[:, 0].copy())
        return SolverResult(states, int(steps[0]), int(steps[0]) * batch.order, batch.order, width)

    return solve


def user(request: str, problem: GoldenProblem, settings: Settings) -> Solve:
    """``integrate`` as a user calls it, from the scene to the trajectory.

    ``request`` is "tolerance", or "digits": then the tolerance says how many.
    """
    from tt_precise.integration import integrate

    precision, names = settings.precision, problem.published.columns
    scene = replace(problem.scene, until=problem.until)
    units = problem.start(precision).units
    asked: dict[str, Any] = {"events": (), "record": ()}
    if request == "digits":
        asked["digits"] = round(-math.log10(settings.tolerance))
    else:
        asked |= {"precision": precision.name, "tolerance": settings.tolerance}
        asked["bits"] = precision.bits if precision.name == "mp" else None
        asked["formulation"] = problem.coordinates

    def solve(times: Sequence[Scalar]) -> SolverResult:
        found = integrate(scene, **asked)
        context = found.precision.context
        state = [
            context.mpf(found.state.values[name]) / units.of_dimension(STATE_DIMENSIONS[name])
            for name in names
        ]
        return SolverResult(
            [state], found.steps, found.steps * found.order, found.order, published=True
        )

    return solve


def all_events(problem: GoldenProblem, settings: Settings) -> Solve:
    """With every event that the model has."""
    return supplied(problem, settings, catalogue(problem.scene.model))


def _with_option(option: str) -> Prepare:
    return lambda problem, settings: bare(problem, settings, **{option: True})


_WAYS: dict[str, Prepare] = {
    "heyoka": bare,
    **{
        f"heyoka, {option}": _with_option(option)
        for option in ("high_accuracy", "fast_math", "compact_mode", "parallel_mode")
    },
    **{f"tt_precise, {request}": partial(user, request) for request in ("tolerance", "digits")},
    **{f"heyoka, {width} lanes": partial(lanes, width) for width in LANES},
    "heyoka, contact watched": supplied,
    "heyoka, one event": partial(supplied, events=("theta_min",)),
    "heyoka, all events": all_events,
    **{
        f"heyoka, records {' '.join(names)}": partial(supplied, record=names)
        for names in (("phi",), ("x",), ("phi", "psi", "x", "y"))
    },
}
OWN = tuple(Method(name, ("heyoka",), prepare, peer=False) for name, prepare in _WAYS.items())
