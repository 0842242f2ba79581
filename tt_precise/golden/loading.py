"""``load``: the golden data of a scene as a table of numbers, optionally with the pose.

Orientation and position do not follow from the published state: they need the quadratures phi, psi,
x and y, which only some scenes publish. Therefore ``load`` integrates the scene with these
quadratures, and compares the other columns of the run with the published columns.
"""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction
from pathlib import Path
from typing import ClassVar, Literal, get_args

import mpmath
import pandas

from tt_precise.golden.digits import DIGITS
from tt_precise.golden.measuring import TrueRows
from tt_precise.golden.store import Folder, read_whole
from tt_precise.golden.table import Table
from tt_precise.runtime.values import Array, InputError, Json, require_name
from tt_precise.scene.scene import RECORDABLE, Scene

Numbers = Literal["exact", "float", "text"]  # as of a trajectory's tables
TEXT_COLUMNS = ("name",)
MOTION_BITS = 200  # 60 digits, of which the motion costs some 10
IN_DOUBLE = 17  # digits that a correctly rounded double needs, with a margin


class GoldenFrame(pandas.DataFrame):
    """A golden trajectory in SI, one row for each sample, with events and manifest.

    A slice is a plain DataFrame.
    """

    _metadata: ClassVar[list[str]] = ["events", "manifest"]

    events: pandas.DataFrame
    manifest: dict[str, Json]


def load(
    scene: str | Path, numbers: Numbers = "float", *, folder: Folder = None, pose: bool = False
) -> GoldenFrame:
    """Return the golden trajectory of ``scene``, with ``.events`` and ``.manifest``.

    Parameters
    ----------
    scene
        A name from ``tt_precise.golden.scenes()`` or of your own data in ``golden``, the scene's
        TOML file, or the folder of its data.
    numbers
        "float": float64, correctly rounded from the decimals, NaN where undefined;
        "text": the decimals as published, "" where undefined;
        "exact": mpmath numbers with all their digits, None where undefined.
    folder
        Folder of golden data; by default that of the package, then ``golden``.
    pose
        Add the columns of the pose (``pose_columns``), with as many digits. Their computation takes
        seconds ("float") to a minute and is checked against the published columns.

    Raises
    ------
    InputError
        The data do not exist or differ from their manifest.
    """
    require_name("numbers", numbers, get_args(Numbers))
    stored = read_whole(scene, folder)
    frame = GoldenFrame(_columns(stored.trajectory, numbers))
    if pose:
        poses = pose_columns(stored.scene, stored.trajectory, in_full=numbers != "float")
        for name, cells in poses.items():
            frame[name] = _converted(name, cells, numbers)
    frame.events = pandas.DataFrame(_columns(stored.events, numbers))
    frame.manifest = deepcopy(stored.manifest)  # the other one is cached
    return frame


def pose_columns(scene: Scene, table: Table, *, in_full: bool) -> dict[str, tuple[str, ...]]:
    """Columns of the pose (SI) at the times of the trajectory ``table``, as decimals.

    With ``in_full`` decimals have ``DIGITS`` digits, else 17, for which quad precision suffices.

    Raises ``InputError``: the axis is exactly vertical at some time, or the run contradicts the
    published columns.
    """
    from tt_precise.integration import integrate
    from tt_precise.integration.columns import VECTOR_COLUMNS
    from tt_precise.mechanics.pose import Pose

    digits = DIGITS if in_full else IN_DOUBLE
    precision, bits = ("mp", MOTION_BITS) if in_full else ("quad", None)
    run = integrate(scene, precision, bits=bits, events=(), record=RECORDABLE)
    times = [Fraction(cell) for cell in table.column("t")]
    poses = run.frame(*VECTOR_COLUMNS, "pose", times=times, numbers="exact")
    context, units = run.precision.context, TrueRows.of_table(scene, table).units
    for name in VECTOR_COLUMNS:
        published = [context.mpf(cell) for cell in table.column(name)]
        scale = max(map(abs, published)) or units[name]
        bound = scale * context.mpf(10) ** (1 - digits)
        off = [abs(a - b) for a, b in zip(poses[name], published, strict=True)]
        # NaN is neither above the bound nor within it, and ``max`` may ignore it
        beyond = [
            difference
            for difference in off
            if not (difference <= bound and context.isfinite(difference))
        ]
        if beyond:
            worst = max(beyond)
            raise InputError(
                f"{scene.name}: {name} of a run for the pose differs by {float(worst):.1g} from "
                f"the golden data (size {float(scale):.1g}), expected {digits} digits; "
                "`tt-precise golden verify` says which is wrong"
            )
    return {
        name: tuple(context.nstr(value, digits, min_fixed=0, max_fixed=0) for value in poses[name])
        for name in Pose._fields
    }


def _columns(table: Table, numbers: Numbers) -> dict[str, Array]:
    return {name: _converted(name, table.column(name), numbers) for name in table.columns}


def _converted(name: str, cells: tuple[str, ...], numbers: Numbers) -> Array:
    if name in TEXT_COLUMNS or numbers == "text":
        return list(cells)
    if name == "direction":
        return [int(cell) for cell in cells]
    if numbers == "float":
        return [float(cell) if cell else float("nan") for cell in cells]
    context = mpmath.MPContext()
    context.dps = DIGITS + 2  # so that 34 decimals come back unchanged
    values = [context.mpf(cell) if cell else None for cell in cells]
    return pandas.Series(values, dtype=object)
