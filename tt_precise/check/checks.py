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

from tt_precise.check.residuals import (
    COARSE,
    FINE,
    RESOLVED,
    StepResiduals,
    by_any_force,
    by_law,
    differentiate,
    least_force,
    norm,
    nutation,
    sums_since_start,
    torque_unit,
    total_energy,
    unresolved,
)
from tt_precise.check.rows import Rows
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS, OF_FLIGHT, OF_QUANTITY, Integral
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.plotting import thinned
from tt_precise.runtime.values import Array, Check, InputError, Sense, require_name, shortened
from tt_precise.scene.numerals import LARGEST
from tt_precise.scene.scene import Scene

PAPER_LIMIT = 1e-6  # "constant with precision of order 10^-6 lambda", section 2.1
# An interval counts ten times as much as the sum of the attitude since the start, and the mean
# torque twice as much as one interval: an integrator's errors add up in the attitude only.
INTERVAL_COUNTS, MEAN_COUNTS = 10.0, 2.0
MEAN_OVER = 10  # A mean torque over fewer intervals says no more than these intervals.
# Torque (m g R alpha) that a typical interval must show: a wrong convention is wrong by 1.
VISIBLE_TORQUE = 0.3
SINKING = 0.1  # Depth in R to which an elastic table may give way under another force.
TOO_FEW_DIGITS = "the file has too few digits"


class Residual(NamedTuple):
    """The values of a check, one for each row, of which errors of the rows' digits are subtracted.

    ``bound`` is the size of error that would go unnoticed. ``unresolved`` says why the rows do not
    decide, "" if they do. ``decided``: ``unresolved`` alone says so, not the bound.
    """

    values: Array
    bound: float = 0.0
    note: str = ""
    unresolved: str = ""
    decided: bool = False


class RowCheck(NamedTuple):
    """A check: name, meaning, function, needed quantities (keys of ``REQUIREMENTS``), limit."""

    name: str
    meaning: str
    run: Callable[[Rows], Residual]
    needs: tuple[str, ...] = ()
    limit: float = PAPER_LIMIT
    sense: Sense = "at most"
    applies: Callable[[Scene], str] = lambda scene: ""

    def result(self, rows: Rows, limit: float) -> Check:
        """Return the result of the check for ``rows``."""
        reason = self.applies(rows.assumed.scene)
        if reason:
            return Check(self.name, "skipped", note=reason, meaning=self.meaning)
        missing = [REQUIREMENTS[need] for need in self.needs]
        missing = [requirement for requirement in missing if not requirement.holds(rows)]
        # a check that does not apply is skipped, whatever the file lacks besides
        for requirement in sorted(missing, key=lambda each: each.verdict != "skipped"):
            return Check(
                self.name, requirement.verdict, note=requirement.words(rows), meaning=self.meaning
            )
        return judge_values(self, rows.t, self.run(rows), limit)


def judge_values(check: RowCheck, t: Array, residual: Residual, limit: float) -> Check:
    """Return the verdict on values: the worst one, and the first one beyond the limit.

    A value that is NaN is beyond it.
    """
    values, sign = residual.values, 1.0 if check.sense == "at most" else -1.0
    badness = numpy.where(numpy.isnan(values), numpy.inf, sign * values)
    beyond = ~(badness < sign * limit) if check.sense == "above" else ~(badness <= sign * limit)
    worst, note, since = int(numpy.argmax(badness)), residual.note, None
    verdict: Any = "pass"
    few = check.sense == "at most" and residual.bound > limit and not residual.decided
    if beyond.any():
        verdict, since = "fail", float(t[int(numpy.argmax(beyond))])
    elif residual.unresolved or few:
        verdict, note = (
            "open",
            residual.unresolved or f"{TOO_FEW_DIGITS} or rows; {note}".strip("; "),
        )
    drawn = thinned(t, badness)
    return Check(
        check.name, verdict, float(sign * badness[worst]), limit, float(t[worst]), note,
        check.meaning, check.sense, since=since,
        bound=None if residual.unresolved else residual.bound or None,
        curve=(t[drawn], sign * badness[drawn]),
    )  # fmt: skip


# ---- needs -------------------------------------------------------------------------------------


