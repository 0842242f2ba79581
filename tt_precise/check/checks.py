"""The checks, one entry each: the condition on every row, the required columns, and the limit.

A check is open if columns are missing, and skipped if it does not apply to the scene. Otherwise
``run`` returns one value for each row; the worst value decides. The formulas are those of
``mechanics``, evaluated on arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import CheckSetup, Samples, change_by_rounding
from tt_precise.check.contact import LIFT_OFF, contact
from tt_precise.check.equations import energy_balance, equations
from tt_precise.check.force_free import spread
from tt_precise.check.friction_power import friction_power, normal_force
from tt_precise.check.kinematics import (
    contact_momentum,
    depth_of,
    jellett_by_depth,
    kinematics,
    soft,
)
from tt_precise.check.result import Residual, check_of_rows, to_one_digit
from tt_precise.mechanics import quantities
from tt_precise.mechanics.compliant import stored_energy
from tt_precise.mechanics.conserved import INTEGRALS, OF_FLIGHT, OF_QUANTITY, Integral
from tt_precise.mechanics.newton import NewtonState, contact_arm
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.values import (
    Array,
    Check,
    InputError,
    Sense,
    Verdict,
    require_name,
    shortened,
)
from tt_precise.scene.numerals import LARGEST
from tt_precise.scene.scene import Scene

SHALLOW = 0.1  # Distance from the table in R beyond which there is no contact.
PROPORTIONAL = 0.99  # correlation of the height with k.z above which the contact arm is wrong


def contact_velocity(rows: Samples, limit: float) -> Residual:
    """|v_A.z| (rolling: |v_A|) of each row over R omega at the start, and the reason if not 0."""
    omega, speed, depth = rows.first.omega, rows.slip, depth_of(rows)
    if depth.any():  # the contact point moves as the table gives way
        rate = numpy.diff(depth) / numpy.diff(rows.t)
        bend = numpy.diff(rate, prepend=rate[:1])
        most = spread(abs(rate)) + spread(abs(bend))
        speed = numpy.maximum(speed - numpy.append(most, most[-1]), 0.0)
    values = speed / (float(rows.setup.body.R * numpy.sqrt(dot(omega, omega))) or 1.0)
    worst = float(values.max())
    fails = worst > limit and rows.setup.columns.name == "rigid body"
    return Residual(values, note=_risen(rows, worst) if fails else soft(float(depth.max())))


def _risen(rows: Samples, worst: float) -> str:
    """The motion of the contact point and the remedy; "" if the point leaves the table."""
    q, body = rows.q, rows.setup.body
    lift = rows.given["vcz"] + cross(q.omega, contact_arm(body, q.k))[2]
    h = numpy.cumsum(numpy.diff(rows.t) * (lift[1:] + lift[:-1]) / 2)
    h, kz = numpy.concatenate(([0.0], h)), rows.state.kz
    if not numpy.ptp(h) <= SHALLOW * body.R:
        return ""
    h, kz, moved = h - h.mean(), kz - kz.mean(), float(numpy.ptp(h))
    common, square = float(h @ kz), float(kz @ kz)
    if common**2 > PROPORTIONAL**2 * square * float(h @ h):
        lever = float(body.R * body.alpha)
        return (
            f"its height follows the axis: alpha R = {lever - common / square:.5g} m would "
            f"keep it on the table, the scene has {lever:.5g} m"
        )
    return (
        f"it sinks and rises by {moved:.1g} m, as a soft contact does: if yours is one, give "
        f"it a limit, as --limit contact_velocity={to_one_digit(2 * worst, math.ceil):g}"
    )


PAPER_LIMIT = 1e-6  # "constant with precision of order 10^-6 lambda", section 2.1

Run = Callable[[Samples, float], Residual]


class RowCheck(NamedTuple):
    """A check: name, meaning, function, and required columns.

    ``run(rows, limit)`` looks at all rows. Values pass that are ``sense`` the limit. ``needs`` are
    keys of ``_lacking``; ``applies`` gives the reason why the check does not apply to a scene, ""
    if it does.
    """

    name: str
    meaning: str
    run: Run
    needs: tuple[str, ...] = ()
    limit: float = PAPER_LIMIT
    sense: Sense = "at most"
    applies: Callable[[CheckSetup], str] = lambda setup: ""

    def result(self, rows: Samples, limit: float) -> Check:
        """Return the result of the check for ``rows``."""
        reason = self.applies(rows.setup)
        if reason:
            return Check(self.name, "skipped", note=reason, meaning=self.meaning)
        lacking = _lacking(rows.setup)
        missing = [lacking[need] for need in self.needs if lacking[need].reason]
        # what does not apply counts before what a file could have had
        for verdict in ("skipped", "open"):
            for one in missing:
                if one.verdict == verdict:
                    return Check(self.name, one.verdict, note=one.reason, meaning=self.meaning)
        seen = self.run(rows, limit)
        return check_of_rows(self.name, self.meaning, self.sense, limit, rows.t, seen)


class Missing(NamedTuple):
    """The reason why a need is missing, "" if present, and the verdict of checks that need it."""

    reason: str
    verdict: Verdict


def _lacking(setup: CheckSetup) -> dict[str, Missing]:
    """The needs of checks by name.

    A check is open if further columns would provide what it lacks, and skipped if nothing would.
    """
    columns, lifts = setup.columns, setup.scene.lifts
    rigid, raised = columns.name == "rigid body", setup.height_given or not lifts
    height = f"needs the height of the lowest point: columns {', '.join(columns.height)}"
    velocity = f"needs the velocity: columns {', '.join(columns.velocity)}"
    other = "the force of another friction law does not follow from the state"
    dissipates = not (setup.rolling or setup.flies) and (setup.scene.body.mu != 0 or lifts)
    may_rise = lifts and not setup.flies
    vertical = setup.velocity_given and (rigid or (setup.height_given and may_rise))
    own, applicable = setup.friction == "scene", not setup.rolling or setup.velocity_given
    conditions: dict[str, tuple[object, str, Verdict]] = {
        "azimuth": (
            columns.azimuth,
            "needs the direction of the axis, which Euler angles without phi lack", "open",
        ),
        "own force": (
            setup.own_force, "holds under the scene's own contact force only",
            "open" if own else "skipped",
        ),
        "force": (setup.own_force, height if own else other, "open" if own else "skipped"),
        "velocity": (setup.has_velocity, velocity, "open"),
        "velocity columns": (
            setup.velocity_given, velocity, "open" if applicable else "skipped",
        ),
        "vertical velocity": (
            vertical,
            "needs the vertical velocity: column vcz" if rigid else height if may_rise else
            f"the {columns.name} columns have no vertical velocity here",
            "open" if rigid or may_rise else "skipped",
        ),
        "vertical slip": (
            rigid or setup.rolling, f"the {columns.name} columns have no vertical component of v_A",
            "skipped",
        ),
        "height": (raised, height, "open"),
        "centre's height": (rigid or raised, height, "open"),
        "contact": (not setup.flies, "there is no contact in flight", "skipped"),
        "no flight": (not lifts, "the top may leave the table", "skipped"),
        "dissipation": (dissipates, "nothing is dissipated: see energy", "skipped"),
        "axis": (
            columns.name == "vectors", f"|k| = 1 by construction in the {columns.name} columns",
            "skipped",
        ),
        "quaternion": (rigid, "no quaternion among the columns", "skipped"),
    }  # fmt: skip
    return {
        need: Missing("" if there else reason, verdict)
        for need, (there, reason, verdict) in conditions.items()
    }


def _component(name: str) -> Callable[[Samples], Array]:
    return lambda rows: numpy.asarray(getattr(rows.state, name))


def _beyond(values: Array, written: Array, limit: float, seen: Residual | None = None) -> Residual:
    """Values beyond the rounding of the written digits."""
    seen = seen or Residual(values)
    bound = float(numpy.max(written))
    if not bound:
        return seen._replace(values=values)
    open_ = seen.open or ("the file has too few digits" if bound > limit else "")
    left = numpy.where(numpy.isnan(values), numpy.nan, numpy.fmax(values - written, 0.0))
    return seen._replace(values=left, bound=seen.bound + bound, open=open_)


NEED_VELOCITY = ("energy", "momentum_x", "momentum_y")


def _integral(integral: Integral) -> RowCheck:
    needs = ["azimuth"] if integral.azimuth else []
    needs += ["own force"] if integral.name != "jellett" else []
    needs += ["velocity"] if integral.name in NEED_VELOCITY else []

    def applies(setup: CheckSetup) -> str:
        if integral.holds(setup.scene.model, setup.scene.body):
            return ""
        rolls = integral.name in ("routh", "modified_energy")
        return f"an integral of {'rolling' if rolls else 'frictionless gliding'} only"

    def run(rows: Samples, limit: float) -> Residual:
        start = integral.evaluate(rows.first)
        scale = float(integral.scale(rows.first)) or 1.0
        written = change_by_rounding(rows, lambda part: integral.evaluate(part.q)) / scale
        change = integral.evaluate(rows.q) - start
        if integral.name == "jellett":  # at most what a table that gives way makes of it
            most = jellett_by_depth(rows)
            change = change - numpy.clip(change, numpy.minimum(most, 0), numpy.maximum(most, 0))
        return _beyond(abs(change) / scale, written + written[0], limit)

    return RowCheck(integral.name, integral.meaning, run, tuple(needs), applies=applies)


def _energy(rows: Samples, limit: float) -> Residual:
    """E is conserved, or never above the least of the rows before."""
    setup, integral = rows.setup, INTEGRALS["energy"]
    if integral.holds(setup.scene.model, setup.scene.body) and setup.own_force:
        return _integral(integral).run(rows, limit)

    def energy_of(part: Samples) -> Array:
        energy: Array = quantities.E(part.q)
        if setup.scene.body.spring:
            energy = energy + stored_energy(setup.body, part.q.state.height, numpy)
        return energy

    energy, scale = energy_of(rows), float(integral.scale(rows.first)) or 1.0
    written = change_by_rounding(rows, energy_of) / scale
    return _beyond((energy - numpy.minimum.accumulate(energy)) / scale, 2 * written.max(), limit)


def _axis(rows: Samples, limit: float) -> Residual:
    return Residual(abs(numpy.sqrt(dot(rows.state.k, rows.state.k)) - 1))


def _quaternion(rows: Samples, limit: float) -> Residual:
    square = sum(rows.given[name] ** 2 for name in ("qw", "qx", "qy", "qz"))
    return Residual(abs(numpy.sqrt(square) - 1))


def _from_row_to_row(run: Run) -> Run:
    """Return ``run`` with the bound that follows from the written digits of the rows."""

    def beyond(rows: Samples, limit: float) -> Residual:
        seen = run(rows, limit)
        if not any(rows.resolution.values()):
            return seen
        state = [change_by_rounding(rows, _component(name)).max() for name in NewtonState._fields]
        omega, L, body = rows.first.omega, rows.first.state.L, rows.setup.body
        turning = math.sqrt(dot(omega, omega))
        sizes = [1.0] * 3 + [math.sqrt(dot(L, L)) or 1.0] * 3 + [body.R * turning or 1.0] * 2
        written = max(float(one) / size for one, size in zip(state, sizes, strict=True))
        written += rows.blur
        # at both ends, and in the rates, which turn the state at the rate of the spin
        return _beyond(seen.values, written * (2 + turning * rows.t), limit, seen)

    return beyond


def _fall(rows: Samples, limit: float) -> Residual:
    rate, body = rows.given["vcz"], rows.setup.body
    omega = rows.first.omega
    scale = float(body.R * numpy.sqrt(dot(omega, omega))) or 1.0
    return Residual(abs(rate - rate[0] + body.g * rows.t) / scale)


def _time(rows: Samples, limit: float) -> Residual:
    return Residual(numpy.diff(rows.t, prepend=-numpy.inf))


def checks_of(scene: Scene) -> tuple[RowCheck, ...]:
    """The ``CHECKS`` that apply to ``scene``."""
    aloft = ("fall", *OF_FLIGHT)
    return tuple(c for c in CHECKS if scene.model == "flight" or c.name not in aloft)


CHECKS = (
    RowCheck(
        "time", "strictly increasing: anything else is refused (s)",
        _time, (), 0.0, "above",
    ),
    _integral(INTEGRALS["jellett"]),
    RowCheck(
        "energy",
        "E, with the energy of an elastic table: constant without friction, never rising with "
        "friction; section 1",
        _energy, ("height", "velocity"),
    ),
    RowCheck(
        "energy_balance", "E falls by the integral of mu g_n v_A^2; section 1",
        _from_row_to_row(energy_balance), ("dissipation", "force", "velocity"),
    ),
    RowCheck(
        "equations", "the state changes by the integral of its rates; eq (1)",
        _from_row_to_row(equations), ("force", "velocity"),
    ),
    RowCheck(
        "contact", "g_n/(m g): the table pushes and never pulls; eq (7)",
        contact, ("contact", "no flight", "force", "velocity"), LIFT_OFF, "at least",
    ),
    RowCheck(
        "kinematics",
        "attitude (rad) and position (over R) follow the velocities, z stands at R (1 - alpha cos "
        "theta); every law",
        kinematics, (), 1e-2,
    ),
    RowCheck(
        "contact_momentum",
        "the angular momentum about the lowest point changes as weight and motion make it, in "
        "units of m g R alpha; every law",
        contact_momentum, ("azimuth", "velocity", "centre's height"), 1e-4,
    ),
    RowCheck(
        "normal_force",
        "F_z/(m g) in the mean from row to row: the table does not pull; every law",
        normal_force, ("contact", "vertical velocity"), -1e-3, "at least",
    ),
    RowCheck(
        "friction_power", "F_t.v_A over m g R omega at the start: never above 0; every law",
        friction_power,
        ("contact", "velocity columns", "azimuth", "velocity", "centre's height"), 1e-3,
    ),
    RowCheck(
        "contact_velocity", "v_A.z = 0 (rolling: v_A = 0), in units of R omega at the start",
        contact_velocity, ("contact", "no flight", "velocity columns", "vertical slip"),
    ),
    RowCheck(
        "fall", "s_dot.z falls at g, in units of R omega at the start",
        _fall, ("vertical velocity",),
    ),
    RowCheck("axis_norm", "|k| = 1", _axis, ("axis",)),
    RowCheck("quaternion_norm", "|q| = 1", _quaternion, ("quaternion",)),
    *(
        _integral(INTEGRALS[name])
        for name in INTEGRALS
        if name not in ("jellett", "energy", "axis_norm")
    ),
)  # fmt: skip


DEFAULT_LIMITS = {check.name: check.limit for check in CHECKS}


def chosen_limits(given: Mapping[str, float]) -> dict[str, float]:
    """The default limits, changed by the given limits.

    Raises ``InputError``: a check of that name does not exist, or its limit is no number that a
    value can pass.
    """
    several, given = given, {OF_QUANTITY.get(name, name): value for name, value in given.items()}
    if len(given) < len(several):
        raise InputError(f"limit: got {', '.join(several)}, expected each check once")
    for name in given:
        require_name("limit", name, DEFAULT_LIMITS)
    senses = {check.name: check.sense for check in CHECKS}
    limits = {name: finite(f"limit of {name}", value) for name, value in given.items()}
    for name, value in limits.items():
        if value < 0 and senses[name] == "at most":
            raise InputError(f"limit of {name}: got {value:g}, expected 0 or a number above 0")
    return DEFAULT_LIMITS | limits


def finite(what: str, value: object) -> float:
    """A number given as a limit.

    Raises ``InputError``: it is not a finite number: every value passes a comparison with NaN.
    """
    number: Any = math.nan if isinstance(value, bool) or not isinstance(value, Real) else value
    if not abs(number) <= LARGEST:
        raise InputError(f"{what}: got {shortened(value)}, expected a finite number")
    return float(number)


def read_limits(texts: Iterable[str]) -> dict[str, float]:
    """Limits by name from NAME=VALUE, or from VALUE for all others with the default 1e-6.

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
