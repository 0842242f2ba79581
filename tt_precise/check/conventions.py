"""Conventions of columns, their conversion to ours, and the search for one that fits.

A ``Convention`` has one choice for each property in which simulators differ: units, the vertical
and the handedness of the world, the symmetry axis of the body, order and direction of the
quaternion, frame of the angular velocity, point and frame of the velocity, point of the position.
``ENGINES`` has those of physics engines; a new engine is one entry.

``candidates`` narrows the choices down by laws that hold for every contact force: the attitude
follows the free motion from row to row, Jellett's integral is constant, and the contact point stays
on the table. The checks decide on the candidates.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, TypeAlias

import numpy

from tt_precise.check.columns import (
    AXIS,
    MOMENTUM,
    OMEGA,
    POSITION,
    QUATERNION,
    VELOCITY,
    Columns,
    listed,
    stacked,
    unit,
)
from tt_precise.check.rows import Rows
from tt_precise.check.sources import Source, open_table
from tt_precise.mechanics.newton import contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import jellett
from tt_precise.mechanics.vectors import axis_of, cross, multiplied, rotate, spin
from tt_precise.runtime.values import Arithmetic, Array, InputError, require_name
from tt_precise.scene.scene import InitialState

FRAME_RATES = (24, 30, 50, 60, 90, 100, 120, 144, 240, 500, 1000)
TIME = {
    "s": 1.0, "ms": 1e-3, "microseconds": 1e-6, "ns": 1e-9, "minutes": 60.0,
    **{f"rows at {rate} Hz": 1 / rate for rate in FRAME_RATES},
}  # fmt: skip
LENGTH = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inches": 0.0254}
ANGLE = {
    "rad": 1.0, "degrees": math.pi / 180, "revolutions": 2 * math.pi,
    "revolutions per minute": math.pi / 30,
}  # fmt: skip
UNIT_OF_L = {"kg m^2/s": 1.0, "g mm^2/s": 1e-9, "kg mm^2/s": 1e-6, "g cm^2/s": 1e-7}
HALF = math.sqrt(0.5)
# Quaternions that rotate the upward direction to z, and z to the symmetry axis of the body.
UP = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, HALF, 0.0, 0.0), "x": (0.5, -0.5, -0.5, -0.5),
    "-z": (0.0, 1.0, 0.0, 0.0),
}  # fmt: skip
TO_AXIS = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, -HALF, 0.0, 0.0), "x": (HALF, 0.0, HALF, 0.0),
    "-z": (0.0, 1.0, 0.0, 0.0), "-y": (HALF, HALF, 0.0, 0.0), "-x": (HALF, 0.0, -HALF, 0.0),
}  # fmt: skip
WORLDS = {
    "z-up": ("z", "right"), "y-up": ("y", "right"),
    "left-handed-z-up": ("z", "left"), "left-handed-y-up": ("y", "left"),
}  # fmt: skip
AXES = ("z", "y", "x")
MIRROR = numpy.array([[1.0], [-1.0], [1.0]])  # reflects polar vectors in y; axial ones by -MIRROR


@dataclass(frozen=True)
class Convention:
    """One choice for each property; by default those of this package.

    The last five belong to vectors and Euler angles.
    """

    time: str = "s"
    length: str = "m"
    angle: str = "rad"
    up: str = "z"
    hand: str = "right"
    axis: str = "z"
    order: str = "scalar first"
    inverse: bool = False
    in_body: bool = False
    opposite: bool = False
    point: str = "cm"
    velocity_in_body: bool = False
    place: str = "cm"
    momentum: str = "kg m^2/s"
    degrees: bool = False
    of_cm: bool = False
    inertial: bool = False
    of_psi: bool = False

    def in_world(self, world: str, axis: str) -> Convention:
        """Return the convention in a named world, with a symmetry axis of the body.

        Raises ``InputError``: there is no such world or axis.
        """
        require_name("world", world, WORLDS)
        require_name("axis", axis, AXES)
        up, hand = WORLDS[world]
        return replace(self, up=up, hand=hand, axis=axis)

    @property
    def changes(self) -> int:
        """The number of properties that differ from ours; y and z exchanged are one of them."""
        differ = sum(getattr(self, each.name) != each.default for each in fields(self))
        return differ - (self.hand == "left" and self.up == "y") + self.opposite

    def words(self, options: bool = True) -> str:
        """Describe the differences from ours, with the options that read a file of a rigid body."""
        worlds = {world: f": add --world {name}" for name, world in WORLDS.items()}
        world, left = (self.up, self.hand), self.hand == "left"
        remedy = worlds.get(world, "") if options else ", or the top spins the other way" * left
        axis = f"{self.axis}: add --axis {self.axis}" if self.axis in AXES else self.axis
        counts = self.time.startswith("rows")
        parts = [f"{'t counts' if counts else 'the time is in'} {self.time}"] * (self.time != "s")
        if world != WORLDS["z-up"]:
            parts.append(f"the world is {'left-handed, ' * left}{self.up} up{remedy}")
        parts += [f"the body's symmetry axis is {axis}"] * (self.axis != "z")
        for name, text in WORDS.items():
            value = getattr(self, name)
            if value != getattr(OURS, name):
                parts.append(text.format(NAMES.get(value, value)))
        return "; ".join(parts)


WORDS = {
    "length": "lengths are in {}",
    "angle": "the angular velocity is in {}",
    "order": "the quaternion has its {}",
    "inverse": "the quaternion is the inverse one, from the inertial to the body frame",
    "in_body": "the angular velocity is in the body frame",
    "opposite": "the angular velocity has the other sign",
    "point": "the velocity is that of {}",
    "velocity_in_body": "the velocity is in the body frame",
    "place": "the position is that of {}",
    "momentum": "the angular momentum is in {}",
    "degrees": "the angles are in degrees",
    "of_cm": "the velocity is that of the centre of mass",
    "inertial": "nu_x, nu_y are inertial components: rotate them by -phi",
    "of_psi": "omega_3 holds psi_dot: omega_3 = psi_dot + phi_dot cos theta",
}
NAMES = {
    "centre": "the sphere's centre", "contact": "the contact point",
    "degrees": "degrees per second", "revolutions": "revolutions per second",
}  # fmt: skip
OURS = Convention()


@numpy.errstate(all="ignore")  # rows that blew up are left to the checks
def convert(columns: Columns, convention: Convention, body: Parameters) -> dict[str, Array]:
    """Convert rigid-body columns from ``convention`` to ours; quaternions keep their length."""
    up, axis, length = UP[convention.up], TO_AXIS[convention.axis], LENGTH[convention.length]
    q = stacked(columns, QUATERNION)
    q = q if convention.order == "scalar first" else numpy.roll(q, 1, axis=0)
    q = q * numpy.array([[1.0], [-1.0], [-1.0], [-1.0]]) if convention.inverse else q
    size = (q * q).sum(axis=0)
    size[size == 0] = 1.0

    def in_world(vector: Array, in_body: bool) -> Array:
        return _rotated(up, _rotated(q, vector) / size if in_body else vector)

    w = stacked(columns, OMEGA) * ANGLE[convention.angle] * (-1 if convention.opposite else 1)
    w = in_world(w, convention.in_body)
    v = length * in_world(stacked(columns, VELOCITY), convention.velocity_in_body)
    x = length * in_world(stacked(columns, POSITION), False)
    q = numpy.array(numpy.broadcast_arrays(*multiplied(multiplied(up, tuple(q)), axis)))
    if convention.hand == "left":
        v, x, w = v * MIRROR, x * MIRROR, -w * MIRROR
        q = q * numpy.array([[1.0], [-1.0], [1.0], [-1.0]])
    k = tuple(axis_of(*q))
    centre = body.R * body.alpha * numpy.array(k)
    if convention.point != "cm":
        arm = tuple(centre) if convention.point == "centre" else contact_arm(body, k)
        v = v - numpy.array(cross(tuple(w), arm))
    x = x - centre if convention.place == "centre" else x
    ours = dict(zip((*QUATERNION, *OMEGA, *VELOCITY, *POSITION), (*q, *w, *v, *x), strict=True))
    return {"t": TIME[convention.time] * columns["t"]} | {n: ours[n] for n in ours if n in columns}


def _rotated(q: Any, vector: Array) -> Array:
    return numpy.array(rotate(tuple(q), tuple(vector)))


def _convert_vectors(columns: Columns, convention: Convention, body: Parameters) -> Columns:
    """Convert vectors; the velocity, always horizontal, is of the contact point or ``of_cm``."""
    mirror = MIRROR if convention.hand == "left" else 1.0
    k, L = (_rotated(UP[convention.up], stacked(columns, names)) for names in (AXIS, MOMENTUM))
    k = k * mirror * (-1.0 if convention.axis == "-z" else 1.0)
    L = L * mirror * UNIT_OF_L[convention.momentum] * (-1.0 if convention.hand == "left" else 1.0)
    v = LENGTH[convention.length] * stacked(columns, ("vx", "vy", "vz")) * mirror
    if convention.of_cm:
        omega = inverse_inertia(body, tuple(k), tuple(L))
        v = v + numpy.array(cross(omega, contact_arm(body, tuple(k))))
    ours = dict(zip((*AXIS, *MOMENTUM, "vx", "vy"), (*k, *L, *v[:2]), strict=True))
    return {"t": TIME[convention.time] * columns["t"]} | {n: ours[n] for n in ours if n in columns}


def _convert_euler(columns: Columns, convention: Convention, body: Parameters) -> Columns:
    """Convert Euler angles; in a mirror phi, psi, the spin and nu_y have the other sign."""
    sign = -1.0 if convention.hand == "left" else 1.0
    rate, length = ANGLE[convention.angle], LENGTH[convention.length]
    angle = ANGLE["degrees"] if convention.degrees else 1.0
    factors = {
        "t": TIME[convention.time], "theta": angle, "phi": sign * angle, "psi": sign * angle,
        "theta_dot": rate, "phi_dot": sign * rate, "omega_3": sign * rate, "psi_dot": sign * rate,
        "nu_x": length, "nu_y": sign * length,
    }  # fmt: skip
    ours = {name: factor * columns[name] for name, factor in factors.items() if name in columns}
    if convention.inertial:
        x, y, phi = ours["nu_x"], ours["nu_y"], ours["phi"]
        cosine, sine = numpy.cos(phi), numpy.sin(phi)
        ours |= {"nu_x": cosine * x + sine * y, "nu_y": cosine * y - sine * x}
    if convention.of_psi:
        ours["omega_3"] = spin(ours["omega_3"], ours["phi_dot"], numpy.cos(ours["theta"]))
    return ours


# ---- the search --------------------------------------------------------------------------------

Candidates: TypeAlias = Iterator[tuple[str, Callable[[Rows], Rows]]]
LOOKED_AT, INTERVALS = 250, 24  # rows of the search, and intervals on which motions are compared
# The free motion, which neglects the torque of the weight, misses a change of the axis by a part
# that is small for a fast top; another convention misses by a part of 1.
PART, ROUGH = 0.25, 0.02
# Misfits of Jellett's integral and of the contact point that any convention may have. Beyond them
# the least one of all conventions is a measure of an engine's own errors.
SMALL, FACTOR = 1e-4, 10.0
MOST_PARTIAL, MOST_TRIED = 32, 24  # conventions behind each law, and candidates


def candidates(rows: Rows) -> Candidates:
    """Yield the conventions of which no law excludes a property, in words, and their conversion.

    Those with the fewest changes come first.
    """
    few, conventions = rows.part(slice(0, LOOKED_AT)), [OURS]
    if len(few.t) < 3:
        return
    own = {"t", *rows.assumed.columns.names, *rows.assumed.columns.height} & {*rows.columns}
    for needed, choices, misfit, small in LAWS:
        if {*needed.split()} <= own:
            values = itertools.product(*(_choices(few, *each) for each in choices.items()))
            changes = [dict(zip(choices, each, strict=True)) for each in values]
            conventions = [replace(each, **change) for each in conventions for change in changes]
            with numpy.errstate(all="ignore"):
                misfits = numpy.array([misfit(_in_ours(few, each)) for each in conventions])
            least = misfits.min(initial=PART, where=~numpy.isnan(misfits))
            most = min(max(FACTOR * least, small), PART)
            best = numpy.argsort(misfits, kind="stable")[:MOST_PARTIAL]
            conventions = [conventions[i] for i in best if misfits[i] <= most]
    conventions.sort(key=lambda each: each.changes)
    for convention in conventions[:MOST_TRIED]:
        # a velocity of the centre of mass that is almost 0 fits too much
        if convention != OURS and not (convention.of_cm and convention.length != "m"):
            yield convention.words("qw" in own), partial(_in_ours, convention=convention)


def _choices(rows: Rows, name: str, choices: Iterable[Any]) -> Iterable[Any]:
    """Return the choices of a property; only whole numbers count rows, only a start tells hands."""
    if name == "hand" and rows.assumed.start == "other":
        return ["right"]
    steps = numpy.diff(rows.columns["t"])
    whole = (abs(steps - numpy.rint(steps)) < 1e-9 * steps).all() and steps.min() >= 1
    return [each for each in choices if name != "time" or whole or not each.startswith("rows")]


def _in_ours(rows: Rows, convention: Convention) -> Rows:
    own = rows.assumed.columns.required
    conversion = convert if "qw" in own else _convert_vectors if "kx" in own else _convert_euler
    return rows.changed(conversion(rows.columns, convention, rows.body))


def _pace(rows: Rows) -> float:
    """Return by how much |omega| misses the turning from row to row, as a part of it."""
    q, w = unit(stacked(rows.columns, QUATERNION)), stacked(rows.columns, OMEGA)
    turned = 2 * numpy.arccos(numpy.minimum(abs((q[:, 1:] * q[:, :-1]).sum(axis=0)), 1.0))
    angle = numpy.sqrt((w[:, 1:] ** 2).sum(axis=0)) * numpy.diff(rows.t)
    short = abs((angle + math.pi) % (2 * math.pi) - math.pi)
    return float(numpy.median(abs(turned - short) / angle)) if angle.max() < 6.28 else math.inf


def _attitude(rows: Rows) -> float:
    """Return by how much free motions from both ends of an interval miss each other half way.

    It is a part of the change of the axis, which rotates about L at |L|/I1.
    """
    first = numpy.unique(numpy.linspace(0, len(rows.t) - 2, INTERVALS).astype(int))
    last, half = first + 1, numpy.diff(rows.t)[first] / 2
    k, rate = rows.motion.k, rows.motion.L / rows.body.I1
    there = _rotated(_rotation(rate[:, first], half), k[:, first])
    back = _rotated(_rotation(rate[:, last], -half), k[:, last])
    known = slice(0 if rows.assumed.columns.azimuth else 2, 3)
    missed, moved = (there - back)[known].ravel(), (k[:, last] - k[:, first])[known].ravel()
    return float(numpy.divide(_rms(missed), _rms(moved)))  # constant rows move by 0


def _rotation(rate: Array, t: Array) -> Array:
    """Return the quaternions of rotations at angular velocities (3, n) for times (n,)."""
    size = numpy.sqrt((rate**2).sum(axis=0))
    sine = numpy.sin(size * t / 2) / numpy.where(size == 0, 1.0, size)
    return numpy.array([numpy.cos(size * t / 2), *(sine * rate)])


def _drift(rows: Rows) -> float:
    """Return the largest change of Jellett's integral over its size."""
    values = jellett(rows.q)
    return float(numpy.ptp(values) / abs(values[0]))


