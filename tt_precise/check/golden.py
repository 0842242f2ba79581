"""Distance from the scene's solution: golden rows, or an integration.

Digits count by the rule of ``mechanics.digits``, as in ``golden.compare``. If digits are requested,
every row must have been compared to this number of digits, and rows must cover the whole motion.
The result has the number of compared rows and the largest gap between rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import TRACK, Block, Samples
from tt_precise.golden.measuring import FewestDigits, Measured
from tt_precise.golden.solution import Rows, Solution
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Array, Check, InputError, Verdict
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.start import LIFTED

NAME = "golden"
MEANING = "correct digits of every column"
DECIDING = 3.0  # digits with which the solution sees clock, attitude and force together

HOLE = 1.5  # intervals without a row, where rows are evenly spaced
PART = 0.1  # Share of the span without a row, from which rows count as missing.
EVEN = 1e-3  # relative, by which most intervals of evenly spaced rows differ


class Evidence:
    """The rows that were compared with the true solution, and the gaps between rows.

    ``compared`` of ``rows``; the first row counts in neither, as it is given.
    """

    def __init__(self) -> None:
        self.rows = self.compared = 0
        self.missed: float | None = None  # time (s) of the first row that was not compared
        self._t = numpy.empty(0)

    def add(self, t: Array, compared: Array) -> None:
        self.rows, self.compared = len(t) - 1, int(compared[1:].sum())
        missed = t[1:][~compared[1:]]
        self.missed = float(missed[0]) if len(missed) else None
        self._t = t

    def gap(self, end: float, spacing: float) -> tuple[float, float, float]:
        """The first gap up to time ``end`` that is too wide, or the largest: from, to, allowed.

        All in s. ``spacing`` of the rows is never too wide. Rows must reach so far that no other
        one would fit before the end.
        """
        t = self._t
        steps = numpy.diff(t)
        # numpy.median would import numpy.ma
        usual = float(numpy.sort(steps)[len(steps) // 2]) if len(steps) else math.inf
        even = len(steps) > 1 and (abs(steps - usual) <= EVEN * usual).mean() > 1 - PART
        widest = max(PART * (end - t[0]), HOLE * spacing)
        if even:
            widest = min(widest, HOLE * usual)
        rest = usual * (1 - EVEN) if even else widest
        if end - t[-1] > rest:
            return float(t[-1]), end, rest
        position = int(numpy.argmax(steps)) if len(steps) else 0
        return float(t[position]), float(t[min(position + 1, len(t) - 1)]), widest


class DigitsOverTime:
    """Summarises measured rows, as in "9 digits until 1.2 s, none from 5 s"."""

    STEPS = (12, 10, 8, 6, 4, 2, 1)  # numbers of digits whose end is searched
    MOST = 3  # of them are named
    EARLY = 0.02  # part of the span before which an end is not worth a word
    FURTHER = 1.2  # times the end before, for another one to be named

    def __init__(self, measured: Measured, begin: float):
        rows = measured.compared & ~measured.start
        self._t, self._errors = measured.t[rows] - begin, measured.worst()[rows]

    def __str__(self) -> str:
        t, errors = self._t, self._errors
        if not len(t):
            return ""
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


class Compared(NamedTuple):
    """The distance from the solution, and the columns that agree to some digits."""

    finding: Check
    columns: frozenset[str] = frozenset()


def no_solution(reason: str) -> Compared:
    """Return the check where the scene's solution is no measure of the rows."""
    return Compared(Check(NAME, "skipped", note=reason, meaning=MEANING))


class Position(NamedTuple):
    """The rows' position on the solution: its time at the first row (s), the turn of the axes.

    ``whole`` says that the file counts from the scene's start, and should reach its end.
    """

    begin: float
    turn: float = 0.0
    whole: bool = True


class Wanted(NamedTuple):
    """The digits that are required, if any, and the time from the first row (s) up to which.

    ``broken`` says why rows are missing at the end, "" if none are. ``columns`` are those that the
    solution has to look at, because nothing else did.
    """

    digits: float | None
    until: float = math.inf
    broken: str = ""
    columns: frozenset[str] = frozenset()


