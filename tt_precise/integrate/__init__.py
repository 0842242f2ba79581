"""Integration with heyoka: precisions, events, trajectories."""

import sys
from types import ModuleType

from tt_precise.integrate.columns import State
from tt_precise.integrate.events import EVENTS, TERMINAL, catalogue
from tt_precise.integrate.integration import integrate
from tt_precise.integrate.trajectory import Trajectory

__all__ = ["EVENTS", "TERMINAL", "State", "Trajectory", "catalogue", "integrate"]


class _CallableModule(ModuleType):
    # the package has a folder and a function of one name; importing the folder would hide the
    # function tt_precise.integrate(...), so the folder can be called in its place
    __call__ = staticmethod(integrate)


sys.modules[__name__].__class__ = _CallableModule
