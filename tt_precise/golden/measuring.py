"""True rows, and how far the rows of a trajectory are from them, at golden times or between them.

A row at a golden time is compared exactly, in decimals. One between two golden times is compared
with the nearer of them, carried to its time by the equations of motion in double: it is held to
what that can resolve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property

import numpy

from tt_precise.golden.carrying import Carrier
from tt_precise.golden.digits import DIGITS, EXACT
from tt_precise.golden.distance import as_decimal, relative_error
from tt_precise.golden.table import Table
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
TINY = float(numpy.finfo(float).tiny)
FIGURES = 1e-8  # relative; an exact error is rounded to nine digits
FAR = 1000  # roundings; a larger error is known to three digits without regard to them
SAME_TIME = 4 * EPS  # relative; a row at a golden time may miss it by a rounding
LIFT_OFF = 1e-12  # relative; a last row may lie so far beyond the end of the solution
TURN = Decimal("6.283185307179586476925286766559005768394338798750211641949889185")
OTHERWISE = 10.0  # times what a row moves by: no law makes it faster
RESOLVED = 1e-8  # relative error that a carried row must resolve to be compared


@dataclass(frozen=True)
class Measured:
    """The distance of rows from the true ones.

    ``t`` are their times (s); ``errors`` and ``bounds`` have an array for each column, of relative
    errors and of what of them may be the comparison's own; NaN where nothing was compared because
    the true entry is undefined or not resolved. ``compared`` says of each row whether every column
    that is defined was compared, ``start`` whether the row is the start itself.
    """

    t: numpy.ndarray
    errors: dict[str, numpy.ndarray]
    bounds: dict[str, numpy.ndarray]
    compared: numpy.ndarray
    start: numpy.ndarray

    def worst(self) -> numpy.ndarray:
        """The largest error of each row that is not within its bound; 0 where all are."""
        found = numpy.zeros(len(self.t))
        for name, errors in self.errors.items():
            found = numpy.fmax(found, numpy.where(errors > self.bounds[name], errors, 0.0))
        return found

    def digits(self) -> dict[str, numpy.ndarray]:
        """Correct digits of every entry; where its error is within the bound, at least so many."""
        with numpy.errstate(divide="ignore"):
            return {
                name: numpy.clip(-numpy.log10(numpy.fmax(errors, self.bounds[name])), 0, DIGITS)
                for name, errors in self.errors.items()
            }


class TrueRows:
    """A table of true rows, which has the state as vectors, as Euler angles, or both."""

    def __init__(self, scene: Scene, table: Table):
        self._scene, self._table = scene, table
        self.names = [name for name in table.columns if name != "t"]

    @cached_property
    def times(self) -> numpy.ndarray:
        """Times of the rows, s."""
        return numpy.array(self._table.floats("t"))

    @cached_property
    def _cells(self) -> dict[str, tuple[str, ...]]:
        return {name: self._table.column(name) for name in self.names}

    @cached_property
    def _numbers(self) -> dict[str, numpy.ndarray]:
        return {name: numpy.array(self._table.floats(name)) for name in self.names}

    @cached_property
    def _sizes(self) -> dict[str, numpy.ndarray]:
        with numpy.errstate(all="ignore"):
            return sizes(self._scene.body.numbers(float), self._numbers, numpy)

    @cached_property
    def _fastest(self) -> numpy.ndarray:
        """How often an entry of a row moves by its size in a second, at most, under any rigid law.

        Rates are about omega times a size; phi and psi have the tilt in theirs.
        """
        if self._scene.body.spring:
            return numpy.full(len(self.times), numpy.inf)
        everything = [self._sizes["omega_3"], self._sizes["vx"] / float(self._scene.body.R)]
        everything += [abs(self._numbers["phi_dot"])] if "phi" in self.names else []
        return OTHERWISE * numpy.fmax.reduce(everything)

    @cached_property
    def _carrier(self) -> Carrier:
        vectors = [self._numbers[name] for name in NewtonState._fields]
        return Carrier(self._scene, vectors)

    def measure(
        self,
        t: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        exactly: Callable[[int, Sequence[str]], Sequence[Scalar]],
        resolved: float = RESOLVED,
        *,
        largest_only: bool = False,
    ) -> Measured:
        """The distance of rows with strictly increasing times ``t`` (s) from the true ones.

        ``values`` are their columns in double, NaN where there is no number;
        ``exactly(row, names)`` gives the numbers of one row as they were given. A row between
        golden times is compared in the columns that can be resolved to ``resolved``. With
        ``largest_only`` decimals are spared where an error is certainly not the largest of its
        column: then it may be off by two roundings of the entry.
        """
        names = [name for name in values if name in self._cells]
        nearest, delays = self._nearest(t)
        here = abs(delays) <= SAME_TIME * abs(t)
        found = Measured(
            t,
            {name: numpy.full(len(t), numpy.nan) for name in names},
            {name: numpy.full(len(t), numpy.nan) for name in names},
            here.copy(),
            here & (nearest == 0),
        )
        at = numpy.flatnonzero(here)
        between = numpy.flatnonzero(~here & (t > 0) & (t <= self.times[-1] * (1 + LIFT_OFF)))
        with numpy.errstate(all="ignore"):  # what is no number has an infinite error
            self._measure_here(found, at, nearest, values, exactly, largest_only)
            if len(between):
                self._measure_between(found, between, nearest, delays, values, resolved)
        return found

    def _measure_here(
        self,
        found: Measured,
        here: numpy.ndarray,
        nearest: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        exactly: Callable[[int, Sequence[str]], Sequence[Scalar]],
        largest_only: bool,
    ) -> None:
        rows = nearest[here]
        close: dict[int, list[str]] = {}
        for name, errors in found.errors.items():
            given, true = values[name][here], self._numbers[name][rows]
            error = abs(turned_back(name, given - true)) / self._sizes[name][rows]
            defined = ~numpy.isnan(true)
            errors[here] = numpy.where(defined & numpy.isnan(error), numpy.inf, error)
            found.bounds[name][here] = numpy.where(defined, 0.0, numpy.nan)
            # what rounding to double may have to do with is looked at in decimals
            rounded = numpy.isclose(given, true, rtol=FAR * EPS, atol=0)
            if largest_only:
                # what two roundings may add to an error or take from it, with a margin
                slack = (2 * EPS * (abs(given) + abs(true)) + TINY) / self._sizes[name][rows]
                least = numpy.fmax.reduce(numpy.where(rounded, error - slack, error), initial=0)
                rounded &= (error + slack) * (1 + FIGURES) >= least
            for at in here[rounded].tolist():
                close.setdefault(at, []).append(name)
        for at, names in close.items():
            for name, given in zip(names, exactly(at, names), strict=True):
                found.errors[name][at] = self._exact_error(name, int(nearest[at]), given)

    def _measure_between(
        self,
        found: Measured,
        between: numpy.ndarray,
        nearest: numpy.ndarray,
        delays: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        resolved: float,
    ) -> None:
        rows, rounding = nearest[between], EPS * abs(found.t[between])
        carried = self._carrier.carry(rows, delays[between], rounding)
        whole = numpy.zeros(len(between), bool)
        lost = numpy.zeros(len(between), bool)
        fastest = abs(delays[between]) * self._fastest[rows]
        for name in found.errors:
            size, true = self._sizes[name][rows], self._numbers[name][rows]
            bound = numpy.where(numpy.isnan(true), numpy.nan, fastest)
            if name in carried.values:
                true = carried.values[name]
                bound = numpy.fmin(carried.bounds[name] / size, fastest)
            fine = bound <= resolved
            error = abs(turned_back(name, values[name][between] - true)) / size
            error = numpy.where(numpy.isnan(error), numpy.inf, error)
            # what is certainly wrong counts, however little the row can be held to
            certain = numpy.where(numpy.isfinite(bound), numpy.fmax(error - bound, 0), numpy.nan)
            found.errors[name][between] = numpy.where(fine, error, certain)
            found.bounds[name][between] = numpy.where(fine, bound, 0 * certain)
            whole |= fine
            lost |= ~fine & numpy.isfinite(true)
        found.compared[between] = whole & ~lost

    def _nearest(self, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        times = self.times
        if len(times) == 1:
            return numpy.zeros(len(t), int), t - times[0]
        near = numpy.clip(numpy.searchsorted(times, t), 1, len(times) - 1)
        near -= abs(times[near - 1] - t) <= abs(times[near] - t)
        return near, t - times[near]

    def _exact_error(self, name: str, row: int, given: Scalar) -> float:
        true = Decimal(self._cells[name][row])
        size = Decimal(self._sizes[name][row])
        number = as_decimal(given)
        if number is not None:
            number = EXACT.add(true, turned_back(name, EXACT.subtract(number, true)))
        return float(relative_error(number, true, size))


def turned_back(name: str, apart: Scalar) -> Scalar:
    """A difference of entries, an array or a decimal; whole turns of phi and psi are none."""
    if name not in ("phi", "psi"):
        return apart
    if isinstance(apart, Decimal):
        turns = EXACT.divide(apart, TURN).to_integral_value()
        return EXACT.subtract(apart, EXACT.multiply(turns, TURN))
    return apart - float(TURN) * numpy.rint(apart / float(TURN))
