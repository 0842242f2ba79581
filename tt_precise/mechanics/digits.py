"""The number of correct digits of an entry: one rule for estimates, comparisons and checks.

An error is relative to the size, at the same time, of the quantity to which the entry belongs. An
entry that passes through zero keeps its digits, and a decayed entry inherits the errors of its
terms. ``integrate(digits=N)`` delivers N digits by this rule; ``check --digits N`` requires N.
"""

from __future__ import annotations

from collections.abc import Mapping

from tt_precise.mechanics import parameters
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, E, Motion
from tt_precise.mechanics.vectors import Vector, cross, dot, horizontal_length
from tt_precise.runtime.values import Functions, Scalar

MOST_GOLDEN = 33  # Digits that golden data can confirm: they are rounded to 34.
RULE = (
    "Errors are relative to the size at that time: 1 for the axis, |L| for L, |v_CM| + |omega||a| "
    "for velocities, the larger of itself and |omega| for a rate, 1 rad for angles, the larger of "
    "the distance and R for positions, E for energies, the larger of itself and sqrt(R/g) for a "
    "time; at least I1 sqrt(g/R), sqrt(g R), sqrt(g/R), m g R. Near the vertical, where the "
    "direction of the tilt is uncertain, |omega| for phi_dot and psi_dot, |k_dot| for theta_dot, "
    "and |v_A| for nu_x and nu_y, are divided by sin theta."
)

ABOUT_THE_VERTICAL = ("phi_dot", "psi_dot")
ALONG_THE_TILT = ("nu_x", "nu_y")


def sizes(body: Parameters, columns: Mapping[str, Scalar], fn: Functions) -> dict[str, Scalar]:
    """Return the size to which the error of each of ``columns`` is relative; see ``RULE``.

    ``columns`` are numbers, or arrays over time, in the units of ``body``: those of a state, as
    vectors or Euler angles, and any others. A column that is None is undefined and has no size. For
    a dimension that the rule does not name the size is the quantity itself.
    """
    q = _motion(body, columns, fn)
    rate = fn.sqrt(body.g / body.R)
    omega, slip = _length(q.omega, fn), _length(q.state.v, fn)
    spinning = larger(omega, rate)
    moving = larger(_length(q.s_dot, fn) + omega * _length(q.a, fn), fn.sqrt(body.g * body.R))
    turning = larger(_length(q.state.L, fn), body.I1 * rate)
    sizes_by_name: dict[str, Scalar] = {}
    for name, value in columns.items():
        if value is None:
            continue
        dimension = STATE_DIMENSIONS.get(name) or QUANTITIES[name].dimension
        if name in ABOUT_THE_VERTICAL:
            sizes_by_name[name] = larger(abs(value), larger(omega / _tilt(q), spinning))
        elif name in ALONG_THE_TILT:
            sizes_by_name[name] = larger(slip / _tilt(q), moving)
        elif name == "theta_dot":  # the part of k_dot in the direction of the tilt
            sizes_by_name[name] = larger(_length(cross(q.omega, q.k), fn) / _tilt(q), spinning)
        elif dimension == parameters.ANGLE:
            sizes_by_name[name] = 1 + 0 * omega
        elif dimension == parameters.RATE:
            sizes_by_name[name] = larger(abs(value), spinning)
        elif dimension == parameters.SPEED:
            sizes_by_name[name] = moving
        elif dimension == parameters.ANGULAR_MOMENTUM:
            sizes_by_name[name] = turning
        elif dimension == parameters.LENGTH:
            sizes_by_name[name] = larger(_distance(name, columns, fn), body.R)
        elif dimension == parameters.ENERGY:
            sizes_by_name[name] = larger(E(q), body.m * body.g * body.R)
        else:
            sizes_by_name[name] = abs(value)
    return sizes_by_name


def larger(a: Scalar, b: Scalar) -> Scalar:
    """The larger of two sizes, in any arithmetic."""
    return (a + b + abs(a - b)) / 2


def _motion(body: Parameters, columns: Mapping[str, Scalar], fn: Functions) -> Motion:
    if "kx" in columns:
        vectors = NewtonState(*(columns[name] for name in NewtonState._fields))
    else:
        euler = EulerState(*(columns[name] for name in EulerState._fields))
        vectors = vectors_from_euler(body, euler, fn)
    if "height" not in columns:
        return Motion(body, vectors, fn)
    return Motion(body, LiftedState(*vectors, columns["height"], columns["rise"]), fn)


def _tilt(q: Motion) -> Scalar:
    # sizes are divided by it, at the vertical itself too
    return horizontal_length(q.fn, q.state.kx, q.state.ky) + 1e-305


def _length(vector: Vector, fn: Functions) -> Scalar:
    return fn.sqrt(dot(vector, vector))


def _distance(name: str, columns: Mapping[str, Scalar], fn: Functions) -> Scalar:
    if "x" in columns and "y" in columns and name in ("x", "y"):
        return horizontal_length(fn, columns["x"], columns["y"])
    return abs(columns[name])
