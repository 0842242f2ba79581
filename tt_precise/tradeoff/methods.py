"""What a method of the trade-off is, and the register of all of them.

A method is one ``@registered(...)`` function that prepares a solver: given a problem and a
tolerance it imports, compiles and returns a function that only integrates.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from tt_precise.integration.precision import Precision
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.registry import Registry
from tt_precise.tradeoff.problem import GoldenProblem

MODULES = (
    "compiled_methods", "jax_methods", "mpmath_methods", "scipy_methods", "taylor_methods",
)  # fmt: skip


class SolverResult(NamedTuple):
    """What a solver returns: a state for each time asked for, and what it took.

    ``work`` counts evaluations of the right-hand side, of a Taylor method the coefficients of
    each state entry (steps times order). ``lanes`` trajectories were made at once.
    ``published`` says that the states are those that users get: of the published formulation, at
    the exact times and not at the rounded ones that were handed over.
    """

    states: Sequence[Sequence[Scalar]]
    steps: int
    work: int
    order: int | None = None
    lanes: int = 1
    published: bool = False


Solve = Callable[
    [Sequence[Scalar]], SolverResult
]  # from dimensionless times, in the method's numbers


class Settings(NamedTuple):
    """What a method is asked for: its tolerance (0: the best it has), and its arithmetic."""

    tolerance: float
    precision: Precision


Prepare = Callable[[GoldenProblem, Settings], Solve]


@dataclass(frozen=True)
class Method:
    """A registered method: its name, who made it, what has to be installed for it."""

    name: str
    packages: tuple[str, ...]
    prepare: Prepare
    peer: bool

    @property
    def missing(self) -> tuple[str, ...]:
        """Packages that it needs and that are not installed."""
        return tuple(name for name in self.packages if importlib.util.find_spec(name) is None)


_registered: Registry[Method] = Registry("method")


def registered(name: str, *packages: str, peer: bool = True) -> Callable[[Prepare], Prepare]:
    """Make a preparing function the method ``name``, which needs ``packages``."""

    def enter(prepare: Prepare) -> Prepare:
        # a method of its own may be another one's function with some arguments
        module = getattr(prepare, "func", prepare).__module__
        _registered.enter(name, Method(name, packages, prepare, peer), module)
        return prepare

    return enter


def methods() -> dict[str, Method]:
    """All methods by name, installed or not."""
    for module in MODULES:
        importlib.import_module(f"tt_precise.tradeoff.{module}")
    return _registered.named()


def method_named(name: str) -> Method:
    """The method called ``name``.

    Raises
    ------
    InputError
        There is no such method.
    """
    known = methods()
    if name not in known:
        raise InputError(f"method: got {name!r}, expected one of: {', '.join(known)}")
    return known[name]
