"""The exact parameters of a Tippe Top, read from the tables of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from tt_precise.mechanics.laws import LAWS, VISCOUS, Law, law_named
from tt_precise.mechanics.parameters import NAMES, SPRINGS, Parameters, of_numbers
from tt_precise.runtime.values import Functions, InputError, Json, Scalar, require_name
from tt_precise.scene.entries import ENTRIES, HERTZ, brief, numbers_of_body, require_keys, written
from tt_precise.scene.numerals import within_doubles

_MOMENT = Fraction(1, 1000), 10, 'm R^2 (a solid sphere has 2/5), or a size such as "1480 g mm^2"'
# Each top on a table is within these bounds; numbers in other units than the file's are not.
PLAUSIBLE = {
    "density of a sphere of m and R": (
        Fraction(1, 10), 100_000, "kg/m^3 (osmium has 22,600): m in kg and R in m, or with a unit, "
        'such as "15 g" and "15 mm"',
    ),
    "I1": _MOMENT, "I3": _MOMENT,
    "g": (Fraction(1, 100), 100, "m/s^2"),
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class TippeTop(Parameters):
    """A Tippe Top with exact parameters in SI: kg, m, 1, kg m^2, kg m^2, m/s^2, and mu.

    Every parameter is an exact decimal or fraction string, an int or a ``Fraction``; a float stands
    for its shortest decimal, 0.015 for "0.015". Users call ``Scene.of``, which takes the keys and
    the units of a scene file and refuses numbers that are evidently in other units.

    Raises ``InputError``: a parameter is not an exact number or outside its range: 0 < alpha < 1;
    m, R, I1, I3, g > 0; I3 <= 2 I1 (no mass distribution has more); mu >= 0; the ranges of the
    friction law and the table.
    """

    def __post_init__(self) -> None:
        for name in (*NAMES, "stiffness", "damping"):
            object.__setattr__(self, name, self._number(name, getattr(self, name)))
        pairs = zip(self.friction.further, self.further, strict=True)
        object.__setattr__(self, "further", tuple(self._number(*pair) for pair in pairs))
        for name, value in self.numbers_by_name.items():
            ENTRIES[name].require(name, value)
        self.friction.check(self.mu, *self.further)
        if self.spring and not self.friction.smooth_at_rest:
            smooth = ", ".join(law.name for law in LAWS.values() if law.smooth_at_rest)
            raise InputError(
                f"contact.law: got compliant with {self.law} friction, expected a law that is "
                f"smooth at rest ({smooth}); sticking needs a rigid table"
            )
        I1, I3 = (moment / (self.m * self.R**2) for moment in (self.I1, self.I3))
        _require(I3 <= 2 * I1, "I3", I3, f"at most 2 I1 = {brief(2 * I1)} (in m R^2)")

    def _number(self, name: str, value: Scalar) -> Fraction:
        own = {"alpha": "", "I1": "kg m^2", "I3": "kg m^2"}
        unit = own.get(name, unit_of(name, self.friction, self.spring))
        return within_doubles(written(value, name, unit=unit), name)

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name} {text}" for name, text in self.texts().items())
        table = f", {self.spring} table" if self.spring else ""
        return f"<TippeTop: {numbers}; {self.law} friction{table}>"

    def texts(self) -> dict[str, str]:
        """Return the numbers in the units of a scene file, as short texts with these units."""
        units = {name: unit_of(name, self.friction, self.spring) for name in self.numbers_by_name}
        values = self.in_file_units().items()
        return {name: f"{brief(value)} {units[name]}".rstrip() for name, value in values}

    @classmethod
    def from_ratios(cls, friction: Law = VISCOUS, spring: str = "", **numbers: Any) -> TippeTop:
        """Return a body from its numbers by name, with I1 and I3 in units of m R^2."""
        scale = written(numbers["m"], "m") * written(numbers["R"], "R") ** 2
        moments = {name: written(numbers[name], name) * scale for name in ("I1", "I3")}
        return of_numbers({**numbers, **moments}, friction, spring, cls)

    def in_file_units(self) -> dict[str, Fraction]:
        """Return the numbers by name in the units of a scene file: I1 and I3 in m R^2."""
        unit = self.m * self.R**2
        return {**self.numbers_by_name, "I1": self.I1 / unit, "I3": self.I3 / unit}

    @property
    def source(self) -> Mapping[str, Mapping[str, Json]]:
        """The tables of a file from which the top was read, as written; or none."""
        tables: Mapping[str, Mapping[str, Json]] = vars(self).get("_source", {})
        return tables

    def tables(self) -> dict[str, dict[str, Any]]:
        """Return the tables [body], [friction] and [contact] of a file, as written if known."""
        if self.source:
            return {name: dict(table) for name, table in self.source.items()}
        tables: dict[str, dict[str, Any]] = {"body": {}}
        if self.friction is not VISCOUS:
            tables["friction"] = {"law": self.law}
        if self.spring:
            tables["contact"] = {"law": "compliant", "force": self.spring}
        for name, value in self.in_file_units().items():
            table = "friction" if name == "mu" and "friction" in tables else ENTRIES[name].table
            tables[table][name] = value
        return tables

    def dimensionless(self, fn: Functions, convert: Callable[[Fraction], Scalar]) -> Parameters:
        """Return the top in units with m = R = g = 1; speeds are in units of sqrt(g R)."""
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


def unit_of(name: str, law: Law = VISCOUS, spring: str = "") -> str:
    """Return the unit of an entry under a friction law and on a table; "" for a pure number."""
    for parameter in law.parameters:
        if parameter.name == name:
            return "" if parameter.unit == "1" else parameter.unit
    entry = ENTRIES.get(name)
    return HERTZ.get(spring, {}).get(name, entry.unit if entry else "")


def top_of(
    body: Mapping[str, Json],
    friction: Mapping[str, Json] | None = None,
    contact: Mapping[str, Json] | None = None,
    *,
    frictionless: bool = False,
) -> tuple[TippeTop, bool]:
    """Return the top of the tables [body], [friction] and [contact], and whether it flies.

    A top that flies continues after loss of contact. ``frictionless`` needs no mu.

    Raises ``InputError``: a key is unknown or missing, or a value is refused.
    """
    if friction is not None and "mu" in body:
        raise InputError("body.mu: got a table [friction] too, expected mu only in that table")
    without_mu = friction is not None or frictionless
    require_keys(body, {*NAMES} - {"mu"} if without_mu else NAMES, NAMES, "body.")
    numbers: dict[str, Any] = {"mu": Fraction(0), **numbers_of_body(body)}
    require_plausible(numbers)
    law = VISCOUS
    if friction is not None:
        law, values = law_of(friction)
        numbers |= values
    table, flies = ({}, False) if contact is None else _contact_of(contact)
    top = TippeTop.from_ratios(**numbers, **table, friction=law)
    tables = {"body": body, "friction": friction, "contact": contact}
    source = {name: dict(table) for name, table in tables.items() if table is not None}
    object.__setattr__(top, "_source", source)
    return top, flies


def law_of(given: Mapping[str, Json]) -> tuple[Law, dict[str, Fraction]]:
    """Return the law of a table [friction] and the numbers of its parameters.

    Raises ``InputError``: a key is unknown or missing, or a value is no number.
    """
    law = law_named(given["law"]) if isinstance(given.get("law"), str) else law_named("")
    names = [parameter.name for parameter in law.parameters]
    require_keys(given, {"law", *names}, (), "friction.")
    return law, {
        name: written(given[name], name, f"friction.{name}", unit=unit_of(name, law))
        for name in names
    }


def _contact_of(given: Mapping[str, Json]) -> tuple[dict[str, Any], bool]:
    """Return the numbers of an elastic table, and whether the top flies after loss of contact."""
    law = given.get("law", "rigid")
    require_name("contact.law", law, ("rigid", "compliant"))
    if law == "rigid":
        require_keys(given, (), {"law", "lost"}, "contact.")
        lost = given.get("lost", "end")
        require_name("contact.lost", lost, ("end", "fly"))
        return {}, lost == "fly"
    require_keys(given, {"law", "force", "stiffness", "damping"}, (), "contact.")
    spring = given["force"]
    require_name("contact.force", spring, SPRINGS)
    numbers = {
        name: written(given[name], name, f"contact.{name}", unit=unit_of(name, spring=spring))
        for name in ("stiffness", "damping")
    }
    return {"spring": spring, **numbers}, False


def require_plausible(numbers: Mapping[str, Fraction]) -> None:
    """Refuse the numbers of a table [body] that are evidently in other units than the file's.

    Raises ``InputError``: mass and radius together, a moment of inertia or gravity are impossible
    for a top.
    """
    density = numbers["m"] / (numbers["R"] ** 3 * Fraction("4.18879"))
    values = {**numbers, "density of a sphere of m and R": density}
    for name, (low, high, unit) in PLAUSIBLE.items():
        expected = f"{float(low):g} to {high} {unit}"
        _require(low <= values[name] <= high, f"body: {name}", values[name], expected)


def _require(holds: bool, name: str, got: Fraction, expected: str) -> None:
    if not holds:
        raise InputError(f"{name}: got {brief(got)}, expected {expected}")
