"""Checks against the scene: its start, the columns beside the state, and its solution.

The first row is the scene's start or a state of its solution: a log may count from 100 s, and a run
may be a restart. Columns beside those of the state must agree with it. The distance from the
solution counts digits by the rule of ``mechanics.digits``, in double up to 15 required digits, in
the file's own digits above.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

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
from tt_precise.runtime.values import Arithmetic, Array, Check, InputError
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState
from tt_precise.scene.start import LIFTED

SAME_START = 1e-5  # The scene's start is copied into a simulator through 32-bit floats at worst.
# Digits with which the solution decides alone: it sees clock, attitude and force together.
DECIDING = 3.0
SAME_COLUMN = 1e-6  # Two sets in one file come from one state: only rounding can separate them.
MOST_IN_DOUBLE = 15.0  # required digits that differences of doubles can show
DOUBLE = Arithmetic(numpy, float)
LEAST_TURN = (
    1e-9  # Angle (rad) below which axes are not turned: rounding of a 32-bit float is more.
)
# Times per radian of spin among which a state is sought, which resolves the nutation, and the most.
TIMES_PER_RADIAN, MOST_TIMES = 20, 20_000
MOST_MINIMA = 8  # Local minima of the distance that are refined.
# Interval without a row, in usual ones, half way to a missing row; share of the motion from which
# rows count as missing; relative difference of most intervals of evenly spaced rows.
MISSING_ROW, SHARE, EVEN = 1.5, 0.1, 1e-3
PAIRS = ((0, 1), (3, 4), (6, 7))  # horizontal components of k, L and v_A
Texts = Callable[[Sequence[str]], Mapping[str, Sequence[Any]]]


# ---- the start ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Begin:
    """The check of the first row, and its position on the solution.

    ``time`` is in s, None if the row is no state of the solution; ``turn`` (rad) is the angle by
    which the file's axes are turned about the vertical.
    """

    check: Check
    time: float | None = None
    turn: float = 0.0


def find_start(rows: Rows, t_first: float, solution: TrueSolution) -> Begin:
    """Compare the first row with the scene's start, then with its solution at any time.

    Raises ``InputError``: the solution cannot be integrated so far.
    """
    meaning = "the first row is the scene's start, or a state of its solution"
    if rows.assumed.start == "other":
        return Begin(Check("start", "skipped", note="another start is meant", meaning=meaning))
    scene = rows.assumed.scene
    bound, start = 16 * rows.rounding, numpy.array(_scene_start(rows).vectors, float)[:8]

    def result(difference: float, note: str, limit: float = SAME_START) -> Check:
        good = difference <= limit + bound
        return Check("start", "pass" if good else "fail", difference, limit, 0.0, note, meaning,
                     bound=bound or None, since=None if good else 0.0)  # fmt: skip

    def at(time: float, limit: float) -> Begin | None:
        true = solution.vectors(numpy.array([time]))
        if true is None or _jellett_difference(rows) > limit + bound:
            return None
        difference, turn = _difference(rows, true[:, 0])
        if not difference <= limit + bound:
            return None
        return Begin(result(difference, f"the solution at t = {time:.6g} s", limit), time, turn)

    difference, turn = _difference(rows, start)
    later = None
    if rows.assumed.friction == "scene" and 0 < t_first <= float(scene.until):
        later = at(t_first, 10.0**-DECIDING)
    near = difference <= SAME_START + bound
    if near and (later is None or difference <= (later.check.value or 0.0)):
        note = f"the scene's start, at t = {t_first:.12g} s in the file" if t_first else ""
        note = f"the scene's start in axes turned by {turn:.6g} rad" if turn else note
        return Begin(result(difference, note), 0.0, turn)
    if rows.assumed.friction == "other" and t_first:
        note = f"the file begins at t = {t_first:.6g} s: add the row at 0, or --start other"
        return Begin(Check("start", "open", note=note, meaning=meaning))
    if later is None and _jellett_difference(rows) <= SAME_START + bound:
        time = _nearest_time(rows, solution)
        later = None if time is None else at(time, SAME_START)
        if later is not None and rows.assumed.friction == "other":
            later = Begin(later.check)
    return later or Begin(result(difference, _other_start(rows, start)))


def _scene_start(rows: Rows) -> InitialState:
    return InitialState.in_si(rows.assumed.scene, DOUBLE)


def _first_row(rows: Rows) -> Array:
    """Return the vectors of the first row; NaN where the velocity is unknown."""
    return numpy.array([float(values[0]) for values in rows.state[:8]])


def _units(rows: Rows) -> Array:
    units = rows.units
    return numpy.repeat([1.0, units["L"], units["v"]], (3, 3, 2))


def _difference(rows: Rows, true: Array) -> tuple[float, float]:
    """Return the relative difference of the first row up to a turn about z, and the turn (rad)."""
    own, other = _first_row(rows) / _units(rows), true / _units(rows)
    finite = ~numpy.isnan(own)
    straight = float(abs(own - other)[finite].max())
    if straight <= LEAST_TURN or not rows.assumed.columns.azimuth:
        return straight, 0.0
    pairs = [(complex(own[i], own[j]), complex(other[i], other[j])) for i, j in PAIRS if finite[i]]
    turn = cmath.phase(sum(x * y.conjugate() for x, y in pairs))
    back = cmath.exp(-1j * turn)
    turned = max(*(abs(x * back - y) for x, y in pairs), *(abs(own[i] - other[i]) for i in (2, 5)))
    return (turned, turn) if turned < straight / 10 and abs(turn) > LEAST_TURN else (straight, 0.0)


def _jellett_difference(rows: Rows) -> float:
    """Return the relative difference of Jellett's integral from the scene's."""
    own, start = float(jellett(rows.first)), _scene_start(rows)
    scene = float(jellett(start.motion(numpy)))
    return abs(own - scene) / (abs(scene) or rows.body.R * rows.units["L"])


def _nearest_time(rows: Rows, solution: TrueSolution) -> float | None:
    """Return the time (s) at which the solution comes nearest to the first row.

    The motion nutates, so that several times are near: the best local minima are refined.
    """
    units = _units(rows)
    own = _in_own_axes(_first_row(rows)[:, None] / units[:, None])
    end = float(rows.assumed.scene.until)
    count = math.ceil(min(TIMES_PER_RADIAN * rows.spin_rate * end, MOST_TIMES)) + 1

    def differences(times: Array) -> Array | None:
        true = solution.vectors(times)
        if true is None:
            return None
        squares = abs(_in_own_axes(true / units[:, None]) - own) ** 2
        total: Array = numpy.nansum(squares, axis=0)
        return total

    times = numpy.linspace(0.0, end, count)
    coarse = differences(times)
    if coarse is None:
        return None
    padded = numpy.pad(coarse, 1, constant_values=numpy.inf)
    minima = numpy.flatnonzero((coarse <= padded[:-2]) & (coarse <= padded[2:]))
    nearest, least = 0.0, math.inf
    for index in minima[numpy.argsort(coarse[minima])][:MOST_MINIMA].tolist():
        width, time = end / (count - 1), float(times[index])
        for _ in range(10):  # each pass divides the interval by ten
            fine = numpy.linspace(max(time - width, 0.0), min(time + width, end), 21)
            distances = differences(fine)
            if distances is None:
                return None
            time, width = float(fine[int(numpy.argmin(distances))]), width / 10
        distance_there = differences(numpy.array([time]))
        if distance_there is not None and distance_there[0] < least:
            nearest, least = time, float(distance_there[0])
    return nearest


def _in_own_axes(vectors: Array) -> Array:
    """Return vectors (8, n) in axes that turn about z with the axis, as complex numbers."""
    k, L, v = (vectors[i] + 1j * vectors[j] for i, j in PAIRS)
    direction = k.conj() / numpy.maximum(abs(k), LEAST_TURN)
    return numpy.array([vectors[2] + 0j, vectors[5], abs(k), L * direction, v * direction])


def _other_start(rows: Rows, start: Array) -> str:
    """Return in words how the first row differs from the scene's start."""
    scene = _scene_start(rows).motion(numpy)
    pairs = {
        "Jellett's integral": (float(jellett(rows.first)), float(jellett(scene))),
        "cos theta": (float(rows.first.k[2]), float(scene.k[2])),
        "|L|": (float(rows.units["L"]), math.sqrt(float((start[3:6] ** 2).sum()))),
    }
    words = [
        f"{name} {own:.6g}, the scene's {true:.6g}"
        for name, (own, true) in pairs.items()
        if not abs(own - true) <= SAME_START * abs(true)
    ]
    text = "; ".join(words) or "the velocities differ"
    return f"another start than the scene's ({text}); use --start other if intended"


