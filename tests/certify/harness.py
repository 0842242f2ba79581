"""A problem of one's choice in front of the program that decides, which may have been changed.

``program()`` loads the modules that are trusted; with a ``Mutant`` one line of them is another.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

from flint import arb, arb_mat

import tt_precise.certify
from tt_precise.certify.certificate import Refused

PACKAGE = "tt_precise.certify"
TRUSTED = ("checker_arithmetic", "checker")  # in the order in which they import each other
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


Rates = Callable[[Sequence[Any]], Sequence[Any]]


def enclosing(trusted: Any, rates: Rates, start: Sequence[arb], order: int) -> Any:
    """The enclosure of y' = ``rates``(y) from a ``start`` of balls."""

    class Enclosing(trusted.checker.Checker):
        vanishing = 0  # order to which functions vanish at t = 0

        def __init__(self) -> None:
            self.bits, self.order = BITS, order
            self.finish = self.entered = arb(0)
            self.end = [arb(x) for x in start]
            self.rates = trusted.checker.Rates(rates, len(self.end))
            self.free = self._moving(self.end)
            n = len(self.free)
            self.basis = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
            self.box = arb_mat(n, 1, [arb(0)] * n)

        def on(self, length: Any, power: int = 0, shift: Any = 0) -> None:
            """One more piece, from the middle of what is enclosed, or ``shift`` from it."""
            begin = [x.mid() for x in self.last()]
            begin = [(x + shift).mid() if i in self.free else x for i, x in enumerate(begin)]
            self.advance(power, arb(length), begin)

        def last(self) -> list[arb]:
            """The states with which the last piece ends."""
            errors = dict(zip(self.free, (self.basis * self.box).entries(), strict=True))
            return [x + errors.get(i, 0) for i, x in enumerate(self.end)]

        def motion(self, state: Sequence[Any]) -> Any:
            return state

        def order_at_entry(self, function: Any) -> int:
            return self.vanishing

        def zeros(self, function: Any, until: Any = None, touches: Any = ()) -> Any:
            """Direction and time of the zeros in the last piece."""
            until = self.finish if until is None else arb(until)
            return trusted.checker.Zeros(self).of(function, until, touches)

    return Enclosing()


__all__ = ["BITS", "Mutant", "Refused", "enclosing", "program"]
