"""Times that can be compared: measured in turn, again and again, each beside a yardstick.

A machine that others use is now faster, now slower. Every measurement therefore stands beside one
of the yardstick, made just before it; the ratio is what is compared, also across machines.
"""

from __future__ import annotations

import gc
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median

from tt_precise.runtime.progress import Progress, silent

Action = Callable[[], object]
Clock = Callable[[], float]


def processor_time() -> float:
    """Seconds that processors have spent on this process, and on those that it has waited for."""
    every = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in every)


@dataclass(frozen=True)
class Turn:
    """What is timed beside which yardstick; ``prepare`` is called anew, untimed, before each.

    ``clock`` counts in s; processor time does not depend on what else the machine has to do, but
    is no time to wait where threads share the work.
    """

    prepare: Callable[[], Action]
    yardstick: Action
    clock: Clock = time.perf_counter


@dataclass
class Timings:
    """Seconds of one action, and of the yardstick just before each of them."""

    seconds: list[float] = field(default_factory=list)
    yardsticks: list[float] = field(default_factory=list)

    @property
    def least(self) -> float:
        """The fastest."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        """The median."""
        return median(self.seconds)

    @property
    def ratio(self) -> float:
        """The median of the ratios to the yardstick beside each: a slow minute slows both."""
        return median(
            one / beside for one, beside in zip(self.seconds, self.yardsticks, strict=True)
        )


def interleaved(
    turns: Sequence[Turn],
    *,
    rounds: int,
    budget_s: float,
    progress: Progress = silent,
) -> list[Timings]:
    """Time every action in turn, ``rounds`` times, and each just after its yardstick.

    An action has at least one turn, and no further one that would bring it above ``budget_s``.
    """
    times = [Timings() for _ in turns]
    for number in range(rounds):
        for place, (turn, mine) in enumerate(zip(turns, times, strict=True)):
            if number and (number + 1) * mine.median > budget_s:
                continue
            action = turn.prepare()
            mine.yardsticks.append(timed(turn.yardstick, turn.clock))
            mine.seconds.append(timed(action, turn.clock))
            progress((number + (place + 1) / len(turns)) / rounds)
    return times


def timed(action: Action, clock: Clock = time.perf_counter) -> float:
    """Seconds that an action takes, without the collection of garbage."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        begin = clock()
        action()
        return clock() - begin
    finally:
        if enabled:
            gc.enable()
