"""The states that physics engines write, as rigid-body columns in each engine's convention.

An engine's file has times, quaternions, linear and angular velocities of one body. Engines differ
in the order of the quaternion, the frame of the angular velocity, and the point whose velocity is
given. A new engine is one new entry in ``CONVENTIONS``.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace

import numpy

from tt_precise.check.columns import listed
from tt_precise.check.conventions import OURS, Convention, Given
from tt_precise.check.sources import ColumnSource, RowSource, open_source
from tt_precise.runtime.values import Array, InputError

CENTRE_OF_SPHERE, CENTRE_OF_MASS = "centre", "cm"
OF_CENTRE = Convention(point=CENTRE_OF_SPHERE, place=CENTRE_OF_SPHERE)
CONVENTIONS = {
    "mujoco": replace(OF_CENTRE, in_body=True),
    "drake": OF_CENTRE,
    **dict.fromkeys(("dart", "exudyn", "ode"), OURS),
    **dict.fromkeys(
        ("bullet", "cannon-es", "jolt", "newton", "rapier"), Convention(order="scalar last")
    ),
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
_MUJOCO = {"qpos": 7, "qvel": 6}


def conventions_of_engine(engine: str) -> tuple[Convention, dict[str, Convention]]:
    """Return the convention of an engine's arrays, and those of others with the same arrays.

    ``engine`` is a name in ``CONVENTIONS``; ":cm" or ":centre" after it says that the body's
    origin is the centre of mass, or the centre of the sphere.

    Raises ``InputError``: there is no such engine.
    """
    own = _convention(engine)
    # an engine whose arrays have other names cannot have written the file
    alike = [name for name in CONVENTIONS if (name == "mujoco") == engine.startswith("mujoco")]
    marked = (f"{name}:{origin}" for name in alike for origin in (CENTRE_OF_SPHERE, CENTRE_OF_MASS))
    others = {_convention(name): name for name in reversed((*alike, *marked))}
    others.pop(own, None)
    return own, {name: other for other, name in reversed(others.items())}


def engine_source(
    source: object, engine: str, rename: Mapping[str, str] | None = None
) -> ColumnSource:
    """Return an engine's arrays (a file, or in memory) under the names of rigid-body columns.

    The numbers are the engine's, in its convention.

    Raises ``InputError``: no such engine or file, or an array is missing or has another shape.
    """
    convention = _convention(engine)
    with closing(open_source(source, rename)) as given:
        widths = _MUJOCO if engine.startswith("mujoco") else _STATE
        arrays = _arrays(given, widths, convention.order == OURS.order)
        where = given.where
    columns = _rigid_body(arrays).columns
    return ColumnSource(list(columns), lambda name: columns[str(name)], {}, where)


def _rigid_body(arrays: Mapping[str, Array]) -> Given:
    if "qpos" in arrays:
        x, q = numpy.hsplit(arrays["qpos"], [3])
        v, w = numpy.hsplit(arrays["qvel"], [3])
        return Given(arrays["t"], q.T, w.T, v.T, x.T)
    q, v, w = (arrays[name].T for name in _STATE)
    return Given(arrays["t"], q, w, v, arrays["position"].T if "position" in arrays else None)


def _convention(engine: str) -> Convention:
    name, colon, origin = engine.partition(":")
    if name not in CONVENTIONS or (colon and origin not in (CENTRE_OF_SPHERE, CENTRE_OF_MASS)):
        raise InputError(
            f"--from: got {engine[:60]!r}, expected one of: {', '.join(CONVENTIONS)}, or one of "
            f"them with :{CENTRE_OF_SPHERE} or :{CENTRE_OF_MASS} behind it"
        )
    convention = CONVENTIONS[name]
    return replace(convention, point=origin, place=origin) if origin else convention


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
