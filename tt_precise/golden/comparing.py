"""``compare``: the number of correct digits of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy
import pandas

from tt_precise.golden.solution import ComparedRows, TrueSolution
from tt_precise.golden.store import Folder, read_whole
from tt_precise.golden.table import as_decimal
from tt_precise.mechanics.digits import RULE
from tt_precise.runtime.values import InputError

BEYOND = 1 + 1e-12  # Factor of the end of golden data: a row there may be a rounding later.


@dataclass(frozen=True)
class Comparison:
    """The distance of a trajectory from golden data, in significant correct digits.

    ``digits`` are the fewest of each column, by name. ``over_time`` has one row for each compared
    time: ``t`` and the digits of each column. ``unmatched`` is the number of rows that could not be
    compared, because their times are outside the golden data.
    """

    scene: str
    digits: pandas.Series[float]
    over_time: pandas.DataFrame
    unmatched: int

    @property
    def worst(self) -> float:
        return float(self.digits.min())

    def __str__(self) -> str:
        lines = [f"{self.scene}: {len(self.over_time)} times compared. {RULE}"]
        lines += [f"  {name:<10} {digits:5.1f}" for name, digits in self.digits.items()]
        if self.unmatched:
            lines.append(f"  {self.unmatched} rows lie outside of the golden data: not compared")
        return "\n".join(lines)


def compare(frame: Any, scene: str | Path, *, folder: Folder = None) -> Comparison:
    """Count the correct digits of a trajectory by comparison with the golden data of ``scene``.

    ``frame`` is a ``Trajectory``, or a table with ``t`` (s) and any columns of the golden
    trajectory, in SI: floats, decimal strings, or numbers of mpmath. Other columns are ignored. If
    all times are golden, rows are compared exactly; otherwise the scene is integrated to 12 digits.
    ``scene`` and ``folder`` are those of ``load``.

    Raises ``InputError``: there are no golden data for the scene, no common column, or no time
    within them.
    """
    stored = read_whole(scene, folder)
    golden = stored.trajectory
    frame = pandas.DataFrame(frame.frame(numbers="text") if hasattr(frame, "frame") else frame)
    names = [name for name in golden.columns[1:] if name in frame.columns]
    if "t" not in frame.columns or not names:
        raise InputError(
            f"columns: got {', '.join(map(str, frame.columns))}, expected t and any of: "
            + ", ".join(golden.columns[1:])
        )
    exact = {name: [as_decimal(value) for value in frame[name]] for name in ("t", *names)}
    numbers = {name: numpy.array(values, dtype=float) for name, values in exact.items()}
    t, (first, *_, last) = numbers["t"], golden.floats("t")
    order = [row for row in numpy.argsort(t).tolist() if first <= t[row] <= BEYOND * last]
    if not order:
        raise InputError(f"t: got no golden time, expected times between {first:g} and {last:g} s")
    rows = ComparedRows(
        t[order],
        {name: numbers[name][order] for name in names},
        lambda row, columns: [exact[name][order[row]] for name in columns],
        lambda row: Fraction(exact["t"][order[row]] or 0),
    )
    distance = TrueSolution(stored.scene, stored.path.parent).distance(rows)
    over_time = pandas.DataFrame({"t": distance.t, **distance.digits()})[distance.compared]
    return Comparison(
        stored.name,
        pandas.Series(distance.fewest(), dtype=float).reindex(names),
        over_time.reset_index(drop=True),
        len(frame) - len(over_time),
    )
