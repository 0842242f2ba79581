"""The states that physics engines write, as rigid-body columns in each engine's convention.

A new engine is one entry of ``CONVENTIONS``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy

from tt_precise.check.columns import OMEGA, POSITION, QUATERNION, VELOCITY, listed
from tt_precise.check.conventions import OURS, Convention
from tt_precise.check.sources import Source, open_table
from tt_precise.runtime.values import Array, InputError

OF_CENTRE = Convention(point="centre", place="centre")
CONVENTIONS = {
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

    ``engine`` is a name of ``CONVENTIONS``; ":cm" or ":centre" behind it says that the origin of
    the body is the centre of mass, or the centre of the sphere.

    Raises ``InputError``: there is no such engine.
    """
    name, colon, origin = engine.partition(":")
    if name not in CONVENTIONS or (colon and origin not in ("centre", "cm")):
        raise InputError(
            f"--from: got {engine[:60]!r}, expected one of: {', '.join(CONVENTIONS)}, or one of "
            "them with :centre or :cm behind it"
        )
    convention = CONVENTIONS[name]
    return replace(convention, point=origin, place=origin) if origin else convention


def engine_table(source: object, engine: str, rename: Mapping[str, str]) -> Source:
    """Return an engine's arrays as rigid-body columns, still in the engine's convention.

    Raises ``InputError``: there is no such engine, or an array is absent or has another shape.
    """
    convention, table = convention_of(engine), open_table(source, rename)
    if "t" not in table.names:
        raise InputError(f"{table.where}: no array t or time among {listed(table.names)}")
    columns = table.load(["t"])
    rows = len(columns["t"])
    for name, (ours, theirs) in (MUJOCO if engine.startswith("mujoco") else ARRAYS).items():
        array = _array(table, name, theirs, rows, len(ours))
        if array is not None:
            # letters say the order of a quaternion, whatever the engine's
            if theirs == QUATERNION and {*theirs} <= {*table.names}:
                array = numpy.roll(array, -1 if convention.order == "scalar last" else 0, axis=0)
            columns |= dict(zip(ours, array, strict=True))
        elif name != "position":
            forms = [f"an array of shape ({rows}, {len(ours)})", f"columns {name}0 ..."]
            forms += [" ".join(theirs)] if theirs else []
            raise InputError(
                f"{table.where}: no {name} among {listed(table.names)}; expected "
                f"{', or '.join(forms)}"
            )
    return Source(table.where, columns, {}, columns.__getitem__)


def _array(
    table: Source, name: str, theirs: tuple[str, ...], rows: int, width: int
) -> Array | None:
    """Return an array (width, rows), from numbered or named columns or from a matrix."""
    for names in (*([f"{name}{mark}{i}" for i in range(width)] for mark in ("", "_")), theirs):
        if names and {*names} <= {*table.names}:
            return numpy.array([*table.load(names).values()])
    matrix = numpy.asarray(table.texts([name])[name]) if name in table.names else numpy.empty(0)
    if matrix.ndim != 2:
        return None
    if matrix.shape not in ((rows, width), (width, rows)) or matrix.dtype.kind not in "fiu":
        raise InputError(
            f"{table.where}: {name}: got shape {matrix.shape} of {matrix.dtype}, expected numbers "
            f"of shape {(rows, width)}"
        )
    columns = matrix.T if matrix.shape == (rows, width) else matrix  # MATLAB transposes
    return columns.astype(float)
