"""heyoka's Taylor integrators in double, extended, quad and mp: compiled once, then reused.

All equations are integrated in dimensionless units (m = R = g = 1).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from types import ModuleType
from typing import Any, TypeVar

from tt_precise.integration.dense_output import (
    ARRIVED,
    DenseOutput,
    Propagation,
    Read,
    Repeat,
    SampleTimes,
    Segment,
    StoredSeries,
)
from tt_precise.integration.equations import Equations, longest_step
from tt_precise.integration.precision import Precision
from tt_precise.integration.setup import Setup, full_tolerance, left_the_table
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Adaptive, Array, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

LONGEST = 2.0**40  # No propagation whose state has the time gets so far: the state ends it.
MOST_CUTS = 4  # A failed propagation is cut back to its last good step so often.
# How far LLVM optimises. Compact code in double has the bits of level 3 at level 1, in 0.6 of the
# time. Wider types have them at level 0, in a seventh of it: a library does their operations.
OPTIMISATION = {"loop": 3, "compact": 1, "wide": 0}
Key = TypeVar("Key", bound=Hashable)
Made = TypeVar("Made")
POOLED_KINDS = 6  # Idle integrators of so many kinds are pooled: each takes 3 to 5 MB.


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse numbers that heyoka does not have, and motions in several segments."""
    if setup.precision.doubles:
        return f"{scene.name}: got {setup.precision.name}, expected one of heyoka's precisions"
    return f"{scene.name}: got a motion in segments" if scene.in_pieces else None


def run(
    scene: Scene,
    setup: Setup,
    start: InitialState,
    samples: SampleTimes | None,
    progress: Progress | None,
) -> list[Segment]:
    """The run from ``start``, in one segment."""
    samples = None if needs_series(setup) else samples
    propagation = propagate(setup, start, samples=samples, progress=progress)
    again = repeating(setup, start, propagation)
    output = DenseOutput(setup, start, propagation, again, samples)
    return [Segment(start.until * 0, output)]


def needs_series(setup: Setup) -> bool:
    """True if the series of the steps are computed at once.

    Events need them, and wider arithmetics take longer than the series.
    """
    return bool(setup.events) or not setup.precision.is_float


def repeating(setup: Setup, start: InitialState, first: Propagation) -> Repeat:
    """Return a function that repeats a propagation, for a reader of its series."""
    until = first.time if first.status == "failed" else None

    def again(read: Read, progress: Progress | None) -> Propagation:
        plain = setup.but(events=())
        return propagate(plain, start, until=until, read=read, progress=progress)

    return again


def propagate(
    setup: Setup,
    start: InitialState,
    *,
    until: Scalar = None,
    read: Read | None = None,
    samples: SampleTimes | None = None,
    progress: Progress | None = None,
    cuts: int = MOST_CUTS,
) -> Propagation:
    """Propagate once from ``start``; returns the outcome in heyoka's numbers.

    ``until`` (a number of heyoka's type) replaces the horizon of the start. ``read`` receives
    heyoka's dense output of each bounded block, in order. At ``samples`` a run in double stores its
    states. A propagation that produces NaN is cut back to its last good step, at most ``cuts``
    times, and has the status "failed", as has a propagation whose steps are too short ever to reach
    the horizon.

    Raises ``InputError``: there are more than ``MOST_EVENTS`` events, or the function of an event
    became undefined.
    """
    form = setup.formulation
    number, zero = setup.precision.number, setup.precision.context.mpf(0)
    exact = setup.precision.context.mpf
    if until is None:
        horizon = number(exact(LONGEST) if setup.phase.has_clock else start.until)
    else:
        horizon = until
    first = number(exact(setup.phase.first_step))
    goals = [first, horizon] if setup.phase.first_step and first < horizon else [horizon]
    zeros, readers = None, [read] if read else []
    if setup.events:
        from tt_precise.integration.steps import of_dense_output
        from tt_precise.integration.zeros import Zeros

        zeros = Zeros(setup, start)
        readers.append(lambda block: zeros.search(of_dense_output(block, setup, start)))
    stored = StoredSeries(setup) if read or needs_series(setup) else None
    if stored:
        readers.append(stored.append)
    with pooled_integrator(setup.but(events=())) as integrator:
        integrator.begin(setup, start)
        longest = longest_step(
            start.body, start.vectors, integrator.adaptive.order, setup.precision, setup.phase
        )
        limits = {} if longest is None else {"max_delta_t": number(longest)}
        outcome, steps, taken = _advance(
            integrator, goals, readers, samples, progress, setup.precision, limits
        )
        status = status_of(outcome, integrator.terminal)
        if (
            status == "complete"
            and setup.contact == "bilateral"
            and left_the_table(form.model, start, setup.precision.context, bool(integrator.losses))
        ):
            status = "contact_ignored"
        if status != "failed":
            propagation = _propagation_of(integrator, status, steps)
            if zeros:
                with_guard_bits = setup.precision.with_guard_bits
                end = None if status in ARRIVED else [*map(with_guard_bits, propagation.state)]
                propagation = replace(propagation, found=zeros.collect(end))
            series = stored.blocks if stored else None
            return replace(propagation, series=series, samples=taken)
        last_good = integrator.adaptive.time
        if outcome == outcomes().err_nf_state:
            last_good = _time_before_failure(setup, start, integrator, horizon)
        if last_good == number(zero):
            integrator.begin(setup, start)
            return _propagation_of(integrator, status, 0)
    if not cuts:  # no time is good
        last_good = number(zero)
    propagation = propagate(setup, start, until=last_good, cuts=cuts - 1)
    return replace(propagation, status="failed")