class Requirement(NamedTuple):
    """A quantity that a check needs: the test, the verdict without it, and the reason.

    The reason may name the columns of the ``velocity`` and of the ``height``.
    """

    holds: Callable[[Rows], bool]
    verdict: Any
    reason: str

    def words(self, rows: Rows) -> str:
        """Return the reason with the names of the columns."""
        columns = rows.assumed.columns
        return self.reason.format(
            velocity=", ".join(columns.velocity), height=", ".join(columns.height)
        )


def has_force(rows: Rows) -> bool:
    """Test that the contact force follows from the state."""
    return rows.assumed.friction == "scene" and _has_height(rows)


def _has_height(rows: Rows) -> bool:
    return rows.assumed.flying or rows.has_height or not rows.assumed.scene.lifts


def _dissipates(rows: Rows) -> bool:
    assumed, body = rows.assumed, rows.assumed.scene.body
    return not (assumed.rolling or assumed.flying) and (body.mu != 0 or bool(body.spring))


def _rises(rows: Rows) -> bool:
    rises = rows.has_height and not rows.assumed.flying
    return "vcz" in rows.columns or rises or rows.assumed.rolling


def _slips(rows: Rows) -> bool:
    return not rows.assumed.rolling or rows.assumed.columns.velocity[0] in rows.columns


HEIGHT = "needs the height of the lowest point: columns {height}"
REQUIREMENTS = {name: Requirement(*row) for name, row in {
    "azimuth": (lambda rows: rows.assumed.columns.azimuth, "open",
                "needs the direction of the axis, which Euler angles without phi lack"),
    "velocity": (lambda rows: rows.has_velocity, "open",
                 "needs the velocity: columns {velocity}"),
    "velocity columns": (_slips, "skipped", "v_A = 0 by construction"),
    "vertical velocity": (_rises, "skipped", "needs the vertical velocity: column vcz"),
    "contact": (lambda rows: not rows.assumed.flying, "skipped", "there is no contact"),
    "scene's force": (lambda rows: rows.assumed.friction == "scene", "skipped",
                      "holds under the scene's own contact force only"),
    "height": (_has_height, "open", HEIGHT),
    "potential": (lambda rows: rows.has_height or not rows.assumed.scene.lifts, "open", HEIGHT),
    "rigid table": (lambda rows: not rows.assumed.scene.lifts, "skipped",
                    "the top may leave the table"),
    "dissipation": (_dissipates, "skipped", "nothing is dissipated: see energy"),
    "axis": (lambda rows: "kx" in rows.columns, "skipped", "|k| = 1 by construction"),
    "quaternion": (lambda rows: "qw" in rows.columns, "skipped", "no quaternion among the columns"),
    "rows": (lambda rows: len(rows.t) >= FINE or obeys_scene(rows), "open",
             f"needs at least {FINE} rows"),
}.items()}  # fmt: skip


# ---- row by row --------------------------------------------------------------------------------


def _beyond(rows: Rows, values: Array, roundings: float) -> Residual:
    """Return values beyond so many times the rounding of the file."""
    slack = roundings * rows.rounding
    left = numpy.where(numpy.isnan(values), numpy.nan, numpy.fmax(values - slack, 0.0))
    return Residual(left, slack)


def _integral(integral: Integral) -> RowCheck:
    """Return the check of a conserved quantity: its change since the start over its scale."""
    needs = ["azimuth"] * integral.azimuth
    needs += ["scene's force", "height"] if integral.name != "jellett" else []
    needs += ["velocity"] if integral.name in ("energy", "momentum_x", "momentum_y") else []
    needs += ["potential"] if integral.name == "energy" else []

    def applies(scene: Scene) -> str:
        if integral.holds(scene.model, scene.body):
            return ""
        rolls = integral.name in ("routh", "modified_energy")
        return f"an integral of {'rolling' if rolls else 'frictionless gliding'} only"

    def run(rows: Rows) -> Residual:
        scale = float(integral.scale(rows.first)) or 1.0
        change = integral.evaluate(rows.q) - integral.evaluate(rows.first)
        if integral.name == "jellett":
            change = _without_depth(rows, change)
        return _beyond(rows, abs(change) / scale + 0 * rows.t, 4.0)

    return RowCheck(integral.name, integral.meaning, run, tuple(needs), applies=applies)


def depth(rows: Rows) -> Array:
    """Return how deep (m) the lowest point lies in a table that gives way; 0 if none is seen.

    Under another force than the scene's a height known to ``SINKING`` R says so.
    """
    if rows.assumed.friction == "scene" or rows.motion.x is None:
        return 0 * rows.t
    deep = numpy.fmax(-rows.height, 0.0)
    return deep if float(deep.max()) < SINKING * rows.body.R else 0 * rows.t


