"""The column sets of a trajectory file, and its rows as vector states.

A new set is one new entry in ``COLUMN_SETS``. A set lists required and optional columns; without
the velocity of the contact point, the checks of this velocity are skipped. The checks receive
``Samples``: rows of one ``CheckSetup``, made from a ``Block`` of columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.check.conventions import QUATERNION
from tt_precise.check.precision import LOOKED_AT, ColumnRounding, precisions, times_of
from tt_precise.mechanics import conversion
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Quaternion, dot
from tt_precise.runtime.values import Functions, InputError, Scalar, require_name, wrong_name
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LIFTED

Columns = Mapping[str, numpy.ndarray]


class ColumnSet(NamedTuple):
    """Names of columns that together determine a state, and the function that reads the state.

    ``state(body, columns, fn)`` is the vector state and v_A.z (0 if the set does not have it).
    ``columns`` holds every required name, and NaN for an unknown velocity. ``azimuth`` says
    whether the direction of the axis is known; Euler angles leave it open. ``height`` has the
    further columns of a top that may leave the table.
    """

    name: str
    required: tuple[str, ...]
    velocity: tuple[str, ...]
    state: Callable[[Parameters, Columns, Functions], tuple[NewtonState, Scalar]]
    azimuth: bool = True
    height: tuple[str, ...] = LIFTED

    @property
    def names(self) -> tuple[str, ...]:
        """All columns of the set, without the time."""
        return self.required + self.velocity

    def missing(self, present: Iterable[str]) -> list[str]:
        """Required columns that are missing."""
        return [name for name in self.required if name not in set(present)]


def _state(kind: Any, columns: Columns) -> Any:
    return kind(*(columns[name] for name in kind._fields))


def _euler(name: str, spin: str, azimuth: bool) -> ColumnSet:
    """Euler angles whose spin is omega_3 or psi_dot, with or without the azimuth phi."""

    def state(body: Parameters, c: Columns, fn: Functions) -> tuple[NewtonState, Scalar]:
        turning = c[spin]
        if spin == "psi_dot":
            turning = conversion.spin(turning, c["phi_dot"], fn.cos(c["theta"]))
        euler = _state(EulerState, {**c, "omega_3": turning})
        return vectors_from_euler(body, euler, fn, c["phi"] if azimuth else 0), 0

    names = ("theta", "theta_dot", "phi_dot", spin, *(("phi",) if azimuth else ()))
    return ColumnSet(name, names, ("nu_x", "nu_y"), state, azimuth)


_ALL = (
    ColumnSet(
        "vectors", ("kx", "ky", "kz", "Lx", "Ly", "Lz"), ("vx", "vy"),
        lambda body, c, fn: (_state(NewtonState, c), 0),
    ),
    ColumnSet(
        "rigid body", ("qw", "qx", "qy", "qz", "wx", "wy", "wz"), ("vcx", "vcy", "vcz"),
        lambda body, c, fn: conversion.vectors_from_rigid_body(
            body, _state(conversion.RigidBodyState, c)
        ),
        height=("z",),
    ),
    _euler("Euler with phi", "omega_3", azimuth=True),
    _euler("Euler with phi and psi_dot", "psi_dot", azimuth=True),
    _euler("Euler", "omega_3", azimuth=False),
    _euler("Euler with psi_dot", "psi_dot", azimuth=False),
)  # fmt: skip
COLUMN_SETS = {entry.name: entry for entry in _ALL}
# The integrals of a state's rates, which a file of any set may have.
TRACK = ("phi", "psi", "x", "y")
ENGINES_OWN = re.compile("(qpos|quaternion)_?0")
OURS = {"t", *TRACK, *(name for entry in _ALL for name in (*entry.names, *entry.height))}


def complete_sets(present: Sequence[str]) -> list[ColumnSet]:
    """The sets that are complete among the columns ``present``, the most informative first."""
    return [entry for entry in _ALL if not entry.missing(present)]


def recognised_columns(present: Iterable[str]) -> list[str]:
    """Columns among ``present`` that some set has; others are ignored."""
    return [name for name in present if name in OURS]


def choose_set(present: Sequence[str], where: str) -> ColumnSet:
    """The column set to check by.

    Raises ``InputError``: no set is complete; the message names the missing columns of the nearest
    set.
    """
    if "t" not in present:
        raise InputError(
            f"{where}: no column t (time in s) among {listed(present)}; "
            "rename yours with --columns theirs=t"
        )
    engines = [name for name in present if ENGINES_OWN.fullmatch(name)]
    complete = complete_sets(present)
    if complete:
        return complete[0]
    if engines:
        raise InputError(
            f"{where}: columns {engines[0]} ... are an engine's own state: read it with "
            f"--from {'mujoco' if engines[0].startswith('q') else 'ENGINE'}"
        )
    nearest = min(_ALL, key=lambda one: len(one.missing(present)) / len(one.required))
    if len(nearest.missing(present)) == len(nearest.required):
        raise InputError(
            f"{where}: no column set among {listed(present)}; expected t and "
            + ", or ".join(" ".join(entry.required) for entry in _ALL)
            + "; rename yours with --columns theirs=ours"
        )
    missing = ", ".join(nearest.missing(present))
    if missing == "omega_3":
        missing += " (or psi_dot: omega_3 = psi_dot + phi_dot cos theta)"
    raise InputError(
        f"{where}: missing {missing} of the {nearest.name} columns "
        f"({' '.join(nearest.required)}) among {listed(present)}; "
        "rename yours with --columns theirs=ours"
    )


def renaming(pairs: Iterable[str]) -> dict[str, str]:
    """Read ``theirs=ours`` pairs; a string may have several, separated by commas.

    Raises ``InputError``: a pair is malformed, or ``ours`` is not a known column.
    """
    names: dict[str, str] = {}
    for pair in (part for text in pairs for part in text.split(",") if part.strip()):
        left, equals, right = (piece.strip() for piece in pair.partition("="))
        if not (left and equals and right):
            raise InputError(f"--columns: got {pair.strip()!r}, expected theirs=ours")
        if right not in OURS:
            raise wrong_name("--columns", right, sorted(OURS), expected="one of ours: ")
        names[left] = right
    return names


def renamed(names: Sequence[str], rename: Mapping[str, str], where: str) -> list[str]:
    """Column names after ``rename``; "time" counts as t unless a column t exists.

    Raises ``InputError``: a column to be renamed is missing, or a known name occurs twice.
    """
    for theirs in rename:
        if theirs not in names:
            raise InputError(f"{where}: no column {theirs!r} to rename among {listed(names)}")
    result = [rename.get(name, name) for name in names]
    if "t" not in result:
        result = ["t" if name == "time" else name for name in result]
    for name in result:
        if name in OURS and result.count(name) > 1:
            raise InputError(f"{where}: column {name} occurs twice, expected once")
    return result


def listed(names: Sequence[str]) -> str:
    """Return the first names of a file's columns for a message, each shortened."""
    shown = [name if len(name) <= 24 else name[:21] + "..." for name in names[:16]]
    more = f", and {len(names) - 16} more" if len(names) > 16 else ""
    return f"the columns {', '.join(shown) or '(none)'}{more}"


