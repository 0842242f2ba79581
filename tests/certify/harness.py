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
# Modules in the order of their imports; ``propose`` is not trusted.
MODULES = ("models", "propose", "kernel", "problem", "motion")
BITS = 200


class Mutant(NamedTuple):
    """A change of one place of a module, and the control that notices it."""

    module: str
    old: str
    new: str
    control: str

    @property
    def name(self) -> str:
        return f"{self.old} -> {self.new}"


def program(mutant: Mutant | None = None) -> Any:
    """The trusted modules, loaded anew, with the change of a mutant."""
    with _set_aside():
        return SimpleNamespace(**{name: _loaded(name, mutant) for name in MODULES})


@contextmanager
def _set_aside() -> Iterator[None]:
    """Let the trusted modules be loaded anew inside the block."""
    names = [f"{PACKAGE}.{name}" for name in MODULES]
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
    setattr(tt_precise.certify, name, module)
    exec(compile(source, str(path), "exec"), module.__dict__)
    return module


@cache
def unchanged() -> Any:
    """The trusted modules as they are."""
    return program()


class Enclosing:
    """The enclosure of y' = ``rates``(y) from a ``start`` of balls, step by step.

    ``guesses`` replace functions of ``propose``.
    """

    vanishing = 0  # order to which functions vanish at t = 0

    def __init__(
        self,
        trusted: Any,
        rates: Callable[[Sequence[Any]], Sequence[Any]],
        start: Sequence[arb],
        order: int,
        **guesses: Callable[..., Any],
    ):
        self.trusted, self.guesses = trusted, guesses
        models, kernel = trusted.models, trusted.kernel
        self.rates = models.Rates(rates, len(start), BITS, order)
        self.states = kernel.StateSet.of(self.rates, arb(0), [arb(x) for x in start])
        self.step: Any = None

    def on(self, length: Any, shift: Any = 0) -> None:
        """Take one more step, from the middle of the states, or ``shift`` from it.

        ``shift`` is that of each component, or of all that are not always zero.
        """
        shifts = shift if isinstance(shift, list) else [shift] * len(self.states.middle)
        pairs = enumerate(zip(self.states.state, shifts, strict=True))
        free = self.states.free
        begin = [(x.mid() + y).mid() if i in free else x.mid() for i, (x, y) in pairs]
        propose = self.trusted.propose
        before = {name: getattr(propose, name) for name in self.guesses}
        vars(propose).update(self.guesses)
        try:
            self.step = self.trusted.kernel.advance(self.rates, self.states, arb(length), begin)
        finally:
            vars(propose).update(before)
        self.states = self.step.after

    def zeros(self, function: Any, until: Any = None, double: Any = ()) -> Any:
        """Return direction and time of the zeros in the last step."""
        until = self.states.time if until is None else arb(until)
        first = self.step.time == 0
        order = (lambda _: self.vanishing) if first else None
        zeros = self.trusted.motion.StepZeros(self.step, lambda state: state, order)
        return zeros.of(function, until, double)
