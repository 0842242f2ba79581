"""The motion of a top from row to row under an unknown contact force.

Attitude q and momentum about the lowest point, Q = L - a x m v, obey

    dq/dt = omega q / 2,    dQ/dt = -da/dt x m v + a x m g z,

in which no contact force appears. The velocity v of the centre of mass does: its vertical part
follows from Q, its horizontal part v_h and the lift v_A.z of the contact point, which is 0 on a
rigid table. So a motion follows from one row and from v_h(t) and v_A.z(t), which are

- *interpolated* (``by_interpolation``) through four or six rows, by polynomials with or without
  the cosine and sine of the nutation; or
- *guided* (``by_guidance``): friction is -c N v_A or -c N v_A/|v_A|, with the N that keeps the
  contact and a c that fits seven intervals, and a force linear in time leads to the next row's
  v_h. No law is assumed: the bound of the error contains the misfit of c.

All intervals are solved at once by collocation at Gauss nodes. Arrays have the shape (components,
nodes, intervals).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy

from tt_precise.mechanics.contact_momentum import (
    contact_lift,
    contact_momentum,
    contact_momentum_rate,
    momentum_and_velocity,
    normal_force_along,
)
from tt_precise.mechanics.newton import contact_arm, inverse_inertia
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import Vector, cross, dot
from tt_precise.runtime.values import Array

# Gauss nodes of an interval in which the top turns by some rad. The polynomial through them then
# misses less than 1e-11 of the motion (measured from 0.1 to 12 rad).
FEWEST_NODES, NODES_PER_RADIAN, MOST_NODES = 5, 2.5, 40
# The fixed point has settled where a sweep changes q by no more than this; its error falls as
# turn^j/j! with the number j of sweeps.
SETTLED, MOST_SWEEPS = 1e-12, 60
# Nutation (rad from row to row) below which polynomials are as good; and the sine of it below which
# its cosine and sine have nearly the same values in all rows. Half and double change no verdict
# (benchmarks/plateaus.py), nor do those of ``NEIGHBOURS``.
LEAST_NUTATION, LEAST_SINE = 0.3, 0.15
# rad of nutation from row to row above which polynomials see nothing: pi by the sampling theorem,
# where the sine vanishes in all rows.
BLIND = math.pi - LEAST_SINE
EVEN = 1e-9  # Part of the spacing by which evenly spaced rows may differ: the rounding of times.
# rad of nutation from row to row above which nothing is seen in any way: a whole turn is none.
FARTHEST = 2 * math.pi
NEIGHBOURS = 3  # Intervals on either side of one from which its coefficient of friction is fitted.


class RigidMotion(NamedTuple):
    """A motion at times ``t`` (s): attitude (4, n), L, v of the centre of mass, position (3, n).

    The quaternion, scalar first, turns the body's frame, whose z is the axis, to the inertial one.
    """

    t: Array
    q: Array
    L: Array
    v: Array
    x: Array | None = None

    def part(self, rows: slice | Array) -> RigidMotion:
        """Return some of the rows, by a slice or indices."""
        x = None if self.x is None else self.x[:, rows]
        return RigidMotion(self.t[rows], self.q[:, rows], self.L[:, rows], self.v[:, rows], x)


class Terms(NamedTuple):
    """Further terms of the motion, none of which a contact force at the lowest point has.

    Damping of L and of v (1/s), torque about the vertical (m g R alpha), missing part of the
    gyroscopic term.
    """

    damping: float = 0.0
    drag: float = 0.0
    torsion: float = 0.0
    gyroscopic: float = 0.0


NO_TERMS = Terms()


class Ends(NamedTuple):
    """Solutions at the end of each interval: q (4, n), Q (3, n), the way of the centre (3, n).

    ``gain`` (n,) is what ``Terms`` add to Jellett's integral on the way, 0 without them.
    """

    q: Array
    Q: Array
    way: Array
    gain: Array


class Way(NamedTuple):
    """An interpolation by ``rows``, with or without the nutation."""

    rows: int
    nutation: bool


@cache
def gauss(count: int) -> tuple[Array, Array, Array]:
    """Return nodes in (0, 1), the matrix of integrals up to each, and the weights of the whole."""
    x, w = numpy.polynomial.legendre.leggauss(count)
    P = numpy.polynomial.legendre.legvander(x, count)
    k = numpy.arange(count)
    integrals = numpy.empty((count, count))
    integrals[:, 0] = x + 1
    integrals[:, 1:] = (P[:, 2:] - P[:, : count - 1]) / (2 * k[1:] + 1)
    matrix = integrals @ ((k + 0.5)[:, None] * P[:, :count].T * w) / 2
    return (x + 1) / 2, matrix, w / 2


def nodes_for(body: Parameters, rows: RigidMotion) -> int:
    """Return the number of nodes for the intervals in which anything is seen."""
    turned = rotation_angles(body, rows)[nutation(body, rows) < FARTHEST]
    turned = numpy.fmax.reduce(turned, initial=0.0)
    return min(FEWEST_NODES + math.ceil(NODES_PER_RADIAN * float(turned)), MOST_NODES)


def axis_of(q: Array) -> Vector:
    """Return the body's z axis in the inertial frame."""
    w, x, y, z = q
    return (2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z)


