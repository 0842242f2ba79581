"""Scenes: a body, a start, a horizon and columns to record, read from TOML with exact numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from tt_precise.mechanics.laws import LAWS, VISCOUS
from tt_precise.mechanics.parameters import of_numbers
from tt_precise.runtime.files import parse_toml, printable, read_toml
from tt_precise.runtime.values import (
    Hints,
    InputError,
    Json,
    keyword_advice,
    require_name,
    wrong_name,
)
from tt_precise.scene.body import (
    UNIT_KEYS,
    TippeTop,
    body_numbers,
    in_unit_keys,
    law_of,
    require_keys,
    sizes_of,
    top_of,
)
from tt_precise.scene.numerals import written
from tt_precise.scene.start import (
    AT_REST,
    CENTRE_OF_MASS,
    CONTACT_POINT,
    LIFTED,
    START_KEYS,
    Inclination,
    LiftedStart,
    Start,
    is_derived,
)

MODELS = ("gliding", "rolling", "flight")
RECORDABLE = ("phi", "psi", "x", "y")
MOST_SAMPLES = 20_000_000
SHORTEST = Fraction("1e-300")  # s
__all__ = [
    "MODELS", "MOST_SAMPLES", "RECORDABLE", "Inclination", "Scene", "Start", "load_scene",
    "parse_scene", "shipped",
]  # fmt: skip

_START = tuple(field.name for field in fields(Start))
# what a changed entry takes the place of
_REPLACES = {
    "psi_dot": ("omega_3",), "omega_3": ("psi_dot",), "at_rest": ("nu_x", "nu_y"),
    "nu_x": ("at_rest",), "nu_y": ("at_rest",),
}  # fmt: skip
_RATES = ("theta", "theta_dot", "phi_dot", "omega_3")
_RUN = ("until", "sample_every", "record", "events")


@dataclass(frozen=True, repr=False)
class Scene(Hints):
    """A body, a start, a horizon and the columns and events to record.

    Times are in s. ``record`` has names of quadratures from ``RECORDABLE`` (phi, psi in rad; x, y
    of the centre of mass in m), ``events`` names from the event catalogue. ``start`` may be a
    mapping as in a scene file, including psi_dot and at_rest, which ``given`` keeps. If ``flies``
    is true, the top continues in flight after loss of contact. ``sizes`` are the keys of [body]
    whose values ``varied`` keeps if m or R changes, such as ``I1_kg_m2``.

    Raises
    ------
    InputError
        A body or start has the wrong type, or a value is out of range.
    """

    _parts = ("body", "start")

    name: str
    model: str
    body: TippeTop
    start: Start
    until: Fraction
    sample_every: Fraction
    title: str = ""
    source: str = ""
    record: tuple[str, ...] = ()
    events: tuple[str, ...] = ()
    flies: bool = False
    text: str = field(default="", repr=False, compare=False)
    given: Mapping[str, Json] = field(default_factory=dict, repr=False, compare=False)
    sizes: frozenset[str] = field(default=frozenset(), repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("until", "sample_every"):
            object.__setattr__(self, name, written(getattr(self, name), name))
        _typed(self.body, TippeTop, "body", "a TippeTop")
        start: object = self.start
        if isinstance(start, Mapping):
            object.__setattr__(self, "start", Start.of(self.body, start))
            object.__setattr__(self, "given", dict(start) if is_derived(start) else {})
        _typed(self.start, Start, "start", "a Start or a mapping of its entries")
        require_name("model", self.model, sorted(MODELS))
        for name in self.record:
            require_name("record", name, sorted(RECORDABLE))
        for wrong, said in self._refusals():
            if wrong:
                raise InputError(said)

    def _refusals(self) -> Iterator[tuple[bool, str]]:
        """Pairs of a condition that no scene may meet and its error message."""
        flight, lifted = self.model == "flight", isinstance(self.start, LiftedStart)
        until, every = str(self.until)[:60], str(self.sample_every)[:60]
        yield self.until < 0, f"until: got {until}, expected seconds, at least 0"
        yield (
            0 < self.until < SHORTEST,
            "until: got less than 1e-300 s, which underflows in double; expected 0 or at least "
            "1e-300 s",
        )
        yield self.sample_every <= 0, f"sample_every: got {every}, expected seconds, above 0"
        yield (
            self.until > MOST_SAMPLES * self.sample_every,
            f"sample_every: got {float(min(self.sample_every, Fraction(10**300))):g}, which gives "
            f"more than {MOST_SAMPLES} samples; expected a longer interval or a smaller until",
        )
        yield (
            self.model == "rolling" and bool(self.body.spring),
            "model: got rolling on an elastic table, expected gliding: rolling is a constraint of "
            "a rigid contact",
        )
        yield (
            lifted and not flight and not self.body.spring,
            "start.height, start.rise: got one of these keys on a rigid table, expected a flight "
            "scene or an elastic table",
        )
        has_contact = self.flies or self.body.mu or self.body.spring
        yield (
            flight and bool(has_contact or self.body.friction is not VISCOUS),
            "model: got flight with friction or a table, expected neither mu nor [friction] nor "
            "[contact]: the top has no contact",
        )
        height, rise = (getattr(self.start, name, Fraction(0)) for name in LIFTED)
        yield (
            flight and (height < 0 or (height == 0 and rise <= 0)),
            f"start.height: got {float(height):g} in a flight scene, expected the height of the "
            "lowest point in m, above 0 (or 0 with a rise above 0)",
        )
        yield (
            self.model == "rolling" and bool(self.start.nu_x or self.start.nu_y),
            'start: got a contact point that glides, expected at_rest = "contact point" (or '
            "nu_x = nu_y = 0) in a rolling scene",
        )

    @classmethod
    def of(cls, *, name: str = "scene", **tables: Any) -> Scene:
        """Return the scene with the tables of a scene file as mappings (same keys, units, checks).

        For example::

            tt.Scene.of(
                model="gliding",
                body={"m_g": 15, "R_mm": 17, "centre_mm": 4, "I1": "0.38", "I3": "0.4", "g": 9.81},
                friction={"law": "coulomb", "mu": "0.3"},
                start={"theta": "10 deg", "omega_3": 150},
                run={"until": 2},
            )

        Raises
        ------
        InputError
            The content is invalid; the line names table and key.
        """
        return _from_table(tables, name, "")

    def from_state(self, state: Any, **run: Any) -> Scene:
        """Return the scene that starts at a state: ``scene.from_state(trajectory.at("3.2"))``.

        Time and azimuth begin at 0, so the motion is the old motion rotated about the vertical.
        ``run`` has entries of [run], such as ``until``.

        Raises
        ------
        InputError
            The axis is vertical, or an entry is refused.
        """
        begun = replace(self, start=Start.of_state(state, lifted=self.lifts), given={}, text="")
        return begun.varied(**run)

    @keyword_advice("entries by name: varied(mu=0.2, R_mm=18)")
    def varied(self, **changes: Any) -> Scene:
        """Return the scene with entries of its file replaced, in the units of the file.

        ``changes`` are entries of [body], [start] and [run]: exact strings or numbers in SI, except
        I1 and I3 in units of m R^2; ``model``; and ``friction``, a whole table:
        ``varied(friction={"law": "coulomb", "mu": "0.3"})``. If m or R changes, what the file gives
        by a key such as ``I1_kg_m2`` or ``centre_mm`` keeps this value (``sizes`` has these keys),
        and alpha, I1 and I3 keep their ratios. A start that is given by psi_dot or at_rest is
        computed again.

        Raises
        ------
        InputError
            There is no such entry, or its value is refused.
        """
        own = self.body.in_file_units()
        if "friction" in changes:
            for law in LAWS.values():
                for name in (parameter.name for parameter in law.parameters):
                    own.pop(name, None)
                    if name in changes:
                        raise InputError(
                            f"varied with a table friction: got {name!r}, expected it in the "
                            f'table: friction={{"law": ..., "{name}": ...}}'
                        )
        parameters = own.keys() & self.body.numbers_by_name.keys()
        known = {*parameters, *UNIT_KEYS, *START_KEYS, *_RUN, "friction", "model"}
        for name in changes:
            require_name("varied", name, sorted(known))
        start = {name: changes[name] for name in START_KEYS if name in changes}
        run = {name: changes[name] for name in (*_RUN, "model") if name in changes}
        changed = {UNIT_KEYS.get(name, (name,))[0] for name in changes}
        kept = {key for key in self.sizes if UNIT_KEYS[key][0] not in changed}
        values = in_unit_keys(self.body)
        scaled = {key: values[key] for key in kept} if changed & {"m", "R"} else {}
        body: dict[str, Any] = dict(body_numbers({**scaled, **changes}, self.body.numbers_by_name))
        if "friction" in changes:
            law, numbers = law_of(_subtable(changes, "friction"))
            body |= {"friction": law, **numbers}
        body |= {name: changes[name] for name in parameters if name in changes}
        top = TippeTop.from_ratios(**{**own, **body}) if body else self.body
        sizes = sizes_of(kept | changes.keys())
        return replace(self, body=top, sizes=sizes, **self._start_with(start, top), **run)

    def _start_with(self, changes: Mapping[str, Json], body: TippeTop) -> dict[str, Any]:
        """The fields ``start`` and, if needed, ``given`` of a scene with this start."""
        # replace(scene, start=...) keeps ``given``, which is then invalid
        given = self.given if self.given and Start.of(self.body, self.given) == self.start else {}
        if not is_derived({**given, **changes}):
            kind = LiftedStart if changes.keys() & set(LIFTED) else type(self.start)
            return {"start": kind(**{**_components(self.start), **changes})}
        values = dict(given or _components(self.start))
        if AT_REST in values and changes.keys() & {"nu_x", "nu_y"}:
            values |= {name: getattr(self.start, name) for name in ("nu_x", "nu_y")}
        values |= changes
        for name, others in _REPLACES.items():
            if name in changes:
                for other in others:
                    if other not in changes:
                        values.pop(other, None)
        return {"start": values}

    def perturbed(self, **relative: str | Fraction) -> Scene:
        """Return the scene with parameters (in SI) and rates changed by exact relative amounts.

        ``perturbed(alpha="1e-9")`` has a top whose alpha is larger by 1e-9. With another m or R the
        moments of inertia keep their values in kg m^2.

        Raises
        ------
        InputError
            There is no such parameter or rate, or the amount is not an exact number.
        """
        start: dict[str, Any] = {}
        body = self.body.numbers_by_name
        known = {*body, *_START}
        for name, size in relative.items():
            require_name("perturbed", name, sorted(known - {"theta"}))
            factor = 1 + written(size, name)
            if name in _START:
                start[name] = getattr(self.start, name) * factor
            else:
                body[name] *= factor
        top = of_numbers(body, self.body.friction, self.body.spring, TippeTop)
        return replace(self, body=top, start=replace(self.start, **start))

    def __repr__(self) -> str:
        start = self.start
        theta = _brief(start.theta.radians_float)
        law = f"{self.body.law} friction, " if self.model == "gliding" and self.body.mu else ""
        return (
            f"<Scene {self.name}: {self.model}, {law}theta {theta} rad, "
            f"omega_3 {_brief(start.omega_3)} rad/s, until {_brief(self.until)} s>"
        )

    def _repr_html_(self) -> str:
        from tt_precise.runtime.tables import as_html

        entries: dict[str, Any] = {
            name: getattr(self, name) for name in ("title", "source", "model")
        }
        start = _components(self.start)
        for table, values in (("body", self.body.numbers_by_name), ("start", start)):
            entries |= {f"{table}.{name}": _readable(value) for name, value in values.items()}
        entries |= {
            name: f"{_readable(getattr(self, name))} s" for name in ("until", "sample_every")
        }
        entries |= {name: ", ".join(getattr(self, name)) or "none" for name in ("record", "events")}
        return as_html(f"Scene {self.name}", entries.items())

    @property
    def lifts(self) -> bool:
        """True if the lowest point of the top may leave the table's height."""
        return self.flies or self.model == "flight" or bool(self.body.spring)

    @property
    def further_columns(self) -> tuple[str, ...]:
        """The columns of its states that a top on a rigid table does not have."""
        return LIFTED if self.lifts else ()

    @property
    def refused_in_angles(self) -> str:
        """The motion that has no equations in Euler angles; "" for other scenes."""
        if self.model == "flight":
            return "a flight"
        return "an elastic table" if self.body.spring else ""

    @property
    def in_pieces(self) -> bool:
        """True if the motion may have several segments with different equations."""
        return self.lifts or self.may_stick

    @property
    def may_stick(self) -> bool:
        """True if friction may bring the contact point to rest: Coulomb's law."""
        return self.model == "gliding" and not self.body.friction.smooth_at_rest

    @cached_property
    def at_rest(self) -> str:
        """The point that is at rest at t = 0: "contact point", "centre of mass", "" for neither.

        A centre of mass counts as at rest if its speed is below 1e-6 of its speed with the contact
        point at rest, because nu_y may be rounded.
        """
        if not (self.start.nu_x or self.start.nu_y):
            return CONTACT_POINT
        rest = Start.of(self.body, {**_components(self.start, _RATES), AT_REST: CENTRE_OF_MASS})
        speeds = [float(abs(getattr(rest, name))) for name in ("nu_x", "nu_y")]
        apart = [float(abs(getattr(rest, n) - getattr(self.start, n))) for n in ("nu_x", "nu_y")]
        return CENTRE_OF_MASS if max(apart) < 1e-6 * max(speeds) else ""

    @property
    def rest_warning(self) -> str:
        """The warning about a top that dry friction may hold at t = 0; empty for other tops."""
        if not self.may_stick or self.at_rest != CONTACT_POINT:
            return ""
        return (
            f"the contact point is at rest at t = 0, where {self.body.law} friction may hold it: "
            "the top then rolls and nothing else happens. A top spun by hand has at_rest = "
            '"centre of mass" in [start]'
        )

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """Exact sample times in s: multiples of ``sample_every`` from 0, and the end."""
        count = int(self.until / self.sample_every)
        times = [k * self.sample_every for k in range(count + 1)]
        return tuple(times if times[-1] == self.until else [*times, self.until])