def _without_depth(rows: Rows, change: Array) -> Array:
    """Return the change of lambda without what a force at the table's level may change.

    A force F at the height h above the lowest point changes lambda at h (F_y a_x - F_x a_y), with
    the horizontal F = m dv/dt; it acts between the lowest point and the table.
    """
    deep, v = depth(rows), rows.motion.v
    if v is None or not deep.any():
        return change
    a_x, a_y, _ = rows.q.a
    h, a_x, a_y = ((values[1:] + values[:-1]) / 2 for values in (deep, a_x, a_y))
    most = rows.body.m * h * (numpy.diff(v[1]) * a_x - numpy.diff(v[0]) * a_y)
    most = numpy.append(0.0, numpy.cumsum(most))
    left: Array = change - numpy.clip(change, numpy.fmin(most, 0), numpy.fmax(most, 0))
    return left


def _energy(rows: Rows) -> Residual:
    """Return the change of E where it is conserved, else its rise above the least value before."""
    integral, scene = INTEGRALS["energy"], rows.assumed.scene
    if integral.holds(scene.model, scene.body) and has_force(rows):
        return _integral(integral).run(rows)
    q = rows.q
    if depth(rows).any() and not rows.has_height:  # the table stores the energy of the depth
        q = Motion(rows.body, NewtonState._make(rows.state[:8]), numpy, scene.model)
    energy = total_energy(rows, q)
    scale = float(abs(integral.scale(rows.first))) or 1.0
    return _beyond(rows, (energy - numpy.minimum.accumulate(energy)) / scale, 8.0)


def _contact(rows: Rows) -> Residual:
    """Return g_n/(m g) in the rows, and its minimum between rows that follow the equations."""
    weight = rows.body.m * rows.body.g
    values = quantities.g_n(rows.q) / weight + 0 * rows.t
    steps = by_law(rows)
    assert steps.state is not None
    assert steps.least is not None
    sums, _ = sums_since_start(steps.state, steps.bounds["state"])
    dips = (steps.least <= 0) & (numpy.fmin(values[1:], values[:-1]) > 0) & (sums <= 1e-3)
    dips &= numpy.isfinite(steps.bounds["state"])
    intervals = numpy.flatnonzero(dips)
    if len(intervals) and not rows.assumed.scene.may_stick:
        between = least_force(rows, intervals) / weight
        values[intervals + 1] = numpy.fmin(values[intervals + 1], between)
    return Residual(values)


def _contact_velocity(rows: Rows) -> Residual:
    """Return |v_A.z| (rolling: |v_A|) over R omega; a table that gives way explains its rate."""
    v_A = rows.contact_velocity
    slip = norm(v_A) if rows.assumed.rolling else abs(v_A[2])
    columns = rows.assumed.columns
    if rows.assumed.rolling and columns.name != "rigid body":
        slip = norm(numpy.array([rows.columns[name] for name in columns.velocity]))
    deep = depth(rows)
    if deep.any():
        rate = numpy.diff(deep) / numpy.diff(rows.t)
        bend = numpy.diff(rate, prepend=rate[:1])
        most = numpy.pad(abs(rate) + abs(bend), (3, 4), mode="edge")
        slip = (
            slip
            - 2 * numpy.lib.stride_tricks.sliding_window_view(most, 7).max(axis=-1)[: len(slip)]
        )
    note = (
        f"a soft contact, {1000 * deep.max():.2g} mm deep at most, is allowed" if deep.any() else ""
    )
    return _beyond(rows, slip / rows.units["v"], 2.0)._replace(note=note)


def _fall(rows: Rows) -> Residual:
    rate = rows.contact_velocity[2] if rows.motion.v is None else rows.motion.v[2]
    return _beyond(rows, abs(rate - rate[0] + rows.body.g * rows.t) / rows.units["v"], 2.0)


def _length(rows: Rows, names: tuple[str, ...]) -> Residual:
    length = norm(numpy.array([rows.columns[name] for name in names]))
    return _beyond(rows, abs(length - 1), 2.0)


def _normal_force(rows: Rows) -> Residual:
    """Return the mean F_z/(m g) from row to row."""
    assert rows.motion.v is not None
    change = numpy.diff(rows.motion.v[2]) + 2 * rows.rounding * rows.units["v"]
    return Residual(numpy.append(numpy.inf, 1 + change / numpy.diff(rows.t) / rows.body.g))


