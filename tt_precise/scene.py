"""Scenes: a body, a start, a horizon and what to record, read from TOML with exact numbers."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

from tt_precise.body import TippeTop
from tt_precise.dry_friction import top_with_friction
from tt_precise.errors import InputError
from tt_precise.numerals import exact
from tt_precise.toml import parse, read_text, shown

MODELS = ("gliding", "rolling")
RECORDABLE = ("phi", "psi", "x", "y")
MOST_SAMPLES = 20_000_000

_NEARLY_PI = Fraction("3.14159")
_PI_FORM = re.compile(r"\s*pi\s*(?:-\s*(?P<offset>\S+)\s*)?", re.ASCII)


class Inclination(NamedTuple):
    """An exact inclination theta: ``offset`` from the upright pole, or from the inverted one.

    theta = pi is no rational number, and pi - 1e-300 is no number of any fixed precision, so the
    distance from the nearer pole is what is stored; sine and cosine are then exact at the poles
    and accurate beside them.
    """

    offset: Fraction
    from_pi: bool = False

    @classmethod
    def parse(cls, value: Any) -> Inclination:
        """Read "0.1", "pi" or "pi - 1e-9"; radians, within [0, pi]."""
        form = _PI_FORM.fullmatch(value) if isinstance(value, str) else None
        if form:
            angle = cls(exact(form["offset"] or 0, "theta"), from_pi=True)
        else:
            angle = cls(exact(value, "theta"))
        if not 0 <= angle.offset <= _NEARLY_PI:
            raise InputError(
                f"theta: got {str(value)[:60]}, expected 0 <= theta <= pi "
                '(near pi write "pi - 1e-3")'
            )
        return angle

    @property
    def at_pole(self) -> bool:
        """Whether the axis is exactly vertical, where Euler angles are undefined."""
        return self.offset == 0

    def sine_cosine(self, fn: Any, convert: Any) -> tuple[Any, Any]:
        """``(sin theta, cos theta)`` in the arithmetic ``fn``."""
        if self.at_pole:
            return convert(Fraction(0)), convert(Fraction(-1 if self.from_pi else 1))
        sine, cosine = fn.sin(convert(self.offset)), fn.cos(convert(self.offset))
        return sine, -cosine if self.from_pi else cosine

    def radians(self, fn: Any, convert: Any) -> Any:
        """Theta itself in the arithmetic ``fn``."""
        offset = convert(self.offset)
        return fn.acos(convert(Fraction(-1))) - offset if self.from_pi else offset

    def __str__(self) -> str:
        if not self.from_pi:
            return str(self.offset)
        return "pi" if self.at_pole else f"pi - {self.offset}"


@dataclass(frozen=True)
class Start:
    """The exact state at t = 0 in Euler angles: rad, rad/s, m/s; phi = psi = x = y = 0."""

    theta: Inclination
    omega_3: Fraction
    theta_dot: Fraction = Fraction(0)
    phi_dot: Fraction = Fraction(0)
    nu_x: Fraction = Fraction(0)
    nu_y: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        given: Any = self.theta
        if not isinstance(given, Inclination):
            object.__setattr__(self, "theta", Inclination.parse(given))
        for name in ("omega_3", "theta_dot", "phi_dot", "nu_x", "nu_y"):
            object.__setattr__(self, name, exact(getattr(self, name), name))


_START = tuple(field.name for field in fields(Start))
_RUN = ("until", "sample_every", "record", "events")


@dataclass(frozen=True)
class Scene:
    """What to integrate: a body, a start, a horizon, and what to record on the way.

    Times in s. ``record`` names quadratures from ``RECORDABLE`` (phi, psi in rad; x, y of the
    centre of mass in m); ``events`` names entries of the event catalogue.
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
    text: str = field(default="", repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("until", "sample_every"):
            object.__setattr__(self, name, exact(getattr(self, name), name))
        _one_of(self.model, MODELS, "model")
        for name in self.record:
            _one_of(name, RECORDABLE, "record")
        if self.until < 0:
            raise InputError(f"until: got {str(self.until)[:60]}, expected seconds, at least 0")
        if self.sample_every <= 0:
            raise InputError(
                f"sample_every: got {str(self.sample_every)[:60]}, expected seconds, above 0"
            )
        if self.until / self.sample_every > MOST_SAMPLES:
            shown = float(min(self.sample_every, Fraction(10**300)))
            raise InputError(
                f"sample_every: got {shown:g}, which makes more than "
                f"{MOST_SAMPLES} samples; expected a longer interval"
            )
        if self.model == "rolling" and (self.start.nu_x or self.start.nu_y):
            raise InputError("nu_x, nu_y: got a gliding velocity, expected none in a rolling scene")

    def varied(self, **changes: Any) -> Scene:
        """The same scene with entries of its file replaced, in the units of the file.

        ``changes`` are entries of [body], [start] and [run]: exact strings or numbers, in SI but
        for I1 and I3, which are in units of m R^2 and stay what they are there if m or R change.

        Raises
        ------
        InputError
            There is no such entry, or its value is refused.
        """
        parameters = [entry.name for entry in fields(self.body)]
        known = {*parameters, *_START, *_RUN}
        for name in changes:
            _one_of(name, known, "varied")
        start = {name: changes[name] for name in _START if name in changes}
        run = {name: changes[name] for name in _RUN if name in changes}
        body = {name: changes[name] for name in parameters if name in changes}
        top = self.body
        if body:
            unit = top.m * top.R**2
            given = {name: getattr(top, name) for name in parameters}
            top = type(top).from_ratios(
                **{**given, "I1": top.I1 / unit, "I3": top.I3 / unit, **body}
            )
        return replace(self, body=top, start=replace(self.start, **start), **run)

    def perturbed(self, **relative: Any) -> Scene:
        """The same scene with parameters (in SI) and rates off by exact relative sizes.

        ``perturbed(alpha="1e-9")`` has a top whose alpha is larger by 1e-9. With another m or R the
        moments of inertia stay what they are in kg m^2.

        Raises
        ------
        InputError
            There is no such parameter or rate, or the size is no exact number.
        """
        start: dict[str, Any] = {}
        body: dict[str, Any] = {}
        known = {*(entry.name for entry in fields(self.body)), *_START}
        for name, size in relative.items():
            _one_of(name, known - {"theta"}, "perturbed")
            owner, changes = (self.start, start) if name in _START else (self.body, body)
            changes[name] = getattr(owner, name) * (1 + exact(size, name))
        return replace(self, body=replace(self.body, **body), start=replace(self.start, **start))

    def _repr_html_(self) -> str:
        from tt_precise.notebook import scene_html

        return scene_html(self)

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """Exact sample times in s: multiples of ``sample_every`` from 0, and the end."""
        count = int(self.until / self.sample_every)
        times = [k * self.sample_every for k in range(count + 1)]
        return tuple(times if times[-1] == self.until else [*times, self.until])


def shipped() -> list[str]:
    """Names of the scenes that ship with the package."""
    return sorted(
        entry.name.removesuffix(".toml")
        for entry in _folder().iterdir()
        if entry.name.endswith(".toml")
    )


def load_scene(scene: str | Path | Scene) -> Scene:
    """Read a scene: a shipped name, or a path to a TOML file.

    Raises
    ------
    InputError
        No such scene or file, or its content is refused; the line names file and key.
    """
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, str) and re.fullmatch(r"[A-Za-z0-9_-]+", scene):
        if scene in shipped():
            text = (_folder() / f"{scene}.toml").read_text("utf-8")
            return parse_scene(text, scene, f"{scene}.toml")
        raise InputError(
            f"scene: got {scene[:60]!r}, expected a path to a .toml file or one of: "
            + ", ".join(shipped())
        )
    path = Path(scene)
    text = read_text(path, "a scene file or a shipped name")
    return parse_scene(text, path.stem, shown(path))