def _readable(value: Any) -> str:
    """A number in short decimals, after "about" if rounded; other values as text."""
    if isinstance(value, Inclination):
        offset = _readable(value.offset)
        return offset if not value.from_pi else f"pi - {offset}" if value.offset else "pi"
    if not isinstance(value, Fraction):
        return str(value)
    double = not value or 1e-300 < abs(value) < 1e300
    decimals = _brief(value if double else Decimal(value.numerator) / Decimal(value.denominator))
    return decimals if Fraction(decimals) == value else f"about {decimals}"


def _brief(value: Fraction | float | Decimal) -> str:
    return f"{value if isinstance(value, Decimal) else float(value):.6g}"


def _components(start: Start, names: Sequence[str] = ()) -> dict[str, Any]:
    return {name: getattr(start, name) for name in names or (e.name for e in fields(start))}


def shipped() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(
        entry.name.removesuffix(".toml")
        for entry in _folder().iterdir()
        if entry.name.endswith(".toml")
    )


def load_scene(scene: str | Path | Scene) -> Scene:
    """Return the scene with a shipped name or from a TOML file.

    Raises
    ------
    InputError
        The scene or file does not exist, or its content is invalid; the line names file and key.
    """
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, str) and re.fullmatch(r"[A-Za-z0-9_-]+", scene):
        if scene in shipped():
            return _shipped(scene)
        files = list(map(str, Path().glob("*.toml")))
        if f"{scene}.toml" in files:
            raise InputError(
                f"scene: got {scene!r}, expected '{scene}.toml', the file's whole name"
            )
        expected = "a path to a .toml file or one of: "
        raise wrong_name("scene", scene, shipped(), expected=expected, further=files)
    path = Path(scene)
    text = read_toml(
        path, "a scene file (`tt-precise scene new FILE` writes one) or a shipped name"
    )
    return parse_scene(text, path.stem, printable(path))


