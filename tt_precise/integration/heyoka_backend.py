"""heyoka's Taylor integrators in double, quad and mp: compiled once, then reused.

All equations are integrated in dimensionless units (m = R = g = 1).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, lru_cache, partial
from typing import Any, TypeVar

from tt_precise.integration.columns import Row
from tt_precise.integration.equations import Equations, longest_step
from tt_precise.integration.precision import LONG_DOUBLES
from tt_precise.integration.setup import Setup, ended_at_start, full_tolerance
from tt_precise.integration.solution import Propagation, Segment, require_few_steps
from tt_precise.integration.steps import Steps, join, of_heyoka
from tt_precise.integration.zeros import Zeros
from tt_precise.runtime.terminal import Progress, import_heyoka
from tt_precise.runtime.values import Adaptive, Array, Scalar
from tt_precise.scene.scene import InitialState, Scene

LONGEST = 2.0**40  # No propagation whose state has the time gets so far: the state ends it.
MOST_SAMPLES = 20_000  # States that are stored of a run at its sample times.
# How far LLVM optimises: compact code has the bits of level 3 at level 1, wide types at level 0.
OPTIMISATION = {"loop": 3, "compact": 1, "wide": 0}
Key = TypeVar("Key", bound=Hashable)
Made = TypeVar("Made")
POOLED_KINDS = 6  # Idle integrators of so many kinds are pooled: each takes 3 to 5 MB.


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse numbers that heyoka does not have, and motions in several segments."""
    refused = setup.precision.doubles or scene.in_pieces
    return f"{scene.name}: got several doubles or segments" if refused else None


def run(
    scene: Scene, setup: Setup, start: InitialState, progress: Progress | None
) -> list[Segment]:
    """The run from ``start``, in one segment."""
    few = 0 < scene.until <= MOST_SAMPLES * scene.sample_every
    samples = sample_times(start, scene).astype(float) if setup.precision.is_float and few else None
    propagation = propagate(setup, start, samples=samples, progress=progress)
    return [Segment(start.until * 0, setup, start, propagation)]


def sample_times(start: InitialState, scene: Scene) -> Array:
    """Return the dimensionless sample times of a scene, as long doubles."""

    def compute() -> Array:
        unit, until = map(LONG_DOUBLES.number, (start.units.time, start.until))
        times = LONG_DOUBLES.of_fractions(scene.sample_times) / unit
        times[-1] = until
        return times

    return start.once("sample times", compute)


class TaylorRun:
    """A propagation so far: its steps, their number, its events, and losses of contact."""

    def __init__(
        self, setup: Setup, start: InitialState, progress: Progress | None = None,
        until: Scalar = None,
    ):  # fmt: skip
        self.setup, self.start, self.progress = setup, start, progress
        clock, context = setup.phase.has_clock, setup.precision.context
        self.goal = until or (context.mpf(LONGEST) if clock else start.until)
        self.blocks, self.steps = list[Steps](), 0
        pulled = setup.contact == "bilateral" and ended_at_start(start, "unilateral", context)
        self.zeros, self.losses = Zeros(setup, start), int(bool(pulled))

    def add(self, block: Steps) -> None:
        """Keep the next steps, and find their events."""
        self.blocks.append(block)
        self.zeros.search(block)

    def report(self, time: Scalar) -> bool:
        """Show the time that is reached; true, because the run goes on."""
        if self.progress and self.goal:
            self.progress(min(1.0, float(time) / float(self.goal)))
        return True

    def ended(self, status: str, time: Scalar, row: Row, order: int) -> Propagation:
        """Return the outcome of a run whose steps are known."""
        if status == "complete" and self.losses:
            status = "contact_ignored"
        events, series = self.zeros.collect(), partial(join, self.blocks)
        return Propagation(status, time, row, self.steps, order, events, series)


