"""The search for the conventions of a file whose rows do not obey the equations as written.

A ``Convention`` has one choice for each group: units, the vertical, the handedness of the world,
the body's axis, order and direction of the quaternion, frame of omega, point and frame of the
velocity, point of the position. ``search`` narrows the choices down in stages: the attitude by the
free motion, from both rows of an interval to its middle; the geometry by height and lift; then all
residuals, for the conventions with the fewest changes first. A left-handed file obeys the same
equations in its own cross product. Therefore ``search`` reads such a file as right-handed, and
compares the sign of Jellett's integral with the scene's.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy

from tt_precise.check.force_free import Misfit, Rounding, misfits, norm
from tt_precise.check.force_free_flow import (
    FARTHEST,
    NO_TERMS,
    RigidMotion,
    Terms,
    axis_of,
    jellett_of,
    lift_of,
)
from tt_precise.mechanics.newton import angular_momentum, contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Quaternion, Vector, cross, multiplied, rotate
from tt_precise.runtime.values import Array, require_name

HALF = math.sqrt(0.5)
RATES = (24, 30, 50, 60, 90, 100, 120, 144, 240, 500, 1000)
TIME = {
    "s": 1.0, "ms": 1e-3, "microseconds": 1e-6, "ns": 1e-9, "minutes": 60.0,
    **{f"rows at {rate} Hz": 1 / rate for rate in RATES},
    **{f"1/{rate} s": 1 / rate for rate in RATES if rate != 1000},
}  # fmt: skip
LENGTH = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inches": 0.0254}
ANGLE = {"rad": 1.0, "degrees": math.pi / 180, "revolutions per minute": math.pi / 30}
ANGLE["revolutions"] = 2 * math.pi
LINEAR_MOMENTUM = {"": 1.0, "g mm^2/s": 1e-9, "kg mm^2/s": 1e-6, "g cm^2/s": 1e-7}
PER_SECOND = {name + " per second" * ("per" not in name): size for name, size in ANGLE.items()}
# What may be in another unit, and the columns that are then.
UNITS = (
    ("the velocities are in", {f"{name}/s": size for name, size in LENGTH.items()},
     "vx vy nu_x nu_y"),
    ("lengths are in", LENGTH, "vcx vcy vcz x y z"),
    ("the angular momentum is in", LINEAR_MOMENTUM, "Lx Ly Lz"),
    ("the angular velocities are in", PER_SECOND, "theta_dot phi_dot omega_3 psi_dot wx wy wz"),
    ("theta is in", {"degrees": ANGLE["degrees"]}, "theta"),
)  # fmt: skip
# Quaternions that turn the direction that is up to z, and z to the body's axis.
UP: dict[str, Quaternion] = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, HALF, 0.0, 0.0), "x": (0.5, -0.5, -0.5, -0.5),
    "-z": (0.0, 1.0, 0.0, 0.0),
}  # fmt: skip
AXIS: dict[str, Quaternion] = {
    "z": (1.0, 0.0, 0.0, 0.0), "y": (HALF, -HALF, 0.0, 0.0), "x": (HALF, 0.0, HALF, 0.0),
    "-z": (0.0, 1.0, 0.0, 0.0), "-y": (HALF, HALF, 0.0, 0.0), "-x": (HALF, 0.0, -HALF, 0.0),
}  # fmt: skip
# The verticals and hands of worlds that have a name, and the ends of the body that may be its axis.
WORLDS = {
    "z-up": ("z", "right"),
    "y-up": ("y", "right"),
    "left-handed-z-up": ("z", "left"),
    "left-handed-y-up": ("y", "left"),
}
AXES = ("z", "y", "x")
QUATERNION, OMEGA = ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz")
POLAR = (("vcx", "vcy", "vcz"), ("x", "y", "z"))

# At half and at double of each constant below (but ``LIMITS``) the same is named of the files of
# seven engines, of two with a wrong column, of five random conventions and of two wrong bodies.
# Rows that are looked at, intervals of the first stage, candidates of it, and those judged in full.
LOOKED_AT, INTERVALS, PARTIALS, TRIES = 250, 24, 32, 24
# What the first stage accepts: rad of misfit, and the part of the turning.
ROUGH, PART = 0.3, 0.25
# Limits of what is beyond the bounds: of integrators that are right, and of engines with soft
# contacts and low orders (measured on MuJoCo, Bullet, Exudyn, Drake and DART).
LIMITS = {
    "spin": 1e-2, "axis": 1e-2, "position": 1e-2, "torque": 1e-4, "jellett": 1e-6, "lift": 1e-6,
    "height": 1e-6,
}  # fmt: skip
ENGINES = {
    "spin": 0.3, "axis": 0.3, "position": 0.3, "torque": 0.1, "jellett": 1e-3, "lift": 0.02,
    "height": 0.02,
}  # fmt: skip
FINEST = 1e-6  # Part of a limit that is nothing.
NEARER = 0.1  # Part of a failure that may be left with a cause: engines have errors of their own.
# Part of what no velocity leaves of the torque that one in another convention may leave: a velocity
# in the next unit leaves 1 - 1/2.54.
SEEN = 0.5
RESOLVED = 1.0  # Bound of the axis (rad) and the torque (m g R alpha) that says nothing.


@dataclass(frozen=True)
class Convention:
    """One choice for each group; ours by default."""

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
        """Return the convention in the world with this name, and with this axis of the body.

        Raises ``InputError``: there is none.
        """
        require_name("world", world, WORLDS)
        require_name("axis", axis, AXES)
        up, hand = WORLDS[world]
        return replace(self, up=up, hand=hand, axis=axis)

    @property
    def changes(self) -> int:
        """The number of groups of columns that differ from ours."""
        differ = sum(getattr(self, one.name) != one.default for one in fields(self))
        # Unity's left-handed y-up world is one change, y and z exchanged.
        return differ - (self.hand == "left" and self.up == "y") + self.opposite

    def words(self) -> str:
        """Name the differences from ours, and the option that reads the file."""
        said = [time_in_words(self.time)] * (self.time != "s")
        if self.up != "z" or self.hand == "left":
            hand = "left-handed, " if self.hand == "left" else ""
            name = f"{'left-handed-' if self.hand == 'left' else ''}{self.up}-up"
            option = f": add --world {name}" if name in WORLDS else ""
            said.append(f"the world is {hand}{self.up} up{option}")
        if self.axis == "-z":
            said.append("the body's axis points from the other end")
        elif self.axis != "z":
            option = f": add --axis {self.axis}" if self.axis in AXES else ""
            said.append(f"the body's symmetry axis is {self.axis}{option}")
        for group, text in WORDS.items():
            choice = getattr(self, group)
            if choice != getattr(OURS, group):
                said.append(text.format(NAMES.get(choice, choice)))
        return "; ".join(said)


def time_in_words(unit: str) -> str:
    """Say in which unit times are."""
    return f"t counts {unit}" if unit.startswith("rows") else f"the time is in {unit}"


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
# Choices of each group that show in a single row.
CHOICES: tuple[tuple[dict[str, Any], ...], ...] = (
    ({"order": "scalar last"},),
    ({"inverse": True},),
    ({"in_body": True},),
    ({"opposite": True},),
    tuple({"angle": name} for name in ANGLE if name != "rad"),
    tuple({"length": name} for name in LENGTH if name != "m"),
    tuple(
        {"up": up, "hand": hand}
        for hand, up in itertools.product(("right", "left"), UP)
        if (hand, up) != ("right", "z")
    ),
    tuple({"axis": name} for name in AXIS if name != "z"),
    ({"point": "centre"}, {"point": "contact"}),
    ({"velocity_in_body": True},),
)


def alternatives() -> Iterator[Convention]:
    """Conventions that differ from ours in one group, then conventions that differ in two."""
    for first in itertools.chain(*CHOICES):
        yield Convention(**first)
    for one, other in itertools.combinations(CHOICES, 2):
        for first, second in itertools.product(one, other):
            yield Convention(**first, **second)


class Given(NamedTuple):
    """Rigid-body columns: t (n,), q (4, n), omega, v or None, x or None (3, n); SI where ours.

    Vectors have L in the place of omega and v_A (with its vertical part) in that of v, as
    ``vectors`` says; then q is some attitude with their axis.
    """

    t: Array
    q: Array
    w: Array
    v: Array | None
    x: Array | None = None
    vectors: bool = False

    @classmethod
    def of_columns(cls, columns: Mapping[str, Array]) -> Given:
        """Return rigid-body columns; v or x is None where it is not complete among them."""
        q, w = (numpy.array([columns[name] for name in names]) for names in (QUATERNION, OMEGA))
        v, x = (
            numpy.array([columns[name] for name in names]) if {*names} <= columns.keys() else None
            for names in POLAR
        )
        return cls(columns["t"], q, w, v, x)

    @property
    def columns(self) -> dict[str, Array]:
        """Rigid-body columns by name."""
        groups = zip((QUATERNION, OMEGA, *POLAR), (self.q, self.w, self.v, self.x), strict=True)
        known = [zip(names, values, strict=True) for names, values in groups if values is not None]
        return {"t": self.t, **dict(itertools.chain(*known))}

    @property
    def of_unit_length(self) -> Given:
        """Divide the quaternions by their lengths."""
        return self._replace(q=self.q / norm(self.q))

    def part(self, rows: Array | slice) -> Given:
        """Return some of the rows."""
        v, x = (None if one is None else one[:, rows] for one in (self.v, self.x))
        return Given(self.t[rows], self.q[:, rows], self.w[:, rows], v, x, self.vectors)

    def rows(self, body: Parameters) -> RigidMotion:
        """Return the motion of ``body``; where v is not known, as if the top rolled."""
        k = axis_of(self.q)
        a = contact_arm(body, k)
        L = self.w if self.vectors else numpy.array(angular_momentum(body, k, _vector(self.w)))
        v = self.v
        if v is None or self.vectors:
            w = inverse_inertia(body, k, _vector(L))
            v = (0.0 if v is None else v) - numpy.array(cross(w, a))
        return RigidMotion(self.t, self.q, L, v, self.x)


def rotated(q: Quaternion | Array, vector: Array) -> Array:
    """Return vectors (3, ...) after the rotations by unit quaternions."""
    return numpy.array(rotate(tuple(q), tuple(vector)))


def _times(p: Quaternion | Array, q: Quaternion | Array) -> Array:
    return numpy.array(numpy.broadcast_arrays(*multiplied(tuple(p), tuple(q))))


def _conjugate(q: Array) -> Array:
    return q * numpy.array([1.0, -1.0, -1.0, -1.0]).reshape(4, *(1,) * (q.ndim - 1))


def attitude(q: Array, convention: Convention) -> Array:
    """Return quaternions with their scalar first, from the body to the inertial frame."""
    q = q if convention.order == "scalar first" else numpy.roll(q, 1, axis=0)
    return _conjugate(q) if convention.inverse else q


@numpy.errstate(all="ignore")  # rows that blew up are left to the checks
def convert(given: Given, convention: Convention, body: Parameters) -> Given:
    """Convert the columns of a file from ``convention`` to ours.

    Quaternions may have any length, and keep it; one of length 0 turns everything to 0.
    """
    up, axis, length = UP[convention.up], AXIS[convention.axis], LENGTH[convention.length]
    q = attitude(given.q, convention)
    size = (q * q).sum(axis=0)
    size[size == 0] = 1.0
    w = given.w * ANGLE[convention.angle] * (-1 if convention.opposite else 1)
    w = rotated(up, rotated(q, w) / size if convention.in_body else w)
    v, x = given.v, given.x
    if v is not None:
        v = length * rotated(up, rotated(q, v) / size if convention.velocity_in_body else v)
    if x is not None:
        x = length * rotated(up, x)
    q = _times(_times(up, q), axis)
    if convention.hand == "left":
        mirror = numpy.array([[1.0], [-1.0], [1.0]])
        w, q = -mirror * w, q * numpy.array([[1.0], [-1.0], [1.0], [-1.0]])
        v, x = (one if one is None else one * mirror for one in (v, x))
    k = numpy.array(axis_of(q)) / size
    centre = body.R * body.alpha * k
    if v is not None and convention.point != "cm":
        arm = contact_arm(body, _vector(k)) if convention.point == "contact" else _vector(centre)
        v = v - numpy.array(cross(_vector(w), arm))
    if x is not None and convention.place == "centre":
        x = x - centre
    return Given(TIME[convention.time] * given.t, q, w, v, x)


def _vector(components: Array | Vector) -> Vector:
    return (components[0], components[1], components[2])


class Fit(NamedTuple):
    """Residuals of rows under the laws that need no force: the excess over the bounds of each.

    ``open`` says that too little is resolved, ``axis_open`` that of the motion of the axis;
    ``jellett`` is the integral at the start.
    """

    parts: dict[str, float]
    open: bool
    axis_open: bool
    jellett: float

    def failing(self, limits: Mapping[str, float]) -> dict[str, float]:
        """Return the parts above their limits."""
        return {n: value for n, value in self.parts.items() if not value <= limits[n]}

    @property
    def passes(self) -> bool:
        """True if every residual is resolved and within its limit."""
        return not self.open and not self.failing(LIMITS)

    @property
    def size(self) -> float:
        """The largest residual in units of engines' errors; infinite where nothing is resolved."""
        return math.inf if self.open else self.size_of(())

    def size_of(self, without: Collection[str]) -> float:
        """The largest part but for some, in units of what engines leave."""
        left = (value / ENGINES[n] for n, value in self.parts.items() if n not in without)
        return max(left, default=0.0)

    @property
    def remainder(self) -> float:
        """The geometric mean of the residuals, in units of the limits."""
        logs = [math.log(max(v / LIMITS[n], FINEST)) for n, v in self.parts.items()]
        return math.exp(sum(logs) / len(logs))


