"""The rows of a trajectory: times, one rigid motion, and the sizes and the precision of both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy

from tt_precise.check.columns import POSITION, Columns, ColumnSet, RigidMotion
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState, contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.runtime.values import Array, require_name
from tt_precise.scene.scene import Scene

EPS = float(numpy.finfo(float).eps)
SAMPLED = 200  # rows from which the precision of a file is inferred
MOST_DIGITS = 10  # a number of more digits is as precise as a double here
DISTINCT = 4  # numbers of so few digits; doubles have them by chance with a probability of 1e-23
# The columns of each quantity whose error is relative to one size.
COLUMNS_OF = {
    "k": "kx ky kz qw qx qy qz theta phi psi", "L": "Lx Ly Lz", "v": "vx vy vcx vcy vcz nu_x nu_y",
    "rate": "wx wy wz theta_dot phi_dot psi_dot omega_3", "x": "x y z", "t": "t",
}  # fmt: skip


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

    ``t`` (s) begins at 0. ``columns`` are in our conventions. ``precision`` is half a unit of the
    last written place of each quantity over its largest number: it is inferred from the file, and
    conversions keep it. ``cache`` has results that several checks need.
    """

    assumed: Assumptions
    t: Array
    columns: Columns
    precision: Mapping[str, float] = field(default_factory=dict)
    cache: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(cls, assumed: Assumptions, columns: Columns) -> Rows:
        """Return the rows of the columns of a file."""
        rows = cls(assumed, columns["t"] - columns["t"][:1], columns)
        few = rows.part(slice(None, None, max(1, len(rows.t) // SAMPLED)))
        return replace(rows, precision={n: half_unit(few._numbers(n)) for n in COLUMNS_OF})

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
        sizes = {"k": 1.0, "L": self.units["L"], "v": self.units["v"], "rate": self.spin_rate}
        sizes |= {"x": self.body.R} if self.has_height else {}
        return max(self._half_unit(name) / size for name, size in sizes.items())

    @property
    def position_rounding(self) -> float:
        """Half a unit of the last written place of the position, in R."""
        return self._half_unit("x") / self.body.R

    @property
    def time_rounding(self) -> float:
        """The angle (rad) by which the top turns within the rounding of a time.

        Times of few digits are exact where they are even.
        """
        steps = numpy.diff(self.columns["t"])
        steps = steps / numpy.sort(steps)[len(steps) // 2]
        even = (abs(steps - numpy.rint(steps)) < 1e-8).all()
        half = 0.0 if even else self._half_unit("t")
        return self.spin_rate * (half + 2 * EPS * float(abs(self.columns["t"]).max()))

    def _half_unit(self, name: str) -> float:
        """Return half a unit of the last written place of a quantity, in SI."""
        return self.precision.get(name, 0.0) * float(abs(self._numbers(name)).max(initial=0.0))

    def _numbers(self, quantity: str) -> Array:
        """Return the columns of a quantity that belong to the state, the position or the time."""
        own = {*self.assumed.columns.names, *POSITION, "t"} & {*self.columns}
        names = [name for name in COLUMNS_OF[quantity].split() if name in own]
        return numpy.array([self.columns[name] for name in names]).reshape(len(names), len(self.t))


def half_unit(values: Array) -> float:
    """Return half a unit of the last place in which numbers are written, over the largest of them.

    The number with the most digits shows the place; 0 stands for full doubles. A short decimal may
    be a 32-bit float: the coarser precision counts.
    """
    numbers = numpy.array(sorted({*values[numpy.isfinite(values) & (values != 0)].tolist()}))
    if len(numbers) < DISTINCT:
        return 0.0
    largest = float(abs(numbers).max())
    single = (numbers == numbers.astype(numpy.float32)).all()
    half = float(numpy.finfo(numpy.float32).eps) / 2 if single else 0.0
    digits = max(len(Decimal(repr(x)).normalize().as_tuple().digits) for x in numbers.tolist())
    if digits <= MOST_DIGITS:
        exponent = math.floor(math.log10(largest * (1 - 1e-9)))  # 1 is written like 0.999
        half = max(half, 10.0 ** (exponent - digits + 1) / 2 / largest)
    return half
