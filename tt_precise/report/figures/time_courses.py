"""What the figures over time share: courses with all extrema in them, and the marked moments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims.evidence import Run, SceneLike
from tt_precise.runtime.arithmetic import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EVERY = 0.004  # s, between the extrema; a nutation lasts 0.037 s
TIME = "$t$ (s)"


def course(*names: str, scene: SceneLike = "reference") -> dict[str, Array]:
    """Float columns by name, and "t": samples united with every extremum of each of them."""
    frame = Run(scene).course(names, EVERY)
    return {str(name): frame[name].to_numpy(dtype=float) for name in frame}


def climb_marks(scene: SceneLike = "reference") -> dict[str, float]:
    """Initiation and ending time in definition A, by the label drawn."""
    begin, end = Run(scene).climb
    return {r"$t_{\theta\approx0}$": begin, r"$t_{\theta\approx\pi}$": end}


def over_time(axes: list[Axes], end: float = 8.0) -> None:
    """Limits and label of the common axis of time."""
    axes[-1].set_xlim(0, end)
    axes[-1].set_xlabel(TIME)
