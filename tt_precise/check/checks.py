"""The checks, one entry each: the condition on every row, the quantities it needs, and the limit.

``run`` of an entry returns one value for each row; the worst one decides. A check is open if
columns are missing or the rows do not resolve it, and skipped if it does not apply to the scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from numbers import Real
from typing import Any, NamedTuple

import numpy

from tt_precise.check import residuals
from tt_precise.check.residuals import FINE, StepResiduals, by_law, norm, unresolved
from tt_precise.check.rows import Rows
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS, OF_FLIGHT, OF_QUANTITY, Integral
from tt_precise.runtime.plotting import thinned
from tt_precise.runtime.values import Array, Check, InputError, Sense, require_name, shortened
from tt_precise.scene.numerals import LARGEST

PAPER_LIMIT = 1e-6  # "constant with precision of order 10^-6 lambda", section 2.1
# An interval counts ten times as much as the sum of the attitude since the start, and the mean
# torque twice as much as one interval: an integrator's errors add up in the attitude only.
INTERVAL_COUNTS, MEAN_COUNTS = 10.0, 2.0
MEAN_OVER = 10  # A mean torque over fewer intervals says no more than these intervals.
# Torque (m g R alpha) that a typical interval must show: a wrong convention is wrong by 1.
VISIBLE_TORQUE = 0.3
SINKING = 0.1  # Depth in R to which a table may give way under another force than the scene's.
MOST_MISSING = 0.5  # Part of the motion that the scene's law may leave unresolved.
LEADING = 2048  # Rows that must obey the scene's law before all rows are asked.
DENSE = 0.1  # Nutation (rad) from row to row up to which eight rows resolve linear friction.
FOLLOWING = 1e-3  # Distance from the equations up to which their motion between rows is theirs.
TOO_FEW_DIGITS = "the file has too few digits"


class Residual(NamedTuple):
    """The values of a check, one for each row, less what errors of the rows' digits explain.

    ``bound`` is the size of error that would go unnoticed. ``unresolved`` says why the rows do not
    decide, "" if they do. If it is ``decided`` so, a large bound alone does not open the check.
    """

    values: Array
    bound: float = 0.0
    note: str = ""
    unresolved: str = ""
    decided: bool = False


class RowCheck(NamedTuple):
    """A check: name, meaning, function, needed quantities (keys of ``absences``), limit."""

    name: str
    meaning: str
    run: Callable[[Rows], Residual]
    needs: tuple[str, ...] = ()
    limit: float = PAPER_LIMIT
    sense: Sense = "at most"

    def result(self, rows: Rows, limit: float) -> Check:
        """Return the result of the check for ``rows``."""
        absent = absences(rows)
        missing = [absent[need] for need in self.needs if need in absent]
        # a check that does not apply is skipped, whatever the file lacks besides
        for verdict, reason in sorted(missing, key=lambda each: each[0] != "skipped"):
            return Check(self.name, verdict, note=reason, meaning=self.meaning)
        return judge_values(self, rows.t, self.run(rows), limit)


def judge_values(check: RowCheck, t: Array, residual: Residual, limit: float) -> Check:
    """Return the verdict on values: the worst one, and the first one beyond the limit.

    A value that is NaN is beyond it.
    """
    values, sign = residual.values, 1.0 if check.sense == "at most" else -1.0
    badness = numpy.where(numpy.isnan(values), numpy.inf, sign * values)
    beyond = ~(badness <= sign * limit)
    worst, note, since = int(numpy.argmax(badness)), residual.note, None
    verdict: Any = "pass"
    few = check.sense == "at most" and residual.bound > limit and not residual.decided
    if beyond.any():
        verdict, since = "fail", float(t[int(numpy.argmax(beyond))])
    elif residual.unresolved or few:
        verdict = "open"
        note = residual.unresolved or f"{TOO_FEW_DIGITS} or rows; {note}".strip("; ")
    drawn = thinned(t, badness)
    return Check(
        check.name, verdict, float(sign * badness[worst]), limit, float(t[worst]), note,
        check.meaning, check.sense, since=since,
        bound=None if residual.unresolved else residual.bound or None,
        curve=(t[drawn], sign * badness[drawn]),
    )  # fmt: skip


# ---- needs -------------------------------------------------------------------------------------


def has_force(rows: Rows) -> bool:
    """Test that the contact force follows from the state."""
    return rows.assumed.friction == "scene" and _has_height(rows)


def _has_height(rows: Rows) -> bool:
    return rows.assumed.flying or rows.has_height or not rows.assumed.scene.lifts


def absences(rows: Rows) -> dict[str, tuple[Any, str]]:
    """Return what checks may need and the rows lack, by name: the verdict without it, and why."""
    assumed, columns, scene = rows.assumed, rows.assumed.columns, rows.assumed.scene
    flying, rolling, rigid = assumed.flying, assumed.rolling, not scene.lifts
    velocity, height = ", ".join(columns.velocity), ", ".join(columns.height)
    height = f"needs the height of the lowest point: columns {height}"
    dissipates = not (rolling or flying) and (scene.body.mu != 0 or bool(scene.body.spring))
    rises = "vcz" in rows.columns or (rows.has_height and not flying) or rolling
    needs: dict[str, tuple[bool, Any, str]] = {
        "azimuth": (columns.azimuth, "open",
                    "needs the direction of the axis, which Euler angles without phi lack"),
        "velocity": (rows.has_velocity, "open", f"needs the velocity: columns {velocity}"),
        "velocity columns": (not rolling or columns.velocity[0] in rows.columns, "skipped",
                             "v_A = 0 by construction"),
        "vertical velocity": (rises, "skipped", "needs the vertical velocity: column vcz"),
        "contact": (not flying, "skipped", "there is no contact"),
        "scene's force": (assumed.friction == "scene", "skipped",
                          "holds under the scene's own contact force only"),
        "height": (_has_height(rows), "open", height),
        "potential": (rows.has_height or rigid, "open", height),
        "rigid table": (rigid, "skipped", "the top may leave the table"),
        "dissipation": (dissipates, "skipped", "nothing is dissipated: see energy"),
        "axis": ("kx" in rows.columns, "skipped", "|k| = 1 by construction"),
        "quaternion": ("qw" in rows.columns, "skipped", "no quaternion among the columns"),
        "rows": (len(rows.t) >= FINE or obeys_scene(rows), "open", f"needs at least {FINE} rows"),
    }  # fmt: skip
    for name, integral in INTEGRALS.items():
        motion = "rolling" if name in ("routh", "modified_energy") else "frictionless gliding"
        holds = name == "energy" or integral.holds(scene.model, scene.body)
        needs[name] = (holds, "skipped", f"an integral of {motion} only")
    return {name: each[1:] for name, each in needs.items() if not each[0]}


# ---- row by row --------------------------------------------------------------------------------


def _beyond(rows: Rows, values: Array, roundings: float) -> Residual:
    """Return values beyond so many times the rounding of the file."""
    slack = roundings * rows.rounding
    left = numpy.where(numpy.isnan(values), numpy.nan, numpy.fmax(values - slack, 0.0))
    return Residual(left, slack)


def _integral(integral: Integral) -> RowCheck:
    """Return the check of a conserved quantity: its change since the start over its scale."""
    needs = [integral.name] + ["azimuth"] * integral.azimuth
    needs += ["scene's force", "height"] if integral.name != "jellett" else []
    needs += ["velocity"] if integral.name in ("momentum_x", "momentum_y") else []

    def run(rows: Rows) -> Residual:
        scale = float(integral.scale(rows.first)) or 1.0
        change = integral.evaluate(rows.q) - integral.evaluate(rows.first)
        return _beyond(rows, abs(change) / scale + 0 * rows.t, 4.0)

    return RowCheck(integral.name, integral.meaning, run, tuple(needs))


def _energy(rows: Rows) -> Residual:
    """Return the change of E where it is conserved, else its rise above the least value before."""
    integral, scene = INTEGRALS["energy"], rows.assumed.scene
    if integral.holds(scene.model, scene.body) and has_force(rows):
        return _integral(integral).run(rows)
    energy = residuals.total_energy(rows, rows.state)
    scale = float(abs(integral.scale(rows.first))) or 1.0
    return _beyond(rows, (energy - numpy.minimum.accumulate(energy)) / scale, 8.0)


def _contact(rows: Rows) -> Residual:
    """Return g_n/(m g) in the rows, and its minimum between rows that follow the equations."""
    values = quantities.g_n(rows.q) / (rows.body.m * rows.body.g) + 0 * rows.t
    if rows.assumed.scene.may_stick:
        return Residual(values)
    steps = by_law(rows)
    sums, _ = residuals.sums_since_start(steps.state, steps.bounds["state"])
    dips = (steps.least[0] < values.min()) & numpy.isfinite(steps.bounds["state"])
    at = numpy.flatnonzero(dips & (sums <= FOLLOWING))
    if len(at):
        y, spans = residuals.flow_state(rows.motion)[:, at], numpy.diff(rows.t)[at]
        between = residuals.law_of(rows).least_margins(y, spans, residuals.flow_sizes(rows))
        values[at + 1] = numpy.fmin(values[at + 1], between)
    return Residual(values)


def _contact_velocity(rows: Rows) -> Residual:
    """Return |v_A.z| (rolling: |v_A|) over R omega."""
    v_A, columns = rows.contact_velocity, rows.assumed.columns
    slip = norm(v_A) if rows.assumed.rolling else abs(v_A[2])
    if rows.assumed.rolling and columns.name != "rigid body":
        slip = norm(numpy.array([rows.columns[name] for name in columns.velocity]))
    deep = 1000 * float(_depth(rows).max())
    note = f"a soft contact, {deep:.2g} mm deep at most" if deep else ""
    return _beyond(rows, slip / rows.units["v"], 2.0)._replace(note=note)


def _depth(rows: Rows) -> Array:
    """Return how deep (m) the lowest point lies in a table that gives way to another force."""
    if rows.assumed.friction == "scene" or rows.motion.x is None:
        return 0 * rows.t
    deep = -rows.height
    return numpy.where((deep > PAPER_LIMIT * rows.body.R) & (deep < SINKING * rows.body.R), deep, 0)


def _fall(rows: Rows) -> Residual:
    rate = rows.contact_velocity[2] if rows.motion.v is None else rows.motion.v[2]
    return _beyond(rows, abs(rate - rate[0] + rows.body.g * rows.t) / rows.units["v"], 2.0)


def _length(rows: Rows, names: tuple[str, ...]) -> Residual:
    length = norm(numpy.array([rows.columns[name] for name in names]))
    return _beyond(rows, abs(length - 1), 2.0)


# ---- from row to row ---------------------------------------------------------------------------


def _excess(
    rows: Rows, values: Array, bound: Array, written: float = 1.0, ends: float = 2.0
) -> tuple[Array, Array, Array]:
    """Return residuals beyond what bounds and digits hide: of intervals, and of their sums.

    Digits hide ``written`` times the rounding of numbers and times at either end of an interval,
    and in a sum ``ends`` of them and, as rates turn the error of a row, the angle of the spin. The
    third array is what is hidden in sums. A value that is NaN is infinitely wrong.
    """
    written = written * (rows.rounding + rows.time_rounding)
    sums, error = residuals.sums_since_start(values, bound)
    hidden = error + written * (ends + rows.spin_rate * rows.t[1:])
    local = numpy.where(numpy.isinf(bound), 0.0, norm(values) - bound - 2 * written)
    local, sums = (numpy.fmax(numpy.where(numpy.isnan(x), numpy.inf, x), 0.0)
                   for x in (local, sums - hidden))  # fmt: skip
    return local, sums, hidden


def _by_scene(rows: Rows, values: Array, ends: float = 2.0) -> Residual:
    """Return the sums of residuals under the scene's law, the largest of all components."""
    bound = by_law(rows).bounds["state"]
    sums = [_excess(rows, component[None], bound, ends=ends)[1:] for component in values]
    largest, hidden = numpy.max([each for each, _ in sums], axis=0), float(sums[0][1][-1])
    missing = int(numpy.isinf(bound).sum())
    note = f"{missing} of {len(bound)} intervals not resolved" if missing else ""
    text = unresolved(rows, bound, MOST_MISSING)
    return Residual(numpy.append(0.0, largest), hidden, note, text)


