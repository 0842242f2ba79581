from .columns import State as State
from .events import EVENTS as EVENTS
from .events import TERMINAL as TERMINAL
from .events import catalogue as catalogue
from .trajectory import Trajectory as Trajectory
from .trajectory import integrate as integrate
