"""Tops on an elastic table, and what a scene says about contact: the table ``[contact]``.

The normal force follows from the depth by which the lowest point of the sphere is in the table:
linear, F_n = stiffness depth + damping depth_dot (N/m, N s/m), or Hunt and Crossley's,
F_n = stiffness depth^(3/2) (1 + damping depth_dot) (N/m^(3/2), s/m). Friction is viscous or
regularised; the formulas are in ``mechanics.compliant``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from fractions import Fraction
from typing import Any, ClassVar

from tt_precise.runtime.errors import InputError
from tt_precise.scene.body import SPRINGS as SPRINGS
from tt_precise.scene.body import Parameters, TippeTop
from tt_precise.scene.numerals import exact

WORDS = ("law", "spring")  # entries that are no numbers


@dataclass(frozen=True)
class CompliantParameters(Parameters):
    """Parameters of a top on an elastic table; ``epsilon`` is 0 for viscous friction."""

    epsilon: Any
    stiffness: Any
    damping: Any
    law: str = field(kw_only=True)  # type: ignore[misc]
    spring: str = field(kw_only=True)  # type: ignore[misc]

    def map(self, convert: Callable[[Any], Any]) -> Parameters:
        """These parameters with every number of them converted."""
        return CompliantParameters(**_converted(self, convert))


@dataclass(frozen=True)
class CompliantTop(TippeTop):
    """A Tippe Top with exact parameters on an elastic table; SI as in ``compliance``.

    Raises
    ------
    InputError
        As of ``TippeTop``; stiffness not above 0, damping below 0, or no such law or spring.
    """

    epsilon: Fraction
    stiffness: Fraction
    damping: Fraction
    law: str = field(kw_only=True)  # type: ignore[misc]
    spring: str = field(kw_only=True)  # type: ignore[misc]
    words: ClassVar[tuple[str, ...]] = WORDS

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.stiffness <= 0:
            raise InputError(
                f"contact.stiffness: got {self.stiffness}, expected a number above 0 in N/m "
                "(N/m^1.5 for hunt-crossley)"
            )
        if self.damping < 0:
            raise InputError(
                f"contact.damping: got {self.damping}, expected at least 0 in N s/m "
                "(s/m for hunt-crossley)"
            )

    def map(self, convert: Callable[[Any], Any]) -> Parameters:
        """These parameters (SI) in another arithmetic; ``convert`` rounds one exact number."""
        return CompliantParameters(**_converted(self, convert))

    def dimensionless(self, fn: Any, convert: Callable[[Fraction], Any]) -> Parameters:
        """The same top with m = R = g = 1."""
        unit, weight = self.m * self.R**2, self.m * self.g
        speed = fn.sqrt(convert(self.g * self.R))
        length = convert(self.R)
        viscous, linear = self.law == "viscous", self.spring == "linear"
        depth = length if linear else length * fn.sqrt(length)
        return CompliantParameters(
            m=1, R=1, g=1, alpha=convert(self.alpha), I1=convert(self.I1 / unit),
            I3=convert(self.I3 / unit),
            mu=convert(self.mu) * speed if viscous else convert(self.mu),
            epsilon=convert(self.epsilon) / speed,
            stiffness=convert(self.stiffness / weight) * depth,
            damping=convert(self.damping / weight if linear else self.damping) * speed,
            law=self.law, spring=self.spring,
        )  # fmt: skip


def _converted(top: Any, convert: Callable[[Any], Any]) -> dict[str, Any]:
    names = [one.name for one in fields(top)]
    return {n: getattr(top, n) if n in WORDS else convert(getattr(top, n)) for n in names}


def top_in_contact(top: TippeTop, contact: Mapping[str, Any]) -> tuple[TippeTop, bool]:
    """The top of a scene's table ``[contact]``, and whether it flies where contact is lost.

    Raises
    ------
    InputError
        No such law, a key that the law does not have, or a missing one; exact Coulomb friction
        on an elastic table.
    """
    law = contact.get("law", "rigid")
    if law not in ("rigid", "compliant"):
        raise InputError(f"contact.law: got {law!r}, expected one of: rigid, compliant")
    wanted = {"law", "lost"} if law == "rigid" else {"law", "force", "stiffness", "damping"}
    for key in sorted(contact.keys() - wanted):
        raise InputError(
            f"unknown key contact.{key[:60]!r}, expected only: {', '.join(sorted(wanted))}"
        )
    if law == "rigid":
        lost = contact.get("lost", "end")
        if lost not in ("end", "fly"):
            raise InputError(f"contact.lost: got {lost!r}, expected one of: end, fly")
        return top, lost == "fly"
    for key in sorted(wanted - contact.keys()):
        raise InputError(f"missing key contact.{key}, expected it to be given")
    if contact["force"] not in SPRINGS:
        raise InputError(
            f"contact.force: got {contact['force']!r}, expected one of: {', '.join(SPRINGS)}"
        )
    if top.law == "coulomb":
        raise InputError(
            "contact.law: got compliant with Coulomb's exact friction, expected the viscous or "
            "the regularised law: sticking is solved on a rigid table only"
        )
    given = {name: exact(contact[name], f"contact.{name}") for name in ("stiffness", "damping")}
    plain = {one.name: getattr(top, one.name) for one in fields(TippeTop)}
    epsilon = getattr(top, "epsilon", Fraction(0))
    return (
        CompliantTop(**plain, epsilon=epsilon, **given, law=top.law, spring=contact["force"]),
        False,
    )
