"""The body: the exact parameters of a Tippe Top, and the units that make it dimensionless."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import KW_ONLY, dataclass
from fractions import Fraction
from typing import Any, NamedTuple, TypeVar

from tt_precise.runtime.values import Functions, InputError, Json, Scalar
from tt_precise.scene.laws import LAWS, VISCOUS, Law, law_named
from tt_precise.scene.numerals import within_doubles, written

SPRINGS = ("linear", "hunt-crossley")
Top = TypeVar("Top", bound="Parameters")
NAMES = ("m", "R", "alpha", "I1", "I3", "g", "mu")


@dataclass(frozen=True)
class Parameters:
    """The parameters of a Tippe Top as scalars of any one arithmetic, in consistent units.

    m mass, R radius, alpha eccentricity of the centre of mass in units of R, I1 and I3 principal
    moments of inertia about it, g gravity, mu the coefficient of the law ``friction``, which is
    F_f = -mu g_n v_A unless given; ``further`` has the values of its other parameters, in order.
    ``spring`` names the force of an elastic table ("" for a rigid one), F_n at a depth:
    linear, stiffness depth + damping depth_dot (N/m, N s/m), or Hunt and Crossley's,
    stiffness depth^(3/2) (1 + damping depth_dot) (N/m^(3/2), s/m); see ``mechanics.compliant``.
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
    given = dict(numbers)
    further = tuple(given.pop(name) for name in friction.further)
    return kind(**given, friction=friction, further=further, spring=spring)


