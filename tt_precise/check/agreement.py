"""Agreement of every extra column with the state, or with the integral of the state's rates.

A second column set, such as theta and omega_3 in a file of vectors, is compared row by row,
relative to the sizes of the rule of digits. Angles and positions that are integrals of the state's
rates are not compared row by row: ``kinematics`` or the comparison with the solution covers them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.conventions import QUATERNION
from tt_precise.check.result import Residual, check_of_rows
from tt_precise.check.start import rounding
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.euler import EulerState, euler_from_vectors
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Quaternion, cross, dot, multiplied, rotate
from tt_precise.runtime.values import Array, Check

NAME = "agreement"
MEANING = "columns beside those of the state agree with it, each relative to its size"
# Two sets in one file come from one state: only rounding, and printing, can separate them.
LIMIT = 1e-6
PRINTED = 4.0  # Roundings of the state: both sets are printed, and one is computed.


def agreement(rows: Samples, followed: frozenset[str]) -> Check:
    """Compare the columns that the state determines; ``followed`` are other columns looked at."""
    own = {"t", *rows.setup.columns.names, *rows.setup.columns.height}
    further = [name for name in rows.given if name not in own]
    open_ = frozenset() if rows.setup.columns.azimuth else HORIZONTAL
    open_ |= frozenset() if rows.setup.has_velocity else VELOCITIES
    derived = {name: of(rows) for name, of in DERIVED.items() if name in {*further} - open_}
    left = [name for name in further if name not in derived and name not in followed]
    if rows.setup.columns.azimuth and all(name in further for name in QUATERNION):
        derived |= zip(QUATERNION, _with_the_axis_of_the_state(rows), strict=True)
    if not further:
        return Check(NAME, "pass", 0.0, LIMIT, 0.0, "no further columns", MEANING)
    worst = numpy.zeros(len(rows.t))
    named, bound = "", PRINTED * rounding(rows)
    for name, size in sizes_of_derived(rows, derived).items():
        apart = rows.given[name] - derived[name]
        if name == "phi":
            apart = (apart + numpy.pi) % (2 * numpy.pi) - numpy.pi
        off = abs(apart) / size - bound
        off = numpy.where(numpy.isfinite(off), off, 0.0)  # ``finite`` counts the others
        named = name if off.max() > max(LIMIT, worst.max()) else named
        worst = numpy.maximum(worst, off)
    lacking = f"{', '.join(left)} not looked at" if left else ""
    note = f"checked {', '.join(further)}"
    if named:
        note = f"{named} does not agree with the {rows.setup.columns.name} columns"
    elif bound > LIMIT:
        note += f"; detects {bound:.0e}"
    seen = Residual(worst, bound, note, lacking, decided=True)
    return check_of_rows(NAME, MEANING, "at most", LIMIT, rows.t, seen)


def _euler(name: str) -> Callable[[Samples], Array]:
    def column(rows: Samples) -> Array:
        values: Array = getattr(_angles(rows), name)
        return values

    return column


def _angles(rows: Samples) -> EulerState:
    return euler_from_vectors(rows.setup.body, NewtonState(*rows.state[:8]), numpy)


def _psi_dot(rows: Samples) -> Array:
    euler = _angles(rows)
    return euler.omega_3 - euler.phi_dot * rows.state.kz


def _vector(name: str) -> Callable[[Samples], Array]:
    return lambda rows: numpy.asarray(getattr(rows.state, name))


def _component(vector: str, axis: int) -> Callable[[Samples], Array]:
    def column(rows: Samples) -> Array:
        values: Array = getattr(rows.q, vector)[axis]
        return numpy.broadcast_to(values, rows.t.shape)

    return column


def _with_the_axis_of_the_state(rows: Samples) -> Quaternion:
    """The file's attitude, turned the shortest way to the state's axis.

    The turn about the axis is not in the state: ``kinematics`` follows it in time.
    """
    given = numpy.array([rows.given[name] for name in QUATERNION])
    w, x, y, z = given / numpy.sqrt((given**2).sum(axis=0))
    own, k = rotate((w, x, y, z), (0.0, 0.0, 1.0)), rows.state.k
    half = numpy.array((1 + dot(own, k), *cross(own, k)))
    turn_w, turn_x, turn_y, turn_z = half / numpy.sqrt((half**2).sum(axis=0))
    return multiplied((turn_w, turn_x, turn_y, turn_z), (w, x, y, z))


# The columns that a state determines, each by its name.
DERIVED: Mapping[str, Callable[[Samples], Array]] = {
    **{name: _euler(name) for name in EulerState._fields},
    "psi_dot": _psi_dot,
    "phi": lambda rows: numpy.arctan2(rows.state.ky, rows.state.kx),
    **{name: _vector(name) for name in NewtonState._fields},
    **{f"w{axis}": _component("omega", n) for n, axis in enumerate("xyz")},
    **{f"vc{axis}": _component("s_dot", n) for n, axis in enumerate("xyz")},
}

# Columns that the direction of the axis decides, which Euler angles without phi leave open.
HORIZONTAL = frozenset(f"{vector}{axis}" for vector in "kLvw" for axis in "xy")
HORIZONTAL |= {"phi", "vcx", "vcy"}
# Those that the velocity of the contact point decides.
VELOCITIES = frozenset(("vx", "vy", "nu_x", "nu_y", "vcx", "vcy"))


def sizes_of_derived(rows: Samples, derived: Mapping[str, Array]) -> dict[str, Array]:
    """Return the sizes of columns that follow from the state of the rows."""
    known = dict(zip(NewtonState._fields, rows.state[:8], strict=True))
    found = sizes(rows.setup.body, {**known, **_of_the_rule(derived)}, numpy)
    omega = found["Lz"] / min(rows.setup.body.I1, rows.setup.body.I3)
    further = {"phi": 1.0 / numpy.hypot(rows.state.kx, rows.state.ky)}
    further |= dict.fromkeys(QUATERNION, numpy.ones_like(rows.t))
    further |= dict.fromkeys(("wx", "wy", "wz"), omega)
    further |= dict.fromkeys(("vcx", "vcy", "vcz"), found["vx"])
    return {
        name: further.get(name, found.get(name))
        for name, values in derived.items()
        if not numpy.isnan(values).all()
    }


def _of_the_rule(derived: Mapping[str, Array]) -> dict[str, Array]:
    return {n: values for n, values in derived.items() if n in (*EulerState._fields, "psi_dot")}