def fit(
    body: Parameters,
    given: Given,
    rounding: Mapping[str, float],
    terms: Terms = NO_TERMS,
) -> Fit:
    """Return how rigid-body rows obey the laws for every force.

    ``rounding`` has half a unit of the last place of t, q, w, v and x.
    """
    with numpy.errstate(all="ignore"):
        rows, moving = given.rows(body), given.v is not None
        k = axis_of(rows.q)
        L, count = rows.L, len(rows.t)
        u = {name: numpy.full(count, 2 * rounding.get(name, 0.0)) for name in "tqwvx"}
        inertia = max(body.I1, body.I3)
        omega = norm(L) / min(body.I1, body.I3)
        if given.vectors:
            u_L, u["w"] = u["w"], u["w"] / min(body.I1, body.I3)
            u["v"] = u["v"] + 2 * body.R * u["w"]
        else:
            u_L = inertia * u["w"] + 2 * abs(body.I3 - body.I1) * omega * u["q"]
        known = Rounding(u["t"], u["q"], u_L, u["v"], u["x"])
        found = misfits(body, rows, known, moving, terms=terms)
        parts: dict[str, float] = {}
        turning = ("axis",) if given.vectors else ("spin", "axis")
        for name in (*turning, *(("torque", "position") if moving else ())):
            if name in found:
                parts[name] = _beyond(found[name])
        jellett, kept = float(jellett_of(body, rows)[0]), found["jellett"]
        parts["jellett"] = largest(numpy.fmax(kept.summed - kept.summed_bound, 0) / abs(jellett))
        scale = body.R * omega[0]
        if moving:
            slack = u["v"] + body.R * (u["w"] + 2 * omega * u["q"])
            parts["lift"] = largest((abs(lift_of(body, rows)) - slack) / scale)
        if given.x is not None:
            off = abs(given.x[2] / body.R - (1 - body.alpha * k[2]))
            parts["height"] = largest(off - u["x"] / body.R - 2 * u["q"])
        names = ("axis", "torque") if moving else ("axis",)
        usual = [float(numpy.sort(found[name].bound)[(count - 1) // 2]) for name in names]
        resolved = [bound < RESOLVED for bound in usual]
        return Fit(parts, not all(resolved), not resolved[0], jellett)


def largest(values: Array) -> float:
    """Return the largest of values above 0, infinite where one is not finite."""
    return float(
        numpy.max(numpy.where(numpy.isfinite(values), numpy.maximum(values, 0), numpy.inf))
    )


def _beyond(one: Misfit) -> float:
    left = numpy.fmax(one.value - one.bound, one.summed - one.summed_bound)
    return float(numpy.nanmax(numpy.append(left, 0.0)))


def rotation_by(vector: Array) -> Array:
    """Return the quaternions of rotations by vectors (3, ...) of their angles (rad)."""
    size = numpy.sqrt((vector**2).sum(axis=0))
    factor = numpy.where(size > 1e-12, numpy.sin(size / 2) / numpy.maximum(size, 1e-300), 0.5)
    return numpy.concatenate((numpy.cos(size / 2)[None], factor * vector))


def _angle_of(q: Array) -> Array:
    """The angle (rad) of rotations."""
    angle: Array = 2 * numpy.arctan2(numpy.sqrt((q[1:] ** 2).sum(axis=0)), abs(q[0]))
    return angle


def units_of_time(t: Array) -> dict[str, float]:
    """Return the units (s) in which times may be: whole numbers may count rows."""
    dt = numpy.diff(t)
    counts = bool(numpy.allclose(dt, numpy.rint(dt)) and dt.min() >= 1)
    other = "1/" if counts else "rows"
    units = {name: unit for name, unit in TIME.items() if not name.startswith(other)}
    if counts and dt.max() > 1:
        del units["rows at 1000 Hz"]  # whole ms
    return units


def in_other_units(given: Mapping[str, Array]) -> Iterator[tuple[str, dict[str, Array]]]:
    """Columns in one other unit, in words and as ours."""
    found = [(time_in_words(unit), size, ["t"]) for unit, size in units_of_time(given["t"]).items()]
    for what, units, groups in UNITS:
        names = [name for name in groups.split() if name in given]
        found += [(f"{what} {unit}", size, names) for unit, size in units.items() if names]
    for text, size, names in found:
        if size != 1:
            yield text, {name: size * given[name] for name in names}


def by_attitude(given: Given, body: Parameters) -> Iterator[tuple[float, Convention]]:
    """Conventions in which the free motion from both rows of an interval meets in its middle."""
    count = len(given.t) - 1
    i = numpy.unique(numpy.linspace(0, count - 1, min(INTERVALS, count)).astype(int))
    dt = given.t[i + 1] - given.t[i]
    units = [
        (time, angle, a * b)
        for (time, a), (angle, b) in itertools.product(
            units_of_time(given.t).items(), ANGLE.items()
        )
    ]
    s = numpy.array([scale for *_, scale in units])[:, None]
    ratio = body.I3 / body.I1
    speed = float(numpy.sort(norm(given.w))[len(given.t) // 2])
    for order, inverse in itertools.product(("scalar first", "scalar last"), (False, True)):
        q = attitude(given.q / norm(given.q), Convention(order=order, inverse=inverse))
        moved = _rms(_angle_of(_times(q[:, i + 1], _conjugate(q[:, i]))))
        for in_body, opposite, axis in itertools.product((False, True), (False, True), "zyx"):
            e = numpy.array(axis_of(numpy.array(AXIS[axis])))
            w = given.w * (-1 if opposite else 1)
            w = rotated(q, w) if in_body else w

            def half(rows: Array, way: float, q: Array = q, w: Array = w, e: Array = e) -> Array:
                k = rotated(q[:, rows], numpy.broadcast_to(e[:, None], (3, len(rows))))
                along = (w[:, rows] * k).sum(axis=0)
                L, d = w[:, rows] + (ratio - 1) * along * k, way * dt / 2 * s
                spin = (1 - ratio) * along * d
                first = _times(rotation_by(L[:, None] * d), q[:, rows][:, None])
                return _times(first, rotation_by(e[:, None, None] * spin))

            off = _angle_of(_times(half(i, 1.0), _conjugate(half(i + 1, -1.0))))
            for (time, angle, scale), one in zip(units, _rms(off), strict=True):
                if one < min(ROUGH, PART * moved) and speed * scale * dt.max() < FARTHEST:
                    yield (
                        float(one),
                        Convention(
                            order=order, inverse=inverse, in_body=in_body, opposite=opposite,
                            axis=axis, time=time, angle=angle,
                        ),
                    )  # fmt: skip


def _rms(values: Array) -> Array:
    mean: Array = numpy.sqrt((values**2).mean(axis=-1))
    return mean


def by_geometry(given: Given, body: Parameters, partial: Convention) -> Iterator[Convention]:
    """Ways up, ends of the axis, points and units that height and lift do not exclude."""
    count = len(given.t)
    at = numpy.unique(numpy.linspace(0, count - 2, min(40, count - 1)).astype(int))
    here, there = slice(0, len(at)), slice(len(at), None)
    pairs = given.part(numpy.concatenate((at, at + 1)))
    h = TIME[partial.time] * (pairs.t[there] - pairs.t[here])
    points = ("cm", "centre", "contact") if given.v is not None else ("cm",)
    frames = (False, True) if given.v is not None else (False,)
    for up, flip in itertools.product(UP, ("", "-")):
        one = replace(partial, up=up, axis=flip + partial.axis)
        by_frame = [convert(pairs, replace(one, velocity_in_body=frame), body) for frame in frames]
        ours = by_frame[0]
        k = axis_of(ours.q)
        arms = {"cm": numpy.zeros_like(ours.w), "contact": numpy.array(contact_arm(body, k))}
        arms["centre"] = body.R * body.alpha * numpy.array(k)
        swings = {p: numpy.array(cross(_vector(ours.w), _vector(arms[p]))) for p in arms}
        places = [(length, "cm") for length in LENGTH]
        if ours.x is not None:
            tall = {"cm": 1 - body.alpha * k[2], "centre": numpy.ones_like(k[2])}
            places = [
                (length, place)
                for (length, unit), place in itertools.product(LENGTH.items(), tall)
                if _rms((ours.x[2] * unit / body.R - tall[place])[here]) < 0.03
            ]
        size = float(numpy.sort(norm(ours.w[:, here]))[len(at) // 2])
        rise = swings["contact"][2, here]
        least = max(0.1 * float(_rms(rise)), 0.01 * body.R * size)
        for (length, place), point, frame in itertools.product(places, points, frames):
            unit, raw = LENGTH[length], by_frame[frame].v
            if raw is not None:
                v = unit * raw - swings[point]
                if _rms(v[2, here] + rise) > least:
                    continue
                if ours.x is not None:
                    x = unit * ours.x - arms[place]
                    moved = x[:, there] - x[:, here]
                    off = moved - h * (v[:, here] + v[:, there]) / 2
                    if _rms(norm(off)) > 0.25 * _rms(norm(moved)):
                        continue
            yield replace(one, length=length, place=place, point=point, velocity_in_body=frame)


class FoundConvention(NamedTuple):
    """A convention in which the rows obey the laws, and how; ``exactly`` or as engines do."""

    convention: Convention
    fit: Fit
    exactly: bool


def search(
    given: Given, body: Parameters, rounding: Mapping[str, float], scenes_jellett: float
) -> tuple[Fit, list[FoundConvention]]:
    """Return the fit of the rows as given, and fitting conventions, fewest changes first."""
    given = given.part(slice(0, LOOKED_AT))
    as_given = Fit({}, True, True, scenes_jellett)
    turning = float(numpy.sort(norm(given.w))[len(given.t) // 2]) * float(numpy.diff(given.t).max())
    if turning < 20:
        as_given = fit(body, convert(given, OURS, body), rounding)
    mirrored = as_given.jellett * scenes_jellett < 0
    if as_given.passes:
        hand = [FoundConvention(replace(OURS, hand="left"), as_given, True)] if mirrored else []
        return as_given, hand
    candidates: dict[Convention, tuple[int, float]] = {}
    with numpy.errstate(all="ignore"):
        partials = sorted(by_attitude(given, body), key=lambda pair: pair[0])
        for off, partial in partials[:PARTIALS]:
            for one in by_geometry(given, body, partial):
                candidates.setdefault(one, (one.changes, off))
    passing: list[FoundConvention] = []
    nearly: list[FoundConvention] = []
    for one, (changes, _) in sorted(candidates.items(), key=lambda pair: pair[1])[:TRIES]:
        if one == OURS:
            continue
        if passing and changes > passing[0].convention.changes:
            break
        if nearly and changes > min(near.convention.changes for near in nearly) + 1:
            break
        found = fit(body, convert(given, one, body), _scaled(rounding, one))
        if found.passes:
            passing.append(FoundConvention(one, found, True))
            continue
        near = as_given.size > 1 and found.size < min(1.0, NEARER * as_given.size)
        if near and _velocity_seen(given, body, rounding, one, found):
            nearly.append(FoundConvention(one, found, False))
    order = passing or sorted(
        nearly,
        key=lambda near: (len(near.fit.failing(LIMITS)), near.fit.remainder),
    )
    return as_given, [
        one._replace(convention=replace(one.convention, hand="left"))
        if one.fit.jellett * scenes_jellett < 0
        else one
        for one in order
    ]


def _velocity_seen(
    given: Given, body: Parameters, rounding: Mapping[str, float], one: Convention, found: Fit
) -> bool:
    """Test that a velocity in another convention leaves less of the torque than none does.

    Beside the spin of a top near the vertical what is small enough might be any velocity.
    """
    kept = (one.length, one.point, one.velocity_in_body)
    if given.v is None or kept == (OURS.length, OURS.point, OURS.velocity_in_body):
        return True
    still = convert(given._replace(v=0 * given.v), one, body)
    left = fit(body, still, _scaled(rounding, one)).parts["torque"]
    return found.parts["torque"] < SEEN * left


def _scaled(rounding: Mapping[str, float], one: Convention) -> dict[str, float]:
    length = LENGTH[one.length]
    units = {"t": TIME[one.time], "w": ANGLE[one.angle], "v": length, "x": length, "q": 1.0}
    return {name: value * units[name] for name, value in rounding.items()}