@dataclass(frozen=True)
class TippeTop(Parameters):
    """A Tippe Top with exact parameters in SI: kg, m, 1, kg m^2, kg m^2, m/s^2, and mu.

    Every parameter is an exact decimal or fraction string, an int or a ``Fraction``; a float stands
    for its shortest decimal, 0.015 for "0.015". Users call ``of``, which takes the keys and the
    units of a scene file and refuses numbers that are evidently in other units.

    Raises
    ------
    InputError
        A parameter is not an exact number or outside its range: 0 < alpha < 1; m, R, I1, I3, g > 0;
        I3 <= 2 I1 (no mass distribution has more); mu >= 0; the ranges of the friction law and the
        table.
    """

    def __post_init__(self) -> None:
        def number(value: Scalar, name: str) -> Fraction:
            return within_doubles(written(value, name), name)

        for name in (*NAMES, "stiffness", "damping"):
            object.__setattr__(self, name, number(getattr(self, name), name))
        pairs = zip(self.further, self.friction.further, strict=True)
        object.__setattr__(self, "further", tuple(number(*pair) for pair in pairs))
        for name in ("m", "R", "I1", "I3", "g"):
            _require(getattr(self, name) > 0, name, getattr(self, name), "a number above 0")
        _require(0 < self.alpha < 1, "alpha", self.alpha, "a number between 0 and 1, both excluded")
        for parameter in self.friction.parameters:
            value = self.numbers_by_name[parameter.name]
            what = "a speed in m/s" if parameter.speeds == 1 else "a number"
            if parameter.positive:
                _require(value > 0, parameter.name, value, f"{what} above 0")
            else:
                _require(value >= 0, parameter.name, value, f"{what} of at least 0")
        self.friction.check(self.mu, *self.further)
        if self.spring:
            _require_table(self)
        _require(
            self.I3 <= 2 * self.I1,
            "I3",
            self.I3 / (self.m * self.R**2),
            f"at most 2 I1 = {_short(2 * self.I1 / (self.m * self.R**2))} (in units of m R^2)",
        )

    @classmethod
    def from_ratios(cls, **given: Any) -> TippeTop:
        """A body with I1 and I3 in units of m R^2, from its numbers by name and other fields."""
        law = given.get("friction", VISCOUS)
        further = tuple(given.pop(name) for name in law.further) or given.pop("further", ())
        scale = written(given["m"], "m") * written(given["R"], "R") ** 2
        ratios = {name: written(given[name], name) * scale for name in ("I1", "I3")}
        return cls(**{**given, **ratios, "further": further})

    def in_file_units(self) -> dict[str, Any]:
        """The numbers from which ``from_ratios`` makes the same body."""
        unit = self.m * self.R**2
        ratios = {"I1": self.I1 / unit, "I3": self.I3 / unit}
        return {**self.numbers_by_name, **ratios, "friction": self.friction, "spring": self.spring}

    def dimensionless(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Parameters:
        """The same top with m = R = g = 1; speeds are in units of sqrt(g R)."""
        scale, speed_squared = self.m * self.R**2, self.g * self.R
        numbers = {
            "m": 1, "R": 1, "g": 1, "alpha": convert(self.alpha),
            "I1": convert(self.I1 / scale), "I3": convert(self.I3 / scale),
        }  # fmt: skip
        for parameter in self.friction.parameters:
            value = self.numbers_by_name[parameter.name]
            squared = value**2 / speed_squared**parameter.speeds
            numbers[parameter.name] = (
                fn.sqrt(convert(squared)) if parameter.speeds else convert(value)
            )
        if self.spring:
            numbers |= self._dimensionless_table(fn, convert)
        return of_numbers(numbers, self.friction, self.spring, Parameters)

    def _dimensionless_table(
        self, fn: Functions, convert: Callable[[Fraction], Scalar]
    ) -> dict[str, Scalar]:
        weight, linear = self.m * self.g, self.spring == "linear"
        speed, length = fn.sqrt(convert(self.g * self.R)), convert(self.R)
        depth = length if linear else length * fn.sqrt(length)
        return {
            "stiffness": convert(self.stiffness / weight) * depth,
            "damping": convert(self.damping / weight if linear else self.damping) * speed,
        }


def _require_table(top: TippeTop) -> None:
    stiffness, damping = "N/m (N/m^1.5 for hunt-crossley)", "N s/m (s/m for hunt-crossley)"
    _require(
        top.stiffness > 0, "contact.stiffness", top.stiffness, f"a number above 0 in {stiffness}"
    )
    _require(top.damping >= 0, "contact.damping", top.damping, f"at least 0 in {damping}")
    if not top.friction.smooth_at_rest:
        smooth = ", ".join(law.name for law in LAWS.values() if law.smooth_at_rest)
        raise InputError(
            f"contact.law: got compliant with {top.law} friction, expected a law that is smooth at "
            f"rest ({smooth}); sticking needs a rigid table"
        )


# Other keys of [body]: the parameter of each, and its unit in SI.
UNIT_KEYS = {
    "m_g": ("m", Fraction(1, 1000)), "R_mm": ("R", Fraction(1, 1000)),
    "centre_m": ("alpha", Fraction(1)), "centre_mm": ("alpha", Fraction(1, 1000)),
    "I1_kg_m2": ("I1", Fraction(1)), "I3_kg_m2": ("I3", Fraction(1)),
}  # fmt: skip


def body_numbers(given: Mapping[str, Json]) -> dict[str, Fraction]:
    """The numbers of a table ``[body]`` in SI, except I1 and I3 in units of m R^2.

    Raises ``InputError``: a quantity is given twice, or is not a number.
    """
    values = {name: written(given[name], name) for name in NAMES if name in given}
    for key, (name, unit) in UNIT_KEYS.items():
        if key not in given:
            continue
        if name in values:
            raise InputError(f"body.{key}: got another key for {name} too, expected one of them")
        value = written(given[key], key) * unit
        if name in ("alpha", "I1", "I3"):
            for other in ("m", "R"):
                _require(values.get(other, 1) > 0, other, values.get(other, Fraction(1)),
                         "a number above 0")  # fmt: skip
            R = values.get("R", Fraction(1))
            value /= R if name == "alpha" else values.get("m", Fraction(1)) * R**2
        values[name] = value
    return values


def top_of(
    body: Mapping[str, Json],
    friction: Mapping[str, Json] | None = None,
    contact: Mapping[str, Json] | None = None,
    *,
    frictionless: bool = False,
) -> tuple[TippeTop, bool]:
    """The top of a scene's tables ``[body]``, ``[friction]`` and ``[contact]``; whether it flies.

    A top that flies continues after loss of contact. ``frictionless`` needs no mu.

    Raises ``InputError``: a key is unknown, missing or given twice, or a value is refused.
    """
    require_keys(body, {}, {*NAMES, *UNIT_KEYS}, "body.")
    given: dict[str, Any] = body_numbers(body)
    law = VISCOUS
    if friction is not None:
        law, values = _friction_of(friction)
        if "mu" in given:
            raise InputError("body.mu: got a table [friction] too, expected mu only in that table")
        given |= values
    elif frictionless:
        given = {"mu": Fraction(0), **given}
    for name in sorted(NAMES):
        if name not in given:
            others = [key for key, (other, _) in UNIT_KEYS.items() if other == name]
            also = f" (or {' or '.join(others)})" if others else ""
            raise InputError(f"missing key body.{name}, expected a value{also}")
    table, flies = ({}, False) if contact is None else _contact_of(contact)
    top = TippeTop.from_ratios(**given, **table, friction=law)
    require_si(top)
    return top, flies


def _friction_of(given: Mapping[str, Json]) -> tuple[Law, dict[str, Fraction]]:
    law = law_named(given["law"]) if isinstance(given.get("law"), str) else law_named("")
    names = [parameter.name for parameter in law.parameters]
    require_keys(given, {"law", *names}, set(), "friction.")
    return law, {name: written(given[name], f"friction.{name}") for name in names}


def _contact_of(given: Mapping[str, Json]) -> tuple[dict[str, Any], bool]:
    """Numbers of an elastic table, and whether the top flies after loss of contact."""
    law = given.get("law", "rigid")
    if law not in ("rigid", "compliant"):
        raise InputError(f"contact.law: got {law!r}, expected one of: rigid, compliant")
    if law == "rigid":
        require_keys(given, set(), {"law", "lost"}, "contact.")
        lost = given.get("lost", "end")
        if lost not in ("end", "fly"):
            raise InputError(f"contact.lost: got {lost!r}, expected one of: end, fly")
        return {}, lost == "fly"
    require_keys(given, {"law", "force", "stiffness", "damping"}, set(), "contact.")
    if given["force"] not in SPRINGS:
        raise InputError(
            f"contact.force: got {given['force']!r}, expected one of: {', '.join(SPRINGS)}"
        )
    numbers = {name: written(given[name], f"contact.{name}") for name in ("stiffness", "damping")}
    return {"spring": given["force"], **numbers}, False


def require_keys(
    table: Mapping[str, Json], required: Collection[str], optional: Collection[str], prefix: str
) -> None:
    """Refuse a table with an unknown key, or without a required one.

    Raises ``InputError``: a key is unknown or missing.
    """
    known = {*required, *optional}
    for key in table:
        if key not in known:
            shown = key[:60] if key.isprintable() else repr(key[:60])
            raise InputError(
                f"unknown key {prefix}{shown}, expected only: " + ", ".join(sorted(known))
            )
    for key in sorted({*required} - table.keys()):
        raise InputError(f"missing key {prefix}{key}, expected a value")


# Generous: every top that stands on a table is within them.
PLAUSIBLE_MOMENT = Fraction(1, 1000), Fraction(10)  # of m R^2; a solid sphere has 2/5
PLAUSIBLE_GRAVITY = Fraction(1, 100), Fraction(100)  # m/s^2
PLAUSIBLE_DENSITY = Fraction(1, 10), Fraction(100_000)  # kg/m^3 of the sphere; osmium has 22,600


def require_si(body: TippeTop) -> None:
    """Refuse a body whose numbers are evidently not in the units of a scene file.

    Raises ``InputError``: a moment of inertia, gravity, or mass and radius together are impossible
    for a top.
    """
    unit = body.m * body.R**2
    low, high = PLAUSIBLE_MOMENT
    for name in ("I1", "I3"):
        ratio = getattr(body, name) / unit
        _require(
            low <= ratio <= high, f"body.{name}", ratio,
            f"{float(low):g} to {high} in units of m R^2; if it is in kg m^2, write "
            f'{name}_kg_m2 = "{_short(ratio)}"',
        )  # fmt: skip
    low, high = PLAUSIBLE_GRAVITY
    expected = f"{float(low):g} to {high} m/s^2 (is it in cm/s^2?)"
    _require(low <= body.g <= high, "body.g", body.g, expected)
    density = body.m / (body.R**3 * Fraction("4.18879"))
    low, high = PLAUSIBLE_DENSITY
    _require(
        low <= density <= high, "body.m, body.R", body.m,
        f"m in kg and R in m: with R = {_short(body.R)} the sphere has a density of "
        f"{_three_digits(density)} kg/m^3 (is it in g, cm or mm? there are m_g and R_mm)",
    )  # fmt: skip


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
        """The dimensionless unit of this dimension, in SI."""
        factor: Scalar = 1
        for unit, power in zip(self, dimension, strict=True):
            if power:
                factor = factor * unit**power
        return factor


def _require(holds: bool, name: str, got: Fraction, expected: str) -> None:
    if not holds:
        raise InputError(f"{name}: got {_short(got)}, expected {expected}")


def _three_digits(value: Fraction) -> str:
    try:
        return f"{float(value):.3g}"
    except OverflowError:
        return "more than 1e308"


def _short(value: Fraction) -> str:
    text = str(value)
    decimal = repr(float(value)) if abs(value) < 10**300 else text
    shown = decimal if Fraction(decimal) == value or len(text) > 24 else text
    return shown if len(shown) <= 60 else f"{shown[:40]}... ({len(shown)} characters)"
