"""Symbolic coordinates: the mechanics in the field of rational functions of parameters and state.

A chart names symbols for the parameters and the state and knows the relations between them: s^2 +
c^2 = 1 for s = sin theta and c = cos theta, |k|^2 = 1 for the axis, and q^2 for the root in Routh's
function, q = I3 sqrt(d(cos theta)). The functions of ``mechanics`` run on these symbols unchanged.
A rational function vanishes on the relations if and only if the remainder of its numerator does:
the relations' leading terms, c^2 and C^2 (or kz^2) and q^2, have no common factor, so they are a
Groebner basis, and the ideal is prime.
"""

from __future__ import annotations

from typing import ClassVar

from sympy import QQ
from sympy.polys.fields import field

from tt_precise.mechanics import euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import NAMES, Parameters
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.runtime.values import Scalar


class Chart:
    """A field with relations; serves as ``fn`` for the functions of ``mechanics``.

    A chart at azimuth 0 differentiates at any azimuth and then sets it to 0, where the axis is
    tilted along X: much smaller expressions, and no loss for equations that commute with rotations
    about z. With the rational numbers of one ``body`` for the parameters it is quicker: an identity
    that fails for this body is false.
    """

    sets_azimuth: ClassVar = False
    azimuth: ClassVar[dict[str, int]]  # symbols, and what they are at azimuth 0

    def __init__(self, leading: str, rest: str, body: Parameters | None = None):
        # Lexicographic order: q, then the leading symbols of the other relations, come first.
        names = ["q", *leading.split(), *NAMES, *rest.split()]
        self.field, *symbols = field(names, QQ)
        self.symbol = dict(zip(names, symbols, strict=True))
        symbols = Parameters(*(self.symbol[name] for name in NAMES))
        self.body = symbols
        if body:
            self.body = body.numbers(lambda x: self.field(QQ(x.numerator, x.denominator)))

    def _relate(self, z: Scalar, sine_squared: Scalar, *unit: Scalar) -> None:
        """Fix q^2 = I3^2 d(z) and the relations ``unit`` = 0."""
        body, q = self.body, self.symbol["q"]
        u = body.alpha - z
        shift = body.m * body.R**2
        self._q_squared = body.I1 * body.I3 + shift * (body.I3 * u**2 + body.I1 * sine_squared)
        relations = [self.here(relation).numer for relation in (q**2 - self._q_squared, *unit)]
        self._relations = [relation for relation in relations if relation]

    def here(self, value: Scalar) -> Scalar:
        """``value`` at azimuth 0 in a chart with this azimuth, unchanged in other charts."""
        return self.at_azimuth_0(value) if self.sets_azimuth else self.field(value)

    def at_azimuth_0(self, value: Scalar) -> Scalar:
        """``value`` where the axis is tilted along X."""
        element = self.field(value)
        for name, number in self.azimuth.items():
            symbol, parts = self.symbol[name].numer, (element.numer, element.denom)
            numerator, denominator = (self.field(part.compose(symbol, number)) for part in parts)
            element = numerator / denominator
        return element

    def vanishes(self, value: Scalar) -> bool:
        """Return whether ``value`` is zero on the relations.

        Raises ``ZeroDivisionError``: its denominator vanishes there.
        """
        return not self._defined(value).numer.rem(self._relations)

    def equal(self, one: Scalar, other: Scalar) -> bool:
        """Return whether two functions agree on the relations.

        Multiplied crosswise, as their difference in lowest terms takes five times as long.

        Raises ``ZeroDivisionError``: a function is undefined on the relations.
        """
        a, b = self._defined(one), self._defined(other)
        return not (a.numer * b.denom - b.numer * a.denom).rem(self._relations)

    def _defined(self, value: Scalar) -> Scalar:
        element = self.here(value)
        if not element.denom.rem(self._relations):
            raise ZeroDivisionError("the denominator vanishes on the relations of the chart")
        return element

    def derivative(self, value: Scalar, rates: dict[str, Scalar]) -> Scalar:
        """Time derivative of ``value`` by the chain rule; ``rates`` of the symbols that change."""
        q_rate = self._chain(self._q_squared, rates) / (2 * self.symbol["q"])
        return self._chain(self.field(value), rates | {"q": q_rate})

    def _chain(self, value: Scalar, rates: dict[str, Scalar]) -> Scalar:
        terms = (self.here(value.diff(self.symbol[name])) * rate for name, rate in rates.items())
        return sum(terms, self.field.zero)

    def sqrt(self, value: Scalar) -> Scalar:
        """The root in Routh's function, I3 sqrt(d) = q; no other root is a rational function."""
        if not self.equal(self.body.I3**2 * value, self._q_squared):
            raise ValueError("the chart knows no square root of this")
        return self.symbol["q"] / self.body.I3


