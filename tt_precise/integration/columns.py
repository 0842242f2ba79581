"""``Columns``: converts dimensionless rows of a state to named columns and states in SI."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy

from tt_precise.integration.equations import QUADRATURE_SCALE, QUADRATURES
from tt_precise.integration.precision import DOUBLES, Precision, functions_of
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.parameters import RATE, SPEED, Dimension
from tt_precise.mechanics.quantities import QUANTITIES, Motion, Pose, Quantity, described, pose
from tt_precise.mechanics.vectors import horizontal_length
from tt_precise.runtime.values import Array, InputError, Json, Scalar, distinct, listed, wrong_name
from tt_precise.scene.scene import InitialState

VECTOR_COLUMNS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER_COLUMNS = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")

POSE = "pose"
POSE_COLUMNS = {
    POSE: Pose._fields,
    "pose:xyzw": ("qx", "qy", "qz", "qw", *Pose._fields[4:]),  # the scalar last
}
POSE_NAMES = frozenset(Pose._fields)
_DIMENSIONS = {"q": Dimension(), "w": RATE, "v": SPEED}
_LENGTH = Dimension(0, 1, 0)
# Difference of a value from that of its row alone, relative to the largest: far above rounding.
COMBINED = 1e-9
MOST_MISSED = 0.1  # rad between a quadrature's phi and the state's; a lost passage makes pi

Name = str | Quantity
"""What a column is called by: its name, or the quantity itself where it is one's own."""

Row = tuple[Scalar, ...]
"""The state in the order of its formulation's columns, and the quadratures (scaled) behind it."""


@dataclass(frozen=True, repr=False)
class State:
    """A state at one time, in SI: ``t`` in s, then name to number, None where undefined.

    Names are those of the trajectory file: kx ... vy, theta ... nu_y, and the recorded quadratures.
    A printed state shows only the digits that its known ``errors`` permit.
    """

    t: Scalar
    values: dict[str, Scalar]
    precision: Precision
    errors: Mapping[str, Scalar] = field(default_factory=dict, compare=False)

    def __repr__(self) -> str:
        theta = self.values.get("theta")
        tilt = "" if theta is None else f": theta {float(theta):.6g} rad"
        return f"<State at t = {float(self.t):.6g} s{tilt}, {self.precision.name}>"

    def _repr_html_(self) -> str:
        from tt_precise.runtime.files import as_html

        rows = [(name, text, described(name).unit) for name, text in self._lines]
        return as_html("State (SI)", rows)

    def __getattr__(self, name: str) -> Scalar:
        values = self.__dict__.get("values", {})  # there are none during copying
        if name in values:
            return values[name]
        text = wrong_name("state", name, values, '; frame("g_n", times=[3]) has quantities')
        raise AttributeError(str(text), name=name, obj=self)

    def __str__(self) -> str:
        return "\n".join(f"{name:>9} {text}" for name, text in self._lines)

    @property
    def _lines(self) -> list[tuple[str, str]]:
        text, values = self.precision.with_error, {"t": self.t, **self.values}
        return [(name, text(value, self.errors.get(name))) for name, value in values.items()]

    def as_text(self) -> dict[str, Json]:
        """Every value in decimals, enough to recover the working precision."""
        return {name: self.precision.text(value) for name, value in self.values.items()}


def name_of(name: Name) -> str:
    """The name of a column as users read it."""
    return str(getattr(name, "name", name))