def distance_from_solution(
    samples: Samples, block: Block, position: Position, solution: Solution, wanted: Wanted
) -> Compared:
    """Compare rows with the solution from the time ``position.begin`` on.

    Raises ``InputError``: digits were requested, but too few rows can be compared.
    """
    begin, asked, broken = position.begin, wanted.digits, wanted.broken
    rows = _rows(samples, block, position)
    fewest, evidence = FewestDigits(), Evidence()
    solution.require_golden()
    try:
        distance = solution.distance(rows, asked, wanted.columns)
    except InputError as error:
        if asked is not None:
            raise
        return Compared(Check(NAME, "open", note=str(error), meaning=MEANING))
    measured = distance.measured
    fewest.add(measured)
    evidence.add(rows.t, measured.compared)
    ended = distance.ended
    if not fewest.rows or (not evidence.compared and fewest.worst >= 1):
        reason = broken or ended or "no row after the start could be compared with the solution"
        if asked is None:
            return Compared(Check(NAME, "open", note=reason, meaning=MEANING))
        if broken:
            return Compared(Check(NAME, "fail", note=reason, meaning=MEANING))
        raise InputError(f"digits: {reason}")
    few = fewest.worst < (asked or 0.0)
    # a log that begins elsewhere is a part of a longer one, and ends where it does
    last = min(begin + wanted.until, distance.last) if position.whole else float(rows.t[-1])
    since, to, allowed = evidence.gap(last, float(samples.setup.scene.sample_every))
    if asked is not None and not (few or broken):
        if evidence.compared < evidence.rows:
            raise InputError(
                f"digits: {evidence.compared} of {evidence.rows} rows after the start could be "
                f"compared to {asked:g} digits, not that at t = {evidence.missed:.6g} s"
                + (f"; {ended}" if ended else "")
            )
        if to - since > allowed:
            raise InputError(
                f"digits: there is no row between t = {since:.6g} and {to:.6g} s, expected "
                f"one every {allowed:.3g} s"
                + (f", or --until {since:.6g} where no more is wanted" if since > 0 else "")
            )
    notes = [f"{evidence.compared} rows compared {distance.how}"]
    if evidence.compared < evidence.rows:
        notes.append(f"{evidence.compared} of {evidence.rows} rows after the start in all")
    notes.append(f"largest gap {to - since:.3g} s")
    notes += [text for text in (broken, ended) if text]
    verdict: Verdict = "fail" if few or (broken and asked is not None) else "pass"
    digits = {name: round(value, 2) for name, value in fewest.digits.items()}
    finding = Check(
        NAME, verdict, fewest.worst, asked, _after(fewest.at, begin), "; ".join(notes), MEANING,
        "at least", digits, history=str(DigitsOverTime(measured, begin)),
    )  # fmt: skip
    good = frozenset(name for name, value in digits.items() if value >= DECIDING)
    return Compared(finding, good if evidence.compared == evidence.rows else frozenset())


def decides(finding: Check) -> bool:
    """True if the solution agrees with all rows to as many digits as decide."""
    return finding.value is not None and finding.verdict == "pass" and finding.value >= DECIDING


def decide_alone(finding: Check, written: float) -> Check:
    """Return the check of a distance that has to decide without the equations.

    It is open where the digits with which the file is ``written`` (a relative error) may be all
    that is missing.
    """
    if finding.value is None or finding.verdict != "pass":
        return finding
    limit = max(DECIDING, finding.limit or 0.0)
    few = finding.value < limit
    verdict: Verdict = "fail" if few else "pass"
    if few and 10.0**-finding.value <= 10.0**-limit + written:
        verdict = "open"
        finding = replace(finding, note=f"the file has too few digits; {finding.note}")
    return replace(finding, verdict=verdict, limit=limit)


def _after(t: float | None, begin: float) -> float | None:
    return None if t is None else t - begin


# Columns that count from anywhere: from 0 in a solution that begins at the start.
FROM_ANYWHERE = ("psi", "x", "y")
SAME_ORIGIN = 1e-5  # rad, or of R: the first row of a file that counts from the solution's origin


def _rows(samples: Samples, block: Block, position: Position) -> Rows:
    """The columns to compare: those of the file, and the vectors of a rigid body."""
    setup, begin = samples.setup, position.begin
    known = {*NewtonState._fields, *EulerState._fields, *TRACK}
    known |= {*LIFTED} if setup.height_given else set()
    known -= {"vx", "vy", "nu_x", "nu_y"} if setup.rolling else set()
    written = [name for name in block.values if name in known]
    values = {name: block.values[name] for name in written}
    if setup.columns.name == "rigid body":
        derived = NewtonState._fields if setup.has_velocity else NewtonState._fields[:6]
        names = (*derived, *(LIFTED if setup.height_given else ()))
        values |= {
            n: getattr(samples.state, n) for n in names if n in known and n not in written
        }  # fmt: skip
    exact = {*written}
    for name in FROM_ANYWHERE:
        unit = 1.0 if name == "psi" else setup.body.R
        if begin == 0 and name in values and abs(values[name][0]) > SAME_ORIGIN * unit:
            values[name] = values[name] - values[name][0]
            exact -= {name}
    if position.turn:
        values, exact = turned_back(values, position.turn), set()

    def exactly(row: int, names: Sequence[str]) -> list[Any]:
        texts = [name for name in names if name in exact]
        cells = dict(zip(texts, block.texts(row, texts), strict=True))
        # text that is not a number counts as missing, as in ``block.values``
        return [
            (cells[name] if numpy.isfinite(block.values[name][row]) else None)
            if name in cells
            else float(values[name][row])
            for name in names
        ]

    def time(row: int) -> Fraction:
        own, first = (as_fraction(block.texts(i, ["t"])[0]) for i in (row, 0))
        return own if begin == float(first) else own - first + Fraction(begin)

    return Rows(samples.t + begin, values, exactly, time)


def turned_back(values: dict[str, Array], turn: float) -> dict[str, Array]:
    """Return the columns in axes turned back about z."""
    found = dict(values)
    c, s = math.cos(turn), math.sin(turn)
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy"), ("x", "y")):
        if x in values and y in values:
            found[x] = c * values[x] + s * values[y]
            found[y] = c * values[y] - s * values[x]
    if "phi" in values:
        found["phi"] = values["phi"] - turn
    return found