# ---- columns that the state determines ---------------------------------------------------------


DERIVED = (*EulerState._fields, *NewtonState._fields, "psi_dot", "phi", *OMEGA, *VELOCITY)


def derived_column(rows: Rows, name: str) -> Array:
    """Return a column of ``DERIVED``, which the state of the rows determines."""
    state, values = rows.state, 0 * rows.t
    if name in NewtonState._fields:
        values = values + getattr(state, name)
    elif name == "phi":
        values = numpy.arctan2(state.ky, state.kx)
    elif name in (*OMEGA, *VELOCITY):
        vector = rows.omega if name in OMEGA else rows.q.s_dot
        values = values + vector["xyz".index(name[-1])]
    else:
        euler = euler_from_vectors(rows.body, NewtonState._make(state[:8]), numpy)
        psi_dot = euler.omega_3 - euler.phi_dot * state.kz
        values = values + (psi_dot if name == "psi_dot" else getattr(euler, name))
    return values


# Columns that the direction of the axis decides, and columns that the velocity decides.
HORIZONTAL = {f"{vector}{axis}" for vector in "kLvw" for axis in "xy"} | {"phi", "vcx", "vcy"}
VELOCITIES = {"vx", "vy", "nu_x", "nu_y", "vcx", "vcy"}


def agreement(rows: Rows, followed: set[str]) -> Check:
    """Compare the columns that the state determines; ``followed`` are other columns looked at."""
    meaning = "columns beside those of the state agree with it, each relative to its size"
    assumed = rows.assumed
    own = {"t", *assumed.columns.names, *assumed.columns.height}
    extra = [name for name in rows.columns if name not in own]
    if not extra:
        return Check("agreement", "pass", 0.0, SAME_COLUMN, 0.0, "no further columns", meaning)
    hidden = set() if assumed.columns.azimuth else HORIZONTAL
    hidden = hidden | (set() if rows.has_velocity else VELOCITIES)
    expected = {
        name: derived_column(rows, name) for name in extra if name in DERIVED and name not in hidden
    }
    left = [name for name in extra if name not in expected and name not in followed]
    bound, worst, wrong, at = 4 * rows.rounding, 0.0, "", 0
    columns = {name: (rows.columns[name], values) for name, values in expected.items()}
    column_sizes = _sizes(rows, expected)
    if "qw" in extra and assumed.columns.azimuth:  # the turn about the axis is no part of the state
        axis = numpy.array(axis_of(*(rows.columns[name] for name in QUATERNION)))
        columns["the quaternion"] = norm(axis - rows.motion.k), 0 * rows.t
        column_sizes["the quaternion"] = 1 + 0 * rows.t
    for name, (values, true) in columns.items():
        off = abs(without_revolutions(name, values - true)) / column_sizes[name] - bound
        off = numpy.where(numpy.isfinite(off), off, 0.0)  # ``finite`` counts the others
        row = int(numpy.argmax(off))
        if off[row] > max(worst, SAME_COLUMN):
            worst, wrong, at = float(off[row]), name, row
    t = float(rows.t[at])
    if wrong:
        note = f"{wrong} does not agree with the {assumed.columns.name} columns"
        return Check("agreement", "fail", worst, SAME_COLUMN, t, note, meaning, since=t)
    note = f"{', '.join(left)} not looked at" if left else f"checked {', '.join(extra)}"
    return Check("agreement", "open" if left else "pass", worst, SAME_COLUMN, t, note, meaning,
                 bound=bound or None)  # fmt: skip