def momentum_at_contact(body: Parameters, rows: RigidMotion) -> Array:
    """Return Q = L - a x m v, shape (3, n)."""
    a = contact_arm(body, axis_of(rows.q))
    return numpy.array(contact_momentum(body, a, _vector(rows.L), _vector(rows.v)))


def jellett_of(body: Parameters, rows: RigidMotion) -> Array:
    """Return Jellett's integral -L.a, shape (n,)."""
    integral: Array = -dot(_vector(rows.L), contact_arm(body, axis_of(rows.q)))
    return integral


def torque_unit(body: Parameters) -> float:
    """Return m g R alpha (N m), the unit of torques."""
    return float(body.m * body.g * body.R * body.alpha)


def lift_of(body: Parameters, rows: RigidMotion) -> Array:
    """Return v_A.z of the contact point, m/s."""
    rising: Array = contact_lift(body, axis_of(rows.q), _vector(rows.L), rows.v[2])
    return rising


def nutation(body: Parameters, rows: RigidMotion) -> Array:
    """Return the angle (rad) by which the axis nutates in each interval.

    The rate is that about the motion of constant inclination, where the swing of the axis has to
    move the centre of mass.
    """
    k, L = axis_of(rows.q), _vector(rows.L)
    size = numpy.sqrt(dot(L, L))[:-1] / body.I1
    heavier = 1 + body.m * (body.R * body.alpha) ** 2 / body.I1 * (1 - k[2][:-1] ** 2)
    angle: Array = size / numpy.sqrt(heavier) * numpy.diff(rows.t)
    return angle


def rotation_angles(body: Parameters, rows: RigidMotion) -> Array:
    """Return the angle (rad) by which the body turns in each interval."""
    k, L = axis_of(rows.q), _vector(rows.L)
    along = dot(L, k)
    omega = numpy.sqrt(numpy.maximum(dot(L, L) - along**2, 0) / body.I1**2 + (along / body.I3) ** 2)
    turned: Array = numpy.maximum(omega[:-1], omega[1:]) * numpy.diff(rows.t)
    return turned


def _vector(components: Array) -> Vector:
    return (components[0], components[1], components[2])


class _State:
    """A motion where q, Q, the horizontal velocity and the lift are known."""

    def __init__(self, body: Parameters, q: Array, Q: Array, v_x: Array, v_y: Array, rising: Array):
        self.k = axis_of(q)
        self.a = contact_arm(body, self.k)
        self.L, self.v = momentum_and_velocity(body, self.k, self.a, _vector(Q), (v_x, v_y), rising)
        self.omega = inverse_inertia(body, self.k, self.L)
        self.k_dot = cross(self.omega, self.k)

    def write(self, body: Parameters, q: Array, rates: Array, terms: Terms = NO_TERMS) -> None:
        """Write the rates of q, Q and the way of the centre, with terms also of the gain."""
        _write_quaternion_rate(q, self.omega, rates)
        rates[4], rates[5], rates[6] = contact_momentum_rate(body, self.a, self.k_dot, self.v)
        rates[7], rates[8], rates[9] = self.v
        if any(terms):
            dragged, torque = cross(self.a, self.v), torque_of(body, self.k, self.L, terms)
            for i in range(3):
                rates[4 + i] += terms.drag * body.m * dragged[i] + torque[i]
            rates[10] = -dot(torque, self.a)


def torque_of(body: Parameters, k: Vector, L: Vector, terms: Terms) -> Vector:
    """Return the torque of ``terms`` about the centre of mass."""
    turned = cross(inverse_inertia(body, k, L), L)
    x, y, z = (terms.gyroscopic * turned[i] - terms.damping * L[i] for i in range(3))
    return x, y, z - terms.torsion * torque_unit(body)


