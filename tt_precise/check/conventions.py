"""Conventions of columns, their conversion to ours, and the search for one that fits.

A ``Convention`` has one choice for each property in which simulators differ: units, the vertical
and the handedness of the world, the symmetry axis of the body, order and direction of the
quaternion, frame of the angular velocity, point and frame of the velocity, point of the position.

``candidates`` narrows the choices down in three stages, each by a law that holds for every contact
force: the attitude follows the free motion from row to row, Jellett's integral is constant, and
the contact point stays on the table. The checks decide on the candidates.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import OMEGA, POSITION, QUATERNION, VELOCITY, Columns, stacked, unit
from tt_precise.check.rows import Rows
from tt_precise.mechanics.newton import contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import axis_of, cross, dot, multiplied, rotate
from tt_precise.runtime.values import Arithmetic, Array, require_name
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
MOMENTUM = {"g mm^2/s": 1e-9, "kg mm^2/s": 1e-6, "g cm^2/s": 1e-7}
HALF = math.sqrt(0.5)
# Quaternions that rotate the upward direction to z, and z to the symmetry axis of the body.
UP = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, HALF, 0.0, 0.0), "x": (0.5, -0.5, -0.5, -0.5),
    "-z": (0.0, 1.0, 0.0, 0.0),
}  # fmt: skip
AXIS = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, -HALF, 0.0, 0.0), "x": (HALF, 0.0, HALF, 0.0),
    "-z": (0.0, 1.0, 0.0, 0.0), "-y": (HALF, HALF, 0.0, 0.0), "-x": (HALF, 0.0, -HALF, 0.0),
}  # fmt: skip
WORLDS = {
    "z-up": ("z", "right"), "y-up": ("y", "right"),
    "left-handed-z-up": ("z", "left"), "left-handed-y-up": ("y", "left"),
}  # fmt: skip
AXES = ("z", "y", "x")
MIRROR = numpy.array([[1.0], [-1.0], [1.0]])  # reflects polar vectors in y; axial ones by -MIRROR

LOOKED_AT, INTERVALS = 250, 24  # rows of the search, and intervals of the first stage
# The free motion, which neglects the torque of the weight, misses the attitude by a part of the
# turning that is small for a fast top; another convention misses by a part of 1.
ROUGH, PART = 0.02, 0.25
# Misfits of Jellett's integral and of the contact point that any convention may have. Beyond them
# the least one of all conventions is a measure of an engine's own errors.
SMALL, FACTOR = 1e-4, 10.0
CHOICES: Mapping[str, Sequence[Any]] = {
    "length": (*LENGTH,), "point": ("cm", "centre", "contact"), "place": ("cm", "centre"),
    "up": (*UP,), "axis": AXES, "order": ("scalar first", "scalar last"),
    **dict.fromkeys(("inverse", "in_body", "opposite", "velocity_in_body"), (False, True)),
}  # fmt: skip
MOST_PARTIAL, MOST_TRIED = 32, 24  # candidates of the first stage, and of the last one


@dataclass(frozen=True)
class Convention:
    """One choice for each property; by default those of this package."""

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

    def words(self) -> str:
        """Describe the differences from ours, with the options that read the file."""
        parts = [time_in_words(self.time)] * (self.time != "s")
        if (self.up, self.hand) != ("z", "right"):
            left = "left-handed, " * (self.hand == "left")
            names = [name for name, world in WORLDS.items() if world == (self.up, self.hand)]
            option = "".join(f": add --world {name}" for name in names)
            parts.append(f"the world is {left}{self.up} up{option}")
        if self.axis != "z":
            option = f": add --axis {self.axis}" * (self.axis in AXES)
            parts.append(f"the body's symmetry axis is {self.axis}{option}")
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
}
NAMES = {
    "centre": "the sphere's centre", "contact": "the contact point",
    "degrees": "degrees per second", "revolutions": "revolutions per second",
}  # fmt: skip
OURS = Convention()


def time_in_words(unit: str) -> str:
    """Return words for the unit of the times."""
    return f"t counts {unit}" if unit.startswith("rows") else f"the time is in {unit}"


@numpy.errstate(all="ignore")  # rows that blew up are left to the checks
def convert(columns: Columns, convention: Convention, body: Parameters) -> dict[str, Array]:
    """Convert rigid-body columns from ``convention`` to ours; quaternions keep their length."""
    up, axis, length = UP[convention.up], AXIS[convention.axis], LENGTH[convention.length]
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


# ---- the search --------------------------------------------------------------------------------


class Candidate(NamedTuple):
    """A convention in words, and the rows as they would be without it."""

    text: str
    change: Callable[[Rows], Rows]


def candidates(rows: Rows) -> Iterator[Candidate]:
    """Yield the conventions that the three stages do not exclude, the fewest changes first."""
    few = rows.part(slice(0, LOOKED_AT))
    if len(few.t) < 3:
        return
    with numpy.errstate(all="ignore"):
        if rows.assumed.columns.name != "rigid body":
            yield from _of_columns(few)
            return
        conventions = _by_contact(few, _by_jellett(few, _by_attitude(few)))
    for convention in conventions:
        yield Candidate(convention.words(), partial(_in_ours, convention=convention))


def _in_ours(rows: Rows, convention: Convention) -> Rows:
    return rows.changed(convert(rows.columns, convention, rows.body))


def _ends(t: Array) -> tuple[Array, Array]:
    """Return the first and the last rows of the intervals of the first stage."""
    first = numpy.unique(numpy.linspace(0, len(t) - 2, INTERVALS).astype(int))
    return first, first + 1


def _variants(base: Iterable[Convention], *names: str) -> list[Convention]:
    """Return conventions with every combination of choices of the properties ``names``."""
    values = list(itertools.product(*(CHOICES[name] for name in names)))
    return [replace(each, **dict(zip(names, v, strict=True))) for each in base for v in values]


def _by_attitude(rows: Rows) -> list[Convention]:
    """Return conventions in which the free motions from both ends of an interval meet half way."""
    first, last = _ends(rows.t)
    units = [(time, angle) for time in _units_of_time(rows) for angle in ANGLE]
    scale = numpy.array([TIME[time] * ANGLE[angle] for time, angle in units])[:, None]
    half = scale * numpy.diff(rows.columns["t"])[first] / 2
    speed = numpy.sqrt((stacked(rows.columns, OMEGA)[:, first] ** 2).sum(axis=0))
    turned = (2 * half * speed).max(axis=1)
    conventions, misfits = [], []
    for convention in _variants([OURS], "axis", "order", "inverse", "in_body", "opposite"):
        columns = convert(rows.columns, convention, rows.body)
        q, w = unit(stacked(columns, QUATERNION)), stacked(columns, OMEGA)
        moved = _rms(_angle(q[:, last], q[:, first]))
        there = _free(rows.body, q[:, first], w[:, first], half)
        back = _free(rows.body, q[:, last], w[:, last], -half)
        misses = _rms(_angle(there, back)) / moved
        conventions += [replace(convention, time=time, angle=angle) for time, angle in units]
        misfits += numpy.where((misses < PART) & (turned < 2 * math.pi), misses, math.inf).tolist()
    return _least(conventions, misfits, ROUGH)[:MOST_PARTIAL]


def _free(body: Parameters, q: Array, w: Array, t: Array) -> Array:
    """Return the orientations after each of the times (units, n) of free motion.

    A symmetric body rotates about L at |L|/I1, and about its axis at omega_3 (1 - I3/I1).
    """
    k = axis_of(*q)
    spin = (w * numpy.array(k)).sum(axis=0)
    about_L = _rotation(w + (body.I3 / body.I1 - 1) * spin * numpy.array(k), t)
    about_axis = _rotation((1 - body.I3 / body.I1) * spin * numpy.array([[0.0], [0.0], [1.0]]), t)
    after = multiplied(multiplied(tuple(about_L), tuple(q)), tuple(about_axis))
    return numpy.array(numpy.broadcast_arrays(*after))


def _rotation(rate: Array, t: Array) -> Array:
    """Return the quaternions of rotations at angular velocities (3, n) for times (..., n)."""
    size = numpy.sqrt((rate**2).sum(axis=0))
    sine = numpy.sin(size * t / 2) / numpy.where(size == 0, 1.0, size)
    return numpy.array([numpy.cos(size * t / 2), *(sine * x for x in rate)])


def _by_jellett(rows: Rows, conventions: Sequence[Convention]) -> list[Convention]:
    """Return verticals and ends of the axis for which Jellett's integral is constant."""
    ends = [replace(each, axis=end + each.axis) for each in conventions for end in ("", "-")]
    worlds = _variants(ends, "up")
    return _least(worlds, [_jellett_drift(_in_ours(rows, each)) for each in worlds])