def _advance(
    integrator: Integrator,
    goals: list[Scalar],
    readers: Sequence[Read],
    samples: SampleTimes | None,
    progress: Progress | None,
    precision: Precision,
    limits: dict[str, Any],
) -> tuple[Any, int, Array | None]:
    """Outcome, steps and states at ``samples`` of a propagation from goal to goal, by blocks.

    Between the blocks, and between the steps of wide arithmetics, Python runs: then progress is
    reported and Ctrl-C works. The outcome is ``step_limit`` if a whole block covered less than eps
    of the horizon (mu = 1e300): the rest would take 1/eps more blocks. There are states, axes
    (time, entry), if the first block after the tiny block reaches the last sample: otherwise heyoka
    would begin another grid a rounding away from the end of the last step.
    """
    kinds, taken = outcomes(), None

    def report(adaptive: Adaptive) -> bool:
        if progress and goals[-1]:
            progress(min(1.0, float(adaptive.time) / float(goals[-1])))
        return True

    with_guard_bits = precision.with_guard_bits
    keywords: dict[str, Any] = {"max_steps": precision.kind.steps, **limits}
    if precision.in_software:
        keywords["callback"] = report
    steps, outcome = 0, kinds.time_limit
    for goal in goals:
        if outcome != kinds.time_limit:
            break
        outcome = kinds.step_limit
        advance, crawl = with_guard_bits(goal), precision.eps * with_guard_bits(goal)
        while outcome == kinds.step_limit and advance >= crawl:
            before = integrator.adaptive.time
            if samples is not None and goal == goals[-1]:
                wanted, samples = samples.doubles.rounded[1:], None
                outcome, _, _, count, _, states = integrator.adaptive.propagate_grid(
                    [before, *wanted], **keywords
                )
                taken = states[1:] if len(states) > len(wanted) else None
            else:
                outcome, _, _, count, output, _ = integrator.adaptive.propagate_until(
                    goal, c_output=bool(readers), **keywords
                )
                for read in readers if output is not None else ():
                    read(output)
            steps += count
            advance = with_guard_bits(integrator.adaptive.time - before)
            report(integrator.adaptive)
    return outcome, steps, taken


def _propagation_of(integrator: Integrator, status: str, steps: int) -> Propagation:
    time, time_low = integrator.adaptive.dtime
    return Propagation(
        status=status,
        time=time,
        time_low=time_low,
        state=_values(integrator.adaptive),
        steps=steps,
        order=integrator.adaptive.order,
    )


