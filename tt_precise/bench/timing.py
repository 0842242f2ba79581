"""Times that can be compared: measured in turn, again and again, each beside a yardstick.

A machine that others use is now faster, now slower. Every measurement therefore stands beside one
of the yardstick, made just before it; the ratio is what is compared, also across machines.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median

from tt_precise.progress import Progress, silent

Action = Callable[[], object]


@dataclass
class Times:
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
    actions: Sequence[Action],
    yardstick: Action,
    *,
    rounds: int,
    budget_s: float,
    progress: Progress = silent,
) -> list[Times]:
    """Time every action in turn, ``rounds`` times, and each beside the yardstick.

    An action has at least one turn, and no further one that would bring it above ``budget_s``.
    """
    times = [Times() for _ in actions]
    for turn in range(rounds):
        for place, (action, mine) in enumerate(zip(actions, times, strict=True)):
            if turn and (turn + 1) * mine.median > budget_s:
                continue
            mine.yardsticks.append(timed(yardstick))
            mine.seconds.append(timed(action))
            progress((turn + (place + 1) / len(actions)) / rounds)
    return times


def timed(action: Action) -> float:
    """Seconds that an action takes, the collection of garbage kept out."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        begin = time.perf_counter()
        action()
        return time.perf_counter() - begin
    finally:
        if enabled:
            gc.enable()
