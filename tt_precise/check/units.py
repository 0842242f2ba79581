"""Refuses trajectories in other units than SI, or of another body than the scene's.

The checks detect a simulator's error, which shows as a small drift. A trajectory is refused here if
it is wrong by a constant factor, or follows the equations only in other units: then the results of
the checks would be meaningless. Only the first rows are tested. The conventions of other simulators
are one table, ``READINGS``, tried in order; a reading may change nothing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy

from tt_precise.check.columns import (
    Block,
    Changed,
    CheckSetup,
    Columns,
    Reading,
    Samples,
    known_sets,
)
from tt_precise.check.equations import EquationResidual
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.newton import NewtonState, axis_rate, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.mechanics.vectors import Vector, cross, dot, subtracted, turned
from tt_precise.runtime.values import InputError

ANGULAR = ("theta_dot", "phi_dot", "omega_3", "wx", "wy", "wz")
LINEAR = ("vx", "vy", "nu_x", "nu_y", "vcx", "vcy", "vcz")
MOMENTUM = ("Lx", "Ly", "Lz")
AXIS = ("qx", "qy", "qz")
OMEGA = ("wx", "wy", "wz")
CENTRE = ("vcx", "vcy", "vcz")
HALF = math.sqrt(0.5)


def _scaled(factor: float, *names: str) -> Reading:
    return lambda given, body: {n: factor * given[n] for n in names if n in given} or None


def _vector(given: Columns, names: tuple[str, str, str]) -> Vector:
    return (given[names[0]], given[names[1]], given[names[2]])


def _named(names: tuple[str, str, str], values: Vector) -> Changed:
    return dict(zip(names, values, strict=True))


def _turned(given: Columns, vector: Vector) -> Vector:
    """A vector of the body's frame in the inertial one."""
    return turned((given["qw"], *_vector(given, AXIS)), vector)


def _rigid(read: Reading, needs: str = "qw") -> Reading:
    """A reading of the rigid-body columns, or of those that have the velocity, alone."""
    return lambda given, body: read(given, body) if needs in given else None


def _from_geometric_centre(given: Columns, body: Parameters) -> Changed:
    # the centre of the sphere is alpha R k away from that of mass
    away = _turned(given, (0.0, 0.0, body.R * body.alpha))
    swing = cross(_vector(given, OMEGA), away)
    return _named(CENTRE, subtracted(_vector(given, CENTRE), swing))


def _with_fitted_time(given: Columns, body: Parameters) -> Changed | None:
    """Times by the factor with which the height of the axis follows its rate."""
    sets = known_sets([*given])
    if not sets or len(given["t"]) < FEWEST:
        return None
    t, still = given["t"], dict.fromkeys(sets[0].velocity, numpy.zeros(len(given["t"])))
    state, _ = sets[0].state(body, {**still, **given}, numpy)
    rate = axis_rate(body, NewtonState(*state))[2]
    by_rate = (t[2:] - t[:-2]) * (rate[:-2] + 4 * rate[1:-1] + rate[2:]) / 6
    factor = float((state.kz[2:] - state.kz[:-2]) @ by_rate) / (float(by_rate @ by_rate) or 1.0)
    return {"t": factor * t} if factor > 0 else None


def _from_y_up(given: Columns, body: Parameters) -> Changed:
    w, x, y, z = given["qw"], *_vector(given, AXIS)
    # turned by a right angle about x, which takes their y to our z
    rigid: Changed = {
        "qw": HALF * (w - x),
        "qx": HALF * (w + x),
        "qy": HALF * (y - z),
        "qz": HALF * (y + z),
    }
    for names in (OMEGA, CENTRE):
        if names[0] in given:
            a, b, c = _vector(given, names)
            rigid |= _named(names, (a, -c, b))
    return rigid


CONVENTIONS: dict[str, Reading] = {
    "the angular velocity is in the body frame": _rigid(
        lambda given, body: _named(OMEGA, _turned(given, _vector(given, OMEGA)))
    ),
    "the quaternion has its scalar last": _rigid(
        lambda given, body: {
            **_named(AXIS, (given["qw"], given["qx"], given["qy"])),
            "qw": given["qz"],
        }
    ),
    "the quaternion is the inverse one, from the inertial to the body frame": _rigid(
        lambda given, body: {name: -given[name] for name in AXIS}
    ),
    "y is up": _rigid(_from_y_up),
    "the velocity is that of the sphere's centre": _rigid(_from_geometric_centre, "vcx"),
}
READINGS: dict[str, Reading] = {
    "the time is in ms": _scaled(1e-3, "t"),
    "the time is in microseconds": _scaled(1e-6, "t"),
    "the time is in ns": _scaled(1e-9, "t"),
    "the time is in minutes": _scaled(60.0, "t"),
    "the time counts rows, or is in a unit of its own": _with_fitted_time,
    "the angle is in degrees": _scaled(math.pi / 180, "theta"),
    "the angular velocities are in deg/s": _scaled(math.pi / 180, *ANGULAR),
    "the angular velocities are in revolutions/s": _scaled(2 * math.pi, *ANGULAR),
    "the angular velocities are in revolutions/min": _scaled(math.pi / 30, *ANGULAR),
    "the angular velocity has the other sign": _scaled(-1.0, *OMEGA),
    **CONVENTIONS,
    "the velocities are in mm/s": _scaled(1e-3, *LINEAR),
    "the velocities are in cm/s": _scaled(1e-2, *LINEAR),
    "the angular momentum is in g mm^2/s": _scaled(1e-9, *MOMENTUM),
    "the angular momentum is in kg mm^2/s": _scaled(1e-6, *MOMENTUM),
    "the angular momentum is in g cm^2/s": _scaled(1e-7, *MOMENTUM),
}  # fmt: skip