def _hand(rows: Rows) -> float:
    """Return 1 if Jellett's integral has another sign than at the scene's own start, else 0.

    A mirrored motion obeys the same laws, and only the start tells the hand of the world.
    """
    start = InitialState.in_si(rows.assumed.scene, Arithmetic(numpy, float))
    return float(jellett(start.motion(numpy)) * jellett(rows.q)[0] < 0)


def _rms(values: Array) -> float:
    return float(numpy.sqrt((values**2).mean()))


BOTH = (False, True)
Law: TypeAlias = tuple[str, Mapping[str, Iterable[Any]], Callable[[Rows], float], float]
# The columns that a law needs, the choices that it restricts, its misfit, and a small misfit. The
# lowest point has no vertical velocity, relative to R omega, and no height, relative to R. A
# horizontal velocity is restricted by no law.
LAWS: tuple[Law, ...] = (
    ("qw", {"time": TIME, "angle": ANGLE}, _pace, PART),
    ("qw", {"axis": TO_AXIS, "order": ("scalar first", "scalar last"),
            **dict.fromkeys(("inverse", "in_body", "opposite"), BOTH)}, _attitude, ROUGH),
    ("qw", {"up": UP}, _drift, SMALL),
    ("qw vcz", {"length": LENGTH, "point": ("cm", "centre", "contact"), "velocity_in_body": BOTH},
     lambda rows: _rms(rows.contact_velocity[2] / rows.units["v"]), SMALL),
    ("qw z", {"length": LENGTH, "place": ("cm", "centre")},
     lambda rows: _rms(rows.height / rows.body.R), SMALL),
    ("kx", {"time": TIME, "momentum": UNIT_OF_L}, _attitude, ROUGH),
    ("kx", {"up": ("z", "y", "x"), "axis": ("z", "-z")}, _drift, SMALL),
    ("theta", {"time": TIME, "angle": ANGLE, "degrees": BOTH}, _attitude, ROUGH),
    ("omega_3", {"of_psi": BOTH}, _attitude, ROUGH),
    ("t", {"hand": ("right", "left")}, _hand, SMALL),
    ("kx vx", {"length": LENGTH, "of_cm": BOTH}, lambda rows: 0.0, SMALL),
    ("nu_x", {"length": LENGTH}, lambda rows: 0.0, SMALL),
    ("nu_x phi", {"inertial": BOTH}, lambda rows: 0.0, SMALL),
)  # fmt: skip


