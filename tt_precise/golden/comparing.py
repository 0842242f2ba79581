"""``compare``: how many digits of somebody's trajectory are right."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas

from tt_precise.body import Units
from tt_precise.errors import InputError
from tt_precise.golden import store
from tt_precise.golden.digits import COARSE, EXACT, digits_left, scale_of
from tt_precise.golden.runs import DIGITS
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table
from tt_precise.integrate.accuracy import KINDS
from tt_precise.integrate.columns import VECTOR_COLUMNS
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.plotting import new_figure, require_format, save, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Digits count relative to the entry, but not below this part of the component's scale: beside a
# zero of a component the error of the others decides, not its own size.
NEAR_ZERO = Decimal("1e-3")

# Rows belong to a golden time that they miss by less; a time printed with 9 digits is meant.
TIME_TOLERANCE = Decimal("1e-9")

INFINITE = Decimal("Infinity")

RULE = (
    "significant digits relative to the golden entry, or to 1e-3 of the largest entry of its "
    "column where it is smaller than that; at most 34"
)


@dataclass(frozen=True)
class Comparison:
    """The distance of a trajectory from golden data, in significant correct digits.

    digits
        The fewest digits of each column, by name.
    over_time
        One row a compared time: ``t`` and the digits of each column.
    unmatched
        Number of rows whose time is no golden time, and which therefore do not count.
    """

    scene: str
    digits: pandas.Series[float]
    over_time: pandas.DataFrame
    unmatched: int

    @property
    def worst(self) -> float:
        """The fewest digits of all."""
        return float(self.digits.min())

    def __str__(self) -> str:
        lines = [f"{self.scene}: {len(self.over_time)} times compared, {RULE}"]
        lines += [f"  {name:<10} {digits:5.1f}" for name, digits in self.digits.items()]
        if self.unmatched:
            lines.append(f"  {self.unmatched} rows lie at no golden time and do not count")
        return "\n".join(lines)

    def figure(self) -> Figure:
        """A picture of the digits over time: vectors above, the other columns below."""
        with styled():
            return self._figure()

    def _figure(self) -> Figure:
        vectors = [name for name in self.digits.index if name in VECTOR_COLUMNS]
        others = [name for name in self.digits.index if name not in VECTOR_COLUMNS]
        panels = [names for names in (vectors, others) if names]
        figure = new_figure(9, 1 + 3.5 * len(panels))
        shared = figure.subplots(len(panels), sharex=True, sharey=True, squeeze=False)
        for axes, names in zip(shared.flat, panels, strict=True):
            for name in names:
                axes.plot(self.over_time["t"], self.over_time[name], label=name, linewidth=0.8)
            axes.set_ylabel("significant correct digits")
            axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
        # entries that happen to be exact (34 digits) may leave the picture, the others may not
        usual = self.over_time[list(self.digits.index)].quantile(0.97).max()
        axes.set_ylim(0, min(DIGITS, 0 if math.isnan(usual) else usual) + 1)
        axes.set_xlabel("t (s)")
        figure.suptitle(f"{self.scene}: distance from the golden trajectory")
        return figure

    def save(self, path: str | Path) -> None:
        """Write the picture; the suffix of ``path`` (.png, .svg, .pdf) says how."""
        require_format(path)
        save(self.figure(), path)


def compare(frame: pandas.DataFrame, scene: str, *, folder: Path | None = None) -> Comparison:
    """Compare a trajectory with the golden data of ``scene``.

    Parameters
    ----------
    frame
        Columns ``t`` (s) and any of those of the golden trajectory, in SI: floats, decimal
        strings, or numbers of mpmath. Other columns are ignored.
    scene
        A name out of ``tt_precise.golden.scenes()``.
    folder
        Where golden data lie; by default what came with the package.

    Raises
    ------
    InputError
        There are no golden data for the scene, no common column, or no common time.
    """
    stored = store.read(scene, folder)
    golden = stored.trajectory
    names = [name for name in golden.columns if name in frame.columns and name != "t"]
    if "t" not in frame.columns or not names:
        raise InputError(
            f"columns: got {', '.join(map(str, frame.columns))}, expected t and any of: "
            + ", ".join(golden.columns[1:])
        )
    pairs = _matched(list(frame["t"]), golden)
    if not pairs:
        raise InputError(
            f"t: got no time of the golden data, expected any of {golden.rows[0][0]}, "
            f"{golden.rows[min(1, len(golden.rows) - 1)][0]}, ... {golden.rows[-1][0]} s"
        )
    measured: dict[str, list[float]] = {"t": [float(golden.rows[j][0]) for _, j in pairs]}
    scales = scales_of(stored)
    for name in names:
        cells, values = golden.column(name), list(frame[name])
        floor = scales[name] * NEAR_ZERO
        measured[name] = [_digits(values[i], cells[j], floor) for i, j in pairs]
    over_time = pandas.DataFrame(measured)
    return Comparison(scene, over_time[names].min(), over_time, len(frame) - len(pairs))


def scales_of(stored: Stored) -> dict[str, Decimal]:
    """The scale of each column, its largest entry.

    A component that is zero altogether takes the scale of its kind, and a kind that is zero
    altogether that of the dimensionless form (m = R = g = 1).
    """
    own = {name: scale_of(stored.trajectory.column(name)) for name in stored.trajectory.columns}
    units = Units.of(stored.scene.body, math, float)
    scales = {}
    for name in stored.trajectory.columns[1:]:
        kind = next(kind for kind in KINDS if name in kind)
        scale = own[name] or max(own.get(other, Decimal(0)) for other in kind)
        scales[name] = scale or Decimal(float(units.of_dimension(STATE_DIMENSIONS[name])))
    return scales


def correct_digits(value: Any, cell: str, size: Decimal) -> float:
    """Digits of ``value`` that agree with the golden ``cell``, relative to ``size``; at most 34.

    NaN where the golden entry is undefined. A value that is missing or not finite where there is
    one has none.
    """
    return right_digits(relative_error(value, cell, size)) if cell else math.nan


def relative_error(value: Any, cell: str, size: Decimal) -> Decimal:
    """What ``value`` differs from the golden ``cell`` by, in terms of ``size``.

    Infinite if it is missing or not finite.
    """
    given = _decimal(value)
    if given is None:
        return INFINITE
    error = EXACT.subtract(given, Decimal(cell)).copy_abs()
    return COARSE.divide(error, size) if size else error and INFINITE


def right_digits(error: Decimal) -> float:
    """The digits that a relative error leaves, between 0 and 34."""
    return min(float(DIGITS), max(0.0, digits_left(error))) if error else float(DIGITS)


def _matched(times: list[Any], golden: Table) -> list[tuple[int, int]]:
    """Pairs of row numbers, here and in the golden table, at the same time."""
    known = [Decimal(cell) for cell in golden.column("t")]
    slack = TIME_TOLERANCE * max(known[-1], Decimal(1))
    given = sorted((time, i) for i, time in enumerate(map(_decimal, times)) if time is not None)
    pairs, j = [], 0
    for time, i in given:
        while j + 1 < len(known) and abs(known[j + 1] - time) <= abs(known[j] - time):
            j += 1
        if abs(known[j] - time) <= slack:
            pairs.append((i, j))
    return pairs


def _digits(value: Any, cell: str, floor: Decimal) -> float:
    return correct_digits(value, cell, max(abs(Decimal(cell or 0)), floor))


def _decimal(value: Any) -> Decimal | None:
    """The exact value of a float, a decimal string or an mpmath number; None if there is none."""
    if value is None or value == "":
        return None
    if hasattr(value, "_mpf_"):
        sign, mantissa, power, _ = value._mpf_
        if not mantissa:
            return None if power else Decimal(0)
        exact = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        quotient = EXACT.divide(Decimal(exact.numerator), Decimal(exact.denominator))
        # an operator's minus would round to the 28 digits of decimal's own context
        return quotient.copy_negate() if sign else quotient
    try:
        number = Decimal(value) if isinstance(value, str | int) else Decimal(float(value))
    except (InvalidOperation, TypeError, ValueError):
        raise InputError(f"trajectory: got {str(value)[:60]!r}, expected a number") from None
    return number if number.is_finite() else None
