"""Integration with heyoka: precisions, events, trajectories."""

from tt_precise.integration.api import integrate
from tt_precise.integration.columns import State
from tt_precise.integration.events import EVENTS, TERMINAL, catalogue
from tt_precise.integration.trajectory import Trajectory

__all__ = ["EVENTS", "TERMINAL", "State", "Trajectory", "catalogue", "integrate"]
