"""Tops whose friction is dry: Coulomb's law, exact or regularised, with a dimensionless mu.

The viscous law of the paper, F_f = -mu g_n v_A, is what ``body`` describes. A dry law is another
class of body, so that whoever is handed a body knows its law; the formulas are in
``mechanics.friction``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import ClassVar

from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json
from tt_precise.scene.body import Parameters, TippeTop
from tt_precise.scene.numerals import exact


@dataclass(frozen=True)
class CoulombParameters(Parameters):
    """Parameters of a top with Coulomb's friction, |F_f| = mu g_n; mu is dimensionless."""

    law: ClassVar[str] = "coulomb"

    def map(self, convert: Callable[[Scalar], Scalar]) -> Parameters:
        """These parameters with every one of them converted."""
        return type(self)(**{f.name: convert(getattr(self, f.name)) for f in fields(self)})


@dataclass(frozen=True)
class RegularisedParameters(CoulombParameters):
    """Parameters of a top with regularised friction; ``epsilon`` is a speed, mu dimensionless."""

    epsilon: Scalar
    law: ClassVar[str] = "regularised"


@dataclass(frozen=True)
class CoulombTop(TippeTop):
    """A Tippe Top with exact parameters and Coulomb's friction; units as in ``TippeTop``."""

    law: ClassVar[str] = "coulomb"
    numbers_as: ClassVar[type[Parameters]] = CoulombParameters

    def map(self, convert: Callable[[Scalar], Scalar]) -> Parameters:
        """These parameters (SI) in another arithmetic; ``convert`` rounds one exact number."""
        return self.numbers_as(**{f.name: convert(getattr(self, f.name)) for f in fields(self)})

    def dimensionless(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Parameters:
        """The same top with m = R = g = 1."""
        scale = self.m * self.R**2
        ratios = {
            "m": 1, "R": 1, "g": 1, "alpha": convert(self.alpha),
            "I1": convert(self.I1 / scale), "I3": convert(self.I3 / scale), "mu": convert(self.mu),
        }  # fmt: skip
        return self.numbers_as(**ratios, **self._speeds(fn, convert))

    def _speeds(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> dict[str, Scalar]:
        """Parameters that are speeds, in units of sqrt(g R)."""
        return {}


@dataclass(frozen=True)
class RegularisedTop(CoulombTop):
    """A Tippe Top whose Coulomb friction is regularised below the speed ``epsilon`` (m/s).

    Raises
    ------
    InputError
        Also where ``epsilon`` is not above 0.
    """

    epsilon: Fraction
    law: ClassVar[str] = "regularised"
    numbers_as: ClassVar[type[Parameters]] = RegularisedParameters

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.epsilon <= 0:
            raise InputError(f"epsilon: got {self.epsilon}, expected a speed above 0 in m/s")

    def _speeds(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> dict[str, Scalar]:
        return {"epsilon": fn.sqrt(convert(self.epsilon**2 / (self.g * self.R)))}


LAWS: dict[str, type[TippeTop]] = {
    "viscous": TippeTop, "regularised": RegularisedTop, "coulomb": CoulombTop,
}  # fmt: skip


def top_with_friction(body: dict[str, Json], friction: dict[str, Json]) -> TippeTop:
    """The top of a scene file's tables ``[body]`` and ``[friction]``.

    Raises
    ------
    InputError
        No such law, a key that the law does not have, or a missing one.
    """
    law = friction.get("law")
    if not isinstance(law, str) or law not in LAWS:
        raise InputError(f"friction.law: got {law!r}, expected one of: {', '.join(LAWS)}")
    if "mu" in body:
        raise InputError(
            "body.mu: got it beside a table [friction], expected mu there and not in [body]"
        )
    wanted = {"law", "mu", "epsilon"} if law == "regularised" else {"law", "mu"}
    for key in sorted(friction.keys() - wanted):
        raise InputError(
            f"unknown key friction.{key[:60]!r}, expected only: {', '.join(sorted(wanted))}"
        )
    for key in sorted(wanted - friction.keys()):
        raise InputError(f"missing key friction.{key}, expected it to be given")
    given = {name: friction[name] for name in wanted - {"law"}}
    for name, value in given.items():
        exact(value, f"friction.{name}")
    return LAWS[law].from_ratios(**body, **given)
