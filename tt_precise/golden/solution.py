"""``TrueSolution``: the true rows of a scene at any times, golden or integrated.

If all times are golden, the rows are golden rows; otherwise the scene is integrated to the
requested digits, which imports heyoka and takes a second.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy

from tt_precise.golden.measuring import AGREEING, SAME_TIME, RowDistances, TrueRows, ending
from tt_precise.golden.store import MANIFEST, Folder, locate, read_whole
from tt_precise.golden.table import Table
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

USUAL_DIGITS = 12.0  # Digits of an integrated solution if none are requested.
# A solution in double, with fewer digits, is read a hundred times faster at many times.
DIGITS_OF_MANY = 8.0
MANY = 5000
AT_ONCE = 50_000  # rows that are read at once: 100 MB
SPARE_DIGITS = 1.0  # by which an integrated row must be better than what is requested
IN_DOUBLE = 13.0  # digits that differences of doubles can show
# An integration ends at so many times the scene's horizon at the latest: times in milliseconds, or
# numbers of rows, would ask for hours of motion.
LONGEST = 10


class Rows(NamedTuple):
    """Rows to compare: times (s), columns in double, and exact numbers.

    ``exactly(row, names)`` gives the original numbers of a row, ``exact_time(row)`` its time.
    """

    t: Array
    values: dict[str, Array]
    exactly: Callable[[int, Sequence[str]], Sequence[Scalar]]
    exact_time: Callable[[int], Fraction]


class Distance(NamedTuple):
    """Rows measured by ``how``, the last time (s) of the solution, and why it ends early."""

    measured: RowDistances
    how: str
    last: float
    ended: str = ""


class TrueSolution:
    """The solution of ``scene``; ``absent`` says why there are no golden rows, "" if there are."""

    def __init__(self, scene: Scene, folder: Folder = None, progress: Progress = silent):
        self.scene, self._folder, self._progress = scene, folder, progress
        self._runs: dict[tuple[float, float, tuple[str, ...]], Trajectory] = {}

    @property
    def golden(self) -> TrueRows | None:
        """The golden rows of the scene, if there are any."""
        return self._golden[0]

    @property
    def absent(self) -> str:
        """The reason why the scene has no golden rows; "" if it has."""
        return self._golden[1]

    def require_golden(self) -> None:
        """Raise ``InputError`` for unusable golden data, or a named folder without golden data."""
        if self.absent and self._folder is not None:
            raise InputError(f"folder: {self.absent}")

    @cached_property
    def _golden(self) -> tuple[TrueRows | None, str, str]:
        """The golden rows, the reason why there are none, and the reason of an early end."""
        name = self.scene.name
        try:
            place = locate(name, self._folder)
        except InputError:
            place = None
        if place is None or not (place.path / MANIFEST).is_file():
            where = "" if self._folder is None else f" in {self._folder}"
            return None, f"no golden data of a scene {name}{where}", ""
        stored = read_whole(name, place.folder)
        scene, true = stored.scene, TrueRows.of_table(stored.scene, stored.trajectory)
        own = self.scene
        if (scene.model, scene.body, scene.start) != (own.model, own.body, own.start):
            return None, f"the golden data of {name} are of another body or start", ""
        status, end = stored.manifest["status"], float(true.times[-1])
        return true, "", "" if status == "complete" else f"the solution {ending(status, end)}"

    def distance(
        self, rows: Rows, digits: float | None = None, needs: frozenset[str] = frozenset()
    ) -> Distance:
        """Measure rows against the solution, integrated to ``digits`` if given.

        ``needs`` are columns that golden rows must have to be used.
        """
        agreeing = AGREEING if digits is None else 10.0**-digits
        true, _, ended = self._golden
        if true is not None and needs <= {*true.names} and self._golden_answer(rows, agreeing):
            measured = true.measure(rows.t, rows.values, rows.exactly, agreeing)
            beyond = ended if (rows.t > true.times[-1]).any() else ""
            return Distance(measured, "at golden times", float(true.times[-1]), beyond)
        return self._integrate(rows, digits, agreeing)

    def _golden_answer(self, rows: Rows, agreeing: float) -> bool:
        """Test that each row has a golden time, or lies at or beyond an early end."""
        true, _, ended = self._golden
        assert true is not None
        here = true.at_their_times(rows.t)
        if ended:
            here |= rows.t >= true.times[-1] * (1 - agreeing)
        return bool(here.all())

    def vectors(self, times: Array) -> Array | None:
        """Vectors (8, times) at times (s); None if the solution does not reach one of them."""
        true, last = self.golden, float(times.max())
        if true is not None and true.at_their_times(times).all():
            return true.vectors(times)
        run = self._run(last, _usual_digits(len(times)), ())
        if run.status != "complete" and float(run.t_end) < last:
            return None
        found = run.table(*NewtonState._fields, times=times)
        return numpy.array([found[name] for name in NewtonState._fields], float)

    def _run(self, until: float | Fraction, digits: float, record: tuple[str, ...]) -> Trajectory:
        """Integrate to the time ``until`` at least, or use a run that reaches this time.

        Raises ``InputError``: ``until`` lies far beyond the scene's horizon.
        """
        from tt_precise.integration import integrate

        longest = float(LONGEST * self.scene.until)
        if until > longest:
            raise InputError(
                f"rows reach t = {float(until):.6g} s of the solution, expected at most "
                f"{longest:g} s, {LONGEST} times the scene's horizon"
            )
        for (reached, good, recorded), run in self._runs.items():
            if reached >= until and good >= digits and {*record} <= {*recorded}:
                return run
        scene = replace(self.scene, until=Fraction(until), events=(), record=record)
        wanted = math.ceil(digits + SPARE_DIGITS)
        run = integrate(scene, digits=wanted, progress=self._progress)
        self._runs[float(until), digits, record] = run
        return run

    def _integrate(self, rows: Rows, digits: float | None, agreeing: float) -> Distance:
        wanted = _usual_digits(len(rows.t)) if digits is None else digits
        exact = digits is not None and digits + SPARE_DIGITS > IN_DOUBLE
        record = tuple(name for name in ("phi", "psi", "x", "y") if name in rows.values)
        # an end that the rows know a little too early is an end; their times may be doubles
        further = 1 + Fraction(max(agreeing, SAME_TIME))
        run = self._run(Fraction(float(max(rows.t[-1], 0.0))) * further, wanted, record)
        complete = run.status == "complete"
        last = as_fraction(run.t_end)
        until = float(self.scene.until) if self.golden is None else float(self.golden.times[-1])
        horizon = max(until, float(last)) if complete else float(last)
        within = (rows.t >= 0) & (rows.t <= float(last) * float(further))
        beyond = within & (rows.t > float(last))
        at = numpy.flatnonzero(within)
        euler = EulerState._fields if {*EulerState._fields} & {*rows.values} else ()
        names = (*NewtonState._fields, *euler, *self.scene.further_columns, *record)
        ended = "" if complete else f"the solution {ending(run.status, float(run.t_end))}"
        measured = RowDistances.nothing(
            rows.t, [n for n in rows.values if n in names], numpy.zeros(len(rows.t), bool)
        )
        if not len(at):
            return Distance(measured, "", horizon, ended)
        for first in range(0, len(at), AT_ONCE):
            part = at[first : first + AT_ONCE]
            if exact:
                times = [min(rows.exact_time(row), last) for row in part.tolist()]
                found = run.table(*names, times=times, numbers="text")
                cells = {n: ["" if x is None else x for x in found[n]] for n in names}
                table = Table.of_columns({"t": [*map(str, rows.t[part].tolist())], **cells})
                true = TrueRows.of_table(run.scene, table)
            else:
                found = run.table(*names, times=numpy.minimum(rows.t[part], float(last)))
                true = TrueRows(run.scene, {**found, "t": rows.t[part]})
            _measure(measured, part, true, rows, exact, agreeing)
        own = 10.0**-run.digits_throughout
        for bound in measured.bounds.values():
            bound[~numpy.isnan(bound)] = own
        measured.start[:] = within & (rows.t == 0)
        away = beyond & (measured.worst() > agreeing)
        for values in (*measured.errors.values(), *measured.bounds.values()):
            values[away] = math.nan
        measured.compared[away] = False
        missed = ended if (~measured.compared).any() else ""
        return Distance(measured, f"integrated in {run.precision.name}", horizon, missed)


def _measure(
    measured: RowDistances, part: Array, true: TrueRows, rows: Rows, exact: bool, agreeing: float
) -> None:
    """Measure the rows ``part``: with their original numbers if ``exact``, else in doubles."""
    found = true.measure(
        rows.t[part],
        {name: values[part] for name, values in rows.values.items()},
        (lambda row, names: rows.exactly(int(part[row]), names)) if exact else None,
        agreeing,
    )
    measured.compared[part] = found.compared
    for name, errors in found.errors.items():
        measured.errors[name][part], measured.bounds[name][part] = errors, found.bounds[name]


def _usual_digits(count: int) -> float:
    return USUAL_DIGITS if count <= MANY else DIGITS_OF_MANY
