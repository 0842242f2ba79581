"""The checks, one entry each: the condition on every row, when it applies, and its limit.

A check is skipped with a reason if the scene or the columns do not allow it. Otherwise ``watch``
takes the first block and returns a function from blocks of rows to one value for each row; the
worst value decides. The formulas are those of ``mechanics``, evaluated on arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from typing import NamedTuple

import numpy

from tt_precise.check.columns import CheckSetup, Samples
from tt_precise.check.equations import (
    EquationResidual,
    SummedResidual,
    least_margin,
    lift_off,
    to_one_digit,
)
from tt_precise.check.friction_power import FrictionPower, normal_force
from tt_precise.check.kinematics import ContactMomentum, Kinematics
from tt_precise.golden.measuring import ending
from tt_precise.mechanics import quantities
from tt_precise.mechanics.compliant import stored_energy
from tt_precise.mechanics.conserved import INTEGRALS, OF_FLIGHT, Integral
from tt_precise.mechanics.newton import contact_arm
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.values import Array, InputError, Sense
from tt_precise.scene.scene import Scene

SHALLOW = 0.1  # of R: with a larger distance from the table there is no contact
PROPORTIONAL = 0.99  # correlation of the height with k.z above which the contact arm is wrong


class ContactVelocity:
    """|v_A.z| (rolling: |v_A|) of each row over R omega at the start, and the reason if not 0."""

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        self._setup, self._limit = setup, limit
        omega = first.first.omega
        self._scale = float(setup.body.R * numpy.sqrt(dot(omega, omega))) or 1.0
        self._worst = self._height = 0.0
        self._sums = numpy.zeros(5)  # of h, kz, h^2, kz^2 and h kz, from the first row on
        self._ends = numpy.zeros(2)  # lowest and highest h, in m
        self._rows = 0

    def __call__(self, samples: Samples) -> numpy.ndarray:
        values: numpy.ndarray = samples.slip / self._scale
        self._worst = max(self._worst, float(values.max()))
        if self._setup.columns.name == "rigid body":
            self._follow(samples)
        return values

    def _follow(self, samples: Samples) -> None:
        q = samples.q
        lift = samples.given["vcz"] + cross(q.omega, contact_arm(self._setup.body, q.k))[2]
        risen = numpy.cumsum(numpy.diff(samples.t) * (lift[1:] + lift[:-1]) / 2)
        new = slice(1 if self._rows else 0, None)  # every later block repeats a row
        h = (self._height + numpy.concatenate(([0.0], risen)))[new]
        kz, self._height = samples.state.kz[new], float(h[-1])
        self._rows += len(h)
        self._sums += [h.sum(), kz.sum(), (h * h).sum(), (kz * kz).sum(), (h * kz).sum()]
        low, high = self._ends
        self._ends = numpy.array([min(low, h.min()), max(high, h.max())])

    @property
    def note(self) -> str:
        """The motion of the contact point and the remedy; "" if it stays on the table."""
        if self._worst <= self._limit or not self._rows:
            return ""
        moved = float(self._ends[1] - self._ends[0])
        if not moved <= SHALLOW * self._setup.body.R:
            return ""
        h, kz, hh, kk, hk = self._sums / self._rows
        spread, common = kk - kz * kz, hk - h * kz
        if common**2 > PROPORTIONAL**2 * spread * (hh - h * h):
            lever = float(self._setup.body.R * self._setup.body.alpha)
            return (
                f"its height follows the axis: alpha R = {lever - common / spread:.5g} m would "
                f"keep it on the table, the scene has {lever:.5g} m"
            )
        return (
            f"it sinks and rises by {moved:.1g} m, as a soft contact does: if yours is one, give "
            f"it a limit, as --limit contact_velocity={to_one_digit(2 * self._worst, math.ceil):g}"
        )


PAPER_LIMIT = 1e-6  # "constant with precision of order 10^-6 lambda", section 2.1

# The last row of a motion that leaves the table has g_n = 0, which rounding makes +- some eps.
LIFT_OFF = -1e-12
LOW = 0.2  # of the weight: beside such a contact force it may vanish between two rows

Watch = Callable[[Samples], numpy.ndarray]


class RowCheck(NamedTuple):
    """A check: its name, its meaning, the reason to skip it ("" if none), and its function.

    Values pass that are ``sense`` the limit. ``watch(setup, first, limit)`` makes the function
    that receives the blocks in order. If it has an ``error_bound``, smaller limits cannot be
    tested, and its ``note`` gives the reason.
    """

    name: str
    meaning: str
    watch: Callable[[CheckSetup, Samples, float], Watch]
    skipped: Callable[[CheckSetup, Samples], str]
    limit: float = PAPER_LIMIT
    sense: Sense = "at most"


def _lacking(setup: CheckSetup) -> dict[str, str]:
    """Reasons why the needs of checks are missing, by the name of the need; "" if present."""
    columns, lifts = setup.columns, setup.scene.lifts
    rigid, raised = columns.name == "rigid body", setup.height_given or not lifts
    height = f"needs the height of the lowest point: columns {', '.join(columns.height)}"
    velocity = f"needs the velocity: columns {', '.join(columns.velocity)}"
    other = "the force of another friction law does not follow from the state"
    dissipates = not (setup.rolling or setup.flies) and (setup.scene.body.mu != 0 or lifts)
    vertical = setup.velocity_given and (rigid or (setup.height_given and not setup.flies))
    conditions = {
        "azimuth": (
            columns.azimuth,
            "needs the direction of the axis, which Euler angles without phi leave open",
        ),
        "own force": (setup.own_force, "holds under the scene's own contact force only"),
        "force": (setup.own_force, height if setup.friction == "scene" else other),
        "velocity": (setup.velocity_known, velocity),
        "velocity columns": (setup.velocity_given, velocity),
        "vertical velocity": (vertical, "needs the vertical velocity: column vcz"),
        "vertical slip": (
            rigid or setup.rolling, f"the {columns.name} columns leave v_A no vertical part",
        ),
        "height": (raised, height),
        "centre's height": (rigid or raised, height),
        "contact": (not setup.flies, "there is no contact in flight"),
        "no flight": (not lifts, "the top may leave the table"),
        "dissipation": (dissipates, "nothing is dissipated: see energy"),
        "axis": (
            columns.name == "vectors", f"|k| = 1 by construction in the {columns.name} columns",
        ),
        "quaternion": (rigid, "no quaternion among the columns"),
    }  # fmt: skip
    return {need: "" if there else reason for need, (there, reason) in conditions.items()}


def _unless(*needs: str) -> Callable[[CheckSetup, Samples], str]:
    """The reason to skip a check with these ``needs``: the first missing need."""

    def skipped(setup: CheckSetup, first: Samples) -> str:
        lacking = _lacking(setup)
        return next((lacking[need] for need in needs if lacking[need]), "")

    return skipped


def _integral(integral: Integral) -> RowCheck:
    needs = ["azimuth"] if integral.azimuth else []
    needs += ["own force"] if integral.name != "jellett" else []

    def skipped(setup: CheckSetup, first: Samples) -> str:
        if not integral.holds(setup.scene.model, setup.scene.body):
            rolls = integral.name in ("routh", "modified_energy")
            return f"an integral of {'rolling' if rolls else 'frictionless gliding'} only"
        lacking = _unless(*needs)(setup, first)
        if lacking or numpy.isfinite(integral.evaluate(first.first)):
            return lacking
        return f"needs the velocity: columns {', '.join(setup.columns.velocity)}"

    def watch(setup: CheckSetup, first: Samples, limit: float) -> Watch:
        start = integral.evaluate(first.first)
        scale = float(integral.scale(first.first)) or 1.0
        return lambda samples: abs(integral.evaluate(samples.q) - start) / scale

    return RowCheck(integral.name, integral.meaning, watch, skipped)


def _energy(integral: Integral) -> RowCheck:
    conserved = _integral(integral)

    def watch(setup: CheckSetup, first: Samples, limit: float) -> Watch:
        if integral.holds(setup.scene.model, setup.scene.body) and setup.own_force:
            return conserved.watch(setup, first, limit)
        scale = float(integral.scale(first.first)) or 1.0
        lowest = numpy.inf

        def rise(samples: Samples) -> numpy.ndarray:
            nonlocal lowest
            energy = quantities.E(samples.q)
            if setup.scene.body.spring:
                energy = energy + stored_energy(setup.body, samples.q.state.height, numpy)
            floor = numpy.minimum(numpy.minimum.accumulate(energy), lowest)
            lowest = float(floor[-1])
            return (energy - floor) / scale

        return rise

    return RowCheck(
        "energy",
        "E, with what an elastic table holds: conserved without friction, never rising with it; "
        "section 1",
        watch,
        _unless("height", "velocity"),
    )


class Contact:
    """g_n over the weight, and when it vanishes."""

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        self._weight, self._limit = setup.body.m * setup.body.g, limit
        self._left = math.inf

    def __call__(self, samples: Samples) -> Array:
        values: Array = quantities.g_n(samples.q) / self._weight + 0 * samples.t
        least = numpy.minimum(values[1:], values[:-1])
        low = numpy.flatnonzero((least < LOW) & (least >= self._limit))
        # half of the way, from either end
        for ends, sign in ((low, 0.5), (low + 1, -0.5)) if len(low) else ():
            steps = sign * numpy.diff(samples.t)[low]
            between = least_margin(samples.rows(ends), steps) / self._weight
            values[low + 1] = numpy.minimum(values[low + 1], between)
        pulls = numpy.flatnonzero(values < self._limit)
        if len(pulls) and self._left == math.inf:
            row = int(pulls[0])  # it may be wrong, and only the solution to it leave the table
            self._left = lift_off(samples.rows(slice(max(row - 1, 0), row + 1)))
        return values

    @property
    def note(self) -> str:
        """When the top leaves the table, and the remedy."""
        return ending("contact_lost", self._left) if self._left < math.inf else ""


def _axis(setup: CheckSetup, first: Samples, limit: float) -> Watch:
    return lambda samples: abs(numpy.sqrt(dot(samples.state.k, samples.state.k)) - 1)


def _quaternion(setup: CheckSetup, first: Samples, limit: float) -> Watch:
    names = ("qw", "qx", "qy", "qz")
    return lambda samples: abs(numpy.sqrt(sum(samples.given[name] ** 2 for name in names)) - 1)


def _residual(part: str) -> Callable[[CheckSetup, Samples, float], Watch]:
    def watch(setup: CheckSetup, first: Samples, limit: float) -> Watch:
        if "residual" not in first.shared:
            first.shared["residual"] = EquationResidual(setup, first)
        return SummedResidual(first.shared["residual"], part, limit)

    return watch


def _fall(setup: CheckSetup, first: Samples, limit: float) -> Watch:
    t, rate, body = first.t[0], first.given["vcz"][0], setup.body
    omega = first.first.omega
    scale = float(body.R * numpy.sqrt(dot(omega, omega))) or 1.0
    return lambda rows: abs(rows.given["vcz"] - rate + body.g * (rows.t - t)) / scale


def _time(setup: CheckSetup, first: Samples, limit: float) -> Watch:
    return lambda samples: numpy.diff(samples.t, prepend=-numpy.inf)


def checks_of(scene: Scene) -> tuple[RowCheck, ...]:
    """The ``CHECKS`` that apply to ``scene``."""
    aloft = ("fall", *OF_FLIGHT)
    return tuple(c for c in CHECKS if scene.model == "flight" or c.name not in aloft)


CHECKS = (
    RowCheck(
        "time", "strictly increasing: anything else is refused (s)",
        _time, _unless(), 0.0, "above",
    ),
    _integral(INTEGRALS["jellett"]),
    _energy(INTEGRALS["energy"]),
    RowCheck(
        "energy_balance", "E falls by the integral of mu g_n v_A^2; section 1",
        _residual("energy"), _unless("dissipation", "force", "velocity"),
    ),
    RowCheck(
        "equations", "the state changes by the integral of its rates; eq (1)",
        _residual("state"), _unless("force", "velocity"),
    ),
    RowCheck(
        "kinematics",
        "attitude (rad) and position (over R) follow the velocities, z stands at R (1 - alpha cos "
        "theta); every law",
        Kinematics, _unless(), 1e-2,
    ),
    RowCheck(
        "contact_momentum",
        "the angular momentum about the lowest point changes as weight and motion make it, in "
        "units of m g R alpha; every law",
        ContactMomentum, _unless("azimuth", "velocity", "centre's height"), 1e-4,
    ),
    RowCheck(
        "normal_force",
        "F_z/(m g) in the mean from row to row: the table does not pull; every law",
        normal_force, _unless("contact", "vertical velocity"), -1e-3, "at least",
    ),
    RowCheck(
        "friction_power", "F_t.v_A over m g R omega at the start: never above 0; every law",
        FrictionPower,
        _unless("contact", "velocity columns", "azimuth", "velocity", "centre's height"), 1e-3,
    ),
    RowCheck(
        "contact", "g_n/(m g): the table pushes, it does not pull; eq (7)",
        Contact, _unless("contact", "no flight", "force", "velocity"), LIFT_OFF, "at least",
    ),
    RowCheck(
        "contact_velocity", "v_A.z = 0 (rolling: v_A = 0), in units of R omega at the start",
        ContactVelocity, _unless("contact", "no flight", "velocity columns", "vertical slip"),
    ),
    RowCheck(
        "fall", "s_dot.z falls at g, in units of R omega at the start",
        _fall, _unless("vertical velocity"),
    ),
    RowCheck("axis_norm", "|k| = 1", _axis, _unless("axis")),
    RowCheck("quaternion_norm", "|q| = 1", _quaternion, _unless("quaternion")),
    *(
        _integral(INTEGRALS[name])
        for name in INTEGRALS
        if name not in ("jellett", "energy", "axis_norm")
    ),
)  # fmt: skip


DEFAULT_LIMITS = {check.name: check.limit for check in CHECKS}


def chosen_limits(given: Mapping[str, float]) -> dict[str, float]:
    """The default limits, changed by those given.

    Raises ``InputError``: a check of that name does not exist, or its limit is not a number.
    """
    for name in given:
        if name not in DEFAULT_LIMITS:
            raise InputError(f"limit: got {name!r}, expected one of: {', '.join(DEFAULT_LIMITS)}")
    return DEFAULT_LIMITS | {
        name: finite(f"limit of {name}", value) for name, value in given.items()
    }


def finite(what: str, value: object) -> float:
    """A number given as a limit.

    Raises ``InputError``: it is not a finite number: every value passes a comparison with NaN.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise InputError(f"{what}: got {value!r}, expected a finite number")
    return float(value)


def read_limits(texts: Iterable[str], option: str = "--limit") -> dict[str, float]:
    """Limits by name from NAME=VALUE, or from VALUE for all others with the default 1e-6.

    ``option`` is the name of the option, for errors.

    Raises ``InputError``: a value is not a number, or a name has two values.
    """
    limits: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            raise InputError(f"{option}: got {text!r}, expected NAME=VALUE or VALUE") from None
        name = name.strip()
        if name in limits or (equals and not name):
            raise InputError(f"{option}: got {text!r}, expected NAME=VALUE or VALUE, each once")
        limits[name] = number
    usual = limits.pop("", None)
    if usual is None:
        return limits
    return {name: usual for name, value in DEFAULT_LIMITS.items() if value == PAPER_LIMIT} | limits