def readings(alone: bool = False) -> Iterator[tuple[str, Reading]]:
    """Every reading with its description, then two conventions at once, unless ``alone``."""
    yield from READINGS.items()
    if alone:
        return
    for first, other in itertools.permutations(CONVENTIONS, 2):
        yield f"{first} and {other}", _both(CONVENTIONS[first], CONVENTIONS[other])


def _both(first: Reading, second: Reading) -> Reading:
    def read(given: Columns, body: Parameters) -> Changed | None:
        once = first(given, body)
        twice = None if once is None else second({**given, **once}, body)
        return None if once is None or twice is None else {**once, **twice}

    return read


FACTOR = 0.1  # off by more than this, and constantly so, is another unit or body
CONSTANT = 0.99  # correlation from which a factor counts as constant
MISFIT, FIT = 0.2, 0.02  # parts of the motion unexplained as given, and in other units
WRONG = 0.35  # as given; rows about a period apart, off by 0.3, fit a slow motion too
FAR = 5.0  # as given: the axis turns many times as far
ROUGHLY = 0.1  # how well intervals need to be resolved to distinguish units
STILL = 1e-9  # relative change of a row that counts as no motion
LOOKED_AT = 400  # rows
TURNING = "the turning of the axis"
CONTACT = "the velocity of the contact point"
JELLETT = "Jellett's integral"
MOTION = "from row to row the motion"
COMPARED = 50  # rows of a second column set
FEWEST = 8  # intervals


def refuse_other_units(
    setup: CheckSetup,
    first: Samples,
    block: Block,
    present: Sequence[str],
    otherwise: Mapping[str, Reading],
) -> None:
    """Look at the first rows; ``otherwise`` has further readings, those of the file itself.

    Raises ``InputError``: units other than SI, or another body, are what explains them.
    """
    rows = first.rows(slice(0, LOOKED_AT))
    theta = rows.given.get("theta")
    if theta is not None and float(abs(theta).max()) > 1.1 * math.pi:
        raise InputError(
            f"theta reaches {abs(theta).max():g}, expected radians from 0 to pi; is it in degrees?"
        )
    rigid = setup.columns.name == "rigid body"
    if rigid and not numpy.all(sum(rows.given[name] ** 2 for name in ("qw", *AXIS))):
        raise InputError("a quaternion is 0, expected an orientation of length 1")
    _refuse_other_units(setup, rows, otherwise)
    _refuse_other_velocities(setup, rows)
    _refuse_other_sets(setup, rows, block, present)


def _refuse_other_units(setup: CheckSetup, rows: Samples, further: Mapping[str, Reading]) -> None:
    """Refuse rows that follow the equations only in other units or conventions."""
    if len(rows.t) <= FEWEST:
        return
    as_given = _misfits(setup, rows.given)
    if max(as_given.values(), default=0.0) < WRONG:
        return
    names = {"t", *setup.columns.names}
    unforced: InputError | None = None
    fits_but_for_force = all(part < MISFIT for name, part in as_given.items() if name != MOTION)
    for convention, read in itertools.chain(further.items(), readings(alone=fits_but_for_force)):
        changed = read(rows.given, setup.body)
        if changed is None or not names & changed.keys():
            continue
        otherwise = _misfits(setup, {**rows.given, **changed}, FIT)
        explained = _explained(as_given, otherwise, convention in further)
        if explained:
            refusal = InputError(
                f"{explained} is off by {_percent(as_given[explained])} from the rows, but only by "
                f"{_percent(otherwise[explained])} if {convention}; expected SI, convert it"
            )
            if otherwise.get(MOTION, otherwise.get(TURNING, 0.0)) < FIT:
                raise refusal
            unforced = unforced or refusal
    if unforced is not None:
        raise unforced


