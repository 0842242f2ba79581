"""``load``: the golden data of a scene as a table of numbers."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal, get_args

import mpmath
import pandas

from tt_precise.golden.digits import DIGITS
from tt_precise.golden.places import Folder
from tt_precise.golden.seal import read_whole
from tt_precise.golden.table import Table
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json

# as of a trajectory's tables; "mpmath" is the older name of "native"
Numbers = Literal["native", "float", "text", "mpmath"]
TEXT_COLUMNS = ("name",)


class GoldenFrame(pandas.DataFrame):
    """A golden trajectory, one row a sample, in SI, with its events and its manifest.

    What is cut out of it is a plain DataFrame.
    """

    _metadata: ClassVar[list[str]] = ["events", "manifest"]

    events: pandas.DataFrame
    manifest: dict[str, Json]


def load(
    scene: str | Path, numbers: Numbers = "float", *, folder: Folder = None, pose: bool = False
) -> GoldenFrame:
    """The golden trajectory of ``scene``, with ``.events`` and ``.manifest``.

    Parameters
    ----------
    scene
        A name out of ``tt_precise.golden.scenes()``, or of data of one's own in ``golden``, or
        the scene's TOML file, or the folder of its data.
    numbers
        "float": float64, correctly rounded from the decimals, NaN where undefined;
        "text": the decimals as published, "" where undefined;
        "native" (or "mpmath"): mpmath numbers with all their digits, None where undefined.
    folder
        Where golden data lie; by default what came with the package, then ``golden``.
    pose
        Add the columns of the pose, with as many digits: see ``tt_precise.golden.pose``. It is
        computed now, in seconds ("float") to a minute, and held against the published columns.

    Raises
    ------
    InputError
        There are no such data, or they are not what their manifest says.
    """
    if numbers not in get_args(Numbers):
        raise InputError(f"numbers: got {numbers!r}, expected one of: native, float, text")
    stored = read_whole(scene, folder)
    frame = GoldenFrame(_columns(stored.trajectory, numbers))
    if pose:
        from tt_precise.golden.pose import pose_columns

        found = pose_columns(stored.scene, stored.trajectory, in_full=numbers != "float")
        for name, cells in found.items():
            frame[name] = _converted(name, cells, numbers)
    frame.events = pandas.DataFrame(_columns(stored.events, numbers))
    frame.manifest = stored.manifest
    return frame


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
