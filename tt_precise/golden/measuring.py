"""True rows, and the distance of a trajectory from the true rows at their times.

A row is compared exactly, in decimals. If the solution ends before its horizon (lift-off, landing),
the time of the end is itself a result: a row that agrees with the last golden row in time and state
is compared with this golden row.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from functools import cached_property
from typing import NamedTuple

import numpy

from tt_precise.golden.digits import DIGITS, EXACTLY, as_decimal, correct_digits
from tt_precise.golden.table import Table
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
FAR = 1000  # roundings; a larger error is known to three digits without regard to them
SAME_TIME = 4 * EPS  # relative; a row at a golden time may miss it by a rounding
REVOLUTION = Decimal("6.283185307179586476925286766559005768394338798750211641949889185")
AGREEING = 1e-7  # relative; a row at an early end of the solution agrees with it to so much


class RowDistances(NamedTuple):
    """The distance of rows from the true rows.

    ``t`` are the times (s) of the rows. ``errors`` and ``bounds`` have an array for each column:
    relative errors, and the part of an error that the comparison may cause; NaN where the true
    entry is undefined or not resolved. ``compared`` is true for each row of which every defined
    column was compared, ``start`` for the row at the start.
    """

    t: numpy.ndarray
    errors: dict[str, numpy.ndarray]
    bounds: dict[str, numpy.ndarray]
    compared: numpy.ndarray
    start: numpy.ndarray

    @classmethod
    def nothing(
        cls, t: numpy.ndarray, names: Sequence[str], compared: numpy.ndarray
    ) -> RowDistances:
        """Return rows without a measured number."""
        errors, bounds = ({name: numpy.full(len(t), numpy.nan) for name in names} for _ in range(2))
        return cls(t, errors, bounds, compared.copy(), numpy.zeros(len(t), bool))

    def worst(self) -> numpy.ndarray:
        """The largest error of each row that exceeds its bound; 0 if none does."""
        worst = numpy.zeros(len(self.t))
        for name, errors in self.errors.items():
            worst = numpy.fmax(worst, numpy.where(errors > self.bounds[name], errors, 0.0))
        return worst

    @property
    def at(self) -> float | None:
        """The time (s) of the largest error of the compared rows; None if there are none."""
        if not self.compared.any():
            return None
        return float(self.t[numpy.argmax(numpy.where(self.compared, self.worst(), -1.0))])

    def fewest(self) -> dict[str, float]:
        """The fewest digits of each column; a lower bound where errors lie within their bounds."""
        found = {}
        for name, errors in self.errors.items():
            bounds, there = self.bounds[name], ~numpy.isnan(errors)
            if there.any():
                largest = numpy.where(errors > bounds, errors, bounds)[there].max()
                found[name] = correct_digits(float(largest))
        return found

    def digits(self) -> dict[str, numpy.ndarray]:
        """Correct digits of every entry; a lower bound where the error is within its bound."""
        with numpy.errstate(divide="ignore"):
            return {
                name: numpy.clip(-numpy.log10(numpy.fmax(errors, self.bounds[name])), 0, DIGITS)
                for name, errors in self.errors.items()
            }


class TrueRows:
    """True rows with the state as vectors, as Euler angles, or both.

    ``numbers`` are the columns as doubles, NaN where undefined; ``cells`` their decimals, "" where
    undefined, for comparisons in decimals.
    """

    def __init__(
        self,
        scene: Scene,
        numbers: Mapping[str, numpy.ndarray],
        cells: Mapping[str, Sequence[str]] | None = None,
    ):
        self._scene, self._numbers, self._cells = scene, numbers, cells or {}
        self.times = numbers["t"]  # s
        self.names = [name for name in numbers if name != "t"]

    @classmethod
    def of_table(cls, scene: Scene, table: Table) -> TrueRows:
        """Return the rows of a table of decimals."""
        numbers = {name: numpy.array(table.floats(name)) for name in table.columns}
        return cls(scene, numbers, {name: table.column(name) for name in table.columns})

    @cached_property
    def _sizes(self) -> dict[str, numpy.ndarray]:
        with numpy.errstate(all="ignore"):
            numbers = {name: self._numbers[name] for name in self.names}
            return sizes(self._scene.body.numbers(float), numbers, numpy)

    @cached_property
    def units(self) -> dict[str, float]:
        """The smallest size of each column; 1 for a column that is nowhere defined."""
        return {
            name: float(min(sizes[numpy.isfinite(sizes)], default=1.0))
            for name, sizes in self._sizes.items()
        }

    def vectors(self, t: numpy.ndarray) -> numpy.ndarray:
        """The vector state (8, times) at times (s) of the rows."""
        nearest, _ = self._nearest(t)
        return numpy.array([self._numbers[name][nearest] for name in NewtonState._fields])

    def at_their_times(self, t: numpy.ndarray) -> numpy.ndarray:
        """Test that each of the times (s) is the time of a row, up to rounding."""
        _, delays = self._nearest(t)
        here: numpy.ndarray = abs(delays) <= SAME_TIME * abs(t)
        return here

    def measure(
        self,
        t: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        exactly: Callable[[int, Sequence[str]], Sequence[Scalar]] | None,
        agreeing: float = AGREEING,
    ) -> RowDistances:
        """The distance of rows with strictly increasing times ``t`` (s) from the true rows.

        ``values`` are the columns of the rows in double, NaN where there is no number.
        ``exactly(row, names)`` gives the original numbers of one row; without ``exactly`` errors
        are those of doubles. A row at another time is not compared, except a row at an early end of
        the solution that agrees with this end to ``agreeing``.
        """
        names = [name for name in values if name in self.names]
        nearest, delays = self._nearest(t)
        here = abs(delays) <= SAME_TIME * abs(t)
        measured = RowDistances.nothing(t, names, here)
        measured.start[:] = here & (nearest == 0)
        with numpy.errstate(all="ignore"):  # a missing number has an infinite error
            at = numpy.flatnonzero(here)
            self._measure_here(measured, at, nearest, values, exactly)
            if self.times[-1] < float(self._scene.until):
                at_end = (nearest == len(self.times) - 1) & ~measured.compared
                at_end &= abs(delays) <= agreeing * self.times[-1]
                at = numpy.flatnonzero(at_end)
                ended = RowDistances.nothing(t, names, at_end)
                self._measure_here(ended, at, nearest, values, exactly)
                at = at[ended.worst()[at] <= agreeing]
                for name in names:
                    measured.errors[name][at] = ended.errors[name][at]
                    measured.bounds[name][at] = ended.bounds[name][at]
                measured.compared[at] = True
        return measured

    def _measure_here(
        self,
        measured: RowDistances,
        here: numpy.ndarray,
        nearest: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        exactly: Callable[[int, Sequence[str]], Sequence[Scalar]] | None,
    ) -> None:
        rows = nearest[here]
        close: dict[int, list[str]] = {}
        for name, errors in measured.errors.items():
            given, true = values[name][here], self._numbers[name][rows]
            apart = abs(without_revolutions(name, given - true))
            error = apart / self._sizes[name][rows]
            defined = ~numpy.isnan(true)
            errors[here] = numpy.where(defined & numpy.isnan(error), numpy.inf, error)
            measured.bounds[name][here] = numpy.where(defined, 0.0, numpy.nan)
            if exactly is None:
                continue
            # errors near the rounding to double are computed in decimals
            rounded = apart <= FAR * EPS * numpy.fmax(abs(given), abs(true))
            for at in here[rounded].tolist():
                close.setdefault(at, []).append(name)
        if exactly is None:
            return
        for at, names in close.items():
            for name, given in zip(names, exactly(at, names), strict=True):
                row = int(nearest[at])
                error = abs(apart_of(name, given, self._cells[name][row]))
                error = error and error / float(self._sizes[name][row])
                measured.errors[name][at] = math.inf if math.isnan(error) else error

    def _nearest(self, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        times = self.times
        near = numpy.clip(numpy.searchsorted(times, t), 1, len(times) - 1)
        near -= abs(times[near - 1] - t) <= abs(times[near] - t)
        return near, t - times[near]


def ending(status: str, t: float) -> str:
    """The reason why a solution ends at ``t`` (s), and the remedy for later rows."""
    unit = 10.0 ** (math.floor(math.log10(t)) - 2) if t > 0 else 1.0
    until = f"--until {math.floor(t / unit) * unit:.12g}"
    if status == "contact_lost":
        return f'leaves the table at {t:.6g} s; {until}, or lost = "fly" in the scene\'s [contact]'
    return f"ends at t = {t:.6g} s: {status}; {until}"


def apart_of(name: str, given: Scalar, cell: str | None) -> float:
    """The exact difference of a number from the decimal ``cell``; NaN if one is missing."""
    number = as_decimal(given)
    if number is None or cell is None:
        return math.nan
    return float(without_revolutions(name, EXACTLY.subtract(number, Decimal(cell))))


def without_revolutions(name: str, apart: Scalar) -> Scalar:
    """A difference of entries, an array or a decimal, without whole turns of phi and psi."""
    if name not in ("phi", "psi"):
        return apart
    if isinstance(apart, Decimal):
        turns = EXACTLY.divide(apart, REVOLUTION).to_integral_value()
        return EXACTLY.subtract(apart, EXACTLY.multiply(turns, REVOLUTION))
    return apart - float(REVOLUTION) * numpy.rint(apart / float(REVOLUTION))
