"""Refuses trajectories that are in other units than SI, or of another body than the scene's.

A simulator's error shows as a small drift and is for the checks to tell. What is refused here is
off by a constant factor, or follows the equations only in other units: then nothing that the
checks could say would mean anything. Looked at are the first rows only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy

from tt_precise.check.blocks import Block
from tt_precise.check.columns import Columns, known_sets
from tt_precise.check.equation_residual import EquationResidual
from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.errors import InputError
from tt_precise.mechanics.newton import arm
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.vectors import added, cross, scaled

FACTOR = 0.1  # off by more than this, and constantly so, is another unit or body
CONSTANT = 0.99  # correlation from which a factor counts as constant
MISFIT, FIT = 0.2, 0.02  # parts of the motion unexplained as given, and in other units
ROUGHLY = 0.1  # how well intervals need to be resolved to tell units apart
STILL = 1e-9  # relative change of a row that counts as no motion
LOOKED_AT = 400  # rows
COMPARED = 50  # rows of a second column set
FEWEST = 8  # intervals


def refuse_other_units(
    setup: CheckSetup, first: Samples, block: Block, present: Sequence[str]
) -> None:
    """Look at the first rows.

    Raises
    ------
    InputError
        Units other than SI, or another body, are what explains them.
    """
    rows = first.rows(slice(0, LOOKED_AT))
    _refuse_degrees(setup, rows)
    _refuse_null_quaternions(setup, rows)
    _refuse_other_units(setup, rows)
    _refuse_other_velocities(setup, rows)
    _refuse_other_sets(setup, rows, block, present)


def _refuse_degrees(setup: CheckSetup, rows: Samples) -> None:
    theta = rows.given.get("theta")
    if theta is not None and float(abs(theta).max()) > 1.1 * math.pi:
        raise InputError(
            f"theta reaches {abs(theta).max():g}, expected radians from 0 to pi; is it in degrees?"
        )


def _refuse_null_quaternions(setup: CheckSetup, rows: Samples) -> None:
    if setup.columns.name == "rigid body":
        squared = sum(rows.given[name] ** 2 for name in ("qw", "qx", "qy", "qz"))
        if not numpy.all(squared):
            raise InputError("a quaternion is 0, expected an orientation of length 1")


def _refuse_other_units(setup: CheckSetup, rows: Samples) -> None:
    """Refuse what follows the equations only once it is read in other units or conventions."""
    if len(rows.t) <= FEWEST:
        return
    as_given = _misfit(setup, rows.given)
    if as_given < MISFIT:
        return
    for name, convert in READINGS.items():
        converted = convert(rows.given)
        if converted is None:
            continue
        otherwise = _misfit(setup, {**rows.given, **converted})
        if otherwise < FIT:
            raise InputError(
                f"from row to row the motion is off by {_percent(as_given)} of what the rows say, "
                f"but only by {_percent(otherwise)} if {name}; expected SI, convert it"
            )


def _misfit(setup: CheckSetup, given: Columns) -> float:
    """Median over intervals of the part of the state's change that its rates do not explain."""
    known, whole = dict(given), setup.velocity_known and setup.own_force
    if not setup.velocity_given or not whole:
        known |= dict.fromkeys(setup.columns.velocity, numpy.zeros_like(given["t"]))
    moving = replace(setup, velocity_given=True)
    samples = moving.samples(Block(known, str, lambda row, names: []))
    change, mismatch = EquationResidual(moving, samples, ROUGHLY).changes(samples)
    if not whole:  # without the force, only how the axis follows L can be told
        axis = slice(0, 3 if setup.columns.azimuth else 1)
        change, mismatch = change[axis], mismatch[axis]
    with numpy.errstate(all="ignore"):
        parts = numpy.sqrt((mismatch**2).sum(axis=0) / (change**2).sum(axis=0))
    # an axis that does not move says nothing
    parts = parts[abs(change).max(axis=0) > STILL]
    if len(parts) < FEWEST:
        return 0.0
    return float(numpy.median(numpy.where(numpy.isfinite(parts), parts, numpy.inf)))


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %" if part < 100 else "far more than all"


Reading = Callable[[Columns], "dict[str, numpy.ndarray] | None"]