def _equations(rows: Rows) -> Residual:
    return _by_scene(rows, by_law(rows).state)


def obeys_scene(rows: Rows) -> bool:
    """Test that the rows obey the scene's own equations; false where any force is resolved."""
    if "obeys scene" not in rows.cache:
        obeys = _has_height(rows) and rows.has_velocity and rows.rounding < PAPER_LIMIT
        if obeys and rows.assumed.friction == "other":
            linear = rows.assumed.smooth and rows.assumed.scene.body.friction.constant
            obeys = not linear or residuals.nutation(rows).max() > DENSE
            if obeys and len(rows.t) > LEADING:
                obeys = obeys_scene(rows.part(slice(LEADING)))
        if obeys:
            residual = _equations(rows)
            obeys = bool(residual.values.max() <= PAPER_LIMIT and residual.bound <= PAPER_LIMIT)
            obeys = obeys and not residual.unresolved
        rows.cache["obeys scene"] = obeys
    return bool(rows.cache["obeys scene"])


def deciding_steps(rows: Rows) -> tuple[StepResiduals, float]:
    """Return residuals by the scene's law where the rows obey it, else of any force.

    Rows that obey one law of force obey what holds under every law, at any spacing. The number is
    the part of the motion that may stay unresolved.
    """
    own = obeys_scene(rows)
    return (by_law(rows), MOST_MISSING) if own else (residuals.by_any_force(rows), 0.0)


