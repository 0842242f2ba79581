"""Integration with heyoka: precisions, events, trajectories."""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader

if TYPE_CHECKING:
    from tt_precise.integration.columns import State
    from tt_precise.integration.events import EVENTS, TERMINAL, catalogue
    from tt_precise.integration.trajectory import Trajectory, integrate

__all__ = ["EVENTS", "TERMINAL", "State", "Trajectory", "catalogue", "integrate"]

__getattr__, __dir__, _ = lazy_loader.attach(
    __name__,
    [],
    {
        "columns": ["State"],
        "events": ["EVENTS", "TERMINAL", "catalogue"],
        "trajectory": ["Trajectory", "integrate"],
    },
)
