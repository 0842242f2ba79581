"""Conversion of the states that physics engines write to rigid-body columns.

An engine's file has times, quaternions, linear and angular velocities of one body. Engines differ
in the order of the quaternion, the frame of the angular velocity, and the point whose velocity is
given. A new engine is one new entry in ``CONVENTIONS``.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy

from tt_precise.check.columns import listed
from tt_precise.check.sources import ColumnSource, RowSource, open_source
from tt_precise.mechanics.conversion import RigidBodyState, axis_of
from tt_precise.mechanics.vectors import cross, rotate
from tt_precise.runtime.values import Array, InputError
from tt_precise.scene.scene import Scene

if TYPE_CHECKING:
    from tt_precise.check.columns import Changed, Columns
    from tt_precise.check.worlds import World
    from tt_precise.mechanics.parameters import Parameters

CENTRE_OF_SPHERE, CENTRE_OF_MASS = "centre", "cm"


class EngineFormat(NamedTuple):
    """The columns and conventions of an engine's file of body states.

    ``scalar_first``: the order of its quaternion; ``in_body_frame``: the angular velocity's frame;
    ``origin``: the point whose velocity it gives, unless the user says otherwise.
    """

    scalar_first: bool
    in_body_frame: bool
    origin: str


_CENTRAL = EngineFormat(scalar_first=False, in_body_frame=False, origin=CENTRE_OF_MASS)
CONVENTIONS = {
    "mujoco": EngineFormat(scalar_first=True, in_body_frame=True, origin=CENTRE_OF_SPHERE),
    "drake": EngineFormat(scalar_first=True, in_body_frame=False, origin=CENTRE_OF_SPHERE),
    **dict.fromkeys(("dart", "exudyn", "ode"), _CENTRAL._replace(scalar_first=True)),
    **dict.fromkeys(("bullet", "cannon-es", "jolt", "newton", "rapier"), _CENTRAL),
}
# Each array of an engine's state by its name, and its width.
_STATE = {"quaternion": 4, "velocity": 3, "angular_velocity": 3}
# The same by the names of their components, the scalar last.
_COMPONENTS = {
    "quaternion": ("qx", "qy", "qz", "qw"),
    "velocity": ("vx", "vy", "vz"),
    "angular_velocity": ("wx", "wy", "wz"),
    "position": ("x", "y", "z"),
}
_RIGID = ("t", *RigidBodyState._fields, "x", "y", "z")
_MUJOCO = {"qpos": 7, "qvel": 6}


def engine_source(
    source: object,
    engine: str,
    scene: Scene,
    rename: Mapping[str, str] | None = None,
    world: World | None = None,
) -> ColumnSource:
    """Return an engine's state (a file, or arrays in memory) as rigid-body columns in SI.

    ``engine`` is a name in ``CONVENTIONS``; ":cm" or ":centre" after it says that the body's
    origin is the centre of mass, or the centre of the sphere. ``world`` has the engine's axes.

    Raises ``InputError``: no such engine or file, or an array is missing or has another shape.
    """
    convention = _convention(engine)
    with closing(open_source(source, rename)) as given:
        widths = _MUJOCO if engine.startswith("mujoco") else _STATE
        arrays = _arrays(given, widths, convention.scalar_first)
        where = given.where
    columns = _rigid_body(arrays, convention, scene, world)
    converted = ColumnSource(list(columns), lambda name: columns[str(name)], {}, where)
    # an engine whose arrays have other names cannot have written the file
    alike = [name for name in CONVENTIONS if (name == "mujoco") == engine.startswith("mujoco")]
    marked = (f"{name}:{origin}" for name in alike for origin in (CENTRE_OF_SPHERE, CENTRE_OF_MASS))
    others = {_convention(name): name for name in reversed((*alike, *marked))}
    others.pop(convention, None)

    def convert(other: str, given: Columns, body: Parameters) -> Changed:
        columns = _rigid_body(arrays, _convention(other), scene, world)
        changed = {name: values[: len(given["t"])] for name, values in columns.items()}
        return {**changed, "t": given["t"]}

    converted.alternatives = {
        f"it is read with --from {other}": partial(convert, other)
        for other in reversed(others.values())
    }
    return converted


def _rigid_body(
    arrays: Mapping[str, Array], convention: EngineFormat, scene: Scene, world: World | None
) -> dict[str, Array]:
    """Return the rigid-body columns (SI) of an engine's arrays."""
    position: Array
    if "qpos" in arrays:
        quaternion, velocity = arrays["qpos"][:, 3:], arrays["qvel"][:, :3]
        omega, position = arrays["qvel"][:, 3:], arrays["qpos"][:, :3]
    else:
        quaternion, velocity = arrays["quaternion"], arrays["velocity"]
        omega, position = arrays["angular_velocity"], arrays.get("position")
    if not convention.scalar_first:
        quaternion = numpy.roll(quaternion, 1, axis=1)
    # the check of finite numbers reports rows that blew up, and needs them unchanged
    good = numpy.isfinite(quaternion).all(axis=1) & (numpy.abs(quaternion).max(axis=1) > 0)
    attitude = numpy.where(good[:, None], quaternion, 1.0).T
    if convention.in_body_frame:
        w, x, y, z = attitude
        turning = rotate((w, x, y, z), (omega[:, 0], omega[:, 1], omega[:, 2]))
        omega = numpy.stack(turning, axis=1) / (w * w + x * x + y * y + z * z)[:, None]
    parts = [arrays["t"][:, None], quaternion, omega, velocity]
    parts += [] if position is None else [position]
    columns = dict(zip(_RIGID, numpy.hstack(parts).T, strict=False))
    if world is not None:
        columns = world.standard(columns)
    if convention.origin == CENTRE_OF_SPHERE:
        q = [numpy.where(good, columns[name], 1.0) for name in ("qw", "qx", "qy", "qz")]
        arm = [float(scene.body.alpha * scene.body.R) * component for component in axis_of(*q)]
        swing = cross((columns["wx"], columns["wy"], columns["wz"]), (arm[0], arm[1], arm[2]))
        for axis, name in enumerate(("vcx", "vcy", "vcz")):
            columns[name] = columns[name] - swing[axis]
        for axis, name in enumerate(("x", "y", "z") if position is not None else ()):
            columns[name] = columns[name] - arm[axis]
    return columns


