from .balls import NotProved as NotProved
from .motion import Enclosure as Enclosure
from .motion import enclose as enclose
from .problem import Problem as Problem
from .problem import problem_of as problem_of
from .statements import Proof as Proof
from .statements import prove as prove