def propagate(
    setup: Setup,
    start: InitialState,
    *,
    until: Scalar = None,
    series: bool = False,
    samples: Array | None = None,
    progress: Progress | None = None,
) -> Propagation:
    """Propagate once from ``start`` to ``until`` or to the horizon of the start.

    A run in double that looks for no events has Taylor steps only if ``series`` asks for them, and
    otherwise its states at ``samples``; wider arithmetics take longer than their series. A run has
    the status "failed", at its last good step, if it produces NaN or steps that are too short.
    """
    series = series or bool(setup.events) or not setup.precision.is_float
    with pooled(build, setup.but(events=())) as integrator:
        run = _BlockwiseRun(setup, start, integrator, progress, until)
        outcome = run.propagate(series, samples)
        if outcome == outcomes().err_nf_state:
            last, order = run.last_good_time(), integrator.adaptive.order
            if last:
                shorter = propagate(setup, start, until=last, series=series)
                return shorter._replace(status="failed")
            row = start.first_row(setup.formulation, setup.record)
            return TaylorRun(setup, start).ended("failed", last, row, order)
        run.losses += len(integrator.losses)
        ended = run.ended(status_of(outcome, integrator.terminal), *run.end)
    if series:
        return ended
    end = ended.time if ended.status == "failed" else until
    again = partial(propagate, setup, start, until=end, series=True)
    return ended._replace(series=lambda: again().series(), samples=run.samples)


class _BlockwiseRun(TaylorRun):
    """A propagation by blocks of steps, between which Ctrl-C works and progress is reported."""

    def __init__(
        self, setup: Setup, start: InitialState, integrator: Integrator,
        progress: Progress | None, until: Scalar,
    ):  # fmt: skip
        super().__init__(setup, start, progress, until)
        integrator.begin(setup, start)
        self.integrator, self.adaptive = integrator, integrator.adaptive
        self.samples: Array | None = None
        precision, order = setup.precision, self.adaptive.order
        longest = longest_step(start.body, start.vectors, order, precision, setup.phase)
        self.limits: dict[str, Any] = {"max_steps": precision.kind.steps}
        if longest is not None:
            self.limits["max_delta_t"] = precision.number(longest)
        if not precision.is_float:
            self.limits["callback"] = lambda adaptive: self.report(adaptive.time)

    @property
    def end(self) -> tuple[Scalar, Row, int]:
        """The time, which a step to an event leaves between two numbers, the state, the order."""
        # one at a time: arrays of heyoka's reals leak memory
        state, widen = self.adaptive.state, self.setup.precision.with_guard_bits
        row = tuple(widen(state[i]) for i in range(len(state)))
        return sum(map(widen, self.adaptive.dtime)), row, self.adaptive.order

    def propagate(self, series: bool, samples: Array | None) -> Any:
        """Propagate to the goal, with states at the samples if these fit in a block of steps.

        heyoka would begin a second grid a rounding away from the end of the last step.
        """
        first = self.setup.precision.context.mpf(self.setup.phase.first_step)
        if 0 < first < self.goal:
            outcome = self._advance(first, series)
            if outcome != outcomes().time_limit:
                return outcome
        if samples is None or series:
            return self._advance(self.goal, series)
        times = [self.adaptive.time, *samples[1:]]
        outcome, _, _, count, _, rows = self.adaptive.propagate_grid(times, **self.limits)
        self.samples = rows if len(rows) == len(samples) else None
        self.steps += count
        self.report(self.adaptive.time)
        return self._advance(self.goal, series) if outcome == outcomes().step_limit else outcome

    def _advance(self, goal: Scalar, series: bool) -> Any:
        """Propagate to a goal; ``step_limit`` if a block covers less than eps of the horizon."""
        precision, adaptive, limit = self.setup.precision, self.adaptive, outcomes().step_limit
        while True:
            before = adaptive.time
            outcome, _, _, count, output, _ = adaptive.propagate_until(
                precision.number(goal), c_output=series, **self.limits
            )
            if output is not None:
                self.add(of_heyoka(output, self.setup, self.start))
            self.steps += count
            self.report(adaptive.time)
            advance = precision.with_guard_bits(adaptive.time - before)
            if outcome != limit or advance < precision.eps * goal:
                return outcome
            require_few_steps(self.steps, float(adaptive.time), float(goal))

    def last_good_time(self) -> Scalar:
        """Return the beginning of the last step before the state becomes NaN."""
        self.integrator.begin(self.setup, self.start)
        times, precision = [self.adaptive.time], self.setup.precision
        horizon = precision.number(self.goal)

        def after_step(adaptive: Adaptive) -> bool:
            if adaptive.time < horizon:  # so that a shorter run that fails again is shorter still
                times.append(adaptive.time)
            return True

        self.adaptive.propagate_until(horizon, callback=after_step)
        return precision.with_guard_bits(times[-1])


