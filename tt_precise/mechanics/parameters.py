"""The parameters of a top in one arithmetic, and the units of the top's quantities."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from fractions import Fraction
from typing import NamedTuple, TypeVar

from tt_precise.mechanics.laws import VISCOUS, Law
from tt_precise.runtime.values import Functions, InputError, Scalar

Top = TypeVar("Top", bound="Parameters")
# The forces of an elastic table that a scene may name.
SPRINGS = ("linear", "hunt-crossley")
# The parameters that every body has, in the order of a scene file.
NAMES = ("m", "R", "alpha", "I1", "I3", "g", "mu")


@dataclass(frozen=True)
class Parameters:
    """The parameters of a Tippe Top as scalars of any one arithmetic, in consistent units.

    m is the mass, R the radius, alpha the eccentricity of the centre of mass in units of R, I1 and
    I3 are the principal moments of inertia about the centre of mass, g is gravity, mu the
    coefficient of the law ``friction``, by default F_f = -mu g_n v_A; ``further`` has the values of
    the law's other parameters, in order. ``spring`` names the force F_n of an elastic table ("" for
    a rigid table): linear, stiffness depth + damping depth_dot (N/m, N s/m), or Hunt and
    Crossley's, stiffness depth^(3/2) (1 + damping depth_dot) (N/m^(3/2), s/m); see
    ``mechanics.compliant``.
    """

    m: Scalar
    R: Scalar
    alpha: Scalar
    I1: Scalar
    I3: Scalar
    g: Scalar
    mu: Scalar
    _: KW_ONLY
    friction: Law = VISCOUS
    further: tuple[Scalar, ...] = ()
    spring: str = ""
    stiffness: Scalar = 0
    damping: Scalar = 0

    @property
    def numbers_by_name(self) -> dict[str, Scalar]:
        """Every number of the body under its key in a scene file."""
        numbers = {name: getattr(self, name) for name in NAMES}
        numbers |= zip(self.friction.further, self.further, strict=True)
        if self.spring:
            numbers |= {"stiffness": self.stiffness, "damping": self.damping}
        return numbers

    def numbers(self, convert: Callable[[Scalar], Scalar]) -> Parameters:
        """These parameters in another arithmetic; ``convert`` rounds one number."""
        return of_numbers(
            {name: convert(value) for name, value in self.numbers_by_name.items()},
            self.friction,
            self.spring,
            Parameters,
        )

    @property
    def law(self) -> str:
        return self.friction.name

    @property
    def gamma(self) -> Scalar:
        """Ratio of the moments of inertia gamma = I1/I3; Theorem 1.1."""
        return self.I1 / self.I3

    @property
    def sigma(self) -> Scalar:
        """Ratio sigma = m R^2/I3; after eq (9)."""
        return self.m * self.R * self.R / self.I3


def of_numbers(numbers: Mapping[str, Scalar], friction: Law, spring: str, kind: type[Top]) -> Top:
    """Parameters from ``numbers_by_name``, exact or not."""
    values = dict(numbers)
    further = tuple(values.pop(name) for name in friction.further)
    return kind(**values, friction=friction, further=further, spring=spring)


DERIVED = {(1, 1, -2): "N", (1, 2, -2): "J", (1, 2, -3): "W"}
_UNITS = {"kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "rad": (0, 0, 0), "1": (0, 0, 0)} | {
    unit: powers for powers, unit in DERIVED.items()
}
_FACTOR = re.compile(r"(kg|rad|[msNJW1])(?:\^(-?\d))?")


class Dimension(NamedTuple):
    """Powers of mass, length and time in a physical quantity."""

    mass: int = 0
    length: int = 0
    time: int = 0

    @property
    def unit(self) -> str:
        """The SI unit, such as "J" or "kg m^2/s"; "1" for a pure number."""
        if self in DERIVED:
            return DERIVED[self]
        named = [("kg", self.mass), ("m", self.length), ("s", self.time)]
        power = [(unit if abs(n) == 1 else f"{unit}^{abs(n)}", n) for unit, n in named if n]
        over = " ".join(text for text, n in power if n > 0) or "1"
        under = "".join("/" + text for text, n in power if n < 0)
        return over + under

    @classmethod
    def of(cls, unit: str) -> Dimension:
        """The dimension of an SI unit in words, such as "m/s", "kg m^2/s", "rad/s", "N m" or "1".

        Raises ``InputError``: it is not of this form, or has a prefix, as "mm".
        """
        powers = [0, 0, 0]
        groups = [group.split() for group in unit.split("/")] if isinstance(unit, str) else [[]]
        for number, group in enumerate(groups):
            factors = [_FACTOR.fullmatch(factor) for factor in group]
            if not factors or None in factors:
                raise InputError(
                    f"unit: got {unit!r:.60}, expected an SI unit without prefix, such as "
                    '"m/s", "kg m^2/s", "rad/s", "N m" or "1"'
                )
            for factor in filter(None, factors):
                sign = (-1 if number else 1) * int(factor[2] or 1)
                powers = [a + sign * b for a, b in zip(powers, _UNITS[factor[1]], strict=True)]
        return cls(*powers)


ANGLE, LENGTH, RATE, SPEED = (Dimension.of(unit) for unit in ("rad", "m", "rad/s", "m/s"))
ENERGY, ANGULAR_MOMENTUM, JELLETT = map(Dimension.of, ("J", "kg m^2/s", "kg m^3/s"))


class Units(NamedTuple):
    """The units of the dimensionless form: mass m, length R, time sqrt(R/g), in SI."""

    mass: Scalar
    length: Scalar
    time: Scalar

    @classmethod
    def of(cls, body: Parameters, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Units:
        """The units of ``body``, each rounded once by ``convert`` (and one square root)."""
        return cls(convert(body.m), convert(body.R), fn.sqrt(convert(body.R / body.g)))

    def of_dimension(self, dimension: Dimension) -> Scalar:
        """The dimensionless unit of this dimension, in SI."""
        factor: Scalar = 1
        for unit, power in zip(self, dimension, strict=True):
            if power:
                factor = factor * unit**power
        return factor