def _by_contact(rows: Rows, conventions: Sequence[Convention]) -> list[Convention]:
    """Return points and units for which the contact point stays on the table, in one hand."""
    groups: list[tuple[str, ...]] = []
    if VELOCITY[0] in rows.columns:
        groups.append(("length", "point", "velocity_in_body"))
    if POSITION[2] in rows.columns:
        groups.append(("place",) if groups else ("length", "place"))
    for names in groups:
        every = _variants(conventions, *names)
        misfits = [_off_table(_in_ours(rows, each), "place" in names) for each in every]
        conventions = _least(every, misfits)
    sign = _sign_of_jellett(rows)
    mirrored = [each for each in conventions if sign * _jellett(_in_ours(rows, each))[0] < 0]
    conventions = [replace(each, hand="left") if each in mirrored else each for each in conventions]
    ordered = sorted((each for each in conventions if each != OURS), key=lambda each: each.changes)
    return ordered[:MOST_TRIED]


def _sign_of_jellett(rows: Rows) -> float:
    """Return the sign of Jellett's integral at the scene's own start, 0 for another start.

    A mirrored motion obeys the same laws, and only the start tells the hand of the world.
    """
    if rows.assumed.start == "other":
        return 0.0
    start = InitialState.in_si(rows.assumed.scene, Arithmetic(numpy, float)).vectors
    return float(numpy.sign(-dot(start.L, contact_arm(rows.body, start.k))))