@cache
def outcomes() -> Any:
    """heyoka's outcomes of a propagation."""
    return import_heyoka().taylor_outcome


def status_of(outcome: Any, terminal: tuple[str, ...]) -> str:
    """The status of a propagation that heyoka ended with ``outcome``."""
    if outcome == outcomes().time_limit:
        return "complete"
    index = -1 - int(outcome)
    return terminal[index] if 0 <= index < len(terminal) else "failed"


@dataclass
class Integrator:
    """A ``heyoka.taylor_adaptive``, the events that end or switch a motion, losses of contact."""

    adaptive: Adaptive
    terminal: tuple[str, ...]
    losses: list[str] = field(default_factory=list)

    def begin(self, setup: Setup, start: InitialState) -> None:
        """Go to ``start``, at time zero, and forget earlier events."""
        form, number = setup.formulation, setup.precision.number
        for i, value in enumerate(start.first_row(form, setup.record)):
            self.adaptive.state[i] = number(value)
        horizon = (start.until,) if setup.phase.has_clock else ()
        for i, value in enumerate((*start.parameters(form), *horizon)):
            self.adaptive.pars[i] = number(value)
        self.adaptive.time = number(setup.precision.context.mpf(0))
        self.adaptive.reset_cooldowns()
        self.losses[:] = []


def build(setup: Setup) -> Integrator:
    """Compile the integrator for ``setup``."""
    heyoka = import_heyoka()
    form, fp_type = setup.formulation, setup.precision.fp_type
    equations = Equations.of(form, setup.record)
    eps, parameters = float(setup.precision.eps), len(form.parameters)
    terminal = setup.phase.ends(equations, heyoka.par[parameters], setup.precision)
    number, losses, noted = setup.precision.number, list[str](), []
    falling: Any = {"direction": heyoka.event_direction.negative, "fp_type": fp_type}
    if setup.contact == "bilateral":
        g_n = terminal.pop("contact_lost")
        noted = [heyoka.nt_event(g_n, lambda *_: losses.append("contact_lost"), **falling)]
    goes_on: Any = setup.phase.condition or (lambda *_: None)
    zero = setup.precision.context.mpf(0)
    integrator = heyoka.taylor_adaptive(
        equations.system,
        [number(zero) for _ in equations.variables],
        pars=[number(zero + 1) for _ in range(parameters + setup.phase.has_clock)],
        fp_type=fp_type,
        t_events=[
            heyoka.t_event(function, callback=goes_on(form, name, eps, setup.tolerance), **falling)
            for name, function in terminal.items()
        ],
        nt_events=noted,
        **numeric_options(setup),
    )
    return Integrator(integrator, tuple(terminal), losses)


def numeric_options(setup: Setup) -> dict[str, Any]:
    """Keyword arguments of ``heyoka.taylor_adaptive`` that fix tolerance and compilation."""
    precision = setup.precision
    # compact code compiles wide types in 0.5 s, not 26 s; double then takes twice as long
    kind = "wide" if not precision.is_float else "compact" if setup.phase.brief else "loop"
    tolerance = precision.context.mpf(setup.tolerance) or full_tolerance(precision)
    options = {"compact_mode": kind != "loop", "opt_level": OPTIMISATION[kind]}
    return {**options, "tol": precision.number(tolerance)}


@lru_cache(maxsize=POOLED_KINDS)
def _idle(make: Callable[[Hashable], Any], key: Hashable) -> list[Any]:
    return []


@contextmanager
def pooled(make: Callable[[Key], Made], key: Key) -> Iterator[Made]:
    """Give ``make(key)``, or an idle object of an earlier call; safe for several threads."""
    idle = _idle(make, key)
    try:
        integrator: Made = idle.pop()
    except IndexError:
        integrator = make(key)
    yield integrator
    idle.append(integrator)  # only after a run without an exception