def parse_scene(text: str, name: str, where: str) -> Scene:
    """Build a scene from TOML text; ``where`` names the source in errors."""
    try:
        return _from_table(parse(text), name, text)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def _from_table(table: Mapping[str, Any], name: str, text: str) -> Scene:
    _keys(table, {"model", "body", "start", "run"}, {"title", "source", "friction"}, "")
    body, start, run = (_subtable(table, key) for key in ("body", "start", "run"))
    friction = _subtable(table, "friction") if "friction" in table else None
    parameters = {f.name for f in fields(TippeTop)}
    # with [friction] its place is there, and the message about two of them says so
    needed, extra = (parameters, set()) if friction is None else (parameters - {"mu"}, {"mu"})
    _keys(body, needed, extra, "body.")
    _keys(start, {"theta", "omega_3"}, {f.name for f in fields(Start)}, "start.")
    _keys(run, {"until"}, {"sample_every", "record", "events"}, "run.")
    return Scene(
        name=name,
        model=_text(table, "model"),
        body=_top(body, friction),
        start=Start(**start),
        until=run["until"],
        sample_every=run.get("sample_every", "0.01"),
        title=_text(table, "title"),
        source=_text(table, "source"),
        record=_names(run, "record"),
        events=_names(run, "events"),
        text=text,
    )


def _top(body: Mapping[str, Any], friction: Mapping[str, Any] | None) -> TippeTop:
    if friction is None:
        return TippeTop.from_ratios(**body)
    return top_with_friction(dict(body), dict(friction))


def _keys(table: Mapping[str, Any], required: set[str], optional: set[str], prefix: str) -> None:
    known = required | optional
    for key in table:
        if key not in known:
            shown = key[:60] if key.isprintable() else repr(key[:60])
            raise InputError(
                f"unknown key {prefix}{shown}, expected only: " + ", ".join(sorted(known))
            )
    for key in sorted(required - table.keys()):
        raise InputError(f"missing key {prefix}{key}, expected it to be given")


def _subtable(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = table[key]
    if not isinstance(value, dict):
        raise InputError(f"{key}: got {str(value)[:60]!r}, expected a table [{key}]")
    return value


def _text(table: Mapping[str, Any], key: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{key}: got {str(value)[:60]!r}, expected text")
    return value


def _names(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    value = table.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise InputError(f"run.{key}: got {str(value)[:60]!r}, expected a list of names")
    return tuple(value)


def _one_of(value: str, allowed: Collection[str], what: str) -> None:
    if value not in allowed:
        raise InputError(
            f"{what}: got {value[:60]!r}, expected one of: " + ", ".join(sorted(allowed))
        )


def _folder() -> Any:
    return resources.files("tt_precise") / "scenes"