def _jellett(rows: Rows) -> Array:
    """Return Jellett's integral in each row."""
    return -(rows.motion.L * numpy.array(contact_arm(rows.body, tuple(rows.motion.k)))).sum(axis=0)


def _jellett_drift(rows: Rows) -> float:
    """Return the largest change of Jellett's integral over its size."""
    jellett = _jellett(rows)
    return float(numpy.ptp(jellett) / abs(jellett[0]))


def _off_table(rows: Rows, height: bool) -> float:
    """Return the height of the lowest point over R, or its vertical velocity over R omega."""
    off = rows.height / rows.body.R if height else rows.contact_velocity[2] / rows.units["v"]
    return float(_rms(off))


def _least(
    conventions: Sequence[Convention], misfits: Sequence[float], small: float = SMALL
) -> list[Convention]:
    """Return the conventions whose misfit is small, or near the least one, the best first."""
    pairs = [pair for pair in zip(misfits, conventions, strict=True) if pair[0] < math.inf]
    pairs.sort(key=lambda pair: pair[0])
    return [each for misfit, each in pairs if misfit <= max(FACTOR * pairs[0][0], small)]


def _units_of_time(rows: Rows) -> list[str]:
    """Return the units in which times may be: only whole numbers count rows."""
    steps = numpy.diff(rows.columns["t"])
    whole = bool((abs(steps - numpy.rint(steps)) < 1e-9 * steps).all() and steps.min() >= 1)
    return [unit for unit in TIME if whole or not unit.startswith("rows")]


def _angle(q: Array, other: Array) -> Array:
    """Return the angles (rad) between unit quaternions."""
    cosine = abs((q * other).sum(axis=0))
    return 2 * numpy.arccos(numpy.minimum(cosine, 1.0))


def _rms(values: Array) -> Any:
    return numpy.sqrt((values**2).mean(axis=-1))


# ---- vectors and Euler angles ------------------------------------------------------------------

RATES = "theta_dot phi_dot omega_3 psi_dot"
UNITS: tuple[tuple[str, str, Mapping[str, float]], ...] = (
    ("the angular momentum is in {}", "Lx Ly Lz", MOMENTUM),
    ("the velocities are in {}/s", "vx vy nu_x nu_y", LENGTH),
    ("the angular velocities are in {}", RATES, ANGLE),
    ("the angles are in {}", "theta phi psi", {"degrees": ANGLE["degrees"]}),
)
# What some columns hold instead of ours.
HELD = {
    "the world is y up": "ky=-kz kz=ky Ly=-Lz Lz=Ly",
    "the world is x up": "kx=ky ky=kz kz=kx Lx=Ly Ly=Lz Lz=Lx",
    "the axis points to the other end of the body": "kx=-kx ky=-ky kz=-kz",
    "Lx, Ly, Lz have the other sign": "Lx=-Lx Ly=-Ly Lz=-Lz",
    "vx, vy have the other sign": "vx=-vx vy=-vy",
    **{f"{v}x, {v}y hold {v}y, {v}x": f"{v}x={v}y {v}y={v}x" for v in "kLv"},
    **{f"{n} has the other sign": f"{n}=-{n}"
       for n in f"kx ky kz Lx Ly Lz vx vy {RATES} nu_x nu_y".split()},
}  # fmt: skip
MIRRORED = {
    "the world is left-handed, or the top spins the other way": "ky=-ky vy=-vy Lx=-Lx Lz=-Lz",
    "the top spins the other way, or the world is left-handed": (
        "phi_dot=-phi_dot phi=-phi omega_3=-omega_3 psi_dot=-psi_dot nu_y=-nu_y"
    ),
}
ColumnChange = tuple[str, Callable[[Rows], Mapping[str, Array]]]


