"""Scenes: a body, a start, a horizon and columns to record, read from TOML with exact numbers.

``InitialState`` has these numbers in an arithmetic.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation
from tt_precise.mechanics.laws import VISCOUS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.files import parse_toml, printable, read_toml
from tt_precise.runtime.values import (
    Arithmetic,
    Functions,
    InputError,
    Json,
    Memory,
    Scalar,
    listed,
    require_name,
    shortened,
    wrong_name,
)
from tt_precise.scene.body import TippeTop, top_of
from tt_precise.scene.entries import ENTRIES, brief, number_of, require_keys, written
from tt_precise.scene.start import CONTACT_POINT, LIFTED, Inclination, LiftedStart, Start

SHIPPED = Path(__file__).parents[1] / "scenes"
MODELS = ("gliding", "rolling", "flight")
RECORDABLE = ("phi", "psi", "x", "y")
MOST_SAMPLES = 20_000_000
SHORTEST = Fraction("1e-300")  # s
__all__ = [
    "MODELS", "MOST_SAMPLES", "RECORDABLE", "Inclination", "InitialState", "Scene", "Start",
    "load_scene", "parse_scene", "shipped",
]  # fmt: skip

_RUN = ("until", "sample_every", "record", "events")


@dataclass(frozen=True, repr=False)
class Scene:
    """A body, a start, a horizon and the columns and events to record.

    Times are in s. ``record`` has names of quadratures from ``RECORDABLE`` (phi, psi in rad; x, y
    of the centre of mass in m), ``events`` names from the event catalogue. ``start`` may be a
    mapping as in a scene file, including psi_dot and at_rest. If ``flies`` is true, the top
    continues in flight after loss of contact. ``changes`` are those of ``varied``.

    Raises ``InputError``: a value is out of range.
    """

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
    changes: Mapping[str, Json] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for name in ("until", "sample_every"):
            number = written(getattr(self, name), name)
            ENTRIES[name].require(name, number)
            object.__setattr__(self, name, number)
        for name in ("record", "events"):
            object.__setattr__(self, name, _names(getattr(self, name), name))
        start: Any = self.start
        if isinstance(start, Mapping):
            object.__setattr__(self, "start", Start.of(self.body, start))
        require_name("model", self.model, sorted(MODELS))
        for name in self.record:
            require_name("record", name, sorted(RECORDABLE))
        for wrong, message in self._refusals():
            if wrong:
                raise InputError(message)

    def _refusals(self) -> Iterator[tuple[bool, str]]:
        """Yield each condition that no scene may meet, and its error message."""
        flight, rolling = self.model == "flight", self.model == "rolling"
        lifted, spring = isinstance(self.start, LiftedStart), bool(self.body.spring)
        rubs = bool(self.body.mu or self.body.friction is not VISCOUS)
        height, rise = (getattr(self.start, name, Fraction(0)) for name in LIFTED)
        yield 0 < self.until < SHORTEST, "until: got less than 1e-300 s, expected 0, or more"
        yield (
            self.until > MOST_SAMPLES * self.sample_every,
            f"sample_every: got {brief(self.sample_every)}, which gives more than {MOST_SAMPLES} "
            "samples; expected a longer interval or a smaller until",
        )
        yield (
            rolling and spring,
            "model: got rolling on an elastic table, expected gliding: rolling needs a rigid table",
        )
        yield (
            rolling and bool(self.start.nu_x or self.start.nu_y),
            "start: got a contact point that glides in a rolling scene, expected at_rest = "
            '"contact point" (or nu_x = nu_y = 0)',
        )
        yield (
            lifted and not flight and not spring,
            "start.height, start.rise: got one of these keys on a rigid table, expected a flight "
            "scene or an elastic table",
        )
        yield (
            flight and (self.flies or rubs or spring),
            "model: got flight with friction or a table, expected neither mu nor [friction] nor "
            "[contact]: the top has no contact",
        )
        yield (
            flight and (height < 0 or (height == 0 and rise <= 0)),
            f"start.height: got {brief(height)} in a flight scene, expected the height of the "
            "lowest point in m, above 0 (or 0 with a rise above 0)",
        )

    @classmethod
    def of(cls, *, name: str = "scene", **tables: Any) -> Scene:
        """Return the scene with the tables of a scene file as mappings (same keys, units, checks).

        For example::

            tt.Scene.of(
                model="gliding",
                body={"m": "15 g", "R": "17 mm", "alpha": "4 mm", "I1": 0.38, "I3": 0.4, "g": 9.81},
                friction={"law": "coulomb", "mu": "0.3"},
                start={"theta": "10 deg", "omega_3": 150},
                run={"until": 2},
            )

        Raises ``InputError``: the content is invalid; the line names table and key.
        """
        return _from_tables(tables, name, "")

    def varied(self, **changes: Any) -> Scene:
        """Return the scene with entries of its file replaced: ``varied(mu=0.2, R="18 mm")``.

        ``changes`` are entries of [body], [friction], [contact], [start] and [run], read and
        checked as in a file; ``model``; and ``friction``, a whole table:
        ``varied(friction={"law": "coulomb", "mu": "0.3"})``. If m or R changes, alpha, I1 and I3
        keep their sizes where they were given with a unit, and their ratios elsewhere. A start
        that is given by psi_dot or at_rest is computed again.

        Raises ``InputError``: there is no such entry, or its value is refused.
        """
        tables = self.tables
        tables |= {name: changes[name] for name in ("model", "friction") if name in changes}
        if "friction" in changes:
            _table(changes, "friction")
            tables["body"].pop("mu", None)
        names = {"model", "friction"} | {
            name for name, entry in ENTRIES.items()
            if entry.table in ("body", "start", "run") or name in tables.get(entry.table, ())
        }  # fmt: skip
        start = {}
        for name in changes.keys() - {"model", "friction"}:
            require_name("varied", name, sorted(names))
            table = "friction" if name == "mu" and "friction" in tables else ENTRIES[name].table
            if table == "friction" and "friction" in changes:
                raise InputError(f"varied: got {name} beside friction, expected it in that table")
            if table == "start":
                start[name] = changes[name]
            else:
                tables[table] = {**tables[table], name: changes[name]}
        all_changes = {**self.changes, **changes}
        tables["start"] = self.start.table_with(start)
        if changes.keys() <= {*start, *_RUN}:
            return replace(self, start=tables["start"], changes=all_changes, **tables["run"])
        return replace(_from_tables(tables, self.name, self.text), changes=all_changes)

    @property
    def tables(self) -> dict[str, Any]:
        """The tables of a file with this scene, as they were written where that is known."""
        tables: dict[str, Any] = {
            **{name: getattr(self, name) for name in ("title", "source", "model")},
            **self.body.tables(),
            "start": dict(self.start.source or self.start.components()),
            "run": {name: getattr(self, name) for name in _RUN},
        }
        if self.flies:
            tables["contact"] = {"law": "rigid", "lost": "fly"}
        return tables

    @property
    def sizes(self) -> frozenset[str]:
        """The ratios of the body that were given by a size, which ``varied`` keeps."""
        table = self.body.source.get("body", {})
        return frozenset(name for name, value in table.items() if number_of(value, name)[1])

    @property
    def derived_from(self) -> Mapping[str, Json]:
        """The entries of a start from which others are computed (psi_dot, at_rest); or none."""
        return self.start.source if self.start.derived else {}

    def __repr__(self) -> str:
        friction = self.model == "gliding" and self.body.mu
        law = f"{self.body.law} friction, " if friction else ""
        changes = ", ".join(f"{name} = {value!s:.30}" for name, value in self.changes.items())
        start = self.start.texts()
        return (
            f"<Scene {self.name}{f' with {changes}' if changes else ''}: {self.model}, {law}theta "
            f"{start['theta']}, omega_3 {start['omega_3']}, until {brief(self.until)} s>"
        )

    def _repr_html_(self) -> str:
        from tt_precise.runtime.files import as_html

        rows = [(name, getattr(self, name)) for name in ("title", "source", "model")]
        run = {name: f"{brief(getattr(self, name))} s" for name in ("until", "sample_every")}
        run |= {name: ", ".join(getattr(self, name)) or "none" for name in ("record", "events")}
        tables = {"body": self.body.texts(), "start": self.start.texts(), "run": run}
        rows += [
            (f"{table}.{n}", text) for table, texts in tables.items() for n, text in texts.items()
        ]
        return as_html(f"Scene {self.name}", rows)

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
        """The point that is at rest at t = 0: "contact point", "centre of mass", "" for neither."""
        return self.start.at_rest(self.body)

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


def shipped() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load_scene(scene: str | Path | Scene) -> Scene:
    """Return the scene with a shipped name or from a TOML file.

    Raises ``InputError``: the scene or file does not exist, or its content is invalid; the line
    names file and key.
    """
    if isinstance(scene, Scene):
        return scene
    if not isinstance(scene, (str, Path)):
        raise InputError(f"scene: got {shortened(scene)}, expected a name, a path or a Scene")
    if isinstance(scene, str) and re.fullmatch(r"[A-Za-z0-9_-]+", scene):
        if scene in shipped():
            return _shipped(scene)
        expected, files = "a path to a .toml file or one of: ", map(str, Path().glob("*.toml"))
        raise wrong_name("scene", scene, shipped(), expected=expected, further=files)
    path = Path(scene)
    text = read_toml(
        path, "a scene file (`tt-precise scene new FILE` writes one) or a shipped name"
    )
    return parse_scene(text, path.stem, printable(path))


@cache
def _shipped(name: str) -> Scene:
    return parse_scene((SHIPPED / f"{name}.toml").read_text("utf-8"), name, f"{name}.toml")


def parse_scene(text: str, name: str, where: str) -> Scene:
    """Build a scene from TOML text; ``where`` names the source in errors."""
    try:
        return _from_tables(parse_toml(text), name, text)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _from_tables(tables: Mapping[str, Json], name: str, text: str) -> Scene:
    optional = {"title", "source", "friction", "contact"}
    require_keys(tables, {"model", "body", "start", "run"}, optional, "")
    run = _table(tables, "run")
    require_keys(run, {"until"}, _RUN, "run.")
    for key in ("title", "source", "model"):
        if not isinstance(tables.get(key, ""), str):
            raise InputError(f"{key}: got {shortened(tables[key])}, expected text")
    friction, contact = (
        _table(tables, key) if key in tables else None for key in ("friction", "contact")
    )
    frictionless = tables["model"] == "flight"
    body, flies = top_of(_table(tables, "body"), friction, contact, frictionless=frictionless)
    texts = {key: tables.get(key, "") for key in ("title", "source", "model")}
    start: Any = _table(tables, "start")
    return Scene(
        name, body=body, start=start, flies=flies, text=text,
        **{"sample_every": ENTRIES["sample_every"].new, **run, **texts},
    )  # fmt: skip


def _table(tables: Mapping[str, Json], key: str) -> Mapping[str, Json]:
    table = tables[key]
    if not isinstance(table, Mapping):
        got = shortened(table)
        raise InputError(f"{key}: got {got}, expected a table [{key}], in Python a dict")
    return table


def _names(names: Any, key: str) -> tuple[str, ...]:
    texts = listed(names)
    if not all(isinstance(name, str) for name in texts):
        raise InputError(f"run.{key}: got {shortened(names)}, expected a list of names")
    return texts


# ---- the start in an arithmetic ------------------------------------------------------------------


@dataclass(frozen=True)
class InitialState(Memory):
    """Body and state of a scene at t = 0 in one arithmetic, the axis at azimuth 0.

    ``vectors`` and ``euler`` are the same state, each computed from the exact numbers: near the
    inverted pole the vectors do not use theta = pi - offset. They are a ``LiftedState`` if the
    scene gives the height of the lowest point. ``until`` is the scene's horizon. All values are in
    the units ``units``, which are given in SI. ``row`` is present where a run continues from an
    earlier segment: its first row, a state of its formulation, followed by quadratures (scaled).
    """

    model: str
    body: Parameters
    units: Units
    vectors: NewtonState
    euler: EulerState
    until: Scalar
    row: tuple[Scalar, ...] = ()

    @classmethod
    def of(cls, scene: Scene, arithmetic: Arithmetic) -> InitialState:
        """The start of ``scene``, dimensionless (m = R = g = 1)."""
        fn, exact = arithmetic.fn, arithmetic.exact
        body, units = scene.body.dimensionless(fn, exact), Units.of(scene.body, fn, exact)
        vectors, euler = _state(scene.start, arithmetic, body, units, {})
        return cls(scene.model, body, units, vectors, euler, exact(scene.until) / units.time)

    @classmethod
    def in_si(cls, scene: Scene, arithmetic: Arithmetic) -> InitialState:
        """The start of ``scene`` in SI."""
        body, until = scene.body.numbers(arithmetic.exact), arithmetic.exact(scene.until)
        vectors, euler = _state(scene.start, arithmetic, body, None, {})
        return cls(scene.model, body, Units(1, 1, 1), vectors, euler, until)

    def from_another(
        self, start: Start, arithmetic: Arithmetic, given: Mapping[str, Scalar]
    ) -> InitialState:
        """Return the initial state of another ``start`` of the same body, with the same horizon.

        ``given`` are components that are already numbers of the arithmetic, in SI.
        """
        vectors, euler = _state(start, arithmetic, self.body, self.units, given)
        return replace(self, vectors=vectors, euler=euler)

    def state(self, form: Formulation) -> tuple[Scalar, ...]:
        """The state of ``form``, in the order of its columns."""
        if self.row:
            return self.row[: len(form.columns)]
        q = Motion(self.body, self.vectors, None, self.model, euler=self.euler)
        return self.once(form.State, lambda: tuple(form.State.of(q)))

    def first_row(self, form: Formulation, record: tuple[str, ...]) -> tuple[Scalar, ...]:
        """The state, followed by the quadratures ``record``, which begin at zero."""
        zero = self.until * 0
        return self.row or (*self.state(form), *(zero for _ in record))

    def parameters(self, form: Formulation) -> tuple[Scalar, ...]:
        """The body's ``parameters`` that ``form`` leaves open."""
        numbers = self.body.numbers_by_name
        return tuple(numbers[name] for name in form.parameters)

    def motion(self, fn: Functions) -> Motion:
        """The motion at the start."""
        return Motion(self.body, self.vectors, fn, self.model)

    def map(self, convert: Callable[[Scalar], Scalar]) -> InitialState:
        """Convert every number of body and state; ``units`` and ``until`` stay."""
        return replace(
            self,
            body=self.body.numbers(convert),
            vectors=type(self.vectors)(*map(convert, self.vectors)),
            euler=EulerState(*map(convert, self.euler)),
            row=tuple(map(convert, self.row)),
        )


def _state(
    start: Start,
    arithmetic: Arithmetic,
    body: Parameters,
    units: Units | None,
    given: Mapping[str, Scalar],
) -> tuple[NewtonState, EulerState]:
    fn, exact = arithmetic.fn, arithmetic.exact
    if "theta" in given:
        theta = given["theta"]
        sine_cosine = fn.sin(theta), fn.cos(theta)
    else:
        theta = start.theta.radians(fn, exact)
        sine_cosine = start.theta.sine_cosine(fn, exact)

    def component(name: str) -> Scalar:
        value = given[name] if name in given else exact(getattr(start, name))
        return value if units is None else value / units.of_dimension(STATE_DIMENSIONS[name])

    euler = EulerState(theta, *map(component, EulerState._fields[1:]))
    vectors: Any = vectors_from_euler(body, euler, fn, sine_cosine=sine_cosine)
    if isinstance(start, LiftedStart):
        vectors = LiftedState(*vectors, *map(component, LIFTED))
    return vectors, euler