def _kinematics(rows: Rows) -> Residual:
    """Return attitude (rad) and position (R) less the integrals of their rates, and the height."""
    steps, allowed = deciding_steps(rows)
    turn = "spin" if rows.motion.q is not None else "axis"
    parts = {turn: (steps.rotation, steps.bounds["rotation"])}
    looked = ["axis" if rows.assumed.columns.azimuth else "inclination"]
    looked += ["spin"] if turn == "spin" else []
    if rows.motion.x is not None and rows.has_velocity and rows.assumed.columns.azimuth:
        bound = steps.bounds["position"] / rows.body.R + 2 * rows.position_rounding
        for name, x, residual in zip("xyz", rows.motion.x, steps.position, strict=True):
            if not numpy.isnan(x).all():
                parts[name] = residual[None] / rows.body.R, bound
                looked.append(name)
    values, hidden, text = {}, 0.0, ""
    for name, (residual, bound) in parts.items():
        local, sums, error = _excess(rows, residual, bound)
        values[name] = numpy.append(0.0, numpy.fmax(INTERVAL_COUNTS * local, sums))
        hidden = max(hidden, float(error[-1]))
        text = text or unresolved(rows, bound, allowed)
    if "z" in rows.columns and not rows.assumed.scene.lifts:
        values["height"] = _off_table(rows)
        looked.append("height")
    worst = max(values, key=lambda name: float(values[name].max()))
    beyond = f"{worst} does not follow; " if values[worst].max() > 1e-2 else ""
    note, largest = f"{beyond}checked {', '.join(looked)}", numpy.max([*values.values()], axis=0)
    return Residual(largest, hidden, note, text, decided=True)