def _scaled(factor: float, *names: str) -> Reading:
    def read(given: Columns) -> dict[str, numpy.ndarray] | None:
        there = [name for name in names if name in given]
        return {name: factor * given[name] for name in there} or None

    return read


def _from_body_frame(given: Columns) -> dict[str, numpy.ndarray] | None:
    if "qw" not in given:
        return None
    w = (given["wx"], given["wy"], given["wz"])
    axis = (given["qx"], given["qy"], given["qz"])
    half = cross(axis, w)
    twice = added(scaled(2 * given["qw"], half), scaled(2, cross(axis, half)))
    return dict(zip(("wx", "wy", "wz"), added(w, twice), strict=True))


def _from_scalar_last(given: Columns) -> dict[str, numpy.ndarray] | None:
    if "qw" not in given:
        return None
    ours, theirs = ("qx", "qy", "qz", "qw"), ("qw", "qx", "qy", "qz")
    return {name: given[other] for name, other in zip(ours, theirs, strict=True)}


ANGULAR = ("theta_dot", "phi_dot", "omega_3", "wx", "wy", "wz")
LINEAR = ("vx", "vy", "nu_x", "nu_y", "vcx", "vcy", "vcz")
MOMENTUM = ("Lx", "Ly", "Lz")
READINGS: dict[str, Reading] = {
    "the time is in ms": _scaled(1e-3, "t"),
    "the angle is in degrees": _scaled(math.pi / 180, "theta"),
    "the angular velocities are in deg/s": _scaled(math.pi / 180, *ANGULAR),
    "the angular velocities are in revolutions/s": _scaled(2 * math.pi, *ANGULAR),
    "the angular velocity is in the body frame": _from_body_frame,
    "the quaternion has its scalar last": _from_scalar_last,
    "the velocities are in mm/s": _scaled(1e-3, *LINEAR),
    "the velocities are in cm/s": _scaled(1e-2, *LINEAR),
    "the angular momentum is in g mm^2/s": _scaled(1e-9, *MOMENTUM),
    "the angular momentum is in kg mm^2/s": _scaled(1e-6, *MOMENTUM),
    "the angular momentum is in g cm^2/s": _scaled(1e-7, *MOMENTUM),
}


def _refuse_other_velocities(setup: CheckSetup, rows: Samples) -> None:
    if setup.columns.name != "rigid body" or not setup.velocity_given:
        return
    body, q = setup.body, rows.q
    expected = -cross(q.omega, arm(body, q.k))[2]
    given = rows.given["vcz"]
    factor = _constant_factor(given, expected)
    if factor is not None:
        lever = float(body.R * body.alpha)
        raise InputError(
            f"vcz fits a centre of mass {factor * lever:.4g} m from the centre of the sphere, "
            f"expected {lever:.4g} m = alpha R; are units or the scene's body others?"
        )


def _refuse_other_sets(
    setup: CheckSetup, rows: Samples, block: Block, present: Sequence[str]
) -> None:
    """Where a file has Euler columns beside its vectors, they must say the same."""
    others = [entry for entry in known_sets(present) if not entry.azimuth]
    if not setup.columns.azimuth or not others:
        return
    few = rows.rows(slice(0, COMPARED))
    names = [name for name in others[0].required if name in QUANTITIES]
    q = Motion(setup.body, few.state, numpy, setup.scene.model)
    with numpy.errstate(all="ignore"):
        for name in names:
            given = block.values[name][: len(few.t)]
            derived = numpy.asarray(QUANTITIES[name].evaluate(q))
            both = numpy.isfinite(given) & numpy.isfinite(derived)
            factor = _constant_factor(given[both], derived[both])
            if factor is not None:
                raise InputError(
                    f"column {name} is {factor:.4g} times what the {setup.columns.name} columns "
                    "say with the scene's body, expected 1; are units or the scene's body others?"
                )


def _constant_factor(given: numpy.ndarray, expected: numpy.ndarray) -> float | None:
    """The factor between them, if it is constant and not 1."""
    size, own = float(expected @ expected), float(given @ given)
    if not size or not own:
        return None
    product = float(given @ expected)
    factor, correlation = product / size, product / math.sqrt(size * own)
    if correlation < CONSTANT or abs(factor - 1) <= FACTOR:
        return None
    return factor