# ---- from row to row ---------------------------------------------------------------------------


def _slack(rows: Rows, size: float) -> Array:
    """Return how much the rounding of numbers and times changes sums since the start, one a row.

    Both ends count, and the rates turn the error of a row at the rate of the spin.
    """
    slack: Array = (size + rows.spin_rate * rows.t) * (rows.rounding + rows.time_rounding)
    return slack


def _sums(rows: Rows, values: Array, bound: Array, size: float = 2.0) -> Residual:
    """Return sums since the start beyond their error bound and the rounding of the file."""
    sums, error = sums_since_start(values, bound)
    hidden = numpy.append(0.0, error) + _slack(rows, size)
    left = numpy.append(0.0, sums) - hidden
    left = numpy.where(numpy.isnan(left), numpy.inf, numpy.fmax(left, 0.0))
    return Residual(left, float(hidden[-1]))


def _by_scene(rows: Rows, values: Array, size: float = 2.0) -> Residual:
    """Return the sums of residuals under the scene's law, the largest of all components."""
    steps = by_law(rows)
    bound = steps.bounds["state"]
    parts = [_sums(rows, component[None], bound, size) for component in values]
    largest = numpy.max([part.values for part in parts], axis=0)
    looked, switches = steps.switches
    note = (
        f"{looked} of {switches} changes of the equations integrated" if looked < switches else ""
    )
    missing = ~numpy.isfinite(bound)
    enough = 2 * int(missing.sum()) <= len(missing) and not (missing & _gaps(rows)).any()
    text = "" if enough else unresolved(rows, bound)
    return Residual(largest, parts[0].bound, note, text)