# ---- engines -----------------------------------------------------------------------------------

OF_CENTRE = Convention(point="centre", place="centre")
ENGINES = {
    "mujoco": replace(OF_CENTRE, in_body=True),
    "drake": OF_CENTRE,
    **dict.fromkeys(("dart", "exudyn", "ode"), OURS),
    **dict.fromkeys(
        ("bullet", "cannon-es", "jolt", "newton", "rapier"), Convention(order="scalar last")
    ),
}
# Each array by its name: our names of its components, and the columns that hold them elsewhere.
ARRAYS = {
    "quaternion": (QUATERNION, QUATERNION),
    "velocity": (VELOCITY, ("vx", "vy", "vz")),
    "angular_velocity": (OMEGA, OMEGA),
    "position": (POSITION, POSITION),
}
MUJOCO = {"qpos": ((*POSITION, *QUATERNION), ()), "qvel": ((*VELOCITY, *OMEGA), ())}


def convention_of(engine: str) -> Convention:
    """Return the convention of an engine's arrays.

    ``engine`` is a name of ``ENGINES``; ":cm" or ":centre" behind it says that the origin of the
    body is the centre of mass, or the centre of the sphere.

    Raises ``InputError``: there is no such engine.
    """
    name, _, origin = engine.partition(":")
    origins = [f"{each}:{point}" for each in ENGINES for point in ("centre", "cm")]
    require_name("--from", engine, [*ENGINES, *origins])
    return replace(ENGINES[name], point=origin, place=origin) if origin else ENGINES[name]