def _sizes(rows: Rows, columns: Mapping[str, Array]) -> dict[str, Array]:
    """Return the size to which an error of each derived column is relative."""
    still = rows.state[:8] if rows.has_velocity else (*rows.state[:6], 0 * rows.t, 0 * rows.t)
    state = dict(zip(NewtonState._fields, still, strict=True))
    euler = {n: v for n, v in columns.items() if n in (*EulerState._fields, "psi_dot")}
    by_rule = sizes(rows.body, {**state, **euler}, numpy)
    omega = by_rule["Lz"] / min(rows.body.I1, rows.body.I3)
    further = dict.fromkeys(("wx", "wy", "wz"), omega)
    further |= dict.fromkeys(("vcx", "vcy", "vcz"), by_rule["vx"])
    further["phi"] = 1 / numpy.hypot(rows.state.kx, rows.state.ky)
    return {name: further.get(name, by_rule.get(name)) for name in columns}


# ---- the solution ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Demand:
    """The digits that are required, if any, and the time (s) up to which rows are.

    ``broken`` says why rows are missing at the end, "" if none are.
    """

    digits: float | None
    until: float = math.inf
    broken: str = ""


def distance(
    rows: Rows, texts: Texts | None, begin: Begin, t_first: float, demand: Demand,
    solution: TrueSolution,
) -> Check:  # fmt: skip
    """Return the correct digits of every column, compared with the scene's solution.

    Raises ``InputError``: digits are required, but too few rows can be compared.
    """
    meaning, scene, digits = "correct digits of every column", rows.assumed.scene, demand.digits
    for option in ("friction", "start"):
        if getattr(rows.assumed, option) == "other":
            note = f"the scene's solution has the scene's own {option}"
            return Check("golden", "skipped", note=note, meaning=meaning)
    time = begin.time
    if time is None:
        if not 0 <= t_first <= float(scene.until):
            note = "the first row is no state of the solution"
            return Check("golden", "skipped", note=note, meaning=meaning)
        time = t_first
    solution.require_golden()
    try:
        compared = _compared_rows(rows, texts if (digits or 0) > MOST_IN_DOUBLE else None, time,
                                  begin.turn)  # fmt: skip
        measured = solution.distance(compared, digits)
    except InputError as error:
        if digits is not None:
            raise
        return Check("golden", "open", note=str(error), meaning=meaning)
    by_column = measured.fewest()
    if (digits or 0) <= MOST_IN_DOUBLE:  # equal doubles are equal up to their rounding
        most = -math.log10(EPS / 2)
        by_column = {name: min(value, most) for name, value in by_column.items()}
    worst = min(by_column.values(), default=0.0)
    number, count = int(measured.compared[1:].sum()), len(rows.t) - 1
    if not measured.compared.any() or (not number and worst >= 1):
        reason = demand.broken or measured.ended or "no row could be compared with the solution"
        if digits is not None and not demand.broken:
            raise InputError(f"digits: {reason}")
        return Check("golden", "fail" if digits else "open", note=reason, meaning=meaning)
    few = digits is not None and worst < digits
    if digits is not None and not few and not demand.broken:
        last = min(time + demand.until, measured.last) if t_first == time == 0 else compared.t[-1]
        _require_coverage(compared.t, measured, digits, float(last), float(scene.sample_every))
    notes = [f"{number} rows compared {measured.how}", demand.broken, measured.ended]
    if number < count:
        notes.insert(1, f"{number} of {count} rows after the start in all")
    failed = few or (digits is not None and demand.broken)
    at = None if measured.at is None else measured.at - time
    return Check(
        "golden", "fail" if failed else "pass", worst, digits, at, "; ".join(filter(None, notes)),
        meaning, "at least", {name: round(value, 2) for name, value in by_column.items()},
        digits_over_time(measured, time),
    )  # fmt: skip


