"""The rows of a trajectory: times, one rigid motion, and the sizes and the precision of both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy

from tt_precise.check.columns import Columns, ColumnSet, RigidMotion
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState, contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.values import Array, require_name
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
MOST_SAMPLED = 4096  # rows from which the precision of a column is inferred
MOST_DIGITS = 10  # a number of more digits is as precise as a double here
FEWEST, DISTINCT = 8, 4  # numbers, and distinct ones, from which a precision is inferred
# Columns that are printed alike, and the quantity they belong to. A component that stays 0 does not
# show its precision, so that components are examined together.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "t": ("t",),
    "k": ("kx", "ky", "kz"),
    "q": ("qw", "qx", "qy", "qz"),
    "angle": ("theta", "phi", "psi"),
    "rate": ("wx", "wy", "wz", "theta_dot", "phi_dot", "psi_dot", "omega_3"),
    "L": ("Lx", "Ly", "Lz"),
    "v": ("vx", "vy", "vcx", "vcy", "vcz", "nu_x", "nu_y", "rise"),
    "x": ("x", "y", "z", "height"),
}


@dataclass(frozen=True)
class Assumptions:
    """The assumptions about a file: its scene, its columns, and whose the force and the start are.

    ``friction`` is "scene" if the contact force is the scene's, "other" if it is unknown; ``start``
    likewise. ``body`` replaces the scene's body in a hypothesis.
    """

    scene: Scene
    columns: ColumnSet
    friction: str = "scene"
    start: str = "scene"
    body: Parameters | None = None

    def __post_init__(self) -> None:
        for name in ("friction", "start"):
            require_name(name, getattr(self, name), ("scene", "other"))

    @property
    def rolling(self) -> bool:
        """True if the contact point is at rest."""
        return self.scene.model == "rolling"

    @property
    def flying(self) -> bool:
        """True if nothing touches the top."""
        return self.scene.model == "flight"

    @property
    def smooth(self) -> bool:
        """True if one smooth system of equations governs the whole motion."""
        return self.flying or not self.scene.in_pieces


@dataclass(frozen=True)
class Rows:
    """The rows of a trajectory.

    ``t`` (s) begins at 0. ``given`` has the columns as read, in our conventions. ``precision`` is
    half a unit of the last written place of each group of columns over its largest number: it is
    inferred from the file, and conversions keep it. ``cache`` has results that several checks need.
    """

    assumed: Assumptions
    t: Array
    columns: Columns
    precision: Mapping[str, float] = field(default_factory=dict)
    cache: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(cls, assumed: Assumptions, columns: Columns) -> Rows:
        """Return the rows of the columns of a file."""
        return cls(assumed, columns["t"] - columns["t"][:1], columns, precisions(columns))

    def part(self, chosen: slice | Array) -> Rows:
        """Return some of the rows, by a slice or by indices."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Rows(self.assumed, self.t[chosen], columns, self.precision)

    def changed(self, columns: Columns | None = None, **assumed: Any) -> Rows:
        """Return the rows with other columns, or under other assumptions."""
        values = {**self.columns, **(columns or {})}
        t = values["t"] - values["t"][0] if columns and "t" in columns else self.t
        return Rows(replace(self.assumed, **assumed), t, values, self.precision)

    @cached_property
    def body(self) -> Parameters:
        """The body in float64 and SI."""
        return self.assumed.body or self.assumed.scene.body.numbers(float)

    @cached_property
    def motion(self) -> RigidMotion:
        """The rows as a rigid motion."""
        return self.assumed.columns.motion(self.body, self.columns, self.assumed.rolling)

    @property
    def has_velocity(self) -> bool:
        """True if the velocity of the centre of mass is known."""
        return self.assumed.rolling or self.assumed.columns.velocity[0] in self.columns

    @property
    def has_height(self) -> bool:
        """True if the top may leave the table, and the height of its lowest point is known."""
        complete = {*self.assumed.columns.height} <= {*self.columns}
        return self.assumed.scene.lifts and self.has_velocity and complete

    @cached_property
    def omega(self) -> Array:
        """The angular velocity (3, n) in rad/s."""
        return numpy.array(inverse_inertia(self.body, tuple(self.motion.k), tuple(self.motion.L)))

    @cached_property
    def contact_velocity(self) -> Array:
        """The velocity v_A = v + omega x a of the contact point, (3, n) in m/s."""
        assert self.motion.v is not None
        arm = contact_arm(self.body, tuple(self.motion.k))
        return self.motion.v + numpy.array(cross(tuple(self.omega), arm))

    @cached_property
    def height(self) -> Array:
        """The height of the lowest point above the table (m); NaN if unknown."""
        x = self.motion.x
        level = self.body.R * (1 - self.body.alpha * self.motion.k[2])
        return numpy.full_like(level, numpy.nan) if x is None else x[2] - level

    @cached_property
    def state(self) -> NewtonState | LiftedState:
        """The vector state of ``mechanics``; v_A is 0 in rolling, and NaN where it is unknown."""
        k, L = self.motion.k, self.motion.L
        if self.has_velocity and not self.assumed.rolling:
            v_A = self.contact_velocity
            if "vx" in self.columns:  # free of the rounding of two conversions
                v_A = numpy.array([self.columns["vx"], self.columns["vy"], v_A[2]])
        else:
            v_A = 0 * k if self.assumed.rolling else numpy.full_like(k, numpy.nan)
        entries: list[Array] = [*k, *L, v_A[0], v_A[1]]
        if self.has_height:
            return LiftedState(*[*entries, self.columns.get("height", self.height), v_A[2]])
        return NewtonState(*entries)

    @cached_property
    def q(self) -> Motion:
        """The rows as the argument of the quantities of ``mechanics``."""
        v = None if self.motion.v is None else tuple(self.motion.v)
        velocity = (lambda: v) if v is not None and "vcz" in self.columns else None
        return Motion(self.body, self.state, numpy, self.assumed.scene.model, s_dot=velocity)

    @cached_property
    def first(self) -> Motion:
        """The first row as such an argument, with floats."""
        state = type(self.state)(*(float(values[0]) for values in self.state))
        return Motion(self.body, state, numpy, self.assumed.scene.model)

    @cached_property
    def spin_rate(self) -> float:
        """|omega| at the start (rad/s), at least sqrt(g/R)."""
        omega = self.first.omega
        return max(math.sqrt(dot(omega, omega)), math.sqrt(self.body.g / self.body.R))

    @cached_property
    def units(self) -> dict[str, float]:
        """The size of each quantity at the start, to which residuals are relative."""
        L = self.first.state.L
        size = math.sqrt(dot(L, L)) or self.body.I1 * self.spin_rate
        speed = self.body.R * self.spin_rate
        return {"k": 1.0, "q": 1.0, "L": size, "v": speed, "x": self.body.R}

    @cached_property
    def rounding(self) -> float:
        """The relative error of the state by the digits in which its columns are written."""
        sizes = {**self.units, "angle": 1.0, "rate": self.spin_rate}
        own = {*self.assumed.columns.names}
        return max((self._half_unit(name, own) / sizes[name] for name in sizes), default=0.0)

    @property
    def time_rounding(self) -> float:
        """The angle (rad) by which the top turns within the rounding of a time.

        Times of few digits are exact, but where they miss an even spacing by these digits.
        """
        t = self.columns["t"]
        steps, half = numpy.diff(t), self._half_unit("t", {"t"})
        usual = float(numpy.sort(steps)[len(steps) // 2])
        off = float(abs(steps - usual * numpy.rint(steps / usual)).max())
        rounded = 1e-8 * usual < off <= 2 * half * (1 + 1e-6)
        return self.spin_rate * (half * rounded + 2 * EPS * float(abs(t).max()))

    def _half_unit(self, group: str, own: set[str]) -> float:
        """Return half a unit of the last place of the columns ``own`` of a group, in SI."""
        precision = self.precision.get(group, 0.0)
        names = [name for name in GROUPS[group] if name in own and name in self.columns]
        if not precision or not names:
            return 0.0
        return precision * max(float(abs(self.columns[name]).max()) for name in names)


def precisions(columns: Columns) -> dict[str, float]:
    """Return half a unit of the last written place of each group over its largest number."""
    relative = {}
    for group, names in GROUPS.items():
        present = [name for name in names if name in columns]
        if present:
            stride = max(1, len(columns["t"]) // MOST_SAMPLED)
            values = numpy.concatenate([columns[name][::stride] for name in present])
            relative[group] = half_unit(values)
    return relative


def half_unit(values: Array) -> float:
    """Return half a unit of the last place in which numbers are printed, over the largest of them.

    Numbers have a fixed number of decimals or of significant digits, or are 32-bit floats; 0 stands
    for full doubles. A double has 10 decimals by chance with a probability of 4e-5, so that
    ``FEWEST`` numbers decide. A short decimal may be a 32-bit float: the coarser precision counts.
    """
    numbers = values[numpy.isfinite(values) & (values != 0)]
    if len(numbers) < FEWEST or numpy.count_nonzero(numpy.diff(numpy.sort(numbers))) < DISTINCT - 1:
        return 0.0
    size = abs(numbers)
    exponents = numpy.floor(numpy.log10(size * (1 - 1e-9)))  # 1 is printed like 0.999
    top = float(exponents.max())
    with numpy.errstate(over="ignore"):
        single = numbers.astype(numpy.float32)
    halves = [0.0]
    if (abs(numbers - single) < 1e-9 * size).all() and len(numpy.unique(single)) >= DISTINCT:
        halves.append(float(numpy.finfo(numpy.float32).eps) / 2)
    for digits in range(1, MOST_DIGITS + 1):  # decimals count from the largest number
        for scale in (top, exponents):
            shifted = numbers * 10.0 ** (digits - 1 - scale)
            whole = numpy.rint(shifted)  # a tiny number is no printed 0
            if (abs(shifted - whole) < 8 * EPS * (1 + 10.0**digits)).all() and whole.all():
                return max(*halves, 10.0 ** (top - digits + 1) / 2 / float(size.max()))
    return max(halves)
