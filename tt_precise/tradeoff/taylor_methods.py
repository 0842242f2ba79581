"""heyoka's Taylor method: bare, with its options, with events and quadratures, in SIMD lanes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from tt_precise.integration.events import catalogue
from tt_precise.integration.paired import Lane
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import Integrator, build
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.turning import TURNING
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.untyped import Adaptive
from tt_precise.tradeoff.bare_loop import bare_adaptive, bare_batch
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, registered
from tt_precise.tradeoff.problem import GoldenProblem

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


def turning(problem: GoldenProblem, settings: Settings) -> Solve:
    """What ``digits=`` runs up to ten digits, alone: in double, with viscous friction.

    The leaner equations in a frame that turns; the states are turned back.
    """
    lane = Lane.of(problem.start(settings.precision))
    setup = replace(setup_of(problem, settings), formulation=TURNING)
    adaptive = bare_adaptive(setup, lane.state, lane.parameters)
    return _solver(adaptive, problem, settings, lane=lane)


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
    lane: Lane | None = None,
) -> Solve:
    import heyoka
    import numpy

    precision = settings.precision
    number = precision.number
    zero = number(precision.context.mpf(0))
    entries = len(problem.form.columns)
    start = problem.state(precision) if lane is None else list(lane.state)
    start += [zero] * (len(adaptive.state) - entries)  # of quadratures
    for i, value in enumerate(lane.parameters if lane else problem.parameters(precision)):
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
        if lane is not None:
            states = [
                list(lane.inertial(time, state, math))
                for time, state in zip(times, states, strict=True)
            ]
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


_register = partial(registered, peer=False)
_register("heyoka", "heyoka")(bare)
_register("heyoka, turning frame", "heyoka")(turning)
_register("heyoka, high_accuracy", "heyoka")(partial(bare, high_accuracy=True))
_register("heyoka, fast_math", "heyoka")(partial(bare, fast_math=True))
_register("heyoka, compact_mode", "heyoka")(partial(bare, compact_mode=True))
_register("heyoka, parallel_mode", "heyoka")(partial(bare, parallel_mode=True))
for _request in ("tolerance", "digits"):
    _register(f"tt_precise, {_request}", "heyoka")(partial(user, _request))
for _width in LANES:
    _register(f"heyoka, {_width} lanes", "heyoka")(partial(lanes, _width))
_register("heyoka, contact watched", "heyoka")(supplied)
_register("heyoka, one event", "heyoka")(partial(supplied, events=("theta_min",)))


@_register("heyoka, all events", "heyoka")
def all_events(problem: GoldenProblem, settings: Settings) -> Solve:
    """With every event that the model has."""
    return supplied(problem, settings, catalogue(problem.scene.model))


for _name in ("phi", "x"):
    _register(f"heyoka, records {_name}", "heyoka")(partial(supplied, record=(_name,)))
_register("heyoka, records phi psi x y", "heyoka")(
    partial(supplied, record=("phi", "psi", "x", "y"))
)
