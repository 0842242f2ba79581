"""The true solution of a scene at any times, and the distance of rows from it.

If all times are golden, the true rows are golden rows; otherwise the scene is integrated to the
requested digits, which imports heyoka and takes a second. Errors are relative to the sizes of
``mechanics.digits``, for ``verify``, ``check`` and ``compare`` alike; ``compare`` counts the digits
of a trajectory.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy

from tt_precise.golden.store import MANIFEST, Folder, Stored, locate, read_whole
from tt_precise.golden.table import DIGITS, EXACTLY, as_decimal, correct_digits
from tt_precise.mechanics.digits import RULE, sizes
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene

if TYPE_CHECKING:
    import pandas

    from tt_precise.integration import Trajectory


# Digits of an integrated solution if none are requested; in double many times are read faster.
USUAL_DIGITS, MANY, DIGITS_OF_MANY = 12.0, 5000, 8.0
AT_ONCE = 50_000  # Rows that are read at once: 100 MB.
SPARE_DIGITS = 1.0  # Digits by which an integrated row must be better than what is requested.
IN_DOUBLE = 13.0  # Digits that differences of doubles can show.
LONGEST = 10  # Factor of the horizon: times in milliseconds would ask for hours of motion.
EPS = float(numpy.finfo(float).eps)
FAR = 1000  # Roundings; a larger error is known to three digits without regard to them.
SAME_TIME = 4 * EPS  # Relative; a row at a golden time may miss it by a rounding.
SAME_END = 1e-7  # Relative; see ``TrueSolution.distance``.
BEYOND = 1 + 1e-12  # Factor of the end of golden data: a row there may be a rounding later.
REVOLUTION = Decimal("6.283185307179586476925286766559005768394338798750211641949889185")
Columns = Mapping[str, Sequence[str] | Array]  # decimals, "" where undefined, or doubles


class ComparedRows(NamedTuple):
    """Rows to compare: times (s), strictly increasing, columns in double, and exact numbers.

    ``exactly(row, names)`` gives the original numbers of a row, ``exact_time(row)`` its time;
    without them rows are compared in double.
    """

    t: Array
    values: dict[str, Array]
    exactly: Callable[[int, Sequence[str]], Sequence[Scalar]] | None = None
    exact_time: Callable[[int], Fraction] | None = None


class Distance(NamedTuple):
    """The distance of rows at times ``t`` (s) from the true rows, measured by ``how``.

    ``errors`` has an array of relative errors for each column: NaN where the true entry is
    undefined or the row is not ``compared``, never less than the error of the solution. ``last`` is
    the last time (s) of the solution; ``ended`` says why the solution ends before the rows.
    """

    t: Array
    errors: dict[str, Array]
    compared: Array
    how: str
    last: float
    ended: str = ""

    def worst(self) -> Array:
        """The largest error of each row; 0 where nothing is compared."""
        return numpy.fmax.reduce([numpy.zeros(len(self.t)), *self.errors.values()])

    @property
    def at(self) -> float | None:
        """The time (s) of the largest error of the compared rows; None if there are none."""
        if not self.compared.any():
            return None
        return float(self.t[numpy.argmax(numpy.where(self.compared, self.worst(), -1.0))])

    def fewest(self) -> dict[str, float]:
        """The fewest digits of each column that was compared."""
        return {
            name: correct_digits(float(numpy.nanmax(errors)))
            for name, errors in self.errors.items()
            if not numpy.isnan(errors).all()
        }

    def digits(self) -> dict[str, Array]:
        """Correct digits of every entry."""
        with numpy.errstate(divide="ignore"):
            return {n: numpy.clip(-numpy.log10(e), 0, DIGITS) for n, e in self.errors.items()}


class TrueSolution:
    """The solution of ``scene``, from its golden data if there are any, and integrated."""

    def __init__(self, scene: Scene, folder: Folder = None, progress: Progress = silent):
        self.scene, self._folder, self._progress = scene, folder, progress
        self._runs: dict[tuple[float, float, tuple[str, ...]], Trajectory] = {}

    @cached_property
    def golden(self) -> Stored | None:
        """The golden data of the scene, if there are any of this body and start."""
        own = self.scene
        try:
            path = locate(own.name, self._folder)
        except InputError:
            return None
        if not (path / MANIFEST).is_file():
            return None
        stored = read_whole(own.name, path.parent)
        scene = stored.scene
        same = (scene.model, scene.body, scene.start) == (own.model, own.body, own.start)
        return stored if same else None

    def require_golden(self) -> None:
        """Raise ``InputError`` for unusable golden data, or a named folder without golden data."""
        if self.golden is None and self._folder is not None:
            own = f"{self.scene.name} in {self._folder} with this body and start"
            raise InputError(f"folder: no golden data of a scene {own}")

    @cached_property
    def _times(self) -> Array:
        return numpy.array(self.golden.trajectory.floats("t") if self.golden else [math.inf])

    def vectors(self, times: Array) -> Array | None:
        """Vectors (8, times) at times (s); None if the solution does not reach one of them."""
        rows, last = _at_times(self._times, times), float(times.max())
        if self.golden is not None and (rows >= 0).all():
            table = self.golden.trajectory
            return numpy.array([table.floats(name) for name in NewtonState._fields])[:, rows]
        run = self._run(last, _usual_digits(len(times)), ())
        if run.status != "complete" and float(run.t_end) < last:
            return None
        columns = run.table(*NewtonState._fields, times=times)
        return numpy.array([columns[name] for name in NewtonState._fields], float)

    def distance(
        self, rows: ComparedRows, digits: float | None = None, needs: frozenset[str] = frozenset()
    ) -> Distance:
        """Measure rows against the solution, integrated to ``digits`` if given.

        ``needs`` are columns that golden rows must have to be used. A row that agrees with an early
        end of the solution in time and state, to the digits that are required (7 if none are), is
        compared with it. No other row beyond the end is compared.
        """
        agreeing = SAME_END if digits is None else max(10.0**-digits, SAME_TIME)
        golden, last = self.golden, float(self._times[-1])
        if golden is not None and needs <= {*golden.trajectory.columns}:
            status, at_end = golden.manifest["status"], len(self._times) - 1
            at = _at_times(self._times, rows.t)
            near_end = (at < 0) & (abs(rows.t - last) <= agreeing * last)
            if status != "complete":
                at[near_end] = at_end
            if ((at >= 0) | ((rows.t > last) & (status != "complete"))).all():
                there = numpy.flatnonzero(at >= 0)
                table = golden.trajectory
                cells = {n: [table.column(n)[i] for i in at[there]] for n in table.columns}
                distance = _unmeasured(rows, table.columns, "at golden times", last)
                _measure(distance, there, self.scene, cells, rows, 0.0)
                return _without_other_ends(distance, near_end, status, last, agreeing)
        return self._from_integration(rows, digits, agreeing)

    def _run(self, until: float | Fraction, digits: float, record: tuple[str, ...]) -> Trajectory:
        """Integrate to the time ``until`` at least, or use a run that reaches this time.

        Raises ``InputError``: ``until`` lies far beyond the scene's horizon.
        """
        from tt_precise.integration import integrate

        longest = float(LONGEST * self.scene.until)
        if until > longest:
            expected = f"expected at most {longest:g} s, {LONGEST} times the scene's horizon"
            raise InputError(f"rows reach t = {float(until):.6g} s of the solution, {expected}")
        for (reached, good, recorded), run in self._runs.items():
            if reached >= until and good >= digits and {*record} <= {*recorded}:
                return run
        scene = replace(self.scene, until=Fraction(until), events=(), record=record)
        run = integrate(scene, digits=math.ceil(digits + SPARE_DIGITS), progress=self._progress)
        self._runs[float(until), digits, record] = run
        return run

    def _from_integration(
        self, rows: ComparedRows, digits: float | None, agreeing: float
    ) -> Distance:
        good = _usual_digits(len(rows.t)) if digits is None else digits
        record = tuple(name for name in ("phi", "psi", "x", "y") if name in rows.values)
        # an end that the rows know a little too early is an end
        beyond = 1 + Fraction(max(agreeing, SAME_TIME))
        run = self._run(Fraction(float(max(rows.t[-1], 0.0))) * beyond, good, record)
        end, scene = as_fraction(run.t_end), run.scene
        euler = EulerState._fields if {*EulerState._fields} & {*rows.values} else ()
        names = (*NewtonState._fields, *euler, *scene.further_columns, *record)
        last = float(end)
        if run.status == "complete":
            last = max(last, float(self._times[-1] if self.golden else self.scene.until))
        distance = _unmeasured(rows, names, f"integrated in {run.precision.name}", last)
        at = numpy.flatnonzero((rows.t >= 0) & (rows.t <= float(end) * float(beyond)))
        exact_time = rows.exact_time if digits and digits + SPARE_DIGITS > IN_DOUBLE else None
        for part in numpy.split(at, range(AT_ONCE, len(at), AT_ONCE)):
            true: Columns
            if exact_time is not None:
                times = [min(exact_time(row), end) for row in part.tolist()]
                table = run.table(*names, times=times, numbers="text")
                true = {name: [cell or "" for cell in table[name]] for name in names}
            else:
                true = run.table(*names, times=numpy.minimum(rows.t[part], float(end)))
            _measure(distance, part, scene, true, rows, 10.0**-run.digits_throughout)
        after = rows.t > float(end) * (1 + SAME_TIME)
        return _without_other_ends(distance, after, run.status, float(end), agreeing)


def relative_errors(
    scene: Scene,
    true: Columns,
    numbers: Mapping[str, Array],
    exactly: Callable[[int, Sequence[str]], Sequence[Scalar]] | None = None,
) -> dict[str, Array]:
    """Errors of ``numbers`` relative to their sizes, an array for each column.

    NaN where the true number is undefined, infinite where the given number is missing. If ``true``
    are decimals, differences near the rounding to double are taken between the decimals and the
    original numbers, which ``exactly(row, names)`` gives.
    """
    body, doubles = scene.body.numbers(float), {n: _doubles(cells) for n, cells in true.items()}
    times, errors = doubles.pop("t", None), dict[str, Array]()
    with numpy.errstate(all="ignore"):
        size_by_name = sizes(body, doubles, numpy)
        if times is not None:
            size_by_name["t"] = numpy.maximum(times, math.sqrt(body.R / body.g))
            doubles["t"] = times
        for name, values in numbers.items():
            apart = abs(without_revolutions(name, values - doubles[name]))
            if exactly is not None:
                close = apart <= FAR * EPS * numpy.fmax(abs(values), abs(doubles[name]))
                for row in numpy.flatnonzero(close).tolist():
                    apart[row] = _apart(name, exactly(row, [name])[0], true[name][row])
            error = numpy.where(apart == 0, 0.0, apart / size_by_name[name])
            error[numpy.isnan(error)] = numpy.inf
            errors[name] = numpy.where(numpy.isnan(doubles[name]), numpy.nan, error)
    return errors


def ending(status: str, t: float) -> str:
    """The reason why a solution ends at ``t`` (s), and the remedy for later rows."""
    unit = 10.0 ** (math.floor(math.log10(t)) - 2) if t > 0 else 1.0
    until = f"--until {math.floor(t / unit) * unit:.12g}"
    if status == "contact_lost":
        return f'leaves the table at {t:.6g} s; {until}, or lost = "fly" in the scene\'s [contact]'
    return f"ends at t = {t:.6g} s: {status}; {until}"


def without_revolutions(name: str, apart: Scalar) -> Scalar:
    """A difference of entries, an array or a decimal, without whole turns of phi and psi."""
    if name not in ("phi", "psi"):
        return apart
    if isinstance(apart, Decimal):
        turns = EXACTLY.divide(apart, REVOLUTION).to_integral_value()
        return EXACTLY.subtract(apart, EXACTLY.multiply(turns, REVOLUTION))
    return apart - float(REVOLUTION) * numpy.rint(apart / float(REVOLUTION))


def _apart(name: str, number: Scalar, cell: str) -> float:
    decimal = as_decimal(number)
    if decimal is None or not cell:
        return math.nan
    return abs(float(without_revolutions(name, EXACTLY.subtract(decimal, Decimal(cell)))))


def _doubles(cells: Sequence[Any] | Array) -> Array:
    decimals = not isinstance(cells, numpy.ndarray)
    return numpy.array([cell or "nan" for cell in cells] if decimals else cells, dtype=float)


def _unmeasured(rows: ComparedRows, names: Sequence[str], how: str, last: float) -> Distance:
    nothing = numpy.full(len(rows.t), numpy.nan)
    errors = {name: nothing.copy() for name in rows.values if name in names}
    return Distance(rows.t, errors, numpy.zeros(len(rows.t), bool), how, last)


def _measure(
    distance: Distance, part: Array, scene: Scene, true: Columns, rows: ComparedRows, floor: float
) -> None:
    """Measure the rows ``part`` into ``distance``, with errors of at least ``floor``."""
    exactly, decimals = rows.exactly, not any(isinstance(x, numpy.ndarray) for x in true.values())
    cells = {name: column for name, column in true.items() if name != "t"}
    numbers = {name: rows.values[name][part] for name in distance.errors}
    own = (lambda row, names: exactly(int(part[row]), names)) if exactly and decimals else None
    for name, error in relative_errors(scene, cells, numbers, own).items():
        distance.errors[name][part] = numpy.where(error < floor, floor, error)
    distance.compared[part] = True


def _without_other_ends(
    distance: Distance, near_end: Array, status: str, end: float, agreeing: float
) -> Distance:
    """The distance without the rows ``near_end`` that differ from an early end; says why."""
    if status == "complete":
        return distance
    away = near_end & ~(distance.worst() <= agreeing)
    distance.compared[away] = False
    for errors in distance.errors.values():
        errors[away] = numpy.nan
    missed = distance.t[-1] > end and not distance.compared[-1]
    return distance._replace(ended=f"the solution {ending(status, end)}" if missed else "")


def _at_times(times: Array, t: Array) -> Array:
    """The index of the row at each time, up to rounding; -1 where there is none."""
    after = numpy.clip(numpy.searchsorted(times, t), 0, len(times) - 1)
    before = numpy.maximum(after - 1, 0)
    near = numpy.where(abs(times[before] - t) <= abs(times[after] - t), before, after)
    return numpy.where(abs(times[near] - t) <= SAME_TIME * abs(t), near, -1)


def _usual_digits(count: int) -> float:
    return USUAL_DIGITS if count <= MANY else DIGITS_OF_MANY


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
    import pandas  # a check of 801 rows needs none

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
