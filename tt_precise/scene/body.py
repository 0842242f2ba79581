"""The exact parameters of a Tippe Top, read from the tables of a scene."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from tt_precise.mechanics.laws import LAWS, VISCOUS, Law, law_named
from tt_precise.mechanics.parameters import NAMES, SPRINGS, Parameters, of_numbers
from tt_precise.runtime.values import Functions, InputError, Json, Scalar, nearest, require_name
from tt_precise.scene.numerals import within_doubles, written


@dataclass(frozen=True, repr=False)
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
        I1, I3 = (moment / (self.m * self.R**2) for moment in (self.I1, self.I3))
        units = "(in units of m R^2; I1_kg_m2 and I3_kg_m2 are in kg m^2)"
        if I1 < PLAUSIBLE_MOMENT[0] <= I3:  # not the fault of I3
            _require(I3 <= 2 * I1, "I1", I1, f"at least I3/2 = {_short(I3 / 2)} {units}")
        _require(I3 <= 2 * I1, "I3", I3, f"at most 2 I1 = {_short(2 * I1)} {units}")

    def __repr__(self) -> str:
        numbers = {**self.in_file_units(), "friction": None, "spring": None}
        shown = (f"{name} {float(n):.6g}" for name, n in numbers.items() if n is not None)
        table = f", {self.spring} table" if self.spring else ""
        return f"<TippeTop: {', '.join(shown)} (I1, I3 in m R^2); {self.law} friction{table}>"

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
    "I1_g_mm2": ("I1", Fraction(1, 10**9)), "I3_g_mm2": ("I3", Fraction(1, 10**9)),
}  # fmt: skip

# The parameters that other ones scale: their ratio, their size with its unit, and these other ones.
# Where m or R changes, the size is kept if the file gives it by a key with a unit, else the ratio.
RATIOS = {
    "alpha": ("alpha", "the centre of mass (m)", "R"),
    "I1": ("I1/(m R^2)", "I1 (kg m^2)", "mR"), "I3": ("I3/(m R^2)", "I3 (kg m^2)", "mR"),
}  # fmt: skip


def in_unit_keys(body: TippeTop) -> dict[str, Fraction]:
    """The values of the keys with units, such as ``R_mm``, of a body."""
    sizes = {"m": body.m, "R": body.R, "alpha": body.alpha * body.R, "I1": body.I1, "I3": body.I3}
    return {key: sizes[name] / unit for key, (name, unit) in UNIT_KEYS.items()}


def sizes_of(keys: Iterable[str]) -> frozenset[str]:
    """The keys among those of a table ``[body]`` that give a size instead of a ratio."""
    return frozenset(key for key in keys if UNIT_KEYS.get(key, ("",))[0] in RATIOS)


def kept_fixed(names: Iterable[str], sizes: Iterable[str]) -> str:
    """The sentence about what keeps its value while ``names`` vary; "" if there is nothing.

    ``sizes`` are those of the scene; entries of a start may be among the names.
    """
    changed = {UNIT_KEYS.get(name, (name,))[0]: name for name in names}
    by_size = {UNIT_KEYS[key][0] for key in sizes}
    kept = [
        size if name in by_size else ratio for name, (ratio, size, scales) in RATIOS.items()
        if name not in changed and changed.keys() & set(scales)
    ]  # fmt: skip
    moved = [changed[name] for name in ("m", "R") if name in changed]
    return f"{' and '.join(moved)} varied at fixed {', '.join(kept)}" if kept else ""


def body_numbers(
    given: Mapping[str, Json], scales: Mapping[str, Fraction] | None = None
) -> dict[str, Fraction]:
    """Return the numbers of a table ``[body]`` in SI, except I1 and I3 in units of m R^2.

    ``scales`` has the m and R that convert the units where ``given`` has none; without them a key
    whose unit needs one of them is converted with 1, and the missing key is refused later.

    Raises ``InputError``: a quantity is given twice, or is not a number.
    """
    values = {name: written(given[name], name) for name in NAMES if name in given}
    for key, (name, unit) in UNIT_KEYS.items():
        if key not in given:
            continue
        if name in values:
            raise InputError(f"body.{key}: got another key for {name} too, expected one of them")
        number = written(given[key], key)
        _require(number > 0, f"body.{key}", number, "a number above 0")
        value = number * unit
        if name in ("alpha", "I1", "I3"):
            sizes = {"m": Fraction(1), "R": Fraction(1), **(scales or {}), **values}
            m, R = sizes["m"], sizes["R"]
            for other, scale in (("m", m), ("R", R)):
                _require(scale > 0, other, scale, "a number above 0")
            value /= R if name == "alpha" else m * R**2
            if name == "alpha" and ("R" in values or scales):
                expected = f"less than the radius, {_short(R / unit)} in the same unit"
                _require(value < 1, f"body.{key}", number, expected)
        values[name] = value
    return values


def top_of(
    body: Mapping[str, Json],
    friction: Mapping[str, Json] | None = None,
    contact: Mapping[str, Json] | None = None,
    *,
    frictionless: bool = False,
) -> tuple[TippeTop, bool]:
    """The top of a scene's tables ``[body]``, ``[friction]`` and ``[contact]``, and if it flies.

    A top that flies continues after loss of contact. ``frictionless`` needs no mu.

    Raises ``InputError``: a key is unknown, missing or given twice, or a value is refused.
    """
    require_keys(body, {}, {*NAMES, *UNIT_KEYS}, "body.")
    given: dict[str, Any] = body_numbers(body)
    law = VISCOUS
    if friction is not None:
        law, values = law_of(friction)
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
    require_si(top, body)
    return top, flies


def law_of(given: Mapping[str, Json]) -> tuple[Law, dict[str, Fraction]]:
    """The law of a table ``[friction]`` and the numbers of its parameters.

    Raises ``InputError``: a key is unknown or missing, or a value is no number.
    """
    law = law_named(given["law"]) if isinstance(given.get("law"), str) else law_named("")
    names = [parameter.name for parameter in law.parameters]
    require_keys(given, {"law", *names}, set(), "friction.")
    return law, {name: written(given[name], name, f"friction.{name}") for name in names}


def _contact_of(given: Mapping[str, Json]) -> tuple[dict[str, Any], bool]:
    """Numbers of an elastic table, and whether the top flies after loss of contact."""
    law = given.get("law", "rigid")
    require_name("contact.law", law, ("rigid", "compliant"))
    if law == "rigid":
        require_keys(given, set(), {"law", "lost"}, "contact.")
        lost = given.get("lost", "end")
        require_name("contact.lost", lost, ("end", "fly"))
        return {}, lost == "fly"
    require_keys(given, {"law", "force", "stiffness", "damping"}, set(), "contact.")
    require_name("contact.force", given["force"], SPRINGS)
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
            near = nearest(key, known)
            hint = f"; did you mean {near}?" if near else ""
            only = ", ".join(sorted(known))
            raise InputError(f"unknown key {prefix}{shown}, expected only: {only}{hint}")
    if missing := sorted({*required} - table.keys()):
        first, *others = missing
        also = f"; also missing: {', '.join(others)}" if others else ""
        raise InputError(f"missing key {prefix}{first}, expected a value{also}")


# Generous: every top that stands on a table is within them.
PLAUSIBLE_MOMENT = Fraction(1, 1000), Fraction(10)  # Units m R^2; a solid sphere has 2/5.
PLAUSIBLE_GRAVITY = Fraction(1, 100), Fraction(100)  # m/s^2
MOMENTS = {"": "m R^2", "_kg_m2": "kg m^2", "_g_mm2": "g mm^2"}  # Ends of the keys, and units.
SIZES = {"m": "kg", "m_g": "g", "R": "m", "R_mm": "mm"}
PLAUSIBLE_DENSITY = Fraction(1, 10), Fraction(100_000)  # kg/m^3 of the sphere; osmium has 22,600


def require_si(body: TippeTop, keys: Iterable[str] = ()) -> None:
    """Refuse a body whose numbers are evidently not in the units of a scene file.

    The message has the numbers under the ``keys`` by which they were given.

    Raises ``InputError``: a moment of inertia, gravity, or mass and radius together are impossible
    for a top.
    """
    units = {UNIT_KEYS[key][0]: key for key in keys if key in UNIT_KEYS}
    in_units = in_unit_keys(body)
    scale = body.m * body.R**2
    density = body.m / (body.R**3 * Fraction("4.18879"))
    low, high = PLAUSIBLE_DENSITY
    m, R = (units.get(name, name) for name in ("m", "R"))
    values = {"m": body.m, "R": body.R, **in_units}
    sizes = " and ".join(f"{key} in {SIZES[key]}" for key in (m, R))
    _require(
        low <= density <= high, f"body.{m}, body.{R}", values[m],
        f"{sizes}: with {R} = {_short(values[R])} the sphere has a density of "
        f"{_three_digits(density)} kg/m^3 (is it in g, cm or mm? there are m_g and R_mm)",
    )  # fmt: skip
    low, high = PLAUSIBLE_MOMENT
    for name in ("I1", "I3"):
        ratio, key = getattr(body, name) / scale, units.get(name, "")
        got = in_units[key] if key else ratio
        conversions = {name: (name, scale)} | UNIT_KEYS
        meant = [
            f'; if it is in {unit}, write {name}{end} = "{_short(got)}"'
            for end, unit in MOMENTS.items()
            if low <= got * conversions[f"{name}{end}"][1] / scale <= high
        ]
        keys_there = "".join(meant) or f"; there are {name}_kg_m2 and {name}_g_mm2"
        found = f", not {_three_digits(ratio)} with {sizes}" if key else ""
        expected = f"{float(low):g} to {high} in units of m R^2{found}{keys_there}"
        _require(low <= ratio <= high, f"body.{key or name}", got, expected)
    low, high = PLAUSIBLE_GRAVITY
    expected = f"{float(low):g} to {high} m/s^2 (is it in cm/s^2?)"
    _require(low <= body.g <= high, "body.g", body.g, expected)


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