def _explained(as_given: dict[str, float], otherwise: dict[str, float], likely: bool) -> str:
    """The part that a reading corrects; "" if none, or if another part is wrong in it.

    How the rows follow the force may be off in either reading: the force may be another one. Then
    the axis of wide rows fits roughly only, which is enough in a ``likely`` reading, where it does
    so in both, or where it does not at all as given.
    """
    turning = as_given.get(TURNING, 0.0)
    rough = likely or not MISFIT <= turning < FAR
    # what a poor simulator does to Jellett's integral is not what a convention does
    most = {MOTION: math.inf, JELLETT: MISFIT, TURNING: MISFIT if rough else FIT}
    if any(part >= most.get(name, FIT) for name, part in otherwise.items()):
        return ""
    fit = {TURNING: MISFIT if turning >= FAR else FIT}
    off = [name for name in otherwise if as_given.get(name, 0.0) >= WRONG]
    better = [name for name in off if otherwise[name] < fit.get(name, FIT)]
    # a soft contact sinks, in any reading that has no vertical motion: the axis must move to tell
    return better[0] if better and (better[0] != CONTACT or TURNING in otherwise) else ""


def _misfits(setup: CheckSetup, given: Columns, most: float = numpy.inf) -> dict[str, float]:
    """Which part of the state's change the rows do not explain, in ways that can be convention.

    How the axis turns, whether the contact point stays on the table and Jellett's integral hold for
    every force. The other parts are not tested if the contact point is off by ``most``.
    """
    misfits = {}
    if setup.columns.name == "rigid body" and setup.velocity_given and not setup.scene.lifts:
        misfits[CONTACT] = _lift(setup, given)
        if misfits[CONTACT] >= most:
            return misfits
    known, whole = dict(given), setup.velocity_known and setup.own_force
    if not setup.velocity_given or not whole:
        known |= dict.fromkeys(setup.columns.velocity, numpy.zeros_like(given["t"]))
    moving = replace(setup, velocity_given=True)
    samples = moving.samples(Block(known))
    change, mismatch = EquationResidual(moving, samples, ROUGHLY).changes(samples)
    axis = slice(0, 3 if setup.columns.azimuth else 1)
    integral = INTEGRALS["jellett"]
    start, scale = integral.evaluate(samples.first), float(integral.scale(samples.first)) or 1.0
    drift = abs(integral.evaluate(samples.q) - start).max() / scale
    parts = {JELLETT: float(drift), TURNING: _part(change[axis], mismatch[axis])}
    if whole:
        parts[MOTION] = _part(change, mismatch)
    return misfits | {name: part for name, part in parts.items() if part is not None}


def _part(change: numpy.ndarray, mismatch: numpy.ndarray) -> float | None:
    """Median over intervals of the mismatch relative to the change; None if little moves."""
    with numpy.errstate(all="ignore"):
        parts = numpy.sqrt((mismatch**2).sum(axis=0) / (change**2).sum(axis=0))
    # an axis that does not move says nothing
    parts = parts[abs(change).max(axis=0) > STILL]
    if len(parts) < FEWEST:
        return None
    # numpy.median would import numpy.ma
    return float(numpy.sort(numpy.where(numpy.isfinite(parts), parts, numpy.inf))[len(parts) // 2])


def _lift(setup: CheckSetup, given: Columns) -> float:
    """Speed at which the contact point leaves the table, relative to its parts."""
    q = setup.samples(Block(dict(given))).q
    swing, rise = cross(q.omega, contact_arm(setup.body, q.k))[2], numpy.asarray(given["vcz"])
    size = math.sqrt(float(numpy.mean(swing**2 + rise**2)))
    still = STILL * float(setup.body.R * numpy.sqrt(numpy.max(dot(q.omega, q.omega))))
    return math.sqrt(float(numpy.mean((swing + rise) ** 2))) / size if size > still else 0.0


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %" if part < 100 else "far more than all"


def _refuse_other_velocities(setup: CheckSetup, rows: Samples) -> None:
    # an elastic contact may swing along with the axis
    soft = setup.scene.lifts or setup.friction == "other"
    if setup.columns.name != "rigid body" or not setup.velocity_given or soft:
        return
    body, q = setup.body, rows.q
    factor = _constant_factor(rows.given["vcz"], -cross(q.omega, contact_arm(body, q.k))[2])
    if factor is not None:
        lever = float(body.R * body.alpha)
        raise InputError(
            f"vcz fits a centre of mass {factor * lever:.4g} m from the centre of the sphere, "
            f"expected {lever:.4g} m = alpha R; are units or the scene's body others?"
        )


def _refuse_other_sets(
    setup: CheckSetup, rows: Samples, block: Block, present: Sequence[str]
) -> None:
    """If a file has Euler columns as well as vectors, both must agree."""
    others = [entry for entry in known_sets(present) if not entry.azimuth]
    if not setup.columns.azimuth or not others:
        return
    few = rows.rows(slice(0, COMPARED))
    for name in (name for name in others[0].required if name in QUANTITIES):
        given = block.values[name][: len(few.t)]
        derived = numpy.asarray(QUANTITIES[name].evaluate(few.q))
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
