"""The column sets of a trajectory table, and the rigid motion that each of them describes.

A new set is one entry of ``COLUMN_SETS``: its columns, and the function from these columns to a
``RigidMotion``. All checks read rigid motions, and none of them knows a column set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy

from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.newton import angular_momentum, contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import axis_of, cross, spin
from tt_precise.runtime.values import Array, InputError, wrong_name
from tt_precise.scene.start import LIFTED

Columns = Mapping[str, Array]
QUATERNION = ("qw", "qx", "qy", "qz")
OMEGA = ("wx", "wy", "wz")
VELOCITY = ("vcx", "vcy", "vcz")
POSITION = ("x", "y", "z")
AXIS, MOMENTUM = ("kx", "ky", "kz"), ("Lx", "Ly", "Lz")


class RigidMotion(NamedTuple):
    """The motion of a rigid body in n rows, in the inertial frame and SI, components first.

    ``k`` (3, n) is the symmetry axis as given, ``q`` (4, n) the orientation, a unit quaternion with
    its scalar first, ``L`` (3, n) the angular momentum about the centre of mass, ``v`` and ``x``
    (3, n) its velocity and position. None is unknown; a component of x without a column is NaN.
    """

    k: Array
    q: Array | None
    L: Array
    v: Array | None
    x: Array | None

    @property
    def attitude(self) -> Array:
        """The orientation; where it is unknown, the shortest rotation from z to the axis."""
        return shortest_rotation(unit(self.k)) if self.q is None else self.q


class ColumnSet(NamedTuple):
    """Columns that determine the state of a top.

    ``velocity`` and ``height`` are optional columns. ``azimuth`` is false if the horizontal
    direction of the axis is open.
    """

    name: str
    required: tuple[str, ...]
    velocity: tuple[str, ...]
    motion: Callable[[Parameters, Columns, bool], RigidMotion]
    azimuth: bool = True
    height: tuple[str, ...] = LIFTED

    @property
    def names(self) -> tuple[str, ...]:
        """All columns of the set but the time and the height."""
        return self.required + self.velocity


def stacked(columns: Columns, names: Sequence[str]) -> Array:
    """Return columns as an array (len(names), n); an absent column is NaN."""
    absent = numpy.full(len(columns["t"]), numpy.nan)
    return numpy.array([columns.get(name, absent) for name in names], dtype=float)


def unit(vectors: Array) -> Array:
    """Return vectors, components first, divided by their lengths."""
    length = numpy.sqrt((vectors**2).sum(axis=0))
    return vectors / numpy.where(length == 0, 1.0, length)


def shortest_rotation(k: Array) -> Array:
    """Return the unit quaternions of the shortest rotations from z to unit vectors ``k``.

    Half the angle comes from the larger one of 1 + k.z and 1 - k.z, which does not cancel.
    """
    side = numpy.hypot(k[0], k[1])
    large = numpy.sqrt((1 + abs(k[2])) / 2)
    small = side / (2 * large)
    w, sine = numpy.where(k[2] > 0, (large, small), (small, large))
    level = numpy.where(side == 0, 1.0, side)  # from pole to pole about x
    x = numpy.where(side == 0, 1.0, -k[1] / level)
    return unit(numpy.array([w, sine * x, sine * k[0] / level, 0 * w]))


def _of_vectors(
    body: Parameters, columns: Columns, k: Array, L: Array, v_A: Array | None
) -> RigidMotion:
    """Return the motion of axis, angular momentum and horizontal contact velocity.

    v = v_A - omega x a; the lowest point moves vertically only where its height is given.
    """
    x = stacked(columns, POSITION) if {*POSITION} & {*columns} else None
    v, q, psi = None, None, columns.get("psi")
    if v_A is not None:
        omega = inverse_inertia(body, tuple(k), tuple(L))
        rise = columns.get(LIFTED[1], 0 * k[2])
        v = numpy.array([*v_A, rise]) - numpy.array(cross(omega, contact_arm(body, tuple(k))))
    if LIFTED[0] in columns and "z" not in columns:
        x = numpy.full_like(k, numpy.nan) if x is None else x
        x[2] = columns[LIFTED[0]] + body.R * (1 - body.alpha * k[2])
    if psi is not None:  # Rz(phi) Ry(theta) Rz(psi) is the shortest rotation after Rz(phi + psi)
        w, i, j, _ = shortest_rotation(unit(k))
        half = (numpy.arctan2(k[1], k[0]) + psi) / 2
        c, s = numpy.cos(half), numpy.sin(half)
        q = numpy.array([w * c, i * c + j * s, j * c - i * s, w * s])
    elif {*QUATERNION} <= {*columns}:
        q = unit(stacked(columns, QUATERNION))
    return RigidMotion(k, q, L, v, x)


def _vectors(body: Parameters, columns: Columns, rolling: bool) -> RigidMotion:
    k, L = stacked(columns, AXIS), stacked(columns, MOMENTUM)
    v_A = stacked(columns, ("vx", "vy")) if "vx" in columns else None
    return _of_vectors(body, columns, k, L, 0 * k[:2] if rolling else v_A)


def _rigid_body(body: Parameters, columns: Columns, rolling: bool) -> RigidMotion:
    q = unit(stacked(columns, QUATERNION))
    k = numpy.array(axis_of(*q))
    L = numpy.array(angular_momentum(body, tuple(k), tuple(stacked(columns, OMEGA))))
    motion = _of_vectors(body, columns, k, L, 0 * k[:2] if rolling else None)
    v = stacked(columns, VELOCITY) if VELOCITY[0] in columns else motion.v
    return motion._replace(q=q, v=v)


def _euler(name: str, spin_column: str, azimuth: bool) -> ColumnSet:
    """Return a set of Euler angles, with the spin omega_3 or psi_dot, with or without phi."""

    def motion(body: Parameters, columns: Columns, rolling: bool) -> RigidMotion:
        omega_3 = columns[spin_column]
        if spin_column == "psi_dot":
            omega_3 = spin(omega_3, columns["phi_dot"], numpy.cos(columns["theta"]))
        zero = 0 * columns["t"]
        still = {"nu_x": zero, "nu_y": zero} if rolling else {}
        euler = stacked({**columns, "omega_3": omega_3, **still}, EulerState._fields)
        phi = columns["phi"] if azimuth else zero
        state = vectors_from_euler(body, EulerState(*euler), numpy, phi)
        v_A = numpy.array([state.vx, state.vy]) if rolling or "nu_x" in columns else None
        motion = _of_vectors(body, columns, numpy.array(state.k), numpy.array(state.L), v_A)
        return motion if azimuth else motion._replace(q=None)

    required = ("theta", "theta_dot", "phi_dot", spin_column, *(("phi",) if azimuth else ()))
    return ColumnSet(name, required, ("nu_x", "nu_y"), motion, azimuth)


# The most informative set first: a table is read by the first complete one.
_ALL = (
    ColumnSet("vectors", (*AXIS, *MOMENTUM), ("vx", "vy"), _vectors),
    ColumnSet("rigid body", (*QUATERNION, *OMEGA), VELOCITY, _rigid_body, height=("z",)),
    _euler("Euler with phi", "omega_3", azimuth=True),
    _euler("Euler with phi and psi_dot", "psi_dot", azimuth=True),
    _euler("Euler", "omega_3", azimuth=False),
    _euler("Euler with psi_dot", "psi_dot", azimuth=False),
)
COLUMN_SETS = {each.name: each for each in _ALL}
TRACK = ("phi", "psi", "x", "y")  # the integrals of a state's rates, in a file of any set
KNOWN = {"t", *TRACK, *(name for each in _ALL for name in (*each.names, *each.height))}


def choose_set(present: Sequence[str], where: str) -> ColumnSet:
    """Return the most informative complete set.

    Raises ``InputError``: no set is complete; the message names what the nearest set lacks.
    """
    nearest = min(_ALL, key=lambda each: len({*each.required} - {*present}) / len(each.required))
    missing = [name for name in ("t", *nearest.required) if name not in present]
    if nearest.name == "rigid body" and {"vx", "vy", "vz"} <= {*present}:
        missing = missing or ["vcx", "vcy", "vcz"]
    if not missing:
        return nearest
    remedies = {
        "vcx": "add --columns vx=vcx,vy=vcy,vz=vcz",
        "omega_3": "or give psi_dot: omega_3 = psi_dot + phi_dot cos theta",
    }
    usual = "rename yours with --columns theirs=ours; --from ENGINE reads an engine's own state"
    raise InputError(
        f"{where}: missing {', '.join(missing)} of the {nearest.name} columns "
        f"({' '.join(nearest.names)}) among {listed(present)}; {remedies.get(missing[0], usual)}"
    )


def require_whole(present: Sequence[str], columns: Sequence[str], what: str, where: str) -> bool:
    """Return whether all ``columns`` are present.

    Raises ``InputError``: some of them are, but not all.
    """
    absent = [name for name in columns if name not in present]
    if absent and len(absent) < len(columns):
        raise InputError(
            f"{where}: no {', '.join(absent)}, expected all columns of the {what} or none"
        )
    return not absent


def renaming(pairs: Iterable[str]) -> dict[str, str]:
    """Read ``theirs=ours`` pairs; a text may have several, separated by commas.

    Raises ``InputError``: a pair is malformed, or ``ours`` is no known column.
    """
    names: dict[str, str] = {}
    for pair in (part for text in pairs for part in text.split(",") if part.strip()):
        theirs, equals, ours = (word.strip() for word in pair.partition("="))
        if not (theirs and equals and ours):
            raise InputError(f"--columns: got {pair.strip()!r}, expected theirs=ours")
        if ours not in KNOWN:
            raise wrong_name("--columns", ours, sorted(KNOWN), expected="one of ours: ")
        names[theirs] = ours
    return names


def renamed(names: Sequence[str], rename: Mapping[str, str], where: str) -> list[str]:
    """Return column names after ``rename``; "time" counts as t unless there is a column t.

    Raises ``InputError``: a column to rename is absent, or a known name occurs twice.
    """
    for theirs in rename:
        if theirs not in names:
            raise InputError(f"{where}: no column {theirs!r} to rename among {listed(names)}")
    result = [rename.get(name, name) for name in names]
    if "t" not in result:
        result = ["t" if name == "time" else name for name in result]
    twice = next((name for name in result if name in KNOWN and result.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{where}: column {twice} occurs twice, expected once")
    return result


def listed(names: Sequence[str]) -> str:
    """Return the first column names of a table for a message."""
    more = f", and {len(names) - 16} more" if len(names) > 16 else ""
    return f"the columns {', '.join(names[:16]) or '(none)'}"[:400] + more
