"""States as physics engines write them, converted to rigid-body columns.

An engine's file has times, quaternions, linear and angular velocities of one body. Engines differ
in the order of the quaternion, the frame of the angular velocity, and the point of the body whose
velocity they give. A new engine is one new entry in ``CONVENTIONS``.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.runtime.values import Array, InputError
from tt_precise.scene.scene import Scene

if TYPE_CHECKING:
    import numpy

    from tt_precise.check.columns import Changed, Columns
    from tt_precise.check.sources import ColumnSource
    from tt_precise.mechanics.parameters import Parameters

CENTRE_OF_SPHERE, CENTRE_OF_MASS = "centre", "cm"


class Convention(NamedTuple):
    """How an engine writes a body's state.

    ``scalar_first``: the order of its quaternion; ``in_body_frame``: the angular velocity's frame;
    ``origin``: the point whose velocity it gives, unless the user says otherwise.
    """

    scalar_first: bool
    in_body_frame: bool
    origin: str


_CENTRAL = Convention(scalar_first=False, in_body_frame=False, origin=CENTRE_OF_MASS)
CONVENTIONS = {
    "mujoco": Convention(scalar_first=True, in_body_frame=True, origin=CENTRE_OF_SPHERE),
    "drake": Convention(scalar_first=True, in_body_frame=False, origin=CENTRE_OF_SPHERE),
    **dict.fromkeys(("dart", "exudyn", "ode"), _CENTRAL._replace(scalar_first=True)),
    **dict.fromkeys(("bullet", "cannon-es", "jolt", "newton", "rapier"), _CENTRAL),
}
# each array by its names in .npz, and its width; in CSV the columns are these names with a number
_TIME = ("t", "time")
_STATE = {"quaternion": 4, "velocity": 3, "angular_velocity": 3}
_POSITION = ("position",)  # which may be there, three wide
_RIGID = ("t", *RigidBodyState._fields, "x", "y", "z")
_MUJOCO = {"qpos": 7, "qvel": 6}


def engine_columns(path: str | Path, engine: str, scene: Scene) -> dict[str, numpy.ndarray]:
    """The rigid-body columns (SI) of an engine's .npz or .csv file.

    ``engine`` is a name in ``CONVENTIONS``; ":cm" or ":centre" after it says that the body's
    origin is the centre of mass, or the centre of the sphere.

    Raises ``InputError``: no such engine or file, or an array is missing or has another shape.
    """
    import numpy
    from scipy.spatial.transform import Rotation

    convention = _convention(engine)
    arrays = _arrays(Path(path), _MUJOCO if engine.startswith("mujoco") else _STATE)
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
    turn = Rotation.from_quat(numpy.where(good[:, None], quaternion, 1.0), scalar_first=True)
    if convention.in_body_frame:
        omega = turn.apply(omega)
    if convention.origin == CENTRE_OF_SPHERE:
        arm = float(scene.body.alpha * scene.body.R) * turn.apply([0.0, 0.0, 1.0])
        velocity = velocity - numpy.cross(omega, arm)
        position = None if position is None else position - arm
    parts = [arrays["t"][:, None], quaternion, omega, velocity]
    parts += [] if position is None else [position]
    return dict(zip(_RIGID, numpy.hstack(parts).T, strict=False))


def engine_source(path: str, engine: str, scene: Scene, rename: Mapping[str, str]) -> ColumnSource:
    """An engine's file as a source of rows, with its readings by other engines' conventions.

    Raises ``InputError``: as ``engine_columns``.
    """
    from tt_precise.check.sources import ColumnSource

    given = engine_columns(path, engine, scene)
    source = ColumnSource(list(given), lambda name: given[str(name)], rename, path)
    # an engine whose arrays have other names cannot have written the file
    alike = [name for name in CONVENTIONS if (name == "mujoco") == engine.startswith("mujoco")]
    marked = (f"{name}:{origin}" for name in alike for origin in (CENTRE_OF_SPHERE, CENTRE_OF_MASS))
    others = {_convention(name): name for name in reversed((*alike, *marked))}
    others.pop(_convention(engine), None)

    def read(other: str, given: Columns, body: Parameters) -> Changed:
        columns = engine_columns(path, other, scene)
        return {name: values[: len(given["t"])] for name, values in columns.items()}

    source.otherwise = {
        f"it is read with --from {other}": partial(read, other)
        for other in reversed(others.values())
    }
    return source


def _convention(engine: str) -> Convention:
    name, colon, origin = engine.partition(":")
    if name not in CONVENTIONS or (colon and origin not in (CENTRE_OF_SPHERE, CENTRE_OF_MASS)):
        raise InputError(
            f"--from: got {engine[:60]!r}, expected one of: {', '.join(CONVENTIONS)}, or one of "
            f"them with :{CENTRE_OF_SPHERE} or :{CENTRE_OF_MASS} behind it"
        )
    convention = CONVENTIONS[name]
    return convention._replace(origin=origin) if origin else convention


def _arrays(path: Path, widths: Mapping[str, int]) -> dict[str, numpy.ndarray]:
    import numpy

    try:
        if path.suffix == ".npz":
            with numpy.load(path, allow_pickle=False) as file:
                given = {name: numpy.asarray(file[name], dtype=float) for name in file.files}
        else:
            given = _numbered(path)
    except (OSError, ValueError, TypeError, zipfile.BadZipFile) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise InputError(f"{path}: {reason}; expected a readable .npz or .csv file") from None
    time = next((given[name] for name in _TIME if name in given), None)
    if time is None:
        raise InputError(f"{path}: no array t or time among {', '.join(given) or 'none'}")
    arrays = {"t": time.reshape(-1)}
    if "position" in given:
        widths = {**widths, "position": 3}
    for name, width in widths.items():
        shape = (len(arrays["t"]), width)
        if name not in given or given[name].shape != shape:
            got = f"shape {given[name].shape}" if name in given else "none"
            raise InputError(
                f"{path}: {name}: got {got}, expected shape {shape} (in CSV columns {name}0 to "
                f"{name}{width - 1})"
            )
        arrays[name] = given[name]
    return arrays


def _numbered(path: Path) -> dict[str, numpy.ndarray]:
    """Columns qpos0, qpos1, ... (or qpos_0, ...) of a CSV file, joined to arrays."""
    import numpy
    import pandas

    frame = pandas.read_csv(path)
    arrays: dict[str, Array] = {}
    for column in frame.columns:
        name = str(column).strip()
        numbered = re.fullmatch(r"([A-Za-z_]+?)_?(\d)", name)
        if numbered and numbered[1] not in _TIME:
            arrays.setdefault(numbered[1], {})[int(numbered[2])] = frame[column]
        else:
            arrays[name] = frame[column]
    return {
        name: numpy.column_stack([value[n] for n in sorted(value)]).astype(float)
        if isinstance(value, dict)
        else value.to_numpy(dtype=float)
        for name, value in arrays.items()
        if name in (*_TIME, *_STATE, *_POSITION, *_MUJOCO)
    }
