"""The body: the exact parameters of a Tippe Top, and the units that make it dimensionless."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import ClassVar, NamedTuple

from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.scene.numerals import within_doubles, written

SPRINGS = ("linear", "hunt-crossley")


@dataclass(frozen=True)
class Parameters:
    """The seven parameters of a Tippe Top as scalars of any one arithmetic.

    m mass, R radius, alpha eccentricity of the centre of mass in units of R, I1 and I3 principal
    moments of inertia about it, g gravity, mu friction in F_f = -mu g_n v_A. Any consistent units.
    ``law`` names the friction law; ``dry_friction`` has the others. ``spring`` names the force of
    an elastic table, where it is one; ``compliance`` has those.
    """

    m: Scalar
    R: Scalar
    alpha: Scalar
    I1: Scalar
    I3: Scalar
    g: Scalar
    mu: Scalar
    law: ClassVar[str] = "viscous"
    spring: ClassVar[str] = ""

    def map(self, convert: Callable[[Scalar], Scalar]) -> Parameters:
        """These parameters with every one of them converted."""
        return Parameters(**{f.name: convert(getattr(self, f.name)) for f in fields(self)})

    @property
    def gamma(self) -> Scalar:
        """Ratio of the moments of inertia gamma = I1/I3; Theorem 1.1."""
        return self.I1 / self.I3

    @property
    def sigma(self) -> Scalar:
        """Ratio sigma = m R^2/I3; after eq (9)."""
        return self.m * self.R * self.R / self.I3


@dataclass(frozen=True)
class TippeTop(Parameters):
    """A Tippe Top with exact parameters in SI: kg, m, 1, kg m^2, kg m^2, m/s^2, s/m.

    Every parameter is given as an exact decimal or fraction string, an int or a ``Fraction``; a
    float stands for its shortest decimal, 0.015 for "0.015".

    Raises
    ------
    InputError
        A parameter is no exact number or outside its range: 0 < alpha < 1; m, R, I1, I3, g > 0;
        I3 <= 2 I1 (no mass distribution has more); mu >= 0.
    """

    words: ClassVar[tuple[str, ...]] = ()  # entries that are no numbers
    numbers_as: ClassVar[type[Parameters]] = Parameters

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self) if field.name not in self.words):
            value = within_doubles(written(getattr(self, name), name), name)
            object.__setattr__(self, name, value)
        for name in ("m", "R", "I1", "I3", "g"):
            _require(getattr(self, name) > 0, name, getattr(self, name), "a number above 0")
        _require(0 < self.alpha < 1, "alpha", self.alpha, "a number between 0 and 1, both excluded")
        _require(self.mu >= 0, "mu", self.mu, "a number of at least 0")
        _require(
            self.I3 <= 2 * self.I1,
            "I3",
            self.I3 / (self.m * self.R**2),
            f"at most 2 I1 = {_short(2 * self.I1 / (self.m * self.R**2))} (in units of m R^2)",
        )

    @classmethod
    def from_ratios(cls, **given: str | int | Fraction) -> TippeTop:
        """A body whose I1 and I3 are given in units of m R^2, as in a scene file."""
        values = {n: written(x, n) for n, x in given.items() if n not in cls.words}
        scale = values["m"] * values["R"] ** 2
        values["I1"] *= scale
        values["I3"] *= scale
        return cls(**values, **{name: given[name] for name in cls.words})

    def numbers(self, convert: Callable[[Fraction], Scalar]) -> Parameters:
        """These parameters (SI) in another arithmetic; ``convert`` rounds one exact number."""
        return self.map(convert)

    def dimensionless(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Parameters:
        """The same top with m = R = g = 1 and mu sqrt(g R) for mu."""
        scale = self.m * self.R**2
        mu_squared = self.mu**2 * self.g * self.R
        return Parameters(
            m=1,
            R=1,
            alpha=convert(self.alpha),
            I1=convert(self.I1 / scale),
            I3=convert(self.I3 / scale),
            g=1,
            mu=fn.sqrt(convert(mu_squared)),
        )


# Generous: no top that stands on a table is beyond them.
PLAUSIBLE_MOMENT = Fraction(1, 1000), Fraction(10)  # of m R^2; a solid sphere has 2/5
PLAUSIBLE_GRAVITY = Fraction(1, 100), Fraction(100)  # m/s^2
PLAUSIBLE_DENSITY = Fraction(1, 10), Fraction(100_000)  # kg/m^3 of the sphere; osmium has 22,600


def require_si(body: TippeTop) -> None:
    """Refuse a body whose numbers can only be meant in other units than those of a scene file.

    Raises
    ------
    InputError
        A moment of inertia, gravity, or mass and radius together are beyond what any top has.
    """
    unit = body.m * body.R**2
    for name in ("I1", "I3"):
        ratio = getattr(body, name) / unit
        low, high = PLAUSIBLE_MOMENT
        if not low <= ratio <= high:
            _refuse_units(
                f"body.{name}", ratio,
                f"{float(low):g} to {high} in units of m R^2; if it is in kg m^2, write "
                f"{_rounded(ratio / unit)}, which is {_short(ratio)}/(m R^2)",
            )  # fmt: skip
    low, high = PLAUSIBLE_GRAVITY
    if not low <= body.g <= high:
        _refuse_units("body.g", body.g, f"{float(low):g} to {high} m/s^2 (is it in cm/s^2?)")
    density = body.m / (body.R**3 * Fraction(4.18879))
    low, high = PLAUSIBLE_DENSITY
    if not low <= density <= high:
        _refuse_units(
            "body.m, body.R", body.m,
            f"m in kg and R in m: with R = {_short(body.R)} the sphere has a density of "
            f"{_rounded(density, 3)} kg/m^3 (is it in g, cm or mm?)",
        )  # fmt: skip


def _refuse_units(name: str, got: Fraction, expected: str) -> None:
    raise InputError(f"{name}: got {_short(got)}, expected {expected}")


class Dimension(NamedTuple):
    """Powers of mass, length and time in a physical quantity."""

    mass: int = 0
    length: int = 0
    time: int = 0

    @property
    def unit(self) -> str:
        """The SI unit in base units, such as "kg m^2/s"; "1" for a pure number."""
        named = [("kg", self.mass), ("m", self.length), ("s", self.time)]
        power = [(unit if abs(n) == 1 else f"{unit}^{abs(n)}", n) for unit, n in named if n]
        over = " ".join(text for text, n in power if n > 0) or "1"
        under = "".join("/" + text for text, n in power if n < 0)
        return over + under


class Units(NamedTuple):
    """The units of the dimensionless form: mass m, length R, time sqrt(R/g), in SI."""

    mass: Scalar
    length: Scalar
    time: Scalar

    @classmethod
    def of(cls, body: TippeTop, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Units:
        """The units of ``body``, each rounded once by ``convert`` (and one square root)."""
        return cls(convert(body.m), convert(body.R), fn.sqrt(convert(body.R / body.g)))

    def of_dimension(self, dimension: Dimension) -> Scalar:
        """How many SI units one dimensionless unit of this dimension is."""
        factor: Scalar = 1
        for unit, power in zip(self, dimension, strict=True):
            if power:
                factor = factor * unit**power
        return factor


def _require(holds: bool, name: str, got: Fraction, expected: str) -> None:
    if not holds:
        raise InputError(f"{name}: got {_short(got)}, expected {expected}")


def _rounded(value: Fraction, digits: int = 6) -> str:
    try:
        return f"{float(value):.{digits}g}"
    except OverflowError:
        return "more than 1e308"


def _short(value: Fraction) -> str:
    text = str(value)
    decimal = repr(float(value)) if abs(value) < 10**300 else text
    shown = decimal if Fraction(decimal) == value or len(text) > 24 else text
    return shown if len(shown) <= 60 else f"{shown[:40]}... ({len(shown)} characters)"
