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
from tt_precise.golden.solution import Distance, Rows, TrueSolution
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Array, Check, InputError, Verdict
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.start import LIFTED

NAME = "golden"
MEANING = "correct digits of every column"
DECIDING = 3.0  # digits with which the solution sees clock, attitude and force together

HOLE = 1.5  # Intervals without a row, half way to a missing row, where rows are evenly spaced.
PART = 0.1  # Share of the span without a row, from which rows count as missing.
EVEN = 1e-3  # relative, by which most intervals of evenly spaced rows differ


def widest_gap(t: Array, end: float, spacing: float) -> tuple[float, float, float]:
    """The first gap up to time ``end`` that is too wide, or the largest: from, to, allowed.

    All in s. ``spacing`` of the rows is never too wide. Rows must reach so far that no other one
    would fit before the end.
    """
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


STEPS_OF_DIGITS = (12, 10, 8, 6, 4, 2, 1)  # The numbers of digits whose end is searched.


def digits_over_time(measured: Distance, begin: float) -> str:
    """Summarise measured rows, as in "9 digits until 1.2 s, none from 5 s".

    The times count from ``begin`` (s). Three numbers of digits are named at most: the first, and
    the last that end a fifth later than the one before; none that ends in the first 2 %.
    """
    rows = measured.compared & (measured.t > 0)
    t, worst = measured.t[rows] - begin, numpy.maximum.accumulate(measured.worst()[rows])
    if not len(t):
        return ""
    spans: list[tuple[int, float]] = []
    for digits in STEPS_OF_DIGITS:
        good = int(numpy.searchsorted(worst, 10.0**-digits, side="right"))
        until = float(t[good - 1]) if good else 0.0
        if good == len(t) or until > max(0.02 * t[-1], 1.2 * spans[-1][1] if spans else 0.0):
            spans.append((digits, until))
        if good == len(t):
            break
    words = [
        f"{digits} {'digit' if digits == 1 else 'digits'} "
        + ("to the end" if until == t[-1] else f"until {until:.3g} s")
        for digits, until in spans[:1] + spans[1:][-2:]
    ]
    if not spans or spans[-1][1] < t[-1]:
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
    samples: Samples, block: Block, position: Position, solution: TrueSolution, wanted: Wanted
) -> Compared:
    """Compare rows with the solution from the time ``position.begin`` on.

    Raises ``InputError``: digits were requested, but too few rows can be compared.
    """
    begin, asked, broken = position.begin, wanted.digits, wanted.broken
    rows = _rows(samples, block, position)
    solution.require_golden()
    try:
        distance = solution.distance(rows, asked, wanted.columns)
    except InputError as error:
        if asked is not None:
            raise
        return Compared(Check(NAME, "open", note=str(error), meaning=MEANING))
    measured, ended = distance, distance.ended
    digits = measured.fewest()
    worst = min(digits.values(), default=0.0)
    # the first row does not count, as it is given
    count, compared = len(rows.t) - 1, int(measured.compared[1:].sum())
    if not measured.compared.any() or (not compared and worst >= 1):
        reason = broken or ended or "no row after the start could be compared with the solution"
        if asked is None:
            return Compared(Check(NAME, "open", note=reason, meaning=MEANING))
        if broken:
            return Compared(Check(NAME, "fail", note=reason, meaning=MEANING))
        raise InputError(f"digits: {reason}")
    few = worst < (asked or 0.0)
    # a log that begins elsewhere is a part of a longer one, and ends where it does
    last = min(begin + wanted.until, distance.last) if position.whole else float(rows.t[-1])
    since, to, allowed = widest_gap(rows.t, last, float(samples.setup.scene.sample_every))
    if asked is not None and not (few or broken):
        if compared < count:
            missed = rows.t[1:][~measured.compared[1:]][0]
            raise InputError(
                f"digits: {compared} of {count} rows after the start could be compared to "
                f"{asked:g} digits, not that at t = {missed:.6g} s"
                + (f"; {ended}" if ended else "")
            )
        if to - since > allowed:
            raise InputError(
                f"digits: there is no row between t = {since:.6g} and {to:.6g} s, expected "
                f"one every {allowed:.3g} s"
                + (f", or --until {since:.6g} where no more is wanted" if since > 0 else "")
            )
    notes = [f"{compared} rows compared {distance.how}"]
    if compared < count:
        notes.append(f"{compared} of {count} rows after the start in all")
    if since == rows.t[-1]:
        notes.append(f"the rows end at {since:.6g} of {to:.6g} s")
    else:
        notes.append(f"largest gap {to - since:.3g} s")
    notes += [text for text in (broken, ended) if text]
    verdict: Verdict = "fail" if few or (broken and asked is not None) else "pass"
    digits = {name: round(value, 2) for name, value in digits.items()}
    at = None if measured.at is None else measured.at - begin
    finding = Check(
        NAME, verdict, worst, asked, at, "; ".join(notes), MEANING, "at least", digits,
        history=digits_over_time(measured, begin),
    )  # fmt: skip
    good = frozenset(name for name, value in digits.items() if value >= DECIDING)
    return Compared(finding, good if compared == count else frozenset())


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
        values, exact = rotate_about_z(values, position.turn), set()

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


def rotate_about_z(values: dict[str, Array], angle: float) -> dict[str, Array]:
    """Return the columns in axes rotated by ``angle`` (rad) about z."""
    found = dict(values)
    c, s = math.cos(angle), math.sin(angle)
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy"), ("x", "y")):
        if x in values and y in values:
            found[x] = c * values[x] + s * values[y]
            found[y] = c * values[y] - s * values[x]
    if "phi" in values:
        found["phi"] = values["phi"] - angle
    return found