def _time_before_failure(
    setup: Setup, start: InitialState, integrator: Integrator, horizon: Scalar
) -> Scalar:
    integrator.begin(setup, start)
    last = integrator.adaptive.time

    def watch(adaptive: Adaptive) -> bool:
        nonlocal last
        good = all(value - value == 0 for value in _values(adaptive))
        # a failure just after the horizon of a shortened run shortens it further
        last = adaptive.time if good and adaptive.time < horizon else last
        return good

    integrator.adaptive.propagate_until(horizon, callback=watch)
    return last


def _values(adaptive: Adaptive) -> tuple[Scalar, ...]:
    # one at a time: arrays of heyoka's reals leak memory
    return tuple(adaptive.state[i] for i in range(len(adaptive.state)))


@cache
def outcomes() -> Any:
    """heyoka's outcomes of a propagation."""
    return import_heyoka().taylor_outcome


def status_of(outcome: Any, terminal: tuple[str, ...]) -> str:
    """The status of a propagation that heyoka ended with ``outcome``."""
    if outcome == outcomes().time_limit:
        return "complete"
    if outcome == outcomes().err_nf_state:
        return "failed"
    index = -1 - int(outcome)
    return terminal[index] if 0 <= index < len(terminal) else "failed"


@dataclass
class Integrator:
    """A ``heyoka.taylor_adaptive``, and the events that end or switch a motion.

    ``losses`` holds the latest time at which g_n fell through 0 in a run that went on there.
    """

    adaptive: Adaptive
    terminal: tuple[str, ...]
    losses: list[Scalar] = field(default_factory=list)

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
        self.losses.clear()


def build(setup: Setup) -> Integrator:
    """Compile the integrator for ``setup``."""
    heyoka = import_heyoka()

    # a trajectory's status and suspect_events have what heyoka would log
    heyoka.set_logger_level_critical()
    form, fp_type = setup.formulation, setup.precision.fp_type
    equations = Equations.of(form, setup.record)
    eps, parameters = float(setup.precision.eps), len(form.parameters)
    terminal = setup.phase.ends(equations, heyoka.par[parameters], setup.precision)
    losses: list[Scalar] = []
    noted = []
    if setup.contact == "bilateral":
        noted = [_loss(heyoka, terminal.pop("contact_lost"), fp_type, losses)]
    goes_on = setup.phase.condition
    conditions = {
        name: {"callback": goes_on(form, name, eps, setup.tolerance)} if goes_on else {}
        for name in terminal
    }
    number, falling = setup.precision.number, heyoka.event_direction.negative
    zero = setup.precision.context.mpf(0)
    integrator = heyoka.taylor_adaptive(
        equations.system,
        [number(zero) for _ in equations.variables],
        pars=[number(zero + 1) for _ in range(parameters + setup.phase.has_clock)],
        fp_type=fp_type,
        t_events=[
            heyoka.t_event(ex, fp_type=fp_type, direction=falling, **conditions[name])
            for name, ex in terminal.items()
        ],
        nt_events=noted,
        **numeric_options(setup),
    )
    return Integrator(integrator, tuple(terminal), losses)


def numeric_options(setup: Setup) -> dict[str, Any]:
    """Keyword arguments of ``heyoka.taylor_adaptive`` that fix tolerance and compilation."""
    number = setup.precision.number
    # compact_mode compiles wide types in half a second instead of 26 s, and runs as fast; double
    # then takes twice as long, which does not matter for brief segments
    compact = setup.phase.brief or not setup.precision.is_float
    options: dict[str, Any] = {"compact_mode": compact}
    kind = "wide" if not setup.precision.is_float else "compact" if compact else "loop"
    options["opt_level"] = OPTIMISATION[kind]
    tolerance = setup.precision.context.mpf(setup.tolerance) or full_tolerance(setup.precision)
    options["tol"] = number(tolerance)
    return options | dict(setup.options)


def _loss(heyoka: ModuleType, numerator: Scalar, fp_type: type, losses: list[Scalar]) -> Any:
    def callback(adaptive: Adaptive, time: Scalar, sign: int) -> None:
        losses[:] = [time]

    falling = heyoka.event_direction.negative
    return heyoka.nt_event(numerator, callback, direction=falling, fp_type=fp_type)


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


def pooled_integrator(setup: Setup) -> AbstractContextManager[Integrator]:
    """An integrator for ``setup``, pooled from an earlier run or newly compiled."""
    return pooled(build, setup)
