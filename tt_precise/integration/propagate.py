"""``propagate``: one integration, from an initial state to the end of its horizon or of the model.

It knows a ``Setup`` and an ``InitialState`` and nothing else, and says how it went in heyoka's own
numbers. ``in_doubles`` is its like for double-double and triple-double.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from tt_precise.integration.events import EVENTS
from tt_precise.integration.precision import Precision
from tt_precise.integration.setup import Setup
from tt_precise.integration.step_limit import longest_step
from tt_precise.integration.system import Hit, Integrator, integrator
from tt_precise.integration.vanishing import FIRST_STEP, settled
from tt_precise.mechanics.formulations import contact_terms
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.runtime.untyped import Adaptive, ContinuousOutput

Status = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed",
    # ends of pieces, at which another one begins
    "slow", "fast", "stick", "slip", "landing", "sinking", "separation", "release",
]  # fmt: skip
ARRIVED: tuple[Status, ...] = ("complete", "contact_ignored")  # at the scene's horizon

STEPS_IN_A_PIECE = {"double": 20_000, "extended": 2_000, "quad": 200, "mp": 200}  # 0.2 s or more

MOST_CUTS = 4  # of a failed propagation, back to its last good step
LONGEST_OWN_TIME = 2.0**40  # where the state ends the propagation


class Pieces(Protocol):
    """What takes the dense outputs of a propagation."""

    def append(self, output: ContinuousOutput, /) -> None:
        """Take the next piece."""

    def clear(self) -> None:
        """Forget all pieces: the propagation begins anew."""


@dataclass(frozen=True)
class Propagation:
    """How one propagation went, in heyoka's own numbers, dimensionless.

    The end is at ``time`` + ``time_low``: a step to an event ends between two numbers. ``samples``
    are the states at the times that were asked for, where all were reached.
    """

    status: Status
    time: Scalar
    time_low: Scalar
    state: tuple[Scalar, ...]
    steps: int
    order: int
    hits: tuple[Hit, ...]
    samples: Array | None = field(default=None, compare=False, repr=False)


class _Sampling:
    """The states of a run in double at rising ``times``, read from its steps as they are taken.

    Where the first bounded piece of the way does not reach the last of them there are none:
    heyoka would begin the next piece's grid a rounding beside where the last step ended.
    """

    def __init__(self, times: Array):
        self._times = times
        self.begun = False
        self.states: Array | None = None  # shape (times, entries)

    def advance(self, adaptive: Adaptive, **keywords: Any) -> tuple[Any, int]:
        """Propagate to the last of the times, or as far as it goes; outcome and steps."""
        import numpy

        self.begun = True
        outcome, _, _, steps, _, states = adaptive.propagate_grid(
            numpy.append(adaptive.time, self._times), **keywords
        )
        if len(states) > len(self._times):
            self.states = states[1:]
        return outcome, steps


def propagate(
    setup: Setup,
    start: InitialState,
    *,
    until: Scalar = None,
    dense: Pieces | None = None,
    samples: Array | None = None,
    progress: Progress | None = None,
    cuts: int = MOST_CUTS,
) -> Propagation:
    """Propagate once from ``start``; how it went, in heyoka's own numbers.

    ``until`` (a number of heyoka's type) replaces the start's own horizon. ``dense`` is given
    heyoka's dense output of each bounded piece of the way, in order. ``samples`` are rising times
    up to the horizon, at which states are wanted of a run in double. A propagation that
    produces NaN is cut back to its last good step, at most ``cuts`` times, and has the status
    "failed", and so has one that is given up because its steps are too short ever to arrive.

    Raises
    ------
    InputError
        More than ``MOST_EVENTS`` events happened, or the function of one became undefined.
    """
    import heyoka

    number, zero = setup.precision.number, setup.precision.context.mpf(0)
    horizon = number(start.until) if until is None else until
    with integrator(setup) as made:
        made.begin(setup, start)
        if setup.formulation.own_time and until is None:
            horizon = number(setup.precision.context.mpf(LONGEST_OWN_TIME))
        rooted = setup.events or setup.formulation.model == "flight"
        first = number(setup.precision.context.mpf(FIRST_STEP)) if rooted else horizon
        goals = [first, horizon] if first < horizon else [horizon]
        longest = longest_step(
            start.body, start.vectors, made.adaptive.order, setup.precision, setup.formulation
        )
        limits = {} if longest is None else {"max_delta_t": number(longest)}
        sampling = None if samples is None else _Sampling(samples)
        outcome, steps = _advance(made, goals, dense, sampling, progress, setup.precision, limits)
        status = status_of(outcome, made.terminal)
        if (
            status == "complete"
            and setup.contact == "bilateral"
            and left_the_table(setup, start, bool(made.losses))
        ):
            status = "contact_ignored"
        if status != "failed":
            found = _propagation_of(setup, start, made, status, steps)
            return found if sampling is None else replace(found, samples=sampling.states)
        last_good = made.adaptive.time
        if outcome == heyoka.taylor_outcome.err_nf_state:
            last_good = _time_before_failure(setup, start, made, horizon)
        if last_good == number(zero):
            made.begin(setup, start)
            return _propagation_of(setup, start, made, status, 0)
    partial = [name for name in setup.events if name not in EVENTS]
    if partial and propagate(setup.but(events=()), start, until=until).status != "failed":
        t = float(setup.precision.guarded(last_good) * start.units.time)
        raise InputError(
            f"events: got {', '.join(partial)}, of which some are undefined at t = {t:.6g} s, "
            "expected functions that are defined all the way, such as theta_max or phi_dot_zero"
        )
    if dense is not None:
        dense.clear()
    if not cuts:  # no time is good
        last_good = number(zero)
    propagation = propagate(setup, start, until=last_good, dense=dense, cuts=cuts - 1)
    return replace(propagation, status="failed")


def _advance(
    made: Integrator,
    goals: list[Scalar],
    dense: Pieces | None,
    sampling: _Sampling | None,
    progress: Progress | None,
    precision: Precision,
    limits: dict[str, Any],
) -> tuple[Any, int]:
    """Outcome and steps of a propagation from goal to goal, in bounded pieces.

    Between the pieces, and between the steps of wide arithmetics, Python runs: that is where
    progress is reported and Ctrl-C gets through. The outcome is ``step_limit`` where a whole piece
    covered less than eps of the horizon (mu = 1e300): the rest would take 1/eps more of them.
    """
    import heyoka

    def report(adaptive: Adaptive) -> bool:
        if progress and goals[-1]:
            progress(min(1.0, float(adaptive.time) / float(goals[-1])))
        return True

    guarded = precision.guarded
    keywords: dict[str, Any] = {"max_steps": STEPS_IN_A_PIECE[precision.name], **limits}
    if precision.name in ("quad", "mp"):
        keywords["callback"] = report
    steps, outcome = 0, heyoka.taylor_outcome.time_limit
    for goal in goals:
        if outcome != heyoka.taylor_outcome.time_limit:
            break
        outcome = heyoka.taylor_outcome.step_limit
        advance, crawl = guarded(goal), precision.eps * guarded(goal)
        while outcome == heyoka.taylor_outcome.step_limit and advance >= crawl:
            before = made.adaptive.time
            if sampling is not None and goal == goals[-1] and not sampling.begun:
                outcome, count = sampling.advance(made.adaptive, **keywords)
            else:
                outcome, _, _, count, output, _ = made.adaptive.propagate_until(
                    goal, c_output=dense is not None, **keywords
                )
                if dense is not None and output is not None:
                    dense.append(output)
            steps += count
            advance = guarded(made.adaptive.time - before)
            report(made.adaptive)
    return outcome, steps


def _propagation_of(
    setup: Setup,
    start: InitialState,
    made: Integrator,
    status: Status,
    steps: int,
) -> Propagation:
    time, time_low = made.adaptive.dtime
    return Propagation(
        status=status,
        time=time,
        time_low=time_low,
        state=_values(made.adaptive),
        steps=steps,
        order=made.adaptive.order,
        hits=settled(made.hits, setup, start, time),
    )


def _time_before_failure(
    setup: Setup, start: InitialState, made: Integrator, horizon: Scalar
) -> Scalar:
    made.begin(setup, start)
    last = made.adaptive.time

    def watch(adaptive: Adaptive) -> bool:
        nonlocal last
        good = all(value - value == 0 for value in _values(adaptive))
        # a failure just behind the horizon of a run that was cut back already takes it further back
        last = adaptive.time if good and adaptive.time < horizon else last
        return good

    made.adaptive.propagate_until(horizon, callback=watch)
    return last


def _values(adaptive: Adaptive) -> tuple[Scalar, ...]:
    # one at a time: arrays of heyoka's reals leak memory
    return tuple(adaptive.state[i] for i in range(len(adaptive.state)))


def status_of(outcome: Any, terminal: tuple[str, ...]) -> Status:
    """The status of a propagation that heyoka ended with ``outcome``."""
    import heyoka

    if outcome == heyoka.taylor_outcome.time_limit:
        return "complete"
    if outcome == heyoka.taylor_outcome.err_nf_state:
        return "failed"
    index = -1 - int(outcome)
    ended: Any = terminal[index] if 0 <= index < len(terminal) else "failed"
    return ended


def left_the_table(setup: Setup, start: InitialState, later: bool) -> bool:
    """Whether g_n was negative at the start, or fell through zero ``later``."""
    numerator, _ = contact_terms(
        setup.formulation.model, start.body, start.vectors, setup.precision.context
    )
    return later or bool(numerator <= 0)
