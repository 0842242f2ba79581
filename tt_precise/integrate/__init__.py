"""Integration with heyoka: precisions, events, trajectories."""

from tt_precise.integrate.columns import State
from tt_precise.integrate.events import EVENTS, TERMINAL, catalogue
from tt_precise.integrate.integration import integrate
from tt_precise.integrate.trajectory import Trajectory
from tt_precise.runtime.lazy import make_callable

__all__ = ["EVENTS", "TERMINAL", "State", "Trajectory", "catalogue", "integrate"]

make_callable(__name__, integrate)
