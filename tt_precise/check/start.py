"""The check of the first row: the scene's start, or a state of the scene's solution.

The first row is compared with the start, then with the solution at the row's own time, then with
the solution at any time: a log may count from 100 s or from 1970, and a run may be a restart.
Starts that differ by a rotation about the vertical are equal. The bound of the comparison includes
half a unit of the last written place.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy

from tt_precise.check.columns import Samples, change_by_rounding
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import jellett
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Arithmetic, Array, Check
from tt_precise.scene.initial_state import InitialState

NAME = "start"
MEANING = "the first row is the scene's start, or a state of its solution"
# The scene's start is copied into a simulator, through 32-bit floats at worst.
LIMIT = 1e-5
# A state of the solution at the row's own time has as many digits as a solution that decides.
LATER = 1e-3
LEAST_ROTATION = 1e-9  # rad; axes that are turned by less are not turned
# A state is sought at so many times per radian of the spin, which resolves the nutation, and at no
# more than so many: motions in pieces are read at 3 ms a time.
TIMES_PER_RADIAN, MOST_TIMES = 20, 20_000
DOUBLE = Arithmetic(numpy, float)

Solution = Callable[[Array], "Array | None"]
"""Vectors (components, times) of the solution at these times (s); None if it does not reach."""


class Begin(NamedTuple):
    """The start of the rows: the solution's time (s) at the first row, or None.

    ``turn`` is the angle (rad) by which their horizontal axes are turned from the scene's.
    """

    finding: Check
    time: float | None = None
    turn: float = 0.0


def look_for_start(rows: Samples, t_first: float, solution: Solution) -> Begin:
    """Return where rows begin whose first row has the time ``t_first`` (s) in the file."""
    setup = rows.setup
    if setup.start == "other":
        note = "another start is meant"
        return Begin(Check(NAME, "skipped", note=note, meaning=MEANING))
    first = _first(rows)
    units, bound = _units(rows), rounding(rows)
    start = InitialState.in_si(setup.scene, DOUBLE).vectors
    apart, turn = _apart(rows, first, numpy.array(start, float)[: len(first)], units)
    own = None
    if setup.friction == "scene" and 0 < t_first <= float(setup.scene.until):
        own = _compare(rows, t_first, solution, LATER + bound)
    if apart <= LIMIT + bound and (own is None or apart <= (own.finding.value or 0.0)):
        note = "" if not t_first else f"the scene's start, at t = {t_first:.12g} s in the file"
        if turn:
            note = f"the scene's start in axes turned by {turn:.6g} rad about the vertical"
        return Begin(_finding("pass", apart, bound, note), 0.0, turn)
    if setup.friction == "other":
        if t_first == 0:
            return Begin(_finding("fail", apart, bound, _differing(rows, start)))
        note = f"the file begins at t = {t_first:.6g} s: add the row at 0, or --start other"
        return Begin(Check(NAME, "open", note=note, meaning=MEANING))
    if own is None and _jellett_apart(rows) <= LIMIT + bound:
        time = _nearest_time(rows, solution)
        own = None if time is None else _compare(rows, time, solution, LIMIT + bound)
    if own is not None:
        return own
    return Begin(_finding("fail", apart, bound, _differing(rows, start)))


def _compare(rows: Samples, time: float, solution: Solution, limit: float) -> Begin | None:
    """Compare the first row with the solution at a time; None for different states."""
    true = solution(numpy.array([time]))
    if true is None or _jellett_apart(rows) > limit:
        return None
    first = _first(rows)
    apart, turn = _apart(rows, first, true[:, 0], _units(rows))
    if not apart <= limit:
        return None
    found = _finding("pass", apart, 0.0, f"the solution at t = {time:.6g} s", limit)
    return Begin(found, time, turn)


def _finding(verdict: str, value: float, bound: float, note: str, limit: float = LIMIT) -> Check:
    return Check(
        NAME, "pass" if verdict == "pass" else "fail", value, limit, 0.0, note, MEANING,
        bound=bound, since=None if verdict == "pass" else 0.0,
    )  # fmt: skip


def _first(rows: Samples) -> Array:
    """The vectors of the first row; NaN where the velocity is unknown."""
    return numpy.array(rows.first.state[:8], float)


def _units(rows: Samples) -> Array:
    """The size of each component in the first row, by the rule of digits."""
    names = NewtonState._fields
    first = {name: float(x) for name, x in zip(names, _first(rows), strict=True)}
    # without a velocity its size is that of the other parts
    still = {name: 0.0 if math.isnan(value) else value for name, value in first.items()}
    found = sizes(rows.setup.body, still, numpy)
    return numpy.array([float(found[name]) for name in names])


def _apart(rows: Samples, first: Array, true: Array, units: Array) -> tuple[float, float]:
    """The relative difference of two states up to a rotation about z, and its angle (rad)."""
    a, b = first / units, true / units
    known = ~numpy.isnan(a)
    if not known[:6].all():  # only a velocity may be unknown: this is no state
        return math.inf, 0.0
    straight = float(abs(a - b)[known].max())
    if straight <= LEAST_ROTATION or not rows.setup.columns.azimuth:
        return straight, 0.0
    pairs = [(0, 1), (3, 4), (6, 7)]
    there = [(complex(a[i], a[j]), complex(b[i], b[j])) for i, j in pairs if known[i]]
    turn = cmath.phase(sum(x * y.conjugate() for x, y in there))
    back = complex(math.cos(turn), -math.sin(turn))
    off = [abs(x * back - y) for x, y in there]
    upright = [abs(a[i] - b[i]) for i in (2, 5)]
    least = float(max(*off, *upright))
    return (
        (least, turn) if least < straight / 10 and abs(turn) > LEAST_ROTATION else (straight, 0.0)
    )


def _jellett_apart(rows: Samples) -> float:
    own = float(jellett(rows.first))
    start = InitialState.in_si(rows.setup.scene, DOUBLE)
    scene = float(jellett(start.motion(numpy)))
    return abs(own - scene) / (abs(scene) or float(start.body.R * _spin(start.vectors)) or 1.0)


def _spin(state: NewtonState | LiftedState) -> float:
    return math.sqrt(state.Lx**2 + state.Ly**2 + state.Lz**2)


def _nearest_time(rows: Samples, solution: Solution) -> float | None:
    """The time at which the solution comes nearest to the first row, by halving its spacing."""
    first, units = _first(rows), _units(rows)
    omega = rows.first.omega
    begin, end = 0.0, float(rows.setup.scene.until)
    turned = math.sqrt(dot(omega, omega)) * end
    count = math.ceil(min(TIMES_PER_RADIAN * turned, MOST_TIMES)) + 1
    for _ in range(8):
        times = numpy.linspace(begin, end, count)
        true = solution(times)
        if true is None:
            return None
        apart = (true[: len(first)] - first[:, None]) / units[:, None]
        if rows.setup.columns.azimuth:  # turned about z all are the same
            kept = [apart[2], apart[5]]
            kept += [
                numpy.hypot(true[i], true[i + 1]) / units[i]
                - math.hypot(*first[i : i + 2]) / units[i]
                for i in (0, 3)
            ]
            apart = numpy.array(kept)
        nearest = int(numpy.argmin(numpy.nansum(apart**2, axis=0)))
        begin, end = times[max(nearest - 1, 0)], times[min(nearest + 1, count - 1)]
        count = 21
    return float(times[nearest])


def _differing(rows: Samples, start: NewtonState | LiftedState) -> str:
    """Name the quantity in which the first row differs most from the start."""
    scene = InitialState.in_si(rows.setup.scene, DOUBLE).motion(numpy)
    parts = {
        "Jellett's integral": (float(jellett(rows.first)), float(jellett(scene))),
        "cos theta": (float(rows.first.k[2]), float(scene.k[2])),
    }
    named = [
        f"{name} {got:.6g}, the scene's {expected:.6g}"
        for name, (got, expected) in parts.items()
        if not abs(got - expected) <= LIMIT * abs(expected)
    ]
    words = "; ".join(named) or "the velocities differ"
    return f"another start than the scene's ({words}); use --start other if intended"


def rounding(rows: Samples) -> float:
    """Return the change of the first row by half a unit of the last place, relative to its size."""

    def first_row(part: Samples) -> Array:
        return numpy.array([float(entry[0]) for entry in part.state[:8]]) / _units(rows)

    return float(numpy.fmax.reduce(change_by_rounding(rows, first_row), initial=0.0))