@cache
def _shipped(name: str) -> Scene:
    text = (_folder() / f"{name}.toml").read_text("utf-8")
    return parse_scene(text, name, f"{name}.toml")


def parse_scene(text: str, name: str, where: str) -> Scene:
    """Build a scene from TOML text; ``where`` names the source in errors."""
    try:
        return _from_table(parse_toml(text), name, text)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _from_table(table: Mapping[str, Json], name: str, text: str) -> Scene:
    require_keys(
        table, {"model", "body", "start", "run"}, {"title", "source", "friction", "contact"}, ""
    )
    body, start, run = (_subtable(table, key) for key in ("body", "start", "run"))
    require_keys(run, {"until"}, {"sample_every", "record", "events"}, "run.")
    friction, contact = (
        _subtable(table, key) if key in table else None for key in ("friction", "contact")
    )
    top, flies = top_of(body, friction, contact, frictionless=table["model"] == "flight")
    return Scene(
        name=name,
        model=_text(table, "model"),
        body=top,
        start=start,  # type: ignore[arg-type]
        until=run["until"],
        sample_every=run.get("sample_every", "0.01"),
        title=_text(table, "title"),
        source=_text(table, "source"),
        record=_names(run, "record"),
        events=_names(run, "events"),
        flies=flies,
        text=text,
        sizes=sizes_of(body),
    )


def _typed(value: object, kind: type, what: str, expected: str) -> None:
    if not isinstance(value, kind):
        raise InputError(f"{what}: got a {type(value).__name__}, expected {expected}")


def _subtable(table: Mapping[str, Json], key: str) -> Mapping[str, Json]:
    value = table[key]
    if not isinstance(value, dict):
        example = ' such as {"law": "coulomb", "mu": "0.3"}' if key == "friction" else ""
        raise InputError(
            f"{key}: got {str(value)[:60]!r}, expected a table [{key}], in Python a dict{example}"
        )
    return value


def _text(table: Mapping[str, Json], key: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{key}: got {str(value)[:60]!r}, expected text")
    return value


def _names(table: Mapping[str, Json], key: str) -> tuple[str, ...]:
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise InputError(f"run.{key}: got {str(value)[:60]!r}, expected a list of names")
    return tuple(value)


def _folder() -> Path:
    # importlib.resources would import tempfile, zipfile, random and more
    return Path(__file__).parents[1] / "scenes"
