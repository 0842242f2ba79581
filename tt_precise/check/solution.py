"""Checks against the scene: its start, the columns beside the state, and its solution.

The first row is the scene's start, at any time in the file, or the solution at the row's own time
or up to a row later: a run may be a restart. Columns beside those of the state must agree with it.
The distance from the solution counts digits by the rule of ``mechanics.digits``, in double up to 15
required digits, in the file's own digits above.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import OMEGA, QUATERNION, TRACK, VELOCITY
from tt_precise.check.law_flow import EPS
from tt_precise.check.residuals import norm
from tt_precise.check.rows import Rows
from tt_precise.golden.solution import ComparedRows, Distance, TrueSolution, without_revolutions
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.euler import EulerState, euler_from_vectors
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import jellett
from tt_precise.mechanics.vectors import axis_of
from tt_precise.runtime.values import Arithmetic, Array, Check, InputError, Verdict
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState
from tt_precise.scene.start import LIFTED

SAME_START = 1e-5  # The scene's start is copied into a simulator through 32-bit floats at worst.
PASSES, TIMES = 9, 65  # of a search for a time; each pass divides the span by 16
# Digits with which the solution decides alone: it sees clock, attitude and force together.
DECIDING = 3.0
SAME_COLUMN = 1e-6  # Two sets in one file come from one state: only rounding can separate them.
MOST_IN_DOUBLE = 15.0  # required digits that differences of doubles can show
# Interval without a row, in intervals of the scene's samples or in parts of the motion, from which
# rows are missing; relative difference of most intervals of evenly spaced rows.
MISSING_ROW, SHARE, EVEN = 1.5, 0.1, 1e-3
Texts = Callable[[Sequence[str]], Mapping[str, Sequence[Any]]]

# ---- the start ---------------------------------------------------------------------------------


class Begin(NamedTuple):
    """The check of the first row, and its time (s) on the solution; None if it is not on it."""

    check: Check
    time: float | None = None


def find_start(rows: Rows, t_first: float, solution: TrueSolution) -> Begin:
    """Compare the first row with the scene's start, and with its solution at the row's own time.

    Raises ``InputError``: the solution cannot be integrated so far.
    """
    meaning = "the first row is the scene's start, or its solution at the row's time"
    assumed, bound, units = rows.assumed, 16 * rows.rounding, rows.units
    if assumed.start == "other":
        return Begin(Check("start", "skipped", note="another start is meant", meaning=meaning))
    own = numpy.array([float(values[0]) for values in rows.state[:8]])
    scale = numpy.repeat([1.0, units["L"], units["v"]], (3, 3, 2))
    start = InitialState.in_si(assumed.scene, Arithmetic(numpy, float))
    states = [(0.0, SAME_START, numpy.array(start.vectors[:8], float))]
    if assumed.friction == "scene" and 0 < t_first <= float(assumed.scene.until):
        later = solution.vectors(numpy.array([t_first]))
        states += [] if later is None else [(t_first, 10.0**-DECIDING, later[:, 0])]

    def compare(time: float, limit: float, true: Array) -> Begin:
        differences = abs(own - true) / scale
        worst = int(numpy.nanargmax(differences))  # an unknown velocity is NaN
        difference = float(differences[worst])
        check = Check("start", "pass", difference, limit, 0.0, "", meaning, bound=bound or None)
        if difference <= limit + bound:
            note = f"the scene's start, at t = {t_first:.12g} s in the file" if t_first else ""
            note = f"the solution at t = {time:.6g} s" if time else note
            return Begin(replace(check, note=note), time)
        note = (
            f"another start than the scene's ({NewtonState._fields[worst]} {own[worst]:.6g}, the "
            f"scene's {true[worst]:.6g}); use --start other if intended"
        )
        return Begin(replace(check, verdict="fail", note=note, since=0.0))

    begins = [compare(*state) for state in states]
    drift = abs(float(jellett(rows.first) - jellett(start.motion(numpy))))
    conserved = drift <= (SAME_START + bound) * rows.body.R * units["L"]
    if conserved and all(begin.time is None for begin in begins):
        late = _nearest_time(own, scale, solution, float(rows.t[1]))
        begins += [] if late is None else [compare(late[0], SAME_START, late[1])]
    passing = [begin for begin in begins if begin.time is not None]
    if passing:
        return min(passing, key=lambda begin: begin.check.value or 0.0)
    if assumed.friction == "other" and t_first:
        note = f"the file begins at t = {t_first:.6g} s: add the row at 0, or --start other"
        return Begin(Check("start", "open", note=note, meaning=meaning))
    return begins[0]


def _nearest_time(
    own: Array, scale: Array, solution: TrueSolution, span: float
) -> tuple[float, Array] | None:
    """Return the time (s) up to ``span`` at which the solution is nearest, and the state there."""
    middle, width, there = span / 2, span / 2, own
    for _ in range(PASSES):
        times = numpy.clip(numpy.linspace(middle - width, middle + width, TIMES), 0.0, span)
        states = solution.vectors(times)
        if states is None:
            return None
        apart = abs(states - own[:, None]) / scale[:, None]
        nearest = int(numpy.argmin(numpy.nanmax(apart, axis=0)))
        middle, width, there = float(times[nearest]), width / 16, states[:, nearest]
    return middle, there


# ---- columns that the state determines ---------------------------------------------------------

# Columns that the direction of the axis decides, and columns that the velocity decides.
HORIZONTAL = {f"{vector}{axis}" for vector in "kLvw" for axis in "xy"} | {"phi", "vcx", "vcy"}
VELOCITIES = {"vx", "vy", "nu_x", "nu_y", "vcx", "vcy"}


def derived_columns(rows: Rows) -> dict[str, tuple[Array, Array]]:
    """Return the columns that the state determines, each with the size of an error of it."""
    zero, body = 0 * rows.t, rows.body
    vectors = NewtonState(*(values + zero for values in rows.state[:8]))
    euler = euler_from_vectors(body, vectors, numpy)
    psi_dot = euler.omega_3 - euler.phi_dot * vectors.kz
    values = {**vectors._asdict(), **euler._asdict(), "psi_dot": psi_dot}
    still = {} if rows.has_velocity else {"vx": zero, "vy": zero}
    by_name = sizes(body, {**values, **still}, numpy)
    values |= {"phi": numpy.arctan2(vectors.ky, vectors.kx)}
    values |= zip(OMEGA, rows.omega, strict=True)
    values |= zip(VELOCITY, (component + zero for component in rows.q.s_dot), strict=True)
    by_name["phi"] = 1 / numpy.hypot(vectors.kx, vectors.ky)
    by_name |= dict.fromkeys(OMEGA, by_name["Lz"] / min(body.I1, body.I3))
    by_name |= dict.fromkeys(VELOCITY, by_name["vx"])
    unknown = set() if rows.assumed.columns.azimuth else HORIZONTAL
    unknown = unknown | (set() if rows.has_velocity else VELOCITIES)
    return {name: (values[name], by_name[name]) for name in values if name not in unknown}


def agreement(rows: Rows, followed: set[str]) -> Check:
    """Compare the columns that the state determines; ``followed`` are other columns looked at."""
    meaning = "columns beside those of the state agree with it, each relative to its size"
    columns, bound = rows.assumed.columns, 4 * rows.rounding
    extra = [n for n in rows.columns if n not in ("t", *columns.names, *columns.height)]
    if not extra:
        return Check("agreement", "pass", 0.0, SAME_COLUMN, 0.0, "no further columns", meaning)
    derived, errors = derived_columns(rows), {"": 0 * rows.t}
    for name, (values, size) in derived.items():
        if name in extra:
            errors[name] = without_revolutions(name, rows.columns[name] - values) / size
    if "qw" in extra and columns.azimuth:  # the turn about the axis is no part of the state
        axis = numpy.array(axis_of(*(rows.columns[name] for name in QUATERNION)))
        errors["the quaternion"] = norm(axis - rows.motion.k)
    for name, error in errors.items():  # ``finite`` counts what is not finite
        errors[name] = numpy.where(numpy.isfinite(error), numpy.fmax(abs(error) - bound, 0), 0.0)
    worst = max(errors, key=lambda name: float(errors[name].max()))
    row = int(numpy.argmax(errors[worst]))
    value, t = float(errors[worst][row]), float(rows.t[row])
    if value > SAME_COLUMN:
        note = f"{worst} does not agree with the {columns.name} columns"
        return Check("agreement", "fail", value, SAME_COLUMN, t, note, meaning, since=t)
    left = [name for name in extra if name not in derived and name not in followed]
    note = f"{', '.join(left)} not looked at" if left else f"checked {', '.join(extra)}"
    return Check("agreement", "open" if left else "pass", value, SAME_COLUMN, t, note, meaning,
                 bound=bound or None)  # fmt: skip


# ---- the solution ------------------------------------------------------------------------------


def distance(
    rows: Rows, texts: Texts | None, begin: Begin, t_first: float, until: float,
    digits: float | None, alone: float | None, solution: TrueSolution,
) -> Check:  # fmt: skip
    """Return the correct digits of every column, compared with the scene's solution.

    If ``digits`` are required, so are rows up to the time ``until`` (s). ``alone`` is the relative
    rounding of the file where the solution has to decide without the equations, else None.

    Raises ``InputError``: digits are required, but too few rows can be compared.
    """
    meaning, scene, time = "correct digits of every column", rows.assumed.scene, begin.time
    for option in ("friction", "start"):
        if getattr(rows.assumed, option) == "other":
            note = f"the scene's solution has the scene's own {option}"
            return Check("golden", "skipped", note=note, meaning=meaning)
    if time is None and not 0 <= t_first <= float(scene.until):
        note = "the first row is no state of the solution"
        return Check("golden", "skipped", note=note, meaning=meaning)
    time = t_first if time is None else time
    solution.require_golden()
    in_double = (digits or 0) <= MOST_IN_DOUBLE
    try:
        measured = solution.distance(
            _compared_rows(rows, None if in_double else texts, time), digits
        )
        number, count, by_column = int(measured.compared[1:].sum()), len(rows.t) - 1, {}
        for name, value in measured.fewest().items():  # equal doubles are equal up to rounding
            by_column[name] = min(value, -math.log10(EPS / 2)) if in_double else value
        worst = min(by_column.values(), default=0.0)
        if not measured.compared.any() or (not number and worst >= 1):
            reason = measured.ended or "no row could be compared with the solution"
            raise InputError(f"digits: {reason}")
        if digits is not None and worst >= digits:
            whole = t_first == time == 0
            end = min(until, measured.last) if whole else float(measured.t[-1])
            _require_coverage(measured, digits, end, float(scene.sample_every))
    except InputError as error:
        if digits is not None:
            raise
        return Check("golden", "open", note=str(error), meaning=meaning)
    compared = f"{number} rows" if number == count else f"{number} of {count} rows"
    note = "; ".join(filter(None, [f"{compared} compared {measured.how}", measured.ended]))
    required = digits or 0.0
    limit = required if alone is None else max(DECIDING, required)
    verdict: Verdict = "pass" if worst >= limit else "fail"
    if required <= worst < limit and 10.0**-worst <= 10.0**-limit + (alone or 0.0):
        verdict, note = "open", f"the file has too few digits; {note}"
    at = None if measured.at is None else measured.at - time
    return Check(
        "golden", verdict, worst, limit or None, at, note, meaning, "at least",
        {name: round(value, 2) for name, value in by_column.items()},
        _over_time(measured, time),
    )  # fmt: skip


def _compared_rows(rows: Rows, texts: Texts | None, time: float) -> ComparedRows:
    """Return the columns to compare, from the time ``time`` (s) of the solution on.

    With ``texts`` their original numbers are exact; columns that are derived or counted from
    another origin are doubles.
    """
    comparable = {*NewtonState._fields, *EulerState._fields, *TRACK}
    comparable |= {*LIFTED} if rows.has_height else set()
    comparable -= {"vx", "vy", "nu_x", "nu_y"} if rows.assumed.rolling else set()
    values = {name: column for name, column in rows.columns.items() if name in comparable}
    exact = {*values} if texts else set()
    if rows.assumed.columns.name == "rigid body":
        names = (*NewtonState._fields, *LIFTED)[: 10 if rows.has_height else 8]
        names = names if rows.has_velocity else names[:6]
        values |= {n: getattr(rows.state, n) for n in names if n in comparable - {*values}}
    for name in {"psi", "x", "y"} & {*values}:  # they count from anywhere, in a solution from 0
        size = 1.0 if name == "psi" else rows.body.R
        if time == 0 and abs(values[name][0]) > SAME_START * size:
            values[name] = values[name] - values[name][0]
            exact -= {name}
    if texts is None:
        return ComparedRows(rows.t + time, values)
    cells = texts(["t", *exact])

    def exactly(row: int, names: Sequence[str]) -> list[Any]:
        return [cells[name][row] if name in exact else float(values[name][row]) for name in names]

    def exact_time(row: int) -> Fraction:
        own, first = (as_fraction(cells["t"][i]) for i in (row, 0))
        return own if time == float(first) else own - first + Fraction(time)

    return ComparedRows(rows.t + time, values, exactly, exact_time)


def _require_coverage(measured: Distance, digits: float, end: float, spacing: float) -> None:
    """Raise ``InputError`` if a row was not compared, or if rows are missing up to ``end`` (s).

    Then an interval is long beside the motion and the scene's ``spacing`` (s), or more evenly
    spaced rows fit into the motion.
    """
    t = measured.t
    missed = t[1:][~measured.compared[1:]]
    if len(missed):
        raise InputError(
            f"digits: {len(missed)} of {len(t) - 1} rows after the start could not be compared to "
            f"{digits:g} digits, first that at t = {missed[0]:.6g} s"
            + (f"; {measured.ended}" if measured.ended else "")
        )
    steps = numpy.diff(t)
    usual = float(numpy.sort(steps)[len(steps) // 2])
    even = (abs(steps - usual) <= EVEN * usual).mean() > 1 - SHARE
    fitting = math.floor((end - t[0]) / usual + EVEN)
    t = numpy.append(t, end)
    steps = numpy.diff(t)
    gap = int(numpy.flatnonzero(steps >= (1 - EVEN) * steps.max())[-1])
    since, later = float(t[gap]), float(t[gap + 1])
    widest = max(SHARE * (end - t[0]), MISSING_ROW * spacing)
    if later - since > widest or (even and fitting >= len(steps)):
        raise InputError(
            f"digits: there is no row between t = {since:.6g} and {later:.6g} s, expected one "
            f"every {usual if even else widest:.3g} s"
        )


def _over_time(measured: Distance, begin: float) -> str:
    """Return digits in words, as in "6 digits until 1.2 s, none from 5 s", from ``begin`` on."""
    rows = measured.compared & (measured.t > 0)
    t, worst = measured.t[rows] - begin, numpy.maximum.accumulate(measured.worst()[rows])
    words: list[str] = []
    for digits in (12, 6, 3, 1):
        good = int(numpy.searchsorted(worst, 10.0**-digits, side="right"))
        if good == len(t) > 0:
            return ", ".join([*words, f"{digits} digit{'s' * (digits > 1)} to the end"])
        if good:
            words.append(f"{digits} digit{'s' * (digits > 1)} until {t[good - 1]:.3g} s")
    none = t[worst > 0.1]
    return ", ".join([*words, f"none from {none[0]:.3g} s"] if len(none) else words)