def _write_quaternion_rate(q: Array, omega: Vector, rates: Array) -> None:
    """Write dq/dt = omega q / 2."""
    wx, wy, wz = (0.5 * w for w in omega)
    rates[0] = -(wx * q[1] + wy * q[2] + wz * q[3])
    rates[1] = wx * q[0] + wy * q[3] - wz * q[2]
    rates[2] = wy * q[0] + wz * q[1] - wx * q[3]
    rates[3] = wz * q[0] + wx * q[2] - wy * q[1]


class FlowRates(NamedTuple):
    """Rates of rows: of q (4, n), Q and k (3, n)."""

    q: Array
    Q: Array
    k: Array


def rates_of(body: Parameters, rows: RigidMotion) -> FlowRates:
    """Return the rates of attitude and momentum in rows."""
    Q, written = momentum_at_contact(body, rows), numpy.empty((10, len(rows.t)))
    state = _State(body, rows.q, Q, rows.v[0], rows.v[1], lift_of(body, rows))
    state.write(body, rows.q, written)
    return FlowRates(written[:4], written[4:7], numpy.array(state.k_dot))


Sweep = Callable[[Array, Array], None]


def _solve(start: Array, h: Array, count: int, sweep: Sweep, guess: Array | None = None) -> Array:
    """Return the solution (components, nodes and end, intervals) of a fixed point.

    ``sweep(y, rates)`` writes the rates at the nodes.
    """
    _, matrix, weights = gauss(count)
    whole = numpy.concatenate((matrix, weights[None]))
    shape = (len(start), count + 1, start.shape[1])
    y = numpy.broadcast_to(start[:, None], shape) if guess is None else guess
    rates = numpy.zeros((len(start), count, start.shape[1]))
    for _ in range(MOST_SWEEPS):
        sweep(y, rates)
        new = whole @ rates
        new *= h
        new += start[:, None]
        # the length of a quaternion is 1: sweeps that overshoot are held there
        new[:4] /= numpy.sqrt((new[:4] ** 2).sum(axis=0))
        change = float(numpy.fmax.reduce(abs(new[:4, -1] - y[:4, -1]), axis=None, initial=0.0))
        y = new
        if change < SETTLED:
            break
    return y


def _shapes(x: Array, angle: Array, count: int) -> Array:
    """Functions (..., count) at ``x``: powers, two of them cos and sin where ``angle`` is not 0."""
    u = x - 0.5
    out = numpy.ones((*u.shape, count))
    for power in range(1, count):  # several times as fast as u**power
        out[..., power] = u * out[..., power - 1]
    seen = angle != 0
    if count > 3 and seen.any():
        phase = (angle[:, None] * u)[seen]
        out[seen, :, -2], out[seen, :, -1] = numpy.cos(phase), numpy.sin(phase)
    return out


def _resolved(way: Way, angle: Array) -> Array:
    """The nutation (rad) from row to row where ``way`` contains it, 0 elsewhere."""
    clear = (angle >= LEAST_NUTATION) & (abs(numpy.sin(angle)) >= LEAST_SINE)
    return numpy.where(clear & way.nutation, angle, 0.0)


def _solution(x: Array, first: Array, seen: Array, wanted: Array) -> Array:
    """Weights (n, points, count) of values at ``x`` (n, count) that give ``wanted`` of the shapes.

    ``first`` are the windows' first rows. Evenly spaced rows need one solution for each position in
    a window.
    """
    one = every = numpy.arange(len(x))
    if not seen.any():
        _, some, back = numpy.unique(first - every, return_index=True, return_inverse=True)
        if abs(x - x[some[back]]).max() < EVEN:
            one, every = some, back
    basis = _shapes(x[one], seen[one], x.shape[1]).swapaxes(1, 2)
    found: Array = numpy.linalg.solve(basis, wanted[one].swapaxes(1, 2)).swapaxes(1, 2)[every]
    return found