class EulerChart(Chart):
    """Euler angles, away from the poles: c, s = cos, sin theta; C, S = cos, sin phi."""

    azimuth: ClassVar = {"C": 1, "S": 0}

    def __init__(self, body: Parameters | None = None) -> None:
        super().__init__("c C", "s S phi " + " ".join(EulerState._fields), body)
        self.c, self.s, self.C, self.S = (self.symbol[name] for name in "csCS")
        self.phi = self.symbol["phi"]
        self.state = EulerState(*(self.symbol[name] for name in EulerState._fields))
        self._relate(self.c, self.s**2, self.c**2 + self.s**2 - 1, self.C**2 + self.S**2 - 1)

    @property
    def vectors(self) -> NewtonState:
        """The vectors of the Euler state."""
        return euler.vectors_from_euler(self.body, self.state, self, self.phi)

    def along(self, value: Scalar, rates: EulerState | RollingEulerState) -> Scalar:
        """Time derivative of ``value`` while the Euler state changes at ``rates``."""
        turning, precession = rates.theta, self.state.phi_dot
        trigonometric = {
            "c": -self.s * turning,
            "s": self.c * turning,
            "C": -self.here(self.S) * precession,
            "S": self.here(self.C) * precession,
        }
        return self.derivative(value, trigonometric | rates._asdict())

    def sin(self, angle: Scalar) -> Scalar:
        return {self.state.theta: self.s, self.phi: self.S}[angle]

    def cos(self, angle: Scalar) -> Scalar:
        return {self.state.theta: self.c, self.phi: self.C}[angle]

    def hypot(self, x: Scalar, y: Scalar) -> Scalar:
        """The horizontal length of the axis, sin theta > 0."""
        if not self.equal(x**2 + y**2, self.s**2):
            raise ValueError("the chart knows the horizontal length of the axis only")
        return self.s

    def atan2(self, y: Scalar, x: Scalar) -> Scalar:
        """The angle with sine ``y`` and cosine ``x``: theta."""
        if (y, x) != (self.s, self.c):
            raise ValueError("the chart knows no angle with this sine and cosine")
        return self.state.theta


class VectorChart(Chart):
    """The vector state of eq (1), poles included: kz^2 = 1 - kx^2 - ky^2."""

    azimuth: ClassVar = {"ky": 0}
    more: ClassVar[tuple[str, ...]] = ()  # further symbols

    def __init__(self, body: Parameters | None = None) -> None:
        names = [*(name for name in NewtonState._fields if name != "kz"), *self.more]
        super().__init__("kz", " ".join(names), body)
        self.state = NewtonState(*(self.symbol[name] for name in NewtonState._fields))
        kx, ky, kz = self.state.k
        self._relate(kz, 1 - kz**2, kx**2 + ky**2 + kz**2 - 1)

    @property
    def vectors(self) -> NewtonState:
        """The state at the azimuth of the chart."""
        return NewtonState(*map(self.here, self.state))

    def along(self, value: Scalar, rates: NewtonState | RollingState) -> Scalar:
        """Time derivative of ``value`` while the vector state changes at ``rates``."""
        return self.derivative(value, rates._asdict())


class EulerChartAtAzimuth0(EulerChart):
    """Euler angles at azimuth 0."""

    sets_azimuth = True


class VectorChartAtAzimuth0(VectorChart):
    """Vectors at azimuth 0: ky = 0."""

    sets_azimuth = True


class ForceChart(VectorChart):
    """Vectors with any force F at the contact point, which may also move vertically."""

    more: ClassVar = ("vz", "Fx", "Fy", "Fz")

    @property
    def v(self) -> tuple[Scalar, Scalar, Scalar]:
        """Velocity of the contact point, not necessarily horizontal."""
        return (*self.state.v[:2], self.symbol["vz"])

    @property
    def force(self) -> tuple[Scalar, Scalar, Scalar]:
        return (self.symbol["Fx"], self.symbol["Fy"], self.symbol["Fz"])
