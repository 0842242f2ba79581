"""The entries of a scene: name, table, dimension, range and meaning, each once.

The reader of files, ``Scene.varied``, sweeps, spreads, `tt-precise scene new`, the table of a
notebook and the documentation are made from ``ENTRIES``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from tt_precise.mechanics.laws import LAWS
from tt_precise.runtime.values import InputError, Json, nearest, shortened
from tt_precise.scene.numerals import WithPi, decimal_of, parse, unit_named, within_doubles

# The kinds of quantities by their SI unit, and an example of each with a unit.
KINDS = {
    "kg": ("a mass", "15 g"), "m": ("a length", "14 mm"), "s": ("a time", "0.5 s"),
    "rad": ("an angle", "5 deg"), "rad/s": ("a rate of turn", "25 rev/s"),
    "m/s": ("a speed", "9 mm/s"), "kg m^2": ("a moment of inertia", "1480 g mm^2"),
}  # fmt: skip


class Entry(NamedTuple):
    """An entry of a scene file: its table, SI unit ("" for a pure number or text) and meaning.

    ``size`` is the unit of a size that a scene may give instead of a ratio; the ratio is the size
    over the powers ``scale`` of m and R, and ``unit`` is then the unit of the ratio in words.
    ``new`` is the value in the file that `tt-precise scene new` writes. A number is above
    ``above``, at least ``least`` and below ``below``.
    """

    table: str
    unit: str
    meaning: str
    new: str = ""
    above: int | None = None
    least: int | None = None
    below: int | None = None
    size: str = ""
    scale: tuple[int, int] = (0, 0)

    @property
    def range(self) -> str:
        """The range in words; "" if every number is in it."""
        if self.below is not None:
            return f"between {self.above} and {self.below}, both excluded"
        if self.above is not None:
            return f"above {self.above}"
        return "" if self.least is None else f"at least {self.least}"

    def require(self, name: str, value: Fraction) -> None:
        """Refuse a number outside the range.

        Raises ``InputError``: it is outside.
        """
        low, least, high = self.above, self.least, self.below
        inside = (low is None or value > low) and (least is None or value >= least)
        if not inside or (high is not None and value >= high):
            unit = f" (in {self.unit})" if self.unit else ""
            raise InputError(f"{name}: got {brief(value)}, expected a number {self.range}{unit}")


ENTRIES = {
    "m": Entry("body", "kg", "mass", "0.015", above=0),
    "R": Entry("body", "m", "radius of the sphere", "0.015", above=0),
    "alpha": Entry(
        "body", "R", "centre of mass below the centre of the sphere", "0.2",
        above=0, below=1, size="m", scale=(0, 1),
    ),
    "I1": Entry(
        "body", "m R^2", "moment of inertia across the axis, about the centre of mass", "0.38",
        above=0, size="kg m^2", scale=(1, 2),
    ),
    "I3": Entry(
        "body", "m R^2", "moment of inertia about the axis, at most 2 I1", "0.4",
        above=0, size="kg m^2", scale=(1, 2),
    ),
    "g": Entry("body", "m/s^2", "gravity", "9.81", above=0),
    "mu": Entry("body", "s/m", "friction F_f = -mu g_n v_A", "0.3", least=0),
    "mu_s": Entry("friction", "", "stribeck: the coefficient at rest, at least mu", least=0),
    "v_s": Entry("friction", "m/s", "stribeck: the speed at which friction falls to mu", above=0),
    "epsilon": Entry(
        "friction", "m/s", "below this speed friction is proportional to the speed", above=0
    ),
    "stiffness": Entry("contact", "N/m", "compliant; N/m^1.5 for hunt-crossley", above=0),
    "damping": Entry("contact", "N s/m", "compliant; s/m for hunt-crossley", least=0),
    "theta": Entry("start", "rad", "inclination of the axis, 0 (upright) to pi", "0.1"),
    "theta_dot": Entry("start", "rad/s", "time derivative of theta", "0"),
    "phi_dot": Entry("start", "rad/s", "precession", "0"),
    "omega_3": Entry("start", "rad/s", "spin about the axis; or psi_dot", "200"),
    "psi_dot": Entry("start", "rad/s", "instead of omega_3 = psi_dot + phi_dot cos theta"),
    "nu_x": Entry("start", "m/s", "velocity of the contact point towards the tilt of the axis"),
    "nu_y": Entry("start", "m/s", "the same across the tilt, along z x tilt"),
    "at_rest": Entry(
        "start", "", '"contact point" or "centre of mass", instead of nu_x, nu_y', "contact point"
    ),
    "height": Entry("start", "m", "height of the lowest point, in flight or on an elastic table"),
    "rise": Entry("start", "m/s", "time derivative of height, which it needs"),
    "until": Entry("run", "s", "horizon", "4", least=0),
    "sample_every": Entry("run", "s", "spacing of the table", "0.01", above=0),
    "record": Entry("run", "", "further columns: any of phi, psi, x, y"),
    "events": Entry("run", "", "events by name; `tt-precise events` lists them"),
}  # fmt: skip
# The units of an elastic table by its force, where they differ from those above.
HERTZ = {"hunt-crossley": {"stiffness": "N/m^1.5", "damping": "s/m"}}
RATIOS = tuple(name for name, entry in ENTRIES.items() if entry.size)


def number_of(
    value: Json, name: str, what: str = "", unit: str | None = None
) -> tuple[WithPi, bool]:
    """Return the number of an entry in SI, and whether it is the size of a ratio.

    The value is of any type that ``decimal_of`` knows, with or without a unit. ``unit`` takes the
    place of the entry's, as friction laws have their own; errors say ``what`` it is.

    Raises ``InputError``: it is no exact number, or its unit has another dimension.
    """
    entry = ENTRIES.get(name, Entry("", "", ""))
    number, text = parse(decimal_of(value), what or name)
    if not text:
        return number, False
    expected = (entry.size or entry.unit) if unit is None else unit
    try:
        factor, dimension = unit_named(text)
        if not expected or dimension != unit_named(expected)[1]:
            raise ValueError(f"{text} measures something else")
        return number * factor, bool(entry.size) and unit is None
    except (ValueError, ArithmeticError) as error:
        kind, *example = KINDS.get(
            expected, (f"a number in {expected}" if expected else "a number alone",)
        )
        such = "".join(f', such as "{text}"' for text in example)
        got = shortened(value)
        raise InputError(f"{what or name}: got {got}, expected {kind}{such} ({error})") from None


def written(
    value: Any,
    name: str = "number",
    what: str = "",
    body: Mapping[str, Fraction] | None = None,
    unit: str | None = None,
) -> Fraction:
    """Return the number of an entry in the unit of the file: SI, or a ratio for alpha, I1, I3.

    The m and R of ``body`` make a ratio of a size.

    Raises ``InputError``: as ``number_of``; a size without ``body``.
    """
    number, is_size = number_of(value, name, what, unit)
    if not is_size:
        return number.rational
    if body is None:
        expected = f"expected a number in units of {ENTRIES[name].unit}"
        raise InputError(f"{what or name}: got {shortened(value)}, {expected}")
    mass, length = ENTRIES[name].scale
    return number.rational / (body["m"] ** mass * body["R"] ** length)


def numbers_of_body(given: Mapping[str, Json]) -> dict[str, Fraction]:
    """Return the numbers of a table [body] in the units of the file, within their ranges.

    Raises ``InputError``: one is no number, or outside its range.
    """
    numbers: dict[str, Fraction] = {}
    for name in sorted(given, key=lambda key: key in RATIOS):  # m and R before the ratios
        numbers[name] = within_doubles(written(given[name], name, "", numbers), name)
        ENTRIES[name].require(name, numbers[name])
    return numbers


def kept_fixed(names: Iterable[str], sizes: Collection[str]) -> str:
    """Return the sentence about the ratios or sizes that stay while ``names`` vary, or "".

    ``sizes`` are those of the scene; entries of a start may be among the names.
    """
    names = list(names)
    moved = [name for name in ("m", "R") if name in names]
    kept = [
        f"{name} ({ENTRIES[name].size if name in sizes else ENTRIES[name].unit})"
        for name in RATIOS
        if name not in names
        and any(power and m in moved for m, power in zip("mR", ENTRIES[name].scale, strict=True))
    ]
    return f"{' and '.join(moved)} varied at fixed {', '.join(kept)}" if kept else ""


def require_keys(
    table: Mapping[str, Json], required: Collection[str], optional: Collection[str], prefix: str
) -> None:
    """Refuse a table with an unknown key, or without a required one.

    Raises ``InputError``: a key is unknown or missing.
    """
    names = sorted({*required, *optional})
    for key in table:
        if key not in names:
            text = key[:60] if key.isprintable() else repr(key[:60])
            near = nearest(key, names)
            hint = f"; did you mean {near}?" if near else ""
            raise InputError(f"unknown key {prefix}{text}, expected only: {', '.join(names)}{hint}")
    if missing := sorted({*required} - table.keys()):
        first, *others = missing
        also = f"; also missing: {', '.join(others)}" if others else ""
        raise InputError(f"missing key {prefix}{first}, expected a value{also}")


def brief(value: Fraction) -> str:
    """Return a number in six digits or as a short fraction if that is exact, else "about" it."""
    double = not value or 1e-300 < abs(value) < 1e300
    number = float(value) if double else Decimal(value.numerator) / Decimal(value.denominator)
    text = f"{number:.6g}"
    if Fraction(text) == value:
        return text
    return str(value) if len(str(value)) <= 8 else f"about {text}"


def new_file(title: str) -> str:
    """Return the text of a valid scene file with comments, which a user changes."""
    lines: dict[str, list[str]] = {"body": [], "start": [], "run": [], "laws": []}
    for name, entry in ENTRIES.items():
        if entry.new:
            size = f'; or a size, such as "{KINDS[entry.size][1]}"' if entry.size else ""
            text = ", ".join(filter(None, (entry.unit, entry.meaning + size)))
            lines[entry.table].append(f'{name} = "{entry.new}"'.ljust(32) + f" # {text}")
    for law in LAWS.values():
        units = ", ".join(f"{parameter.name} ({parameter.unit})" for parameter in law.parameters)
        lines["laws"].append(f'# law = "{law.name}"'.ljust(32) + f" # {units}")
    values = {name: "\n".join(texts) for name, texts in lines.items()}
    template = (Path(__file__).parent / "new.toml").read_text("utf-8")
    return template.format(title=title.replace("\\", "\\\\").replace('"', '\\"'), **values)
