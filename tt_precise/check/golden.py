"""Distance from the true solution: golden data, or a fresh solution.

Digits count by the rule of ``mechanics.digits``, the same as in ``golden.compare``. A row between
golden times is compared with the golden row nearest to it, carried to its time by the equations of
motion; with ``fresh``, rows that golden data do not reach are compared with a solution that is
computed at their own times.

If digits are requested, every row must have been compared to this number of digits, and no stretch
of the motion may be without rows. The finding shows the fraction of compared rows and the largest
gap between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy

from tt_precise.check.columns import TRACK, Block, CheckSetup, Samples
from tt_precise.check.result import RunningWorst
from tt_precise.golden.digits import correct_digits
from tt_precise.golden.measuring import (
    RESOLVED,
    SAME_TIME,
    SPARE_DIGITS,
    FewestDigits,
    Measured,
    TrueRows,
    ending,
    nothing_measured,
)
from tt_precise.golden.store import MANIFEST, Folder, locate, read_whole
from tt_precise.golden.table import Table
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Check, InputError, Verdict
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LIFTED

MEANING = "correct digits of every column"
USUAL_DIGITS = 12.0  # of a fresh solution if no digits are requested
IN_DOUBLE = 13.0  # digits that differences of doubles can show

HOLE = 1.5  # intervals without a row, where rows are evenly spaced
PART = 0.1  # of the span without a row, where they are not
EVEN = 1e-3  # relative, by which most intervals of evenly spaced rows differ


class Evidence:
    """The rows that were compared with the true solution, and the gaps between rows.

    ``compared`` of ``rows``; the start counts in neither, as it is given.
    """

    def __init__(self) -> None:
        self.rows = self.compared = 0
        self.missed: float | None = None  # time (s) of the first row that was not compared
        self._t: list[numpy.ndarray] = []

    def add(self, t: numpy.ndarray, compared: numpy.ndarray) -> None:
        after = t > 0
        self.rows += int((t != 0).sum())
        self.compared += int((compared & after).sum())
        self.miss(t[~compared & (t != 0)])
        self._t.append(t.copy())  # a view would keep its whole block

    def miss(self, t: numpy.ndarray) -> None:
        """Record the first of these rows, which could not be compared."""
        if len(t):
            self.missed = float(t[0]) if self.missed is None else min(self.missed, float(t[0]))

    def gap(self, end: float, spacing: float) -> tuple[float, float, float]:
        """The first gap up to time ``end`` that is too wide, or the largest: from, to, allowed.

        All in s. ``spacing`` of the rows is never too wide. Rows may begin one interval after the
        start, and must reach so far that no other one would fit before the end.
        """
        t = numpy.concatenate(self._t)
        steps = numpy.diff(t)
        # numpy.median would import numpy.ma
        usual = float(numpy.sort(steps)[len(steps) // 2]) if len(steps) else math.inf
        even = len(steps) > 1 and (abs(steps - usual) <= EVEN * usual).mean() > 1 - PART
        widest = max(PART * end, HOLE * spacing)
        if even:
            widest = min(widest, HOLE * usual)
        begin, rest = (usual * (1 + EVEN), usual * (1 - EVEN)) if even else (widest, widest)
        if t[0] > begin:
            return 0.0, float(t[0]), begin
        if end - t[-1] > rest:
            return float(t[-1]), end, rest
        place = int(numpy.argmax(steps)) if len(steps) else 0
        return float(t[place]), float(t[min(place + 1, len(t) - 1)]), widest


class DigitsOverTime:
    """Summarises blocks of measured rows, as in "9 digits until 1.2 s, none from 5 s"."""

    STEPS = (12, 10, 8, 6, 4, 2, 1)  # numbers of digits whose end is searched
    MOST = 3  # of them are named
    EARLY = 0.02  # part of the span before which an end is not worth a word
    FURTHER = 1.2  # times the end before, for another one to be named

    def __init__(self) -> None:
        self._errors = RunningWorst()

    def add(self, measured: Measured) -> None:
        rows = measured.compared & ~measured.start
        if rows.any():
            self._errors.add(measured.t[rows], measured.worst()[rows])

    @property
    def from_the_start(self) -> bool:
        """Whether the first row after the start has no correct digit."""
        _, errors = self._errors.curve
        return len(errors) > 0 and correct_digits(errors[0]) < 1

    def __str__(self) -> str:
        t, errors = self._errors.curve
        if not len(t):
            return ""
        order = numpy.argsort(t)
        t, errors = t[order], errors[order]
        worst = numpy.maximum.accumulate(errors)
        spans: list[tuple[int, float]] = []
        for digits in self.STEPS:
            good = int(numpy.searchsorted(worst, 10.0**-digits, side="right"))
            if good == len(t):
                spans.append((digits, float(t[-1])))
                break
            until = float(t[good - 1]) if good else 0.0
            if until > self.EARLY * t[-1] and (not spans or until > self.FURTHER * spans[-1][1]):
                spans.append((digits, until))
        whole = bool(spans) and spans[-1][1] == t[-1]
        named = spans[:1] + spans[1:][-(self.MOST - 1) :]
        words = [
            f"{digits} {'digit' if digits == 1 else 'digits'} "
            + ("to the end" if until == t[-1] else f"until {until:.3g} s")
            for digits, until in named
        ]
        if not whole:
            beyond = numpy.flatnonzero(worst > 0.1)
            words.append(f"none from {t[beyond[0]]:.3g} s" if len(beyond) else "fewer then")
        return ", ".join(words)


class OpenRows(NamedTuple):
    """Rows without a golden row: times (s), columns, and the cells as written."""

    t: numpy.ndarray
    values: dict[str, numpy.ndarray]
    cells: Callable[[int, Sequence[str]], list[Any]]


class GoldenDistance:
    """Compares blocks with the golden data of the scene, and keeps rows for a fresh computation.

    ``asked`` are the required digits, or None for a report only.
    """

    def __init__(
        self,
        setup: CheckSetup,
        present: Sequence[str],
        asked: float | None,
        fresh: bool,
        folder: Folder,
    ):
        self._setup, self._asked, self._fresh = setup, asked, fresh
        self._true, self._absent, self._ended = _golden_rows(setup, folder)
        known = {*NewtonState._fields, *EulerState._fields}
        known |= {*LIFTED} if setup.height_given else set()
        known |= {*TRACK} if fresh else {*TRACK} & {*(self._true.names if self._true else ())}
        known -= {"vx", "vy", "nu_x", "nu_y"} if setup.rolling else set()
        self._written = [name for name in present if name in known]
        self._derived: list[str] = []
        if setup.columns.name == "rigid body":
            derived = NewtonState._fields if setup.velocity_known else NewtonState._fields[:6]
            derived = (*derived, *(LIFTED if setup.height_given else ()))
            self._derived = [n for n in derived if n in known and n not in self._written]
        self._fewest, self._over_time = FewestDigits(), DigitsOverTime()
        self._evidence = Evidence()
        self._open: list[OpenRows] = []
        # rows are expected so far
        self._last = setup.scene.until if self._true is None else self._true.times[-1]
        self._resolved = RESOLVED if asked is None else 10.0 ** -(asked + SPARE_DIGITS)

    def look(self, block: Block, samples: Samples) -> None:
        t = block.values["t"]
        compared = numpy.zeros(len(block), bool)
        values = {name: block.values[name] for name in self._written}
        values |= {name: getattr(samples.state, name) for name in self._derived}
        cells = partial(self._cells, block, samples)
        if self._true is not None:
            measured = self._true.measure(t, values, cells, self._resolved, largest_only=True)
            self._take(measured)
            compared = measured.compared
        if self._fresh and not compared.all():
            rest = numpy.flatnonzero(~compared)
            there = {name: entries[rest] for name, entries in values.items()}
            self._open.append(
                OpenRows(t[rest], there, lambda row, names: cells(int(rest[row]), names))
            )
            compared = numpy.ones(len(block), bool)
        self._evidence.add(t, compared)

    def _take(self, measured: Measured) -> None:
        self._fewest.add(measured)
        self._over_time.add(measured)

    def _cells(self, block: Block, samples: Samples, row: int, names: Sequence[str]) -> list[Any]:
        written = [name for name in names if name in self._written]
        cells = dict(zip(written, block.texts(row, written), strict=True))
        # text that is not a number counts as missing, as in ``block.values``
        return [
            (cells[name] if numpy.isfinite(block.values[name][row]) else None)
            if name in cells
            else block.texts(row, ["t"])[0]
            if name == "t"
            else float(getattr(samples.state, name)[row])
            for name in names
        ]

    def finding(self, until: float, broken: str, progress: Progress) -> Check:
        """The distance up to time ``until`` (s), with a fresh computation where one is allowed.

        ``broken`` says why rows are missing at the end, "" if none are.

        Raises ``InputError``: digits were requested, but there are no golden data, or too few rows
        to compare.
        """
        notes, evidence = [], self._evidence
        beyond = self._true is not None and (evidence.missed or 0.0) > self._true.times[-1]
        ended = self._ended if beyond else ""
        here = self._fewest.exactly
        carried = evidence.compared - here - sum(int((rows.t != 0).sum()) for rows in self._open)
        if here:
            notes.append(f"{here} rows compared at golden times")
        if carried:
            notes.append(f"{carried} with the golden solution carried to their times")
        if self._open:
            note, ended = self._recompute(progress)
            notes.append(note)
        if not self._fewest.rows or (not evidence.compared and self._fewest.worst >= 1):
            lacking = (
                self._absent or ended or "no row after the start could be compared with golden data"
            )
            reason = broken or f"{lacking}; --fresh computes the solution"
            if self._asked is None:
                return Check("golden", "skipped", note=reason)
            if broken:
                return Check("golden", "fail", note=reason)
            raise InputError(f"digits: {lacking}; {self._advice()}")
        few = self._fewest.worst < (self._asked or 0.0)
        since, to, allowed = evidence.gap(
            min(until, float(self._last)), float(self._setup.scene.sample_every)
        )
        if self._asked is not None and not (few or broken):
            if evidence.compared < evidence.rows:
                raise InputError(
                    f"digits: {evidence.compared} of {evidence.rows} rows after the start could be "
                    f"compared to {self._asked:g} digits, not that at t = {evidence.missed:.6g} s; "
                    + (ended or self._advice())
                )
            if to - since > allowed:
                raise InputError(
                    f"digits: there is no row between t = {since:.6g} and {to:.6g} s, expected "
                    f"one every {allowed:.3g} s"
                    + (f", or --until {since:.6g} where no more is wanted" if since > 0 else "")
                )
        if evidence.compared < evidence.rows:
            notes.append(f"{evidence.compared} of {evidence.rows} rows after the start in all")
        notes.append(f"largest gap {to - since:.3g} s")
        if self._asked is None:
            notes.append("reported only: --digits N asks for N")
        notes += [text for text in (broken, ended) if text]
        worst = self._fewest.worst
        verdict: Verdict = "fail" if few or (broken and self._asked is not None) else "pass"
        if worst < 1 and self._over_time.from_the_start:
            notes.insert(0, "another start than the scene's: no digit is right from the start")
            verdict = "fail" if verdict == "fail" else "info"
        return Check(
            "golden", verdict, worst, self._asked, self._fewest.at, "; ".join(notes), MEANING,
            "at least",
            {name: round(value, 2) for name, value in self._fewest.digits.items()},
            history=str(self._over_time),
        )  # fmt: skip

    def _recompute(self, progress: Progress) -> tuple[str, str]:
        """Compare the open rows with a fresh solution; returns a summary and the solution's end."""
        fresh = FreshSolution(self._setup.scene, self._open, self._asked, progress)
        done = beyond = 0
        for rows in self._open:
            measured = fresh.measured(rows)
            self._take(measured)
            done += int(measured.compared.sum())
            beyond += int((~measured.compared).sum())
            self._evidence.miss(measured.t[~measured.compared])
        self._evidence.compared -= beyond
        if fresh.ended:
            self._last = min(self._last, fresh.last)
        return f"{done} rows computed afresh in {fresh.arithmetic}", fresh.ended if beyond else ""

    def _advice(self) -> str:
        if self._true is None:
            return "expected --fresh, which computes the solution"
        times = self._true.times
        shown = ", ".join(f"{t:g}" for t in times[:3])
        return (
            "expected --fresh, which computes the solution at the trajectory's own times, or rows "
            f"at the golden times {shown} ... {times[-1]:g} s (--until {times[-1]:.12g})"
        )


