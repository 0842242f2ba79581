"""What a claim is, and the registry that a decorator fills: a new claim is one new entry.

    @claim("NUM-20", quote="0.005106", where="Sec. 2.3", control={"printed": "0.005107"})
    def potential_energy_at_8_s(printed="0.005106"):
        '''E_pot at 8 s.'''
        return judged(rounds_to(printed, evidence.at("E_pot", "8"), "J"), note=...)

The docstring states the claim in our own words. The keyword arguments are what it is about (the
printed value or formula, the scene), and default to what the paper says. ``control`` replaces
some of them by something false: the tests see the verdict change.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import TypeVar

from tt_precise.claims.verdicts import Finding
from tt_precise.runtime.docstrings import docstring
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.registry import Registry

KINDS = {
    "EQ": "equation",
    "TH": "theorem",
    "NUM": "number",
    "QUAL": "quality",
    "FIG": "figure",
    "SWP": "sweep",
    "SUM": "summary",
    "NT": "setting",
}

_ID = re.compile(rf"({'|'.join(KINDS)})-(\d\d)", re.ASCII)


@dataclass(frozen=True)
class Claim:
    """One checkable statement of the paper.

    Attributes
    ----------
    id
        Such as "NUM-20"; its prefix is its ``kind``.
    statement
        What is claimed, in our own words: the function's docstring.
    quote, where
        A short quote, and its place in the paper.
    definition
        The definitions used where the paper leaves them open.
    function
        Judges it: keyword arguments (defaults: what the paper says) to a ``Finding``.
    control
        Keyword arguments that make the claim false; None for wording that nothing can test.
    slow
        Whether judging it, and its control after it, takes a second of a core or more where
        the evidence that others share is there; the tests leave such controls to ``make slow``.
    """

    id: str
    statement: str
    quote: str
    where: str
    definition: str
    function: Callable[..., Finding] = field(repr=False)
    control: Mapping[str, object] | None = field(repr=False)
    slow: bool = False

    def __post_init__(self) -> None:
        if not _ID.fullmatch(self.id):
            raise ValueError(f"claim id: got {self.id!r}, expected such as 'NUM-20'")
        for name in ("statement", "quote", "where"):
            if not getattr(self, name):
                raise ValueError(f"claim {self.id}: got no {name}, expected one")
        if self.control is not None:
            object.__setattr__(self, "control", MappingProxyType(dict(self.control)))

    @property
    def kind(self) -> str:
        """Equation, theorem, number, quality, figure, sweep, summary or setting."""
        return KINDS[self.id.split("-")[0]]

    @property
    def group(self) -> str:
        """The module it stands in; claims of one group share their evidence."""
        return self.function.__module__

    @property
    def order(self) -> tuple[int, int]:
        """Key that sorts claims: by kind, then by number."""
        prefix, number = self.id.split("-")
        return list(KINDS).index(prefix), int(number)


T = TypeVar("T")

_registered: Registry[Claim] = Registry("claim")


def claim(
    id: str,
    *,
    quote: str,
    where: str,
    control: Mapping[str, object] | None,
    definition: str = "",
    slow: bool = False,
) -> Callable[[Callable[..., Finding]], Callable[..., Finding]]:
    """Register the decorated function, which judges a claim; see ``Claim``."""

    def register(function: Callable[..., Finding]) -> Callable[..., Finding]:
        statement = " ".join(docstring(function).split())
        made = Claim(id, statement, quote, where, definition, function, control, slow)
        _registered.enter(id, made, function.__module__)
        return function

    return register


@cache
def claims() -> Mapping[str, Claim]:
    """All claims by id, sorted; found in the modules of ``claims.statements``."""
    from tt_precise.claims import statements

    for module in pkgutil.iter_modules(statements.__path__, f"{statements.__name__}."):
        importlib.import_module(module.name)
    ordered = sorted(_registered, key=lambda one: one.order)
    return MappingProxyType({one.id: one for one in ordered})


def claim_named(id: str) -> Claim:
    """The claim with this id (in any case).

    Raises
    ------
    InputError
        There is no such claim.
    """
    return named(id, claims())


def named(id: str, known: Mapping[str, T]) -> T:
    """What ``known`` has under a claim's id (in any case).

    Raises
    ------
    InputError
        There is no such claim.
    """
    if id.upper() not in known:
        prefix = id.upper().split("-")[0]
        near = [one for one in known if one.startswith(f"{prefix}-")]
        some = f"{near[0]} to {near[-1]}" if near else "such as NUM-22"
        raise InputError(f"claim: got {id[:60]!r}, expected an id {some}; see `tt-precise claims`")
    return known[id.upper()]