def engine_table(source: object, engine: str, rename: Mapping[str, str]) -> Source:
    """Return an engine's arrays as rigid-body columns, still in the engine's convention.

    Raises ``InputError``: there is no such engine, or an array is absent or has another shape.
    """
    convention, table = convention_of(engine), open_table(source, rename)
    if "t" not in table.names:
        raise InputError(f"{table.where}: no array t or time among {listed(table.names)}")
    columns = table.load(["t"])
    for name, (ours, theirs) in (MUJOCO if engine.startswith("mujoco") else ARRAYS).items():
        array = _array(table, name, theirs, len(ours))
        if array is not None:
            # letters say the order of a quaternion, whatever the engine's
            if theirs == QUATERNION and {*theirs} <= {*table.names}:
                array = numpy.roll(array, -1 if convention.order == "scalar last" else 0, axis=0)
            columns |= dict(zip(ours, array, strict=True))
        elif name != "position":
            raise InputError(
                f"{table.where}: no {name} among {listed(table.names)}; expected an array of "
                f"{len(ours)} columns, or columns {' '.join(theirs) or f'{name}0 ...'}"
            )
    return Source(table.where, columns, {}, columns.__getitem__)


def _array(table: Source, name: str, theirs: tuple[str, ...], width: int) -> Array | None:
    """Return an array, components first, from numbered or named columns or from a matrix."""
    for names in (*([f"{name}{mark}{i}" for i in range(width)] for mark in ("", "_")), theirs):
        if names and {*names} <= {*table.names}:
            return numpy.array([*table.load(names).values()])
    if name not in table.names:
        return None
    matrix = numpy.asarray(table.texts([name])[name])
    if matrix.shape[1:] != (width,) or matrix.dtype.kind not in "fiu":
        raise InputError(
            f"{table.where}: {name}: got shape {matrix.shape} of {matrix.dtype}, expected numbers "
            f"in {width} columns"
        )
    return matrix.T.astype(float)