class Columns:
    """The columns and quantities of a run's dimensionless rows, of numbers or arrays over time."""

    def __init__(self, setup: Setup, start: InitialState):
        self.layout, self.precision = setup.layout, setup.precision
        self.form, self.record = self.layout
        self.start, self.further = start, setup.further

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Default columns: vectors where the azimuth is known, Euler state, quadratures."""
        vectors = VECTOR_COLUMNS if self.has_azimuth else ()
        return (*vectors, *EULER_COLUMNS, *self.further, *self.record)

    @cached_property
    def has_azimuth(self) -> bool:
        """True if the direction of the tilt is known, not only Euler rates."""
        return self.form.coordinates == "newton" or "phi" in self.record

    def dimension(self, name: Name) -> Dimension:
        """The dimension of a column; raises for unknown names."""
        if isinstance(name, Quantity):
            return name.dimension
        if name in self.dimensions:
            return self.dimensions[name]
        also = ", pose, digits, error:NAME or drift:NAME, or a tt.quantity(function, unit) itself"
        raise wrong_name("column", name, self.dimensions, also)

    @cached_property
    def dimensions(self) -> dict[str, Dimension]:
        """The dimensions of all columns by name."""
        own = {n: STATE_DIMENSIONS[n] for n in self.names}
        available = (q for q in QUANTITIES.values() if self.has_azimuth or not q.azimuth)
        pose = {n: _DIMENSIONS.get(n[0], _LENGTH) for n in Pose._fields}
        return pose | own | {q.name: q.dimension for q in available}

    def motion(self, row: Row) -> Motion:
        """The ``Motion`` of a row."""
        return self.layout.motion(self.start.body, row, self.precision.context)

    def of_arrays(
        self, names: Sequence[Name], row: Sequence[Array], numbers: Any = DOUBLES
    ) -> dict[Any, Array]:
        """An array for each column (SI), from an array for each entry; NaN where undefined."""
        q, columns = self.array_motion(row, numbers), dict[Any, Array]()
        recorded = zip(self.record, row[len(self.form.columns) :], strict=True)
        quadratures = {name: values * QUADRATURE_SCALE for name, values in recorded}
        pose = cache(lambda: pose_of(q, quadratures))
        with numpy.errstate(all="ignore"):
            for name in names:
                if isinstance(name, Quantity):
                    values = _of_user(name, q, self.array_motion([x[-1:] for x in row], numbers))
                elif name in quadratures:
                    values = quadratures[name]
                elif name in self.further or name in VECTOR_COLUMNS:
                    values = getattr(q.state, name, 0 * q.state.kz)
                elif name in POSE_NAMES:
                    values = getattr(pose(), name)
                else:
                    values = QUANTITIES[name].evaluate(q)
                values = values * self._unit(self.dimension(name), numbers)
                if not hasattr(values, "__len__"):
                    values = values * numpy.ones(len(row[0]))  # one number for all rows
                columns[name] = values
        return columns

    def _unit(self, dimension: Dimension, numbers: Any) -> Scalar:
        units = self.start.units
        return self.start.once(
            (dimension, numbers), lambda: numbers.number(units.of_dimension(dimension))
        )

    def array_motion(self, row: Sequence[Array], numbers: Any) -> Motion:
        """The ``Motion`` of rows, given as an array for each entry, in an arithmetic of arrays."""
        start = self.start
        body = start.once(("body", numbers), lambda: start.body.numbers(numbers.number))
        return self.layout.motion(body, row, functions_of(numbers))


def quantity(
    function: Callable[[Motion], Scalar], unit: str | None = None, name: str | None = None
) -> Quantity:
    """A user's quantity with its SI unit, as a column: ``frame(tt.quantity(slip, "m/s"))``.

    Among the ``events`` of ``integrate`` a quantity gives its extrema, called ``extremum:slip``,
    where it is smooth: of a root, such as a speed, take the square where it may be 0. ``name`` is
    by default that of the function.

    ``function`` takes the ``Motion``, in units of m = R = g = 1 and in the arithmetic of the run,
    and returns one number in these units. Use the elementary functions ``motion.fn.sqrt``, ``sin``
    and others. ``unit`` is an SI unit without prefix, such as "m/s", "kg m^2/s", "J" or "1";
    without one the numbers stay in units of m = R = g = 1, and the column's name says so.

    Raises
    ------
    InputError
        ``function`` is not a function with a name, or the unit does not have this form.
    """
    if not (callable(function) and hasattr(function, "__name__")):
        raise InputError(f"quantity: got {function!r:.60}, expected a function of the motion")
    own = Quantity.of(function, unit)
    return own if name is None else replace(own, name=name)


def _of_user(own: Quantity, q: Motion, last: Motion) -> Scalar:
    """The values of a user's quantity, of which that of the ``last`` row alone is the last.

    Others are vectors, or combine several times, as ``numpy.linalg.norm`` of a vector does.
    """
    values, single = own.evaluate(q), own.evaluate(last)
    if not isinstance(values, (tuple, list)):
        rows, alone = numpy.ravel(values), numpy.ravel(single)
        apart, largest = abs(rows[-1] - alone[0]), numpy.fmax.reduce(abs(rows), initial=0)
        equal = rows[-1] == alone[0] or apart <= COMBINED * largest or alone[0] != alone[0]
        if len(alone) == 1 and equal:
            return values
    raise InputError(
        f"column: got values of {own.name} that are vectors or combine several times, expected a "
        "function of the numbers at one time: vectors are tuples, so write motion.omega[2], and "
        "motion.fn.sqrt(x*x + y*y + z*z) in the place of numpy.linalg.norm"
    )


def expanded(names: Iterable[Any]) -> tuple[Name, ...]:
    """The requested columns as a flat list, with functions as quantities and the pose expanded."""
    columns: list[Name] = []
    for name in names:
        if callable(name) and hasattr(name, "__name__"):
            columns.append(Quantity.of(name))
        elif isinstance(name, Quantity):
            columns.append(name)
        elif isinstance(name, str):  # every table begins with t
            for column in listed(name):
                columns += POSE_COLUMNS.get(column, (column,) if column != "t" else ())
        elif isinstance(name, Iterable):
            columns += expanded(name)
        else:
            raise InputError(f"column: got {name!r:.60}, expected names or functions of the motion")
    return distinct("column", columns)


def vertical() -> InputError:
    """The error of a pose at a pole."""
    return InputError(
        "pose: got an axis that is exactly vertical at some time, where phi and psi are "
        "undefined; expected another scene"
    )


def pose_of(q: Motion, recorded: Mapping[str, Scalar]) -> Pose:
    """The pose of a motion with ``recorded`` phi, psi, x and y; for one row or arrays."""
    if missing := [name for name in QUADRATURES if name not in recorded]:
        raise InputError(
            f"column: got a pose of a run without {', '.join(missing)}, expected them among its "
            "record"
        )
    fn, phi = q.fn, recorded["phi"]
    pi = fn.atan2(abs(0 * phi), abs(0 * phi) - 1)  # of the arithmetic, whichever it is
    nearest = getattr(fn, "nint", None) or fn.round
    # the azimuth of the state itself, in the turn that the quadrature counted
    azimuth = fn.atan2(q.state.ky, q.state.kx)
    azimuth = azimuth + 2 * pi * nearest((phi - azimuth) / (2 * pi))
    # phi loses the half turn where the axis passes through the vertical
    if bool((numpy.abs(numpy.asarray(phi - azimuth, dtype=float)) > MOST_MISSED).any()):
        raise vertical()
    length = horizontal_length(fn, q.state.kx, q.state.ky)
    return pose(q, length, azimuth, recorded["psi"], recorded["x"], recorded["y"])
