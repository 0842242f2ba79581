"""``load``: the golden data of a scene as tables of numbers."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import ClassVar, Literal, get_args

import mpmath
import pandas

from tt_precise.golden.store import Folder, read_whole
from tt_precise.golden.table import DIGITS, Table
from tt_precise.runtime.values import Array, Json, require_name

Numbers = Literal["exact", "float", "text"]  # As of a trajectory's tables.


class GoldenFrame(pandas.DataFrame):
    """A golden trajectory in SI, one row for each sample, with events and manifest.

    A slice is a plain DataFrame.
    """

    _metadata: ClassVar[list[str]] = ["events", "manifest"]

    events: pandas.DataFrame
    manifest: dict[str, Json]


def load(scene: str | Path, numbers: Numbers = "float", *, folder: Folder = None) -> GoldenFrame:
    """Return the golden trajectory of ``scene``, with ``.events`` and ``.manifest``.

    ``scene`` is a name from ``tt_precise.golden.scenes()`` or of your own data in ``golden``, the
    scene's TOML file, or the folder of its data. ``numbers`` are "float": float64, correctly
    rounded from the decimals, NaN where undefined; "text": the decimals as published, "" where
    undefined; or "exact": mpmath numbers with all their digits, None where undefined. ``folder`` is
    that of golden data; by default that of the package, then ``golden``.

    Raises ``InputError``: the data do not exist or differ from their manifest.
    """
    require_name("numbers", numbers, get_args(Numbers))
    stored = read_whole(scene, folder)
    columns, events = (
        {name: _converted(table, name, numbers) for name in table.columns}
        for table in (stored.trajectory, stored.events)
    )
    frame = GoldenFrame(columns)
    frame.events = pandas.DataFrame(events)
    frame.manifest = deepcopy(stored.manifest)  # the other one is cached
    return frame


def _converted(table: Table, name: str, numbers: Numbers) -> Array:
    cells = table.column(name)
    if name == "name" or numbers == "text":
        return list(cells)
    if name == "direction":
        return [int(cell) for cell in cells]
    if numbers == "float":
        return list(table.floats(name))
    context = mpmath.MPContext()
    context.dps = DIGITS + 2  # so that 34 decimals come back unchanged
    return pandas.Series([context.mpf(cell) if cell else None for cell in cells], dtype=object)
