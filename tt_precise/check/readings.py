"""Units and conventions that other simulators write: how each is read as ours.

A new one is one new entry in ``READINGS``. A reading changes some columns, or says that it has
nothing to change.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy

from tt_precise.check.columns import Columns
from tt_precise.mechanics.vectors import Vector, added, cross, scaled, subtracted
from tt_precise.scene.body import Parameters

Changed = dict[str, numpy.ndarray]
Reading = Callable[[Columns, Parameters], Changed | None]

ANGULAR = ("theta_dot", "phi_dot", "omega_3", "wx", "wy", "wz")
LINEAR = ("vx", "vy", "nu_x", "nu_y", "vcx", "vcy", "vcz")
MOMENTUM = ("Lx", "Ly", "Lz")
AXIS = ("qx", "qy", "qz")
OMEGA = ("wx", "wy", "wz")
CENTRE = ("vcx", "vcy", "vcz")
HALF = math.sqrt(0.5)


def _scaled(factor: float, *names: str) -> Reading:
    def read(given: Columns, body: Parameters) -> Changed | None:
        return {name: factor * given[name] for name in names if name in given} or None

    return read


def _vector(given: Columns, names: tuple[str, str, str]) -> Vector:
    return (given[names[0]], given[names[1]], given[names[2]])


def _named(names: tuple[str, str, str], values: Vector) -> Changed:
    return dict(zip(names, values, strict=True))


def _turned(given: Columns, vector: Vector) -> Vector:
    """A vector of the body's frame in the inertial one."""
    axis = _vector(given, AXIS)
    half = cross(axis, vector)
    return added(vector, added(scaled(2 * given["qw"], half), scaled(2, cross(axis, half))))


def _from_body_frame(given: Columns, body: Parameters) -> Changed | None:
    if "qw" not in given:
        return None
    return _named(OMEGA, _turned(given, _vector(given, OMEGA)))


def _from_scalar_last(given: Columns, body: Parameters) -> Changed | None:
    if "qw" not in given:
        return None
    ours, theirs = (*AXIS, "qw"), ("qw", *AXIS)
    return {name: given[other] for name, other in zip(ours, theirs, strict=True)}


def _from_inverse(given: Columns, body: Parameters) -> Changed | None:
    if "qw" not in given:
        return None
    return {name: -given[name] for name in AXIS}


def _from_geometric_centre(given: Columns, body: Parameters) -> Changed | None:
    # the centre of the sphere is alpha R k away from that of mass
    if "vcx" not in given:
        return None
    away = _turned(given, (0.0, 0.0, body.R * body.alpha))
    swing = cross(_vector(given, OMEGA), away)
    return _named(CENTRE, subtracted(_vector(given, CENTRE), swing))


def _from_y_up(given: Columns, body: Parameters) -> Changed | None:
    if "qw" not in given:
        return None
    w, x, y, z = given["qw"], *_vector(given, AXIS)
    # turned by a right angle about x, which takes their y to our z
    turned: Changed = {
        "qw": HALF * (w - x), "qx": HALF * (w + x), "qy": HALF * (y - z), "qz": HALF * (y + z),
    }  # fmt: skip
    for names in (OMEGA, CENTRE):
        if names[0] in given:
            a, b, c = _vector(given, names)
            turned |= _named(names, (a, -c, b))
    return turned


READINGS: dict[str, Reading] = {
    "the time is in ms": _scaled(1e-3, "t"),
    "the time is in microseconds": _scaled(1e-6, "t"),
    "the time is in ns": _scaled(1e-9, "t"),
    "the time is in minutes": _scaled(60.0, "t"),
    "the angle is in degrees": _scaled(math.pi / 180, "theta"),
    "the angular velocities are in deg/s": _scaled(math.pi / 180, *ANGULAR),
    "the angular velocities are in revolutions/s": _scaled(2 * math.pi, *ANGULAR),
    "the angular velocities are in revolutions/min": _scaled(math.pi / 30, *ANGULAR),
    "the angular velocity has the other sign": _scaled(-1.0, *OMEGA),
    "the angular velocity is in the body frame": _from_body_frame,
    "the quaternion has its scalar last": _from_scalar_last,
    "the quaternion is the inverse one, from the inertial to the body frame": _from_inverse,
    "y is up": _from_y_up,
    "the velocity is that of the sphere's centre": _from_geometric_centre,
    "the velocities are in mm/s": _scaled(1e-3, *LINEAR),
    "the velocities are in cm/s": _scaled(1e-2, *LINEAR),
    "the angular momentum is in g mm^2/s": _scaled(1e-9, *MOMENTUM),
    "the angular momentum is in kg mm^2/s": _scaled(1e-6, *MOMENTUM),
    "the angular momentum is in g cm^2/s": _scaled(1e-7, *MOMENTUM),
}  # fmt: skip
CONVENTIONS = [name for name, read in READINGS.items() if read.__name__.startswith("_from")]


def readings(alone: bool = False) -> Iterator[tuple[str, Reading]]:
    """Every reading with what it says, then two conventions at once, unless ``alone``."""
    yield from READINGS.items()
    if alone:
        return
    for one, other in itertools.permutations(CONVENTIONS, 2):
        yield f"{one} and {other}", _both(READINGS[one], READINGS[other])


def _both(first: Reading, second: Reading) -> Reading:
    def read(given: Columns, body: Parameters) -> Changed | None:
        once = first(given, body)
        twice = None if once is None else second({**given, **once}, body)
        return None if once is None or twice is None else {**once, **twice}

    return read