def weights(t: Array, way: Way, angle: Array, at: Array) -> tuple[Array, Array]:
    """Rows (n, m) and their weights (n, len(at), m) of the interpolation of each interval."""
    count = min(way.rows, len(t))
    first = numpy.clip(numpy.arange(len(t) - 1) - (count // 2 - 1), 0, len(t) - count)
    rows = first[:, None] + numpy.arange(count)
    x = (t[rows] - t[:-1, None]) / numpy.diff(t)[:, None]  # 0 to 1 within the interval
    seen = _resolved(way, angle)
    wanted = _shapes(numpy.broadcast_to(at, (len(x), len(at))), seen, count)
    return rows, _solution(x, first, seen, wanted)


def rates_in_rows(t: Array, values: Array, way: Way, angle: Array) -> Array:
    """Return the rates (components, n) of ``values`` in the rows, through the rows about each.

    ``angle`` is the nutation of each interval (rad).
    """
    count = min(way.rows, len(t))
    first = numpy.clip(numpy.arange(len(t)) - count // 2, 0, len(t) - count)
    rows = first[:, None] + numpy.arange(count)
    spacing = numpy.ptp(t[rows], axis=1)[:, None] / (count - 1)
    after = numpy.pad(_resolved(way, angle) / numpy.diff(t), (0, 1), mode="edge")
    seen = after * spacing[:, 0]
    wanted = numpy.zeros((len(t), 1, count))
    wanted[:, 0, 1] = 1.0
    wanted[:, 0, -1] += seen
    found = _solution((t[rows] - t[:, None]) / spacing + 0.5, first, seen, wanted)[:, 0] / spacing
    return numpy.einsum("np,cnp->cn", found, values[:, rows], optimize=False)


def interpolate(t: Array, values: Array, way: Way, angle: Array, at: Array) -> Array:
    """Values (components, n rows) at the fractions ``at`` of each interval: (components, at, n)."""
    rows, found = weights(t, way, angle, at)
    return numpy.einsum("nap,cnp->can", found, values[:, rows], optimize=False)


def by_interpolation(
    body: Parameters, rows: RigidMotion, ways: Sequence[Way], terms: Terms = NO_TERMS
) -> list[Ends]:
    """Return the ends of each interval's motion, for each way to interpolate v_h and the lift."""
    Q, lift = momentum_at_contact(body, rows), lift_of(body, rows)
    known = numpy.stack((rows.v[0], rows.v[1], lift))
    h, count = numpy.diff(rows.t), nodes_for(body, rows)
    at, angle = gauss(count)[0], nutation(body, rows)
    start = numpy.concatenate((rows.q, Q, *_nothing(rows, terms)))[:, :-1]
    ends = []
    guess = None
    for way in ways:
        given = interpolate(rows.t, known, way, angle, at)

        def sweep(y: Array, rates: Array, given: Array = given) -> None:
            q = y[:4, :-1]
            _State(body, q, y[4:7, :-1], *given).write(body, q, rates, terms)

        guess = _solve(start, h, count, sweep, guess)
        ends.append(_ends(guess[:, -1], terms))
    return ends


def _nothing(rows: RigidMotion, terms: Terms) -> list[Array]:
    """The way of the centre and, with terms, the gain, where both begin."""
    return [0 * rows.v, 0 * rows.v[: any(terms)]]


def _ends(end: Array, terms: Terms) -> Ends:
    return Ends(end[:4], end[4:7], end[7:10], end[10] if any(terms) else 0 * end[0])


def by_momentum(
    body: Parameters, rows: RigidMotion, ways: Sequence[Way], terms: Terms = NO_TERMS
) -> list[Ends]:
    """Return the ends of each interval's turning alone, for each way to interpolate L."""
    h, count = numpy.diff(rows.t), nodes_for(body, rows)
    at, angle = gauss(count)[0], nutation(body, rows)
    start, still = rows.q[:, :-1], numpy.zeros((3, len(h)))
    weight = h * gauss(count)[2][:, None]
    ends = []
    guess = None
    for way in ways:
        L = interpolate(rows.t, rows.L, way, angle, at)

        def sweep(y: Array, rates: Array, L: Array = L) -> None:
            q = y[:, :-1]
            _write_quaternion_rate(q, inverse_inertia(body, axis_of(q), _vector(L)), rates)

        guess = _solve(start, h, count, sweep, guess)
        k = axis_of(guess[:, :-1])
        gained = -dot(torque_of(body, k, _vector(L), terms), contact_arm(body, k))
        ends.append(Ends(guess[:, -1], still, still, (weight * gained).sum(axis=0)))
    return ends


class Guided(NamedTuple):
    """Motions with friction of unknown strength.

    ``best`` has a force linear in time beside friction, ``less`` one that is constant in each
    interval, ``plain`` no friction, ``other`` the other law's. ``unexplained`` is the part of the
    change of v_h about an interval that friction leaves over, ``against`` its ratio to the other
    law's. ``strength`` is c, in s/m where ``viscous`` and a number where not.
    """

    best: Ends
    less: Ends
    plain: Ends
    other: Ends
    unexplained: Array
    against: Array
    strength: Array
    viscous: Array


class _Guidance:
    """The fixed point of intervals whose v_h has to reach the next row's."""

    def __init__(self, body: Parameters, rows: RigidMotion, terms: Terms):
        self.body, self.terms, self.h = body, terms, numpy.diff(rows.t)
        self.count = nodes_for(body, rows)
        nodes = gauss(self.count)[0]
        lift = lift_of(body, rows)
        self.rise = numpy.diff(lift) / self.h
        self.lift = lift[:-1] + nodes[:, None] * numpy.diff(lift)
        self.start = numpy.concatenate(
            (rows.q, momentum_at_contact(body, rows), *_nothing(rows, terms), 0 * rows.v[:2])
        )[:, :-1]
        self.v, self.change = rows.v[:2, :-1], numpy.diff(rows.v[:2])
        self.s = nodes[:, None]
        L = numpy.sqrt(dot(_vector(rows.L), _vector(rows.L)))
        # m/s: below this nothing glides
        self.least = 1e-6 * body.R * float(L.max()) / body.I1

    def solve(
        self, friction: bool, coulomb: bool, linear: bool, guess: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return the solution, the change of v_h not explained by friction (2, n), and c."""
        body, h, count = self.body, self.h, self.count
        strength = numpy.zeros_like(h)
        force, slope = self.change / h, 0 * self.change

        def sweep(y: Array, rates: Array) -> None:
            nonlocal strength, force, slope
            q, push = y[:4, :-1], y[-2:]
            if friction:
                J = push[:, -1]
                still = (self.least if not coulomb else 1e-6) * body.g * h
                strength = -_about((self.change * J).sum(0)) / (_about((J * J).sum(0)) + still**2)
                strength = numpy.where(numpy.isfinite(strength), strength, 0.0)
                force = (self.change + strength * J) / h
                if linear:
                    slope = numpy.gradient(force, axis=1)
            s = self.s
            bend = (s * s - s) / 2  # the integral of s - 1/2
            v_x, v_y = (
                self.v[i] - strength * push[i, :-1] + h * (s * force[i] + bend * slope[i])
                for i in range(2)
            )
            at = _State(body, q, y[4:7, :-1], v_x, v_y, self.lift)
            at.write(body, q, rates, self.terms)
            if friction:
                swing = cross(at.omega, at.a)
                slip_x, slip_y = v_x + swing[0], v_y + swing[1]
                if coulomb:
                    speed = numpy.sqrt(slip_x**2 + slip_y**2 + self.least**2)
                    slip_x, slip_y = slip_x / speed, slip_y / speed
                along = (-strength * slip_x, -strength * slip_y, 1.0)
                more = tuple(force[i] + (s - 0.5) * slope[i] for i in range(2))
                N = normal_force_along(body, at.k, at.a, at.L, along, more, self.rise)
                rates[-2], rates[-1] = N * slip_x, N * slip_y

        y = _solve(self.start, h, count, sweep, guess)
        return y, force * h, strength


def _about(values: Array) -> Array:
    """Sums over ``NEIGHBOURS`` on either side, the ends repeated."""
    padded = numpy.pad(values, NEIGHBOURS, mode="edge")
    return numpy.convolve(padded, numpy.ones(2 * NEIGHBOURS + 1), "valid")


def by_law(body: Parameters, rows: RigidMotion, coulomb: bool, terms: Terms = NO_TERMS) -> Ends:
    """Return motions of each interval under one law of friction, of unknown strength."""
    y, _, _ = _Guidance(body, rows, terms).solve(True, coulomb, True)
    return _ends(y[:, -1], terms)


def by_guidance(body: Parameters, rows: RigidMotion, terms: Terms = NO_TERMS) -> Guided:
    """Return motions of each interval under friction of unknown strength."""
    guidance = _Guidance(body, rows, terms)
    plain, _, _ = guidance.solve(False, False, False)
    changed = _about((guidance.change**2).sum(0))
    pairs, left, strengths = [], [], []
    for law in (False, True):
        less, _, _ = guidance.solve(True, law, False, plain)
        best, over, strength = guidance.solve(True, law, True, less)
        strengths.append(strength)
        pairs.append((best, less))
        part = numpy.sqrt(_about((over**2).sum(0)) / numpy.maximum(changed, 1e-300))
        left.append(numpy.minimum(numpy.nan_to_num(part, nan=1.0), 1.0))
    better = left[1] < left[0]
    viscous, coulomb = ([y[:, -1] for y in pair] for pair in pairs)
    best = numpy.where(better, coulomb[0], viscous[0])
    less = numpy.where(better, coulomb[1], viscous[1])
    other = numpy.where(better, viscous[0], coulomb[0])
    least, most = numpy.minimum(*left), numpy.maximum(*left)
    first, second, third, last = (_ends(y, terms) for y in (best, less, plain[:, -1], other))
    return Guided(
        first, second, third, last, least, least / numpy.maximum(most, 1e-300),
        numpy.where(better, strengths[1], strengths[0]), ~better,
    )  # fmt: skip
