"""True rows, and the distance of a trajectory from them, at golden times or between them.

A row at a golden time is compared exactly, in decimals. A row between two golden times is compared
with the nearer golden row, carried to its time in double by the Taylor coefficients that the
equations of motion give at the golden row; the comparison is as sharp as this allows. If the
solution ends before its horizon (lift-off, landing), the time of the end is itself a result: a row
that agrees with the last golden row in time and state is compared with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from functools import cached_property
from typing import NamedTuple

import numpy

from tt_precise.golden.digits import DIGITS, EXACT, as_decimal, correct_digits
from tt_precise.golden.table import Table
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene
from tt_precise.taylor.series import SeriesFunctions, coefficients

EPS = float(numpy.finfo(float).eps)
TINY = float(numpy.finfo(float).tiny)
FIGURES = 1e-8  # relative; far above the rounding of an error
FAR = 1000  # roundings; a larger error is known to three digits without regard to them
SAME_TIME = 4 * EPS  # relative; a row at a golden time may miss it by a rounding
LIFT_OFF = 1e-12  # relative; a last row may lie so far beyond the end of the solution
TURN = Decimal("6.283185307179586476925286766559005768394338798750211641949889185")
OTHERWISE = 10.0  # times what a row moves by: no law makes it faster
RESOLVED = 1e-8  # relative error that a carried row must resolve to be compared
SPARE_DIGITS = 1.0  # by which a carried or computed row must be better than what is asked
ORDER = 24
# The terms left out are less than the last two, where two terms are at most this part of the two
# before them (two, because every other one may be zero).
SHRINKING = 0.25
# Rounding of the row and of the equations, in terms of what the rates are made of: they may cancel.
ROUNDINGS = 16 * EPS


class Measured(NamedTuple):
    """The distance of rows from the true ones.

    ``t`` are their times (s). ``errors`` and ``bounds`` have an array for each column: relative
    errors, and the part of them that the comparison may cause; NaN where nothing was compared
    because the true entry is undefined or not resolved. ``compared`` tells for each row whether
    every defined column was compared, ``start`` whether the row is the start.
    """

    t: numpy.ndarray
    errors: dict[str, numpy.ndarray]
    bounds: dict[str, numpy.ndarray]
    compared: numpy.ndarray
    start: numpy.ndarray

    def worst(self) -> numpy.ndarray:
        """The largest error of each row that exceeds its bound; 0 if none does."""
        worst = numpy.zeros(len(self.t))
        for name, errors in self.errors.items():
            worst = numpy.fmax(worst, numpy.where(errors > self.bounds[name], errors, 0.0))
        return worst

    def digits(self) -> dict[str, numpy.ndarray]:
        """Correct digits of every entry; where its error is within the bound, at least so many."""
        with numpy.errstate(divide="ignore"):
            return {
                name: numpy.clip(-numpy.log10(numpy.fmax(errors, self.bounds[name])), 0, DIGITS)
                for name, errors in self.errors.items()
            }


class TrueRows:
    """A table of true rows with the state as vectors, as Euler angles, or both."""

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
    def units(self) -> dict[str, float]:
        """The smallest size of each column; 1 for one that is nowhere defined."""
        return {
            name: float(min(sizes[numpy.isfinite(sizes)], default=1.0))
            for name, sizes in self._sizes.items()
        }

    @cached_property
    def _fastest(self) -> numpy.ndarray:
        """An upper bound of the rate of an entry over its size (1/s), under any rigid law.

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
        golden times is compared in the columns that can be resolved to ``resolved``, one at an
        early end if it agrees to ``SPARE_DIGITS`` less. With ``largest_only`` decimals are spared
        where an error is certainly not the largest of its column: then it may be off by two
        roundings of the entry.
        """
        names = [name for name in values if name in self._cells]
        nearest, delays = self._nearest(t)
        here = abs(delays) <= SAME_TIME * abs(t)
        measured = nothing_measured(t, names, here)
        measured.start[:] = here & (nearest == 0)
        at = numpy.flatnonzero(here)
        between = numpy.flatnonzero(~here & (t > 0) & (t <= self.times[-1] * (1 + LIFT_OFF)))
        with numpy.errstate(all="ignore"):  # a missing number has an infinite error
            self._measure_here(measured, at, nearest, values, exactly, largest_only)
            if len(between):
                self._measure_between(measured, between, nearest, delays, values, resolved)
            if self.times[-1] < float(self._scene.until):
                agreeing = resolved * 10**SPARE_DIGITS
                at_end = (nearest == len(self.times) - 1) & ~measured.compared
                at_end &= abs(delays) <= agreeing * self.times[-1]
                at = numpy.flatnonzero(at_end)
                ended = nothing_measured(t, names, at_end)
                self._measure_here(ended, at, nearest, values, exactly, largest_only)
                at = at[ended.worst()[at] <= agreeing]
                for name in names:
                    measured.errors[name][at] = ended.errors[name][at]
                    measured.bounds[name][at] = ended.bounds[name][at]
                measured.compared[at] = True
        return measured

    def _measure_here(
        self,
        measured: Measured,
        here: numpy.ndarray,
        nearest: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        exactly: Callable[[int, Sequence[str]], Sequence[Scalar]],
        largest_only: bool,
    ) -> None:
        rows = nearest[here]
        close: dict[int, list[str]] = {}
        for name, errors in measured.errors.items():
            given, true = values[name][here], self._numbers[name][rows]
            apart = abs(turned_back(name, given - true))
            error = apart / self._sizes[name][rows]
            defined = ~numpy.isnan(true)
            errors[here] = numpy.where(defined & numpy.isnan(error), numpy.inf, error)
            measured.bounds[name][here] = numpy.where(defined, 0.0, numpy.nan)
            # errors near the rounding to double are computed in decimals
            rounded = apart <= FAR * EPS * numpy.fmax(abs(given), abs(true))
            if largest_only:
                # what two roundings may add to an error or take from it, with a margin
                slack = (2 * EPS * (abs(given) + abs(true)) + TINY) / self._sizes[name][rows]
                least = numpy.fmax.reduce(numpy.where(rounded, error - slack, error), initial=0)
                rounded &= (error + slack) * (1 + FIGURES) >= least
            for at in here[rounded].tolist():
                close.setdefault(at, []).append(name)
        for at, names in close.items():
            for name, given in zip(names, exactly(at, names), strict=True):
                row = int(nearest[at])
                error = abs(apart_of(name, given, self._cells[name][row]))
                error = error and error / float(self._sizes[name][row])
                measured.errors[name][at] = math.inf if math.isnan(error) else error

    def _measure_between(
        self,
        measured: Measured,
        between: numpy.ndarray,
        nearest: numpy.ndarray,
        delays: numpy.ndarray,
        values: Mapping[str, numpy.ndarray],
        resolved: float,
    ) -> None:
        rows, rounding = nearest[between], EPS * abs(measured.t[between])
        carried = self._carrier.carry(rows, delays[between], rounding)
        whole = numpy.zeros(len(between), bool)
        lost = numpy.zeros(len(between), bool)
        fastest = abs(delays[between]) * self._fastest[rows]
        for name in measured.errors:
            size, true = self._sizes[name][rows], self._numbers[name][rows]
            bound = numpy.where(numpy.isnan(true), numpy.nan, fastest)
            if name in carried.values:
                # elsewhere the golden row itself is nearer than what its series says
                sharper = carried.bounds[name] / size < fastest
                true = numpy.where(sharper, carried.values[name], true)
                bound = numpy.where(sharper, carried.bounds[name] / size, bound)
            fine = bound <= resolved
            error = abs(turned_back(name, values[name][between] - true)) / size
            error = numpy.where(numpy.isnan(error), numpy.inf, error)
            # what is certainly wrong counts, however little the row can be held to
            certain = numpy.where(numpy.isfinite(bound), numpy.fmax(error - bound, 0), numpy.nan)
            measured.errors[name][between] = numpy.where(fine, error, certain)
            measured.bounds[name][between] = numpy.where(fine, bound, 0 * certain)
            whole |= fine
            lost |= ~fine & numpy.isfinite(true)
        measured.compared[between] = whole & ~lost

    def _nearest(self, t: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        times = self.times
        near = numpy.clip(numpy.searchsorted(times, t), 1, len(times) - 1)
        near -= abs(times[near - 1] - t) <= abs(times[near] - t)
        return near, t - times[near]


def nothing_measured(t: numpy.ndarray, names: list[str], compared: numpy.ndarray) -> Measured:
    """Of rows of which no number was measured yet."""
    errors, bounds = ({name: numpy.full(len(t), numpy.nan) for name in names} for _ in range(2))
    return Measured(t, errors, bounds, compared.copy(), numpy.zeros(len(t), bool))


def ending(status: str, t: float) -> str:
    """Why a solution ends at ``t`` (s), and the remedy for later rows."""
    unit = 10.0 ** (math.floor(math.log10(t)) - 2) if t > 0 else 1.0
    until = f"--until {math.floor(t / unit) * unit:.12g}"
    if status == "contact_lost":
        return f'leaves the table at {t:.6g} s; {until}, or lost = "fly" in the scene\'s [contact]'
    return f"ends at t = {t:.6g} s: {status}; {until}"


def apart_of(name: str, given: Scalar, cell: str | None) -> float:
    """The exact difference of a number from the decimal ``cell``; NaN where one is missing."""
    number = as_decimal(given)
    if number is None or cell is None:
        return math.nan
    return float(turned_back(name, EXACT.subtract(number, Decimal(cell))))


def turned_back(name: str, apart: Scalar) -> Scalar:
    """A difference of entries, an array or a decimal, without whole turns of phi and psi."""
    if name not in ("phi", "psi"):
        return apart
    if isinstance(apart, Decimal):
        turns = EXACT.divide(apart, TURN).to_integral_value()
        return EXACT.subtract(apart, EXACT.multiply(turns, TURN))
    return apart - float(TURN) * numpy.rint(apart / float(TURN))


class FewestDigits:
    """Accumulates blocks of measured rows.

    ``rows`` were compared, of which ``exactly`` at golden times, the start apart; ``at`` is the
    time (s) of the largest error of all.
    """

    def __init__(self) -> None:
        self.rows = self.exactly = 0
        self.at: float | None = None
        self._worst = -1.0
        self._errors: dict[str, float] = {}  # the largest that are not within their bounds
        self._bounds: dict[str, float] = {}  # the largest of those that errors were within

    def add(self, measured: Measured) -> None:
        self.rows += int(measured.compared.sum())
        for name, errors in measured.errors.items():
            bounds, there = measured.bounds[name], ~numpy.isnan(errors)
            if not there.any():
                continue
            own = errors > bounds
            before, bound = self._errors.get(name, 0.0), self._bounds.get(name, 0.0)
            self._errors[name] = float(numpy.max(errors, where=own, initial=before))
            self._bounds[name] = float(numpy.max(bounds, where=there & ~own, initial=bound))
        exact = [bounds == 0 for bounds in measured.bounds.values()]
        if exact:
            self.exactly += int(
                (numpy.any(exact, axis=0) & measured.compared & ~measured.start).sum()
            )
        worst = measured.worst()
        if measured.compared.any():
            row = int(numpy.argmax(numpy.where(measured.compared, worst, -1.0)))
            if worst[row] > self._worst:
                self._worst, self.at = float(worst[row]), float(measured.t[row])

    @property
    def digits(self) -> dict[str, float]:
        """Of each column; at least so many where most rows lie between golden times."""
        between = self.rows > 2 * self.exactly + 1
        return {
            name: correct_digits(max(error, self._bounds[name]) if between else error)
            for name, error in self._errors.items()
        }

    @property
    def worst(self) -> float:
        return min(self.digits.values())


class Carried(NamedTuple):
    """Columns by name at the requested times, and bounds of their errors; NaN where undefined."""

    values: dict[str, numpy.ndarray]
    bounds: dict[str, numpy.ndarray]


class Carrier:
    """The solutions through rows of vectors, each in double around its own time.

    ``vectors`` has shape (6 or 8, rows), SI, in the order of ``NewtonState``; rows that start
    nowhere are NaN.
    """

    def __init__(self, scene: Scene, vectors: Sequence[numpy.ndarray]):
        self._body = scene.body.numbers(float)
        self._lifts = scene.lifts and scene.model != "flight"
        self._form = formulation(scene.model, "newton", scene.body.friction)
        self._start = [numpy.asarray(entry, float) for entry in vectors]

    @cached_property
    def _coefficients(self) -> numpy.ndarray:
        """Shape (rows, terms, entries): a matrix for each row."""

        def rates(entries: tuple[Scalar, ...]) -> Sequence[Scalar]:
            series: Sequence[Scalar] = self._form.rates(
                self._body, self._form.State(*entries), SeriesFunctions(numpy)
            )
            return series

        width = len(self._form.columns)
        with numpy.errstate(all="ignore"):
            series = coefficients(rates, self._start[:width], ORDER)
        return numpy.ascontiguousarray(series.transpose(2, 1, 0))

    @cached_property
    def _scales(self) -> numpy.ndarray:
        parts = (slice(0, 3), slice(3, 6), slice(6, 8))
        sizes = [float(numpy.nanmax(numpy.abs(self._start[part]), initial=0)) for part in parts]
        kinds = [0, 0, 0, 1, 1, 1, 2, 2][: len(self._form.columns)]
        return numpy.array([sizes[kind] or 1.0 for kind in kinds])

    @cached_property
    def _rates(self) -> numpy.ndarray:
        """How large the terms are that the rates are sums of, shape (rows, entries)."""
        kx, ky, _, Lx, Ly, Lz, *v = self._start
        R, g = self._body.R, self._body.g
        L = numpy.sqrt(Lx**2 + Ly**2 + Lz**2)
        omega = L / min(self._body.I1, self._body.I3)
        speed = R * omega + numpy.sqrt(R * g)
        # all but the vertical entries, and all rates, vanish together in an upright spin
        tilt = numpy.hypot(kx, ky) + numpy.hypot(Lx, Ly) / numpy.fmax(L, TINY)
        if v:
            tilt = tilt + numpy.hypot(*v) / speed
        tilt = numpy.fmin(tilt, 1.0)
        sizes = [omega * tilt] * 3 + [L * omega * tilt] * 3 + [speed**2 / R * tilt] * 2
        return numpy.array(sizes[: len(self._form.columns)]).T

    def carry(self, rows: numpy.ndarray, delays: numpy.ndarray, rounding: numpy.ndarray) -> Carried:
        """Row ``rows[i]`` at ``delays[i]`` seconds after its time, for each i; rows ascending.

        ``rounding`` is the error of each delay, in s.
        """
        width = len(self._scales)
        change, bound = numpy.empty((len(rows), width)), numpy.empty((len(rows), width))
        with numpy.errstate(all="ignore"):
            for part in _stretches(rows):
                matrix = self._coefficients[rows[part.start]]
                powers = numpy.cumprod(numpy.tile(delays[part], (ORDER, 1)), axis=0).T
                slopes = abs(matrix[2:]) * numpy.arange(2, ORDER + 1)[:, None]
                change[part] = powers @ matrix[1:]
                sizes = abs(powers) @ abs(matrix[1:])
                terms = (abs(powers[:, -4:, None] * matrix[-4:]) / self._scales).max(axis=2)
                last, before = terms[:, 2:].sum(axis=1), terms[:, :2].sum(axis=1)
                tail = numpy.where(last <= SHRINKING * before, last, numpy.inf)
                bound[part] = (
                    ROUNDINGS * (sizes + abs(delays[part, None]) * self._rates[rows[part.start]])
                    + tail[:, None] * self._scales
                    + rounding[part, None] * (abs(matrix[1]) + abs(powers[:, :-1]) @ slopes)
                )
                if self._lifts:  # where the top is not on the table, the equations are others
                    bound[part] = numpy.inf
                if not self._form.friction.smooth_at_rest:
                    # smooth only while the gliding cannot come to rest
                    moved = numpy.hypot(sizes[:, 6], sizes[:, 7])
                    speed = numpy.hypot(*(entry[rows[part.start]] for entry in self._start[6:]))
                    bound[part][~(moved < speed)] = numpy.inf
        given = numpy.array([entry[rows] for entry in self._start[:width]]).T
        values = (given + change).T
        bounds = (bound + EPS * (abs(given) + abs(change))).T
        names = self._form.columns
        euler, euler_bounds = self._euler(values, bounds)
        return Carried(
            {**dict(zip(names, values, strict=True)), **euler},
            {**dict(zip(names, bounds, strict=True)), **euler_bounds},
        )

    def _euler(
        self, values: numpy.ndarray, bounds: numpy.ndarray
    ) -> tuple[dict[str, numpy.ndarray], dict[str, numpy.ndarray]]:
        """The Euler angles of vectors, and what errors of the vectors make of them."""

        def angles(vectors: numpy.ndarray) -> numpy.ndarray:
            state = NewtonState(*vectors, *(numpy.zeros_like(vectors[0]),) * (8 - len(vectors)))
            return numpy.array(euler_from_vectors(self._body, state, numpy))

        with numpy.errstate(all="ignore"):
            columns = angles(values)
            spread = ROUNDINGS * abs(columns)
            for entry, bound in enumerate(bounds):
                moved = values.copy()
                moved[entry] += bound
                spread += abs(angles(moved) - columns)
        names = EulerState._fields
        return dict(zip(names, columns, strict=True)), dict(zip(names, spread, strict=True))


def _stretches(rows: numpy.ndarray) -> Iterator[slice]:
    """Runs of equal entries."""
    ends = numpy.flatnonzero(numpy.diff(rows, append=-1)) + 1
    start = 0
    for end in ends.tolist():
        yield slice(start, end)
        start = end