class FreshSolution:
    """The solution of ``scene`` at the times of rows, to a digit more than is ``asked`` for.

    Raises ``InputError``: this accuracy cannot be reached.
    """

    def __init__(
        self, scene: Scene, rows: Sequence[OpenRows], asked: float | None, progress: Progress
    ):
        from tt_precise.integration import integrate

        self._exact = asked is not None and asked + SPARE_DIGITS > IN_DOUBLE
        names = rows[0].values.keys()
        last = max(self._times(rows[-1])[-1], Fraction(0))
        wanted = math.ceil((USUAL_DIGITS if asked is None else asked) + SPARE_DIGITS)
        record = tuple(name for name in TRACK if name in names)
        self._agreeing = RESOLVED * 10**SPARE_DIGITS if asked is None else 10.0**-asked
        # an end that the rows know a little too early is an end; their times may be doubles
        self._further = 1 + Fraction(max(self._agreeing, SAME_TIME))
        until = last * self._further
        scene = replace(scene, until=until, events=(), record=record)
        self._run = run = integrate(scene, digits=wanted, progress=progress)
        self._own = 10.0**-run.digits_throughout
        lifted = LIFTED if scene.lifts else ()
        self._names = (*NewtonState._fields, *EulerState._fields, *lifted, *record)
        self.arithmetic = run.precision.name
        self.last, self.ended = until, ""
        if run.status != "complete":
            self.last = as_fraction(run.t_end)
            self.ended = f"the solution {ending(run.status, float(run.t_end))}"

    def measured(self, rows: OpenRows) -> Measured:
        """The distance of rows; those beyond the solution's end are not compared.

        But for one that agrees with an early end in time and state, as in ``TrueRows``.
        """
        times = self._times(rows)
        farthest = self.last * self._further
        within = numpy.array([0 <= t <= farthest for t in times], bool)
        beyond = within & numpy.array([t > self.last for t in times], bool)
        inner = [min(t, self.last) for t in times if 0 <= t <= farthest]
        if not inner:
            return nothing_measured(rows.t, [*rows.values], within)
        numbers: Literal["text", "float"] = "text" if self._exact else "float"
        frame = self._run.frame(*self._names, times=inner, numbers=numbers)
        columns = {"t": list(map(str, rows.t[within].tolist()))}
        for name in self._names:
            columns[name] = ["" if x is None or x != x else str(x) for x in frame[name]]
        true = TrueRows(self._run.scene, Table.of_columns(columns))
        measured = true.measure(rows.t, rows.values, rows.cells, largest_only=True)
        for bound in measured.bounds.values():
            bound[~numpy.isnan(bound)] = self._own
        measured.start[:] = within & (rows.t == 0)
        away = beyond & (measured.worst() > self._agreeing)
        for values in (*measured.errors.values(), *measured.bounds.values()):
            values[away] = math.nan
        measured.compared[away] = False
        return measured

    def _times(self, rows: OpenRows) -> list[Fraction]:
        if not self._exact:
            return list(map(Fraction, rows.t.tolist()))
        return [as_fraction(rows.cells(row, ["t"])[0]) for row in range(len(rows.t))]


def _golden_rows(setup: CheckSetup, folder: Folder) -> tuple[TrueRows | None, str, str]:
    """The golden rows of the scene, or why there are none, and why they end early, if they do."""
    name = setup.scene.name
    try:
        place = locate(name, folder)
    except InputError:
        place = None
    if place is None or not (place.path / MANIFEST).is_file():
        where = "" if folder is None else f" in {folder}"
        return None, f"no golden data of a scene {name}{where}", ""
    stored = read_whole(name, place.folder)
    true = TrueRows(stored.scene, stored.trajectory)
    scene = stored.scene
    if (scene.model, scene.body, scene.start) != (
        setup.scene.model, setup.scene.body, setup.scene.start,
    ):  # fmt: skip
        return None, f"the golden data of {name} are of another body or start", ""
    status, end = stored.manifest["status"], float(true.times[-1])
    return true, "", "" if status == "complete" else f"the solution {ending(status, end)}"