def _compared_rows(rows: Rows, texts: Texts | None, time: float, turn: float) -> ComparedRows:
    """Return the columns to compare, from the time ``time`` (s) of the solution on.

    With ``texts`` their original numbers are exact; columns that are derived, turned or counted
    from another origin are doubles.
    """
    comparable = {*NewtonState._fields, *EulerState._fields, *TRACK}
    comparable |= {*LIFTED} if rows.has_height else set()
    comparable -= {"vx", "vy", "nu_x", "nu_y"} if rows.assumed.rolling else set()
    values = {name: column for name, column in rows.columns.items() if name in comparable}
    exact = {*values} if texts and not turn else set()
    if rows.assumed.columns.name == "rigid body":
        names = (*NewtonState._fields, *LIFTED)[: 10 if rows.has_height else 8]
        names = names if rows.has_velocity else names[:6]
        values |= {n: getattr(rows.state, n) for n in names if n in comparable - {*values}}
    for name in ("psi", "x", "y"):  # they count from anywhere, in a solution from 0
        size = 1.0 if name == "psi" else rows.body.R
        if time == 0 and name in values and abs(values[name][0]) > SAME_START * size:
            values[name] = values[name] - values[name][0]
            exact -= {name}
    values = turn_about_z(values, turn) if turn else values
    if texts is None:
        return ComparedRows(rows.t + time, values)
    cells = texts(["t", *exact])

    def exactly(row: int, names: Sequence[str]) -> list[Any]:
        return [cells[name][row] if name in exact else float(values[name][row]) for name in names]

    def exact_time(row: int) -> Fraction:
        own, first = (as_fraction(cells["t"][i]) for i in (row, 0))
        return own if time == float(first) else own - first + Fraction(time)

    return ComparedRows(rows.t + time, values, exactly, exact_time)