# ---- rows of a trajectory --------------------------------------------------------------------


@dataclass(frozen=True)
class Block:
    """The rows of a table: name to float64 array, and the place of a row for messages.

    ``texts(row, names)`` gives the cells of a row as written, exact to the last digit. ``written``
    has the precision of columns whose numbers do not show it, because they follow from others.
    """

    values: dict[str, numpy.ndarray]
    where: Callable[[int], str] = str
    texts: Callable[[int, Sequence[str]], list[Any]] = lambda row, names: []
    written: Mapping[str, ColumnRounding] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.values["t"])

    def head(self, count: int) -> Block:
        values = {name: array[:count] for name, array in self.values.items()}
        return replace(self, values=values)

    def converted(self, of: Callable[[Columns], Columns]) -> Block:
        """Return the columns that ``of`` makes of these; only times are as written.

        Half a unit of the last place of each column changes them by what is left of its precision.
        """
        values = {**self.values, **of(self.values)}
        stride = max(1, len(self) // LOOKED_AT)
        few = {name: array[::stride] for name, array in self.values.items()}
        here, found = of(few), {**precisions(self.values), **self.written}
        half_units = dict.fromkeys(here, 0.0)
        for name in [name for name, one in found.items() if one.half_unit and name != "t"]:
            moved = of({**few, name: few[name] + found[name].half_unit})
            for other in half_units:
                half_units[other] += float(numpy.max(abs(moved[other] - here[other])))

        def texts(row: int, names: Sequence[str]) -> list[Any]:
            time = self.texts(row, ["t"])[0]
            return [time if name == "t" else float(values[name][row]) for name in names]

        written = {
            name: ColumnRounding(half_unit, found[name].words)
            for name, half_unit in half_units.items()
            if name != "t"
        }
        return Block(values, self.where, texts, written)


OWN_OR_OTHER = ("scene", "other")


@dataclass(frozen=True)
class CheckSetup:
    """A scene, the column set of its trajectory, and the known quantities.

    ``height_given`` says whether the height of the lowest point is known, which matters if the top
    may leave the table.

    ``friction`` is "scene" if the trajectory obeys the scene's contact force (or the scene rolls),
    and "other" for any other contact force: another friction law, an elastic table, an unknown
    force. ``start`` is "scene" if the motion is the scene's own, and "other" if it has another
    start.
    """

    scene: Scene
    columns: ColumnSet
    velocity_given: bool
    friction: str = "scene"
    height_given: bool = False
    assumed: Parameters | None = None
    start: str = "scene"

    def __post_init__(self) -> None:
        for name, value in (("friction", self.friction), ("start", self.start)):
            require_name(name, value, OWN_OR_OTHER)

    @cached_property
    def body(self) -> Parameters:
        """The body in float64, SI."""
        return self.assumed or self.scene.body.numbers(float)

    @cached_property
    def time(self) -> float:
        """The scene's unit of time sqrt(R/g) in s."""
        body = self.scene.body.numbers(float)
        return float(numpy.sqrt(body.R / body.g))

    @property
    def rolling(self) -> bool:
        """True if the contact point rests on the table."""
        return self.scene.model == "rolling"

    @property
    def flies(self) -> bool:
        """True if nothing touches the top."""
        return self.scene.model == "flight"

    @property
    def may_switch(self) -> bool:
        """True if the motion may change its equations."""
        return self.height_given if self.flies else self.scene.in_pieces

    @property
    def own_force(self) -> bool:
        """True if the contact force follows from the state."""
        known = self.flies or self.height_given or not self.scene.lifts
        return self.friction == "scene" and known

    @property
    def has_velocity(self) -> bool:
        """True if the velocity of the contact point is given, or zero in rolling."""
        return self.velocity_given or self.rolling

    def samples(self, block: Block) -> Samples:
        """The rows of ``block`` as vectors."""
        rows = len(block)
        known = dict(block.values)
        if not self.velocity_given:
            known |= dict.fromkeys(self.columns.velocity, numpy.full(rows, numpy.nan))
        state: NewtonState | LiftedState
        state, lift = self.columns.state(self.body, known, numpy)
        slip = numpy.abs(lift)
        if self.rolling:
            slip = numpy.sqrt(state.vx**2 + state.vy**2 + slip**2)
            state = state._replace(vx=0, vy=0)
        if self.height_given:
            raised = [known[name] for name in self.columns.height]
            if self.columns.height == ("z",):
                raised = [known["z"] - self.body.R * (1 - self.body.alpha * state.kz), lift]
            state = LiftedState(*state, *raised)
        entries = [numpy.broadcast_to(numpy.asarray(x, float), rows) for x in state]
        slip = numpy.broadcast_to(slip, rows)
        return Samples(self, known["t"], type(state)(*entries), slip, block.values, block.written)


@dataclass(frozen=True)
class Samples:
    """The rows of a trajectory: times (s), vector states (SI), and the columns as given.

    ``t`` begins at 0, in the first row. ``slip`` is the speed of the contact point that the contact
    forbids: |v_A.z|, and in rolling |v_A|. ``shared`` stores results for several checks.
    """

    setup: CheckSetup
    t: numpy.ndarray
    state: NewtonState | LiftedState
    slip: numpy.ndarray
    given: dict[str, numpy.ndarray]
    written: Mapping[str, ColumnRounding] = field(default_factory=dict)
    shared: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def q(self) -> Motion:
        """The rows as a motion whose entries are arrays."""
        return Motion(self.setup.body, self.state, numpy, self.setup.scene.model)

    def forget(self) -> None:
        """Release the values cached for several checks: some 500 bytes a row."""
        self.shared.clear()
        self.__dict__.pop("q", None)

    @cached_property
    def precisions(self) -> dict[str, ColumnRounding]:
        """The precision in which each known column is written."""
        return {**precisions(self.given), **self.written}

    @cached_property
    def resolution(self) -> dict[str, float]:
        """Half a unit of the last place in which each column is written; 0 for full doubles."""
        return {name: one.half_unit for name, one in self.precisions.items()}

    @cached_property
    def blur(self) -> float:
        """The change of the state, over its size, within the rounding of times that drift."""
        clock, omega, body = times_of(self.t), self.first.omega, self.setup.body
        turning = math.sqrt(dot(omega, omega))
        rounding = clock.rounding if clock.drifts else 0.0
        return (turning + body.g / body.R / (turning or 1.0)) * rounding

    @cached_property
    def quaternion(self) -> Quaternion | None:
        """The attitude (scalar first, body to inertial frame); None if the file leaves it open.

        Given as a quaternion, or by the axis, its azimuth and the angle psi.
        """
        if all(name in self.given for name in QUATERNION) and self.setup.columns.azimuth:
            qw, qx, qy, qz = (self.given[name] for name in QUATERNION)
            return (qw, qx, qy, qz)
        if "psi" not in self.given or not self.setup.columns.azimuth:
            return None
        k, psi = self.state.k, self.given["psi"]
        phi = numpy.arctan2(k[1], k[0])
        c, s = (f(numpy.arctan2(numpy.hypot(k[0], k[1]), k[2]) / 2) for f in (numpy.cos, numpy.sin))
        both, apart = (phi + psi) / 2, (phi - psi) / 2
        return (
            c * numpy.cos(both), -s * numpy.sin(apart), s * numpy.cos(apart), c * numpy.sin(both)
        )  # fmt: skip

    def rows(self, wanted: slice | numpy.ndarray) -> Samples:
        """Some of the rows, by a slice or an array of indices."""
        return Samples(
            self.setup,
            self.t[wanted],
            type(self.state)(*(entry[wanted] for entry in self.state)),
            self.slip[wanted],
            {name: values[wanted] for name, values in self.given.items()},
            self.written,
        )

    def changed(self, columns: Columns, setup: CheckSetup | None = None) -> Samples:
        """Return the rows with other ``columns``, or with another set-up."""
        block = Block({**self.given, **columns}, written=self.written)
        return (setup or self.setup).samples(block)

    @cached_property
    def first(self) -> Motion:
        """The first row as a motion of numbers."""
        state = type(self.state)(*(float(entry[0]) for entry in self.state))
        return Motion(self.setup.body, state, numpy, self.setup.scene.model)


def change_by_rounding(rows: Samples, of: Callable[[Samples], numpy.ndarray]) -> numpy.ndarray:
    """Return the change of a quantity by half a unit of the last written place of each column."""
    names = [name for name in rows.setup.columns.names if rows.resolution.get(name)]
    if not names:
        return numpy.zeros(len(rows.t))
    here = of(rows)
    changed = (rows.changed({name: rows.given[name] + rows.resolution[name]}) for name in names)
    moved = [abs(of(other) - here) for other in changed]
    total: numpy.ndarray = numpy.sum(moved, axis=0)
    return total