def _of_columns(few: Rows) -> Iterator[Candidate]:
    """Yield the changes of columns, one or two at once, that a few rows do not exclude."""
    groups = [group for group in _groups(few) if group]
    chosen = [(change,) for group in groups for change in group]
    for pair in itertools.combinations(groups, 2):
        chosen += itertools.product(*pair)  # type: ignore[arg-type]
    tried, sign = 0, _sign_of_jellett(few)
    for changes in chosen:

        def change(rows: Rows, changes: Sequence[ColumnChange] = changes) -> Rows:
            for _, columns in changes:
                rows = rows.changed(columns(rows))
            return rows

        if tried < MOST_TRIED and _plausible(change(few), sign):
            tried += 1
            yield Candidate("; ".join(text for text, _ in changes), change)


def _groups(few: Rows) -> Iterator[list[ColumnChange]]:
    """Yield the changes of the columns of a file, by groups of which at most one holds."""
    present = {*few.columns}
    yield [(time_in_words(unit), _scaled("t", TIME[unit])) for unit in _units_of_time(few)[1:]]
    for text, names, units in UNITS:
        if present & {*names.split()}:
            yield [(text.format(n), _scaled(names, u)) for n, u in units.items() if u != 1]
    swaps = HELD | (MIRRORED if few.assumed.start == "scene" else {})
    yield [(text, _exchanged(by)) for text, by in swaps.items() if by.partition("=")[0] in present]
    for text, needed, change in DERIVED:
        if {*needed.split()} <= present:
            yield [(text, change)]


def _scaled(names: str, factor: float) -> Callable[[Rows], Mapping[str, Array]]:
    return lambda rows: {n: factor * rows.columns[n] for n in names.split() if n in rows.columns}


def _exchanged(words: str) -> Callable[[Rows], Mapping[str, Array]]:
    pairs = [word.split("=") for word in words.split()]
    terms = [(ours, theirs.lstrip("-"), -1.0 if "-" in theirs else 1.0) for ours, theirs in pairs]
    return lambda rows: {
        ours: sign * rows.columns[theirs] for ours, theirs, sign in terms if ours in rows.columns
    }


def _of_centre_of_mass(rows: Rows) -> Mapping[str, Array]:
    x, y, _ = cross(tuple(rows.omega), contact_arm(rows.body, tuple(rows.motion.k)))
    return {"vx": rows.columns["vx"] + x, "vy": rows.columns["vy"] + y}


def _inertial(rows: Rows) -> Mapping[str, Array]:
    phi, x, y = (rows.columns[name] for name in ("phi", "nu_x", "nu_y"))
    cosine, sine = numpy.cos(phi), numpy.sin(phi)
    return {"nu_x": cosine * x + sine * y, "nu_y": cosine * y - sine * x}


def _spin(rows: Rows) -> Mapping[str, Array]:
    psi_dot, phi_dot, theta = (rows.columns[name] for name in ("omega_3", "phi_dot", "theta"))
    return {"omega_3": psi_dot + phi_dot * numpy.cos(theta)}


# What some columns hold that follows from the state: in words, the columns, and the change.
DERIVED = (
    ("the velocity is that of the centre of mass", "vx", _of_centre_of_mass),
    ("nu_x, nu_y are inertial components: rotate them by -phi", "phi nu_x", _inertial),
    ("omega_3 holds psi_dot: omega_3 = psi_dot + phi_dot cos theta", "omega_3", _spin),
)


def _plausible(rows: Rows, sign: float) -> bool:
    """Test that the axis follows the free motion, and that Jellett's integral is constant."""
    if not (_jellett_drift(rows) < PART and sign * _jellett(rows)[0] >= 0):
        return False
    first, last = _ends(rows.t)
    half = numpy.diff(rows.t)[first] / 2
    k, rate = rows.motion.k, rows.motion.L / rows.body.I1
    there = _rotated(_rotation(rate[:, first], half), k[:, first])
    back = _rotated(_rotation(rate[:, last], -half), k[:, last])
    components = slice(0 if rows.assumed.columns.azimuth else 2, 3)
    changes = (there - back)[components].ravel(), (k[:, last] - k[:, first])[components].ravel()
    return bool(_rms(changes[0]) < PART * _rms(changes[1]))