def turn_about_z(columns: Mapping[str, Array], angle: float) -> dict[str, Array]:
    """Return the columns in axes that are turned by ``angle`` (rad) about z."""
    turned, c, s = dict(columns), math.cos(angle), math.sin(angle)
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy"), ("x", "y")):
        if x in columns and y in columns:
            turned[x] = c * columns[x] + s * columns[y]
            turned[y] = c * columns[y] - s * columns[x]
    if "phi" in columns:
        turned["phi"] = columns["phi"] - angle
    return turned


def _require_coverage(
    t: Array, measured: Distance, digits: float, end: float, spacing: float
) -> None:
    """Require that every row was compared, and that no row is missing up to ``end`` (s).

    Raises ``InputError``: it was not, or one is missing. Rows that are ``spacing`` (s) apart are
    never too far apart; a row that would not fit before the end is not missing.
    """
    if not measured.compared[1:].all():
        missed = t[1:][~measured.compared[1:]]
        raise InputError(
            f"digits: {len(missed)} of {len(t) - 1} rows after the start could not be compared to "
            f"{digits:g} digits, first that at t = {missed[0]:.6g} s"
            + (f"; {measured.ended}" if measured.ended else "")
        )
    steps = numpy.diff(t)
    usual = float(numpy.sort(steps)[len(steps) // 2])
    even = (abs(steps - usual) <= EVEN * usual).mean() > 1 - SHARE
    widest = max(SHARE * (end - t[0]), MISSING_ROW * spacing)
    widest = min(widest, MISSING_ROW * usual) if even else widest
    gap = int(numpy.argmax(steps))
    since, until, allowed = float(t[gap]), float(t[gap + 1]), widest
    if end - t[-1] > (usual * (1 - EVEN) if even else widest):
        since, until, allowed = float(t[-1]), end, usual if even else widest
    elif until - since <= widest:
        return
    remedy = f", or --until {since:.6g}" if since > 0 else ""
    raise InputError(
        f"digits: there is no row between t = {since:.6g} and {until:.6g} s, expected one every "
        f"{allowed:.3g} s{remedy}"
    )


def digits_over_time(measured: Distance, begin: float) -> str:
    """Return digits over time, as in "6 digits until 1.2 s, none from 5 s", counted from ``begin``.

    At most three numbers of digits are named; none that ends within 2 % of the motion, or less than
    a fifth later than the one before.
    """
    rows = measured.compared & (measured.t > 0)
    t, worst = measured.t[rows] - begin, numpy.maximum.accumulate(measured.worst()[rows])
    if not len(t):
        return ""
    spans: list[tuple[int, float]] = []
    for digits in (12, 10, 8, 6, 4, 2, 1):
        good = int(numpy.searchsorted(worst, 10.0**-digits, side="right"))
        until = float(t[good - 1]) if good else 0.0
        if good == len(t) or until > max(0.02 * t[-1], 1.2 * spans[-1][1] if spans else 0.0):
            spans.append((digits, until))
        if good == len(t):
            break
    words = [
        f"{digits} digit{'s' * (digits > 1)} "
        + ("to the end" if until == t[-1] else f"until {until:.3g} s")
        for digits, until in spans[:1] + spans[1:][-2:]
    ]
    if not spans or spans[-1][1] < t[-1]:
        none = numpy.flatnonzero(worst > 0.1)
        words.append(f"none from {t[none[0]]:.3g} s" if len(none) else "fewer then")
    return ", ".join(words)


def decides(check: Check) -> bool:
    """Test that the rows agree with the solution to as many digits as decide."""
    return check.verdict == "pass" and check.value is not None and check.value >= DECIDING


def decide_alone(check: Check, written: float) -> Check:
    """Return the check of a distance that has to decide without the equations.

    It is open where the rounding of the file, a relative error ``written``, may be the difference.
    """
    if check.value is None or check.verdict != "pass":
        return check
    limit = max(DECIDING, check.limit or 0.0)
    if check.value >= limit:
        return replace(check, limit=limit)
    if 10.0**-check.value <= 10.0**-limit + written:
        note = f"the file has too few digits; {check.note}"
        return replace(check, verdict="open", limit=limit, note=note)
    return replace(check, verdict="fail", limit=limit)