def _gaps(rows: Rows) -> Array:
    """Return the intervals that are far longer than usual ones."""
    steps = numpy.diff(rows.t)
    gaps: Array = steps > 5 * numpy.sort(steps)[len(steps) // 2]
    return gaps


def _equations(rows: Rows) -> Residual:
    state = by_law(rows).state
    assert state is not None
    return _by_scene(rows, state)


def _energy_balance(rows: Rows) -> Residual:
    energy = by_law(rows).energy
    assert energy is not None
    return _by_scene(rows, energy[None], 8.0)


def obeys_scene(rows: Rows) -> bool:
    """Test that the rows obey the scene's own equations, to its usual limit."""
    if "obeys scene" not in rows.cache:
        obeys = False
        if _has_height(rows) and rows.has_velocity and rows.rounding < PAPER_LIMIT:
            residual = _equations(rows)
            good = residual.values.max() <= PAPER_LIMIT and residual.bound <= PAPER_LIMIT
            obeys = bool(good and not residual.unresolved)
        rows.cache["obeys scene"] = obeys
    return bool(rows.cache["obeys scene"])


def deciding_steps(rows: Rows) -> StepResiduals:
    """Return residuals by the scene's law where the rows obey it, else of any force.

    Rows that obey one law of force obey what holds under every law, at any spacing.
    """
    return by_law(rows) if obeys_scene(rows) else by_any_force(rows)


def _kinematics(rows: Rows) -> Residual:
    """Return attitude (rad) and position (R) less the integrals of their rates, and the height."""
    steps, parts = deciding_steps(rows), {}
    looked = ["axis" if rows.assumed.columns.azimuth else "inclination"]
    looked += ["spin"] if rows.motion.q is not None else []
    parts[""] = (steps.rotation, steps.bounds["rotation"], 1.0)
    x = rows.motion.x if rows.has_velocity and rows.assumed.columns.azimuth else None
    for axis, name in enumerate("xyz"):
        if x is not None and not numpy.isnan(x[axis]).all():
            looked.append(name)
            parts[name] = (steps.position[axis][None], steps.bounds["position"], rows.body.R)
    values, worst, bound, text = 0 * rows.t, "", 0.0, ""
    written = 2 * rows.rounding + rows.time_rounding
    for name, (residual, error, size) in parts.items():
        residual, error = residual / size, error / size
        error = error + 2 * rows.position_rounding if name else error
        sums = _sums(rows, residual, error)
        local = INTERVAL_COUNTS * (norm(residual) - error - written)
        local = numpy.append(0.0, numpy.where(numpy.isinf(error), 0.0, local))
        both = numpy.fmax(sums.values, numpy.where(numpy.isnan(local), numpy.inf, local))
        worst = name if both.max() > values.max() else worst
        values, bound = numpy.fmax(values, both), max(bound, sums.bound)
        text = text or _unresolved(rows, error)
    if "z" in rows.columns and not rows.assumed.scene.lifts:
        off = _off_table(rows)
        worst = "height" if off.max() > values.max() else worst
        values = numpy.fmax(values, off)
        looked += ["height"]
    names = {"": looked[-1] if "spin" in looked[:2] else "axis"}
    beyond = f"{names.get(worst, worst)} does not follow; " if values.max() > 1e-2 else ""
    note = f"{beyond}checked {', '.join(looked)}"
    return Residual(values, bound, note, text, decided=True)


def _off_table(rows: Rows) -> Array:
    """Return how far (R) the lowest point is from the table, beyond the rounding of the file.

    Under another force the top may leave the table, or an elastic one give way, but not at the
    start.
    """
    height = rows.height / rows.body.R
    if rows.assumed.friction == "other":
        above = numpy.where(rows.t == 0, height, 0.0 * height)
        height = numpy.maximum(numpy.maximum(above, -height) - SINKING, 0.0)
    off: Array = numpy.maximum(abs(height) - 4 * rows.rounding - rows.position_rounding, 0.0)
    return off


def _unresolved(rows: Rows, bound: Array) -> str:
    """Return why the deciding residuals do not decide."""
    if not obeys_scene(rows):
        return unresolved(rows, bound)
    missing = ~numpy.isfinite(bound)  # changes of the phase that were not integrated
    return unresolved(rows, bound) if 2 * int(missing.sum()) > len(missing) else ""


def _contact_momentum(rows: Rows) -> Residual:
    """Return the torque about the lowest point beside weight and motion (m g R alpha)."""
    steps, unit = deciding_steps(rows), torque_unit(rows.body)
    bound, h = steps.bounds["momentum"], numpy.diff(rows.t)
    written = 4 * rows.units["L"] * (rows.rounding + rows.time_rounding)
    sinks = _depth_torque(rows)
    slack = 2 * written + sinks
    local = (norm(steps.momentum) - bound - slack) / (unit * h)
    local = numpy.where(numpy.isinf(bound), 0.0, local)
    sums, error = sums_since_start(steps.momentum, bound)
    span = rows.t[1:] - rows.t[0]
    hidden = error + written * (1 + rows.spin_rate * span) + numpy.cumsum(sinks)
    mean = MEAN_COUNTS * (sums - hidden) / (unit * span)
    mean[:MEAN_OVER] = 0.0
    values = numpy.fmax(numpy.fmax(mean, local), 0.0)
    values = numpy.where(numpy.isnan(steps.momentum).any(axis=0), numpy.inf, values)
    typical = float(numpy.sort((bound + slack) / (unit * h))[len(h) // 2])
    text = _unresolved(rows, bound) or ("" if typical <= VISIBLE_TORQUE else TOO_FEW_DIGITS)
    note = ""
    if values.max() > 1e-4 and not obeys_scene(rows):
        x, y, z = (float(v) for v in numpy.nansum(steps.momentum, axis=1))
        vertical = math.hypot(x, y) < 0.1 * abs(z)
        note = "the torque left is about the vertical, as torsional friction is" if vertical else ""
    # a torque that turns with the nutation cancels in the mean: an interval must show it
    return Residual(numpy.append(0.0, values), typical, note, text, decided=True)


def _depth_torque(rows: Rows) -> Array:
    """Return the angular impulse that a force above the lowest point of a soft contact may have."""
    deep, v = depth(rows), rows.motion.v
    if v is None or not deep.any():
        return numpy.zeros(len(rows.t) - 1)
    push = rows.body.m * norm(numpy.diff(v[:2]))
    impulse: Array = numpy.fmax(deep[1:], deep[:-1]) * push
    return impulse


def _friction_power(rows: Rows) -> Residual:
    """Return the power of friction F_t.v_A over m g R omega; above 0 friction would push."""
    body, v, v_A = rows.body, rows.motion.v, rows.contact_velocity[:2, :-1]
    assert v is not None
    fine = differentiate(rows.t, v, FINE)
    error = norm(fine - differentiate(rows.t, v, COARSE))
    error += 4 * rows.rounding * rows.units["v"] / numpy.diff(rows.t)
    unit = body.g * rows.units["v"]
    bound = error * norm(v_A) / unit
    bound[nutation(rows) >= RESOLVED] = numpy.inf
    power = (fine[:2] * v_A).sum(axis=0) / unit
    excess = numpy.where(numpy.isfinite(bound), numpy.fmax(power - bound, 0.0), 0.0)
    excess = numpy.where(numpy.isnan(power), numpy.inf, excess)
    resolved = bound <= 1e-3
    share = float((~resolved).mean())
    text = f"{share:.0%} of the rows are not resolved" if share > 0.5 else ""
    typical = float(bound[resolved].max()) if resolved.any() else 0.0
    law = friction_law(fine, error, v_A, body.g)[0]
    return Residual(numpy.append(excess, 0.0), typical, law, text, decided=True)


def friction_law(acceleration: Array, error: Array, v_A: Array, g: float) -> tuple[str, float]:
    """Return the law that friction follows, in words, and its nearly constant coefficient.

    The force over the mass is the ``acceleration`` plus ``g``; "" where neither law is seen.
    """
    speed, push = norm(v_A), norm(acceleration[:2])
    normal = acceleration[2] + g
    clear = (error < 0.1 * push) & (normal > 0) & (speed > 0.05 * speed.max())
    if clear.sum() < FINE:
        return "", math.nan
    for law, ratio, unit in (
        ("Coulomb's", push / normal, ""), ("viscous", push / normal / speed, " s/m v_A"),
    ):  # fmt: skip
        mean, deviation = float(ratio[clear].mean()), float(ratio[clear].std())
        if deviation < 0.05 * mean:
            text = f"friction seen: {mean:.3g} +- {deviation:.1g}{unit} of F_z, as {law}"
            return text, mean
    return "", math.nan


CHECKS = (
    RowCheck("time", "strictly increasing (s)",
             lambda rows: Residual(numpy.diff(rows.t, prepend=-numpy.inf)), (), 0.0, "above"),
    _integral(INTEGRALS["jellett"]),
    RowCheck("energy", "E, with the energy of an elastic table: constant without friction, never "
             "rising with friction; section 1", _energy, ("potential", "velocity")),
    RowCheck("energy_balance", "E falls by the integral of mu g_n v_A^2; section 1",
             _energy_balance, ("dissipation", "scene's force", "height", "velocity")),
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
    RowCheck("friction_power", "F_t.v_A over m g R omega at the start: never above 0; every law",
             _friction_power,
             ("contact", "dissipation", "azimuth", "velocity", "height", "rows"), 1e-3),
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
# The checks that cost most, the cheapest first.
COSTLY = ("equations", "energy_balance", "contact", "kinematics", "contact_momentum",
          "friction_power")  # fmt: skip


def judge(rows: Rows, limits: Mapping[str, float]) -> Iterator[Check]:
    """Return the results of all checks of the scene's model, the cheapest first."""
    aloft = () if rows.assumed.flying else ("fall", *OF_FLIGHT)
    order = [check for check in CHECKS if check.name not in COSTLY]
    order += sorted((check for check in CHECKS if check.name in COSTLY),
                    key=lambda check: COSTLY.index(check.name))  # fmt: skip
    for check in order:
        if check.name not in aloft:
            yield check.result(rows, limits[check.name])


def chosen_limits(given: Mapping[str, float]) -> dict[str, float]:
    """Return the default limits, changed by the given ones.

    Raises ``InputError``: there is no such check, or no value could pass.
    """
    limits = {OF_QUANTITY.get(name, name): value for name, value in given.items()}
    if len(limits) < len(given):
        raise InputError(f"limit: got {', '.join(given)}, expected each check once")
    senses = {check.name: check.sense for check in CHECKS}
    for name, value in limits.items():
        require_name("limit", name, DEFAULT_LIMITS)
        if finite(f"limit of {name}", value) < 0 and senses[name] == "at most":
            raise InputError(f"limit of {name}: got {value:g}, expected 0 or a number above 0")
    return DEFAULT_LIMITS | {name: float(value) for name, value in limits.items()}


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
            raise InputError(f"--limit: got {text!r}, expected NAME=VALUE or VALUE") from None
        name = name.strip()
        if name in limits or (equals and not name):
            raise InputError(f"--limit: got {text!r}, expected NAME=VALUE or VALUE, each once")
        limits[name] = number
    usual = limits.pop("", None)
    if usual is None:
        return limits
    return {name: usual for name, value in DEFAULT_LIMITS.items() if value == PAPER_LIMIT} | limits