def _convention(engine: str) -> EngineFormat:
    name, colon, origin = engine.partition(":")
    if name not in CONVENTIONS or (colon and origin not in (CENTRE_OF_SPHERE, CENTRE_OF_MASS)):
        raise InputError(
            f"--from: got {engine[:60]!r}, expected one of: {', '.join(CONVENTIONS)}, or one of "
            f"them with :{CENTRE_OF_SPHERE} or :{CENTRE_OF_MASS} behind it"
        )
    convention = CONVENTIONS[name]
    return convention._replace(origin=origin) if origin else convention


def _arrays(source: RowSource, widths: Mapping[str, int], scalar_first: bool) -> dict[str, Array]:
    """Return the times (rows,) and arrays (rows, width) of a source.

    An array stands under its own name, or as columns (``_columns_of``).
    """
    every = {**widths, "position": 3}
    names = {name: _columns_of(source, name, width) for name, width in every.items()}
    if "t" not in source.names:
        raise InputError(f"{source.where}: no array t or time among {listed(source.names)}")
    rows = source.load(["t", *(one for columns in names.values() for one in columns)]).values
    arrays = {"t": rows["t"]}
    for name, columns in names.items():
        if columns:
            if scalar_first and columns == _COMPONENTS["quaternion"]:
                columns = (columns[3], *columns[:3])
            arrays[name] = numpy.column_stack([rows[column] for column in columns])
        elif isinstance(source, ColumnSource) and name in source.names:
            arrays[name] = _matrix(source, name, (len(rows["t"]), every[name]))
        elif name in widths:
            raise InputError(
                f"{source.where}: no {name} among {listed(source.names)}; expected an array of "
                f"shape ({len(rows['t'])}, {widths[name]}), or columns {_columns_in_words(name)}"
            )
    return arrays


def _columns_of(source: RowSource, name: str, width: int) -> tuple[str, ...]:
    """Return the columns of an array, such as qpos0, qpos_0 or qx, in order; () if there are none.

    The components of a quaternion are those of ``_COMPONENTS``.
    """
    numbered = (tuple(f"{name}{mark}{n}" for n in range(width)) for mark in ("", "_"))
    forms = (*numbered, _COMPONENTS.get(name, ()))
    return next((form for form in forms if form and {*form} <= {*source.names}), ())


def _columns_in_words(name: str) -> str:
    width = {**_MUJOCO, **_STATE}[name]
    words = f"{name}0 to {name}{width - 1}"
    return f"{words}, or {' '.join(_COMPONENTS[name])}" if name in _COMPONENTS else words


def _matrix(source: ColumnSource, name: str, shape: tuple[int, int]) -> Array:
    try:
        array = numpy.asarray(source.column(name), dtype=float)
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        raise InputError(f"{source.where}: {name}: {error}; expected numbers") from None
    if array.shape == shape[::-1] != shape:  # MATLAB writes the other way round
        array = array.T
    if array.shape != shape:
        raise InputError(
            f"{source.where}: {name}: got shape {array.shape}, expected shape {shape} (in CSV "
            f"columns {name}0 to {name}{shape[1] - 1})"
        )
    return array
