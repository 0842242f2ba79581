"""The rows of a file as the motion of a rigid body, with their rounding: for every force law.

Directions that a file leaves open are integrated, and velocities that it lacks follow from
positions where these are known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.conventions import QUATERNION
from tt_precise.check.force_free import DENSE, LOCAL, Rounding, chunks, norm, spread
from tt_precise.check.force_free_flow import (
    RigidMotion,
    Way,
    gauss,
    interpolate,
    nutation,
    rates_in_rows,
    rotation_angles,
)
from tt_precise.check.precision import times_of
from tt_precise.check.result import to_one_digit
from tt_precise.mechanics.newton import contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross
from tt_precise.runtime.values import Array

FEWEST_ROWS = 6
# The first way gives a rate in a row; its error is less than 6 times its distance from the second
# if it is at least a seventh nearer. A third way, seven rows without the nutation, is no wider
# where right rows come nearest to their bounds.
RATE_WAYS, DERIVATIVE = (Way(7, True), Way(5, False)), 6.0
# The rate of roundings through seven evenly spaced rows, over rounding and spacing: the sum of the
# weights' sizes, 2 (3/4 + 3/20 + 1/60).
ROUNDED_RATE = 11 / 6
# Four rows a turn of the nutation, rad from row to row: twice as many as the sampling theorem asks.
CLEAR = math.pi / 2
# By this power of the spacing the bounds fall at least (measured, 60 to 240 Hz): the interpolation
# through the fewest rows is of order 4, and a force with kinks of less.
FALLS_AS = 3
LARGEST_SHARE = 1e4  # Largest ratio of a bound to the required one: nothing at all is seen.


@dataclass(frozen=True)
class Movement:
    """The rows of a file as a motion, and the known quantities.

    ``spin`` says that the turn about the axis is known, ``moving`` that the velocity is;
    ``visited`` are the indices of the rows that are far enough apart to say something.
    """

    body: Parameters
    rows: RigidMotion
    rounding: Rounding
    spin: bool
    moving: bool
    visited: Array

    @cached_property
    def sparse(self) -> RigidMotion:
        """The rows to visit."""
        every = len(self.visited) == len(self.rows.t)
        return self.rows if every else self.rows.part(self.visited)

    @property
    def sparse_rounding(self) -> Rounding:
        """The roundings of the rows to visit."""
        return Rounding(*(part[self.visited] for part in self.rounding))


def motion_as_given(samples: Samples) -> Motion:
    """The rows as a motion, with the velocity of the centre of mass from the columns if given."""
    given, state = samples.given, samples.state
    if "vcz" not in given or not samples.setup.velocity_given:
        return samples.q
    centre = (given["vcx"], given["vcy"], given["vcz"])
    return Motion(samples.setup.body, state, numpy, samples.setup.scene.model, s_dot=lambda: centre)


def movement_of(samples: Samples) -> Movement:
    """Return the rows as a motion, prepared once for all checks."""
    if "movement" not in samples.shared:
        samples.shared["movement"] = _prepare(samples)
    prepared: Movement = samples.shared["movement"]
    return prepared


def _prepare(samples: Samples) -> Movement:
    setup, state, given = samples.setup, samples.state, samples.given
    body, count = setup.body, len(samples.t)
    k = numpy.array(state.k, dtype=float)
    k = k / norm(k)
    L = numpy.array(numpy.broadcast_arrays(*state.L), dtype=float)
    spin = samples.quaternion is not None
    q = numpy.array(samples.quaternion) if spin else shortest_rotation(k)
    q = q / norm(q)
    # q and -q are one attitude: that of a row is the one nearer to the row before
    q[:, 1:] *= numpy.cumprod(numpy.where((q[:, 1:] * q[:, :-1]).sum(axis=0) < 0, -1.0, 1.0))
    half, clock = samples.resolution, times_of(samples.t)

    def half_unit(*names: str) -> float:
        return 2 * max((half.get(name, 0.0) for name in names), default=0.0)

    omega = norm(L) / min(body.I1, body.I3)
    u_q = half_unit("kx", "ky", "kz", *QUATERNION, "theta", "phi", "psi") + numpy.zeros(count)
    u_L = half_unit("Lx", "Ly", "Lz") + max(body.I1, body.I3) * half_unit(
        "wx", "wy", "wz", "theta_dot", "phi_dot", "omega_3"
    )
    u_L = u_L + (2 * abs(body.I3 - body.I1) * omega * u_q if spin else 0 * u_q)
    u_v = half_unit("vcx", "vcy", "vcz", "vx", "vy", "nu_x", "nu_y") + numpy.zeros(count)
    u_x = numpy.full(count, half_unit("x", "y", "z"))
    if not spin:
        u_v = u_v + 2 * body.R * u_L / min(body.I1, body.I3)
    x = numpy.array([given.get(name, numpy.full(count, numpy.nan)) for name in "xyz"])
    known = numpy.isfinite(x[:, :1]).any()
    moving = setup.has_velocity and (setup.height_given or not setup.scene.lifts or spin)
    if moving:
        v = numpy.array(numpy.broadcast_arrays(*motion_as_given(samples).s_dot), dtype=float)
    elif numpy.isfinite(x[:2]).all() and count >= FEWEST_ROWS and not setup.scene.lifts:
        v = numpy.zeros((3, count))
        v[:2], error = rates_with_errors(body, RigidMotion(clock.t, q, L, v), x[:2], u_x)
        a = contact_arm(body, (k[0], k[1], k[2]))
        along = (1 / body.I3 - 1 / body.I1) * (L * k).sum(axis=0)
        turning = L / body.I1 + along * k
        v[2] = -cross((turning[0], turning[1], turning[2]), a)[2]
        moving, u_v = True, u_v + error
    else:
        v = numpy.zeros((3, count))
    if not setup.columns.azimuth:
        turned, error = azimuth(clock.t, given["phi_dot"])
        turned = turned + numpy.pi * passed_pole(clock.t, given["theta"], given["theta_dot"])
        k, L, v = (about_vertical(part, turned) for part in (k, L, v))
        q = shortest_rotation(k)
        # turning everything about the vertical leaves the inclination alone
        u_v = u_v + error * numpy.hypot(v[0], v[1])
    rows = RigidMotion(clock.t, q, L, v, x if known else None)
    rounding = Rounding(
        numpy.full(count, 2 * clock.rounding), u_q, u_L, u_v, u_x
    )  # fmt: skip
    return Movement(body, rows, rounding, spin, moving, visited(body, rows))


def shortest_rotation(k: Array) -> Array:
    """Return quaternions that turn z to ``k`` (3, n) by the shortest way."""
    below = k[2] < 0
    half = numpy.where(below, (k[0] ** 2 + k[1] ** 2) / numpy.maximum(1 - k[2], 1), 1 + k[2])
    w = numpy.sqrt(half / 2)
    down = w == 0
    safe = numpy.where(down, 1.0, 2 * w)
    return numpy.array([w, numpy.where(down, 1.0, -k[1] / safe), k[0] / safe, 0 * w])


def azimuth(t: Array, rate: Array) -> tuple[Array, Array]:
    """Return the integral of phi_dot (rad), and its error bound from row to row."""
    nodes, _, whole = gauss(FEWEST_ROWS)
    h, still = numpy.diff(t), numpy.zeros(len(t) - 1)
    best, other = (
        h * (whole @ interpolate(t, rate[None], Way(rows, False), still, nodes)[0])
        for rows in (FEWEST_ROWS, FEWEST_ROWS - 2)
    )
    error = numpy.append(abs(best - other), 0.0)
    return numpy.append(0.0, numpy.cumsum(best)), LOCAL * spread(error)


def passed_pole(t: Array, theta: Array, rate: Array) -> Array:
    """Return how often the axis has passed through a pole, where phi jumps by pi without a rate.

    It has between two rows if its distances from the pole fit their rates better with opposite
    signs than with the same sign.
    """
    passes, h = numpy.zeros(len(t)), numpy.diff(t)
    for away in (theta, numpy.pi - theta):
        speed = rate if away is theta else -rate
        a, b, u, v = away[:-1], away[1:], speed[:-1], speed[1:]
        through = abs(a + b + h * (u - v) / 2) < abs(b - a - h * (u + v) / 2)
        passes[1:] += through & (u < 0) & (v > 0)
    return numpy.cumsum(passes)


def about_vertical(vectors: Array, angle: Array) -> Array:
    """Return vectors (3, n) turned by angles about the vertical."""
    c, s = numpy.cos(angle), numpy.sin(angle)
    x, y, z = vectors
    return numpy.array([c * x - s * y, s * x + c * y, z])


def rates_with_errors(
    body: Parameters, rows: RigidMotion, values: Array, rounding: Array
) -> tuple[Array, Array]:
    """Return the rates (components, n) of ``values`` in the rows, and the error of each (n,).

    By polynomials with the cosine and sine of the nutation, and by fewer rows without: rows that
    are too far apart see a nutation as a slow motion, which the second way gives away. The values
    are rounded by ``rounding`` (n,).
    """
    nutated, parts = nutation(body, rows), []
    for taken, kept in chunks(len(rows.t)):
        t, angle = rows.t[taken], nutated[taken]
        found = (rates_in_rows(t, values[:, taken], w, angle[: len(t) - 1]) for w in RATE_WAYS)
        parts.append([rates[:, kept] for rates in found])
    best, other = (numpy.concatenate(rates, axis=1) for rates in zip(*parts, strict=True))
    h = numpy.pad(numpy.diff(rows.t), (0, 1), mode="edge")
    return best, DERIVATIVE * spread(norm(best - other)) + ROUNDED_RATE * spread(rounding) / h


def visited(body: Parameters, rows: RigidMotion) -> Array:
    """Return indices of rows between which the top turns by ``DENSE``.

    All rows are visited if they are farther apart, or if the top turns by less altogether than
    shows anything.
    """
    count = len(rows.t)
    turned = rotation_angles(body, rows) if count > 1 else numpy.zeros(0)
    if not float(turned.sum()) < DENSE * (count - 1):
        return numpy.arange(count)
    cell = numpy.floor(numpy.concatenate(([0.0], numpy.cumsum(turned))) / DENSE)
    found = numpy.flatnonzero(numpy.diff(cell, prepend=-1.0))
    if len(found) < FEWEST_ROWS:
        return numpy.arange(count)
    return found if found[-1] == count - 1 else numpy.append(found, count - 1)


def too_few(count: int) -> str:
    """Say that ``count`` rows are too few for rates."""
    return f"{count} rows, expected at least {FEWEST_ROWS}"


def sufficient_spacing(body: Parameters, rows: RigidMotion, share: Array) -> float:
    """Return a time (s) between rows with which all intervals would be resolved.

    ``share`` is the bound of each interval over the required one, above 1 where not resolved.
    """
    with numpy.errstate(all="ignore"):
        share = numpy.where(numpy.isfinite(share), share, LARGEST_SHARE)
        finer = numpy.minimum(share ** (-1 / FALLS_AS), CLEAR / nutation(body, rows))
    return to_one_digit(float((numpy.diff(rows.t) * finer)[share > 1].min()), math.floor)
