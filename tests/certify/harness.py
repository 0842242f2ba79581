"""A problem of one's choice in front of the program that decides, which may have been changed.

``program()`` loads the modules that are trusted; with a ``Mutant`` one line of them is another.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

from flint import arb

import tt_precise.certify

PACKAGE = "tt_precise.certify"
# Modules in the order of their imports.
TRUSTED = ("models", "kernel", "start", "zeros", "problem", "motion")
BITS = 200


class Mutant(NamedTuple):
    """A change of one place of a module, and the control that notices it."""

    name: str
    module: str
    old: str
    new: str
    control: str


def program(mutant: Mutant | None = None) -> Any:
    """The trusted modules, loaded anew, with the change of a mutant."""
    with _set_aside():
        return SimpleNamespace(**{name: _loaded(name, mutant) for name in TRUSTED})


@contextmanager
def _set_aside() -> Iterator[None]:
    """Let the trusted modules be loaded anew inside the block."""
    names = [f"{PACKAGE}.{name}" for name in TRUSTED]
    before = {name: importlib.import_module(name) for name in names}
    try:
        for name in names:
            del sys.modules[name]
        yield
    finally:
        for name, module in before.items():
            sys.modules[name] = module
            setattr(tt_precise.certify, name.rpartition(".")[2], module)


def _loaded(name: str, mutant: Mutant | None) -> ModuleType:
    path = Path(str(tt_precise.certify.__file__)).with_name(f"{name}.py")
    source = path.read_text("utf-8")
    if mutant is not None and mutant.module == name:
        assert source.count(mutant.old) == 1, (mutant.name, source.count(mutant.old))
        source = source.replace(mutant.old, mutant.new)
    spec = importlib.util.spec_from_file_location(f"{PACKAGE}.{name}", path)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    exec(compile(source, str(path), "exec"), module.__dict__)
    return module


@cache
def unchanged() -> Any:
    """The trusted modules as they are."""
    return program()


class Enclosing:
    """The enclosure of y' = ``rates``(y) from a ``start`` of balls, step by step.

    ``weights``, if there are any, are those of the norm.
    """

    vanishing = 0  # order to which functions vanish at t = 0

    def __init__(
        self,
        trusted: Any,
        rates: Callable[[Sequence[Any]], Sequence[Any]],
        start: Sequence[arb],
        order: int,
        weights: Sequence[Any] = (),
    ):
        self.trusted, kernel = trusted, trusted.kernel
        self.weights = [arb(weight) for weight in weights]
        self.equations = kernel.KernelEquations(
            trusted.models.Rates(rates, len(start)), BITS, order
        )
        self.states = kernel.StateSet.of(self.equations, arb(0), [arb(x) for x in start])
        self.step: Any = None

    def on(self, length: Any, power: int = 0, shift: Any = 0) -> None:
        """Take one more step, from the middle of the states, or ``shift`` from it.

        ``shift`` is that of each component, or of all that are not always zero.
        """
        shifts = shift if isinstance(shift, list) else [shift] * len(self.states.middle)
        pairs = enumerate(zip(self.states.state, shifts, strict=True))
        free = self.states.free
        begin = [(x.mid() + y).mid() if i in free else x.mid() for i, (x, y) in pairs]
        kernel = self.trusted.kernel
        choice = kernel._weights
        if self.weights:
            kernel._weights = lambda band: self.weights
        try:
            self.step = kernel.advance(self.equations, self.states, power, arb(length), begin)
        finally:
            kernel._weights = choice
        self.states = self.step.after

    @property
    def length(self) -> arb:
        return self.step.length

    @property
    def finish(self) -> arb:
        return self.states.time

    def at(self, s: Any) -> Any:
        """Return the states at a local time of the last step."""
        return self.step.at(arb(s))

    def last(self) -> Any:
        """Return the states at the end of the last step."""
        return self.states.state

    def zeros(self, function: Any, until: Any = None, double: Any = ()) -> Any:
        """Return direction and time of the zeros in the last step."""
        until = self.finish if until is None else arb(until)
        first = self.step.time == 0
        order = (lambda _: self.vanishing) if first else None
        zeros = self.trusted.zeros.StepZeros(self.step, lambda state: state, order)
        return zeros.of(function, until, double)
