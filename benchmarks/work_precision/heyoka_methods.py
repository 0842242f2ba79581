"""heyoka's Taylor method: bare, with its options, with events and quadratures, in SIMD lanes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import heyoka
import numpy

from benchmarks.work_precision.peers import Method, Prepare, Settings, Solve, SolverResult
from benchmarks.work_precision.problem import GoldenProblem
from tt_precise.integration import integrate
from tt_precise.integration.equations import Equations
from tt_precise.integration.events import catalogue
from tt_precise.integration.heyoka_backend import build, numeric_options
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import of_heyoka
from tt_precise.integration.zeros import Zeros
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.runtime.values import Adaptive, Array, Scalar


def bare_batch(setup: Setup, state: Array, parameters: Array) -> Adaptive:
    """The bare equations in SIMD lanes: a column of ``state`` and of ``parameters`` for each."""
    return heyoka.taylor_adaptive_batch(
        Equations.of(setup.formulation).system,
        state.copy(),
        pars=parameters,
        **numeric_options(setup),
    )


LANES = (4, 8)
# Relative spread of the starts in a batch: lanes that take equal steps would flatter it.
SPREAD = 1e-6


def setup_of(
    problem: GoldenProblem,
    settings: Settings,
    events: Sequence[str] = (),
    record: Sequence[str] = (),
) -> Setup:
    """Return the setup that ``integrate`` compiles for these settings."""
    return Setup(
        formulation=problem.form,
        precision=settings.precision,
        events=tuple(events),
        record=tuple(record),
        tolerance=settings.tolerance,
    )


def bare(problem: GoldenProblem, settings: Settings, options: Sequence[str] = ()) -> Solve:
    """The equations and nothing else: no events, not even the end of contact."""
    setup = setup_of(problem, settings)
    adaptive = heyoka.taylor_adaptive(
        Equations.of(setup.formulation).system,
        problem.state(settings.precision),
        pars=problem.parameters(settings.precision),
        fp_type=setup.precision.fp_type,
        **{**numeric_options(setup), **dict.fromkeys(options, True)},
    )
    return _solver(adaptive, problem, settings)


def supplied(
    problem: GoldenProblem,
    settings: Settings,
    events: Sequence[str] = (),
    record: Sequence[str] = (),
) -> Solve:
    """Return the run of ``integrate`` with events and records; it ends with the contact."""
    names = catalogue(problem.scene.model) if events == ("all",) else events
    setup = setup_of(problem, settings, names, record)
    made = build(setup.but(events=()))
    return _solver(made.adaptive, problem, settings, setup)


def _solver(
    adaptive: Adaptive,
    problem: GoldenProblem,
    settings: Settings,
    setup: Setup | None = None,
) -> Solve:
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
        if setup:
            adaptive.reset_cooldowns()
        if setup and setup.events:
            zeros = Zeros(setup, problem.start(precision))
            outcome, _, _, steps, output, _ = adaptive.propagate_until(times[-1], c_output=True)
            zeros.search(of_heyoka(output, setup, zeros.start))
            rows = output(numpy.array(times, dtype=precision.fp_type))
            states = [[row[j] for j in range(entries)] for row in rows]
        elif len(times) == 1:
            outcome, _, _, steps, _, _ = adaptive.propagate_until(times[0])
            states = [[adaptive.state[i] for i in range(entries)]]
        else:
            grid: Array = [zero, *times]
            if precision.name == "double":
                grid = numpy.array(grid, dtype=precision.fp_type)
            outcome, _, _, steps, _, rows = adaptive.propagate_grid(grid)
            states = [[rows[i, j] for j in range(entries)] for i in range(1, len(rows))]
        if outcome != heyoka.taylor_outcome.time_limit:
            raise ArithmeticError(f"heyoka stopped with {outcome}")
        return SolverResult(states, steps, steps * adaptive.order, adaptive.order)

    return solve


def lanes(width: int, problem: GoldenProblem, settings: Settings) -> Solve:
    """``width`` slightly different starts at once in SIMD lanes; the first is the problem's."""
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
        trajectory = integrate(scene, **asked)
        context = trajectory.precision.context
        state = [
            context.mpf(trajectory.state.values[name]) / units.of_dimension(STATE_DIMENSIONS[name])
            for name in names
        ]
        return SolverResult(
            [state],
            trajectory.steps,
            trajectory.steps * trajectory.order,
            trajectory.order,
            published=True,
        )

    return solve


_WAYS: dict[str, Prepare] = {
    "heyoka": bare,
    **{
        f"heyoka, {option}": partial(bare, options=(option,))
        for option in ("high_accuracy", "fast_math", "compact_mode", "parallel_mode")
    },
    **{f"tt_precise, {request}": partial(user, request) for request in ("tolerance", "digits")},
    **{f"heyoka, {width} lanes": partial(lanes, width) for width in LANES},
    "heyoka, contact watched": supplied,
    "heyoka, one event": partial(supplied, events=("theta_min",)),
    "heyoka, all events": partial(supplied, events=("all",)),
    **{
        f"heyoka, records {', '.join(names)}": partial(supplied, record=names)
        for names in (("phi",), ("x",), ("phi", "psi", "x", "y"))
    },
}
OWN = tuple(Method(name, ("heyoka",), prepare, peer=False) for name, prepare in _WAYS.items())