def _off_table(rows: Rows) -> Array:
    """Return how far (R) the lowest point is from the table, beyond the rounding of the file.

    Under another force the top may leave the table, or a table give way, but not at the start.
    """
    height = rows.height / rows.body.R
    if rows.assumed.friction == "other":
        height = numpy.maximum(numpy.where(rows.t == 0, height, 0.0 * height), -height) - SINKING
        height = numpy.maximum(height, 0.0)
    off: Array = numpy.maximum(abs(height) - 4 * rows.rounding - rows.position_rounding, 0.0)
    return off


def _contact_momentum(rows: Rows) -> Residual:
    """Return the torque about the lowest point beside weight and motion (m g R alpha)."""
    (steps, allowed), v = deciding_steps(rows), rows.motion.v
    assert v is not None
    deep, unit, size = _depth(rows), residuals.torque_unit(rows.body), 4 * rows.units["L"]
    # a soft contact may act anywhere between the lowest point and the table
    lever = numpy.fmax(deep[1:], deep[:-1]) * rows.body.m * norm(numpy.diff(v[:2]))
    bound = steps.bounds["momentum"] + lever
    local, sums, _ = _excess(rows, steps.momentum, bound, size, 1.0)
    h, span = numpy.diff(rows.t), rows.t[1:] - rows.t[0]
    mean = MEAN_COUNTS * sums / span
    mean[:MEAN_OVER] = 0.0
    values = numpy.append(0.0, numpy.fmax(mean, local / h) / unit)
    # a torque that turns with the nutation cancels in the mean: an interval must show it
    written = 2 * size * (rows.rounding + rows.time_rounding)
    typical = float(numpy.sort((bound + written) / (unit * h))[len(h) // 2])
    text = unresolved(rows, bound, allowed) or TOO_FEW_DIGITS * (typical > VISIBLE_TORQUE)
    return Residual(values, typical, "", text, decided=True)


def _normal_force(rows: Rows) -> Residual:
    """Return the mean F_z/(m g) from row to row."""
    assert rows.motion.v is not None
    change = numpy.diff(rows.motion.v[2]) + 2 * rows.rounding * rows.units["v"]
    return Residual(numpy.append(numpy.inf, 1 + change / numpy.diff(rows.t) / rows.body.g))


CHECKS = (
    _integral(INTEGRALS["jellett"]),
    RowCheck("energy", "E, with the energy of an elastic table: constant without friction, never "
             "rising with friction; section 1", _energy, ("potential", "velocity")),
    RowCheck("energy_balance", "E falls by the integral of mu g_n v_A^2; section 1",
             lambda rows: _by_scene(rows, by_law(rows).energy, 8.0),
             ("dissipation", "scene's force", "height", "velocity")),
    RowCheck("equations", "the state changes by the integral of its rates; eq (1)",
             _equations, ("scene's force", "height", "velocity")),
    RowCheck("contact", "g_n/(m g): the table pushes and never pulls; eq (7)", _contact,
             ("contact", "rigid table", "scene's force", "velocity"), -1e-12, "at least"),
    RowCheck("kinematics", "attitude (rad) and position (over R) follow the velocities, z stands "
             "at R (1 - alpha cos theta); every law", _kinematics, ("rows",), 1e-2),
    RowCheck("contact_momentum", "the angular momentum about the lowest point changes as weight "
             "and motion make it change (m g R alpha); every law", _contact_momentum,
             ("azimuth", "velocity", "height", "rows"), 1e-4),
    RowCheck("normal_force", "mean F_z/(m g) from row to row: the table does not pull; every law",
             _normal_force, ("contact", "velocity", "vertical velocity"), -1e-3, "at least"),
    RowCheck("contact_velocity", "v_A.z = 0 (rolling: v_A = 0), in R omega at the start",
             _contact_velocity,
             ("contact", "rigid table", "velocity", "velocity columns", "vertical velocity")),
    RowCheck("fall", "s_dot.z falls at g, in R omega at the start", _fall,
             ("velocity", "vertical velocity")),
    RowCheck("axis_norm", "|k| = 1", partial(_length, names=("kx", "ky", "kz")), ("axis",)),
    RowCheck("quaternion_norm", "|q| = 1",
             partial(_length, names=("qw", "qx", "qy", "qz")), ("quaternion",)),
    *(_integral(INTEGRALS[name]) for name in INTEGRALS
      if name not in ("jellett", "energy", "axis_norm")),
)  # fmt: skip
DEFAULT_LIMITS = {check.name: check.limit for check in CHECKS}
COSTLY = ("equations", "energy_balance", "contact", "kinematics", "contact_momentum")


def judge(rows: Rows, limits: Mapping[str, float]) -> Iterator[Check]:
    """Return the results of all checks of the scene's model, the cheapest first."""
    aloft = () if rows.assumed.flying else ("fall", *OF_FLIGHT)
    for check in sorted(CHECKS, key=lambda check: check.name in COSTLY):
        if check.name not in aloft:
            yield check.result(rows, limits[check.name])


def chosen_limits(given: Mapping[str, float]) -> dict[str, float]:
    """Return the default limits, changed by the given ones.

    Raises ``InputError``: there is no such check, or a limit is no finite number.
    """
    limits = {OF_QUANTITY.get(name, name): value for name, value in given.items()}
    for name in limits:
        require_name("limit", name, DEFAULT_LIMITS)
    return DEFAULT_LIMITS | {n: finite(f"limit of {n}", value) for n, value in limits.items()}


def finite(what: str, value: object) -> float:
    """Return a finite number.

    Raises ``InputError``: it is none; every value would pass a comparison with NaN.
    """
    number: Any = math.nan if isinstance(value, bool) or not isinstance(value, Real) else value
    if not abs(number) <= LARGEST:
        raise InputError(f"{what}: got {shortened(value)}, expected a finite number")
    return float(number)


def read_limits(texts: Iterable[str]) -> dict[str, float]:
    """Return limits from NAME=VALUE, or from VALUE for every check with the default 1e-6.

    Raises ``InputError``: a value is not a number, or a name has two values.
    """
    limits: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if math.isnan(number) or name in limits or (equals and not name):
            raise InputError(f"--limit: got {text!r}, expected NAME=VALUE or VALUE, each once")
        limits[name] = number
    usual = [name for name, value in DEFAULT_LIMITS.items() if value == PAPER_LIMIT]
    return (dict.fromkeys(usual, limits.pop("")) if "" in limits else {}) | limits
