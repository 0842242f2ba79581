"""Residuals independent of the contact force: attitude, position, momentum about the lowest point.

``force_free_flow`` propagates each row to the time of the next row; the difference from the next
row is also summed from the start. The flow is computed in several ways, and the spread of the
results bounds its error: a difference beyond the bound is an error of the rows. An interval is not
resolved if its bound is above the sensitivity of the check; if too much of the motion is not
resolved, the check is open. The bounds contain the rounding of the file's numbers.

If rows are closer together than the flow needs, the flow visits only some rows; the rows between
are compared with cubics through the visited rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy

from tt_precise.check.force_free_flow import (
    BLIND,
    FARTHEST,
    LEAST_NUTATION,
    NO_TERMS,
    Ends,
    RigidMotion,
    Terms,
    Way,
    axis_of,
    by_guidance,
    by_interpolation,
    by_momentum,
    jellett_of,
    lift_of,
    momentum_at_contact,
    nutation,
    torque_unit,
)
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import dot, multiplied
from tt_precise.runtime.values import Array

EPS = float(numpy.finfo(float).eps)
# The first way gives the value, its distances from the others the bound.
WAYS = (Way(6, True), Way(4, True), Way(6, False), Way(4, False))
# Factors between the spread of the ways and the bound, of one interval and of sums, by polynomials
# and guided. A factor f assumes that the first way is nearer to the truth than every other way, by
# f/(1 + f) at least. docs/explanation/measured.md says what right rows need.
LOCAL, SUMMED = 30.0, 10.0
GUIDED_LOCAL, GUIDED_SUMMED = 20.0, 10.0
# Nutation (rad from row to row) from which on the bounds by polynomials are three times as large:
# otherwise right rows need a factor of 41 there.
DIM = 2.2
# Intervals at either end whose interpolation has most of its rows on one side: their bounds are
# three times as large. Otherwise right Euler rows of ``rocking`` and ``flight`` fail (a slow test).
ONE_SIDED = 2
# The part of the change of v_h that friction of unknown strength may leave over where it guides.
# Half of it hides one fault of a hundredth, double changes no verdict (benchmarks/plateaus.py).
EXPLAINED = 5e-3
# Intervals on either side of one whose spread counts for its bound: the rows of the widest way.
SPREAD = 3
CHUNK = 4000  # Intervals solved at once: bounds memory to some 100 MB.
# rad by which the top turns between rows that the flow visits, where rows are closer together. It
# decides about time only: half and double change no verdict.
DENSE = 0.07


class Rounding(NamedTuple):
    """Errors of rows by the rounding of their numbers: t (s), attitude (rad), L, v, x (SI)."""

    t: Array
    q: Array
    L: Array
    v: Array
    x: Array


PARTS = {
    "spin": slice(0, 1),
    "axis": slice(1, 4),
    "inclination": slice(3, 4),
    "torque": slice(4, 7),
    "position": slice(7, 10),
    "jellett": slice(10, 11),
}


@dataclass(frozen=True)
class Misfit:
    """Differences of the rows from the flow: spin and axis (rad), torque (m g R alpha), way (R).

    Jellett's integral (kg m^2/s) changes along the flow by the torque of its ``Terms`` alone.
    For each interval that ends at ``t``: ``value`` of the interval, ``summed`` since the start (the
    torque as a mean), and the bounds of their errors, infinite where nothing is seen. ``drift`` has
    the components of ``summed``.
    """

    t: Array
    value: Array
    bound: Array
    summed: Array
    summed_bound: Array
    drift: Array


def spread(values: Array) -> Array:
    """Return the largest of each value and its neighbours."""
    padded = numpy.pad(values, SPREAD, mode="edge")
    windows = numpy.lib.stride_tricks.sliding_window_view(padded, 2 * SPREAD + 1)
    largest: Array = windows.max(axis=-1)
    return largest


def norm(components: Array) -> Array:
    """Return the length of vectors (components first)."""
    size: Array = numpy.sqrt((components**2).sum(axis=0))
    return size


def differences(body: Parameters, rows: RigidMotion, Q: Array, ends: Ends) -> Array:
    """Return the differences of the rows from the ends of the flow, shape (11, intervals).

    Where an attitude has no known turn about its axis, the first component says nothing; nor does
    the way where a position is NaN.
    """
    to, end = rows.q[:, 1:], ends.q
    w, *turned = multiplied(tuple(to), (end[0], -end[1], -end[2], -end[3]))
    sine = numpy.sqrt(sum(part**2 for part in turned))
    sign = numpy.where(w < 0, -1.0, 1.0)
    angle = 2 * numpy.arctan2(sine, abs(w))
    factor = sign * numpy.where(sine > 1e-12, angle / numpy.maximum(sine, 1e-300), 2.0)
    vector = factor * numpy.array(turned)
    k, reached = numpy.array(axis_of(to)), numpy.array(axis_of(end))
    about = (vector * k).sum(axis=0)
    torque = (Q[:, 1:] - ends.Q) / torque_unit(body)
    way = numpy.zeros_like(ends.way)
    if rows.x is not None:
        way = numpy.nan_to_num((numpy.diff(rows.x) - ends.way) / body.R)
    jellett = numpy.diff(jellett_of(body, rows)) - ends.gain
    return numpy.concatenate((about[None], k - reached, torque, way, jellett[None]))


def chunks(count: int) -> Iterator[tuple[slice, slice]]:
    """Ranges of rows with a margin for interpolation, and of intervals without the margin."""
    margin = 2 * SPREAD + 3
    for first in range(0, count, CHUNK):
        last = min(first + CHUNK, count)
        begin, end = max(first - margin, 0), min(last + margin, count)
        yield slice(begin, end + 1), slice(first - begin, last - begin)


def _solve(
    body: Parameters,
    rows: RigidMotion,
    moving: bool,
    guide: bool,
    ways: tuple[Way, ...],
    terms: Terms,
) -> dict[str, Array]:
    """Differences (11, intervals) by the best way, and those of the other ways from it."""
    Q = momentum_at_contact(body, rows)

    def apart(flow: Sequence[Ends]) -> tuple[Array, Array]:
        first, *others = (differences(body, rows, Q, ends) for ends in flow)
        return first, numpy.array([first - other for other in others])

    best, others = apart((by_interpolation if moving else by_momentum)(body, rows, ways, terms))
    found = {"best": best, "others": others}
    if guide:
        guided = by_guidance(body, rows, terms)
        best, others = apart((guided.best, guided.less, guided.plain, guided.other))
        left, against = guided.unexplained, guided.against
        found |= {"guided": best, "guided others": others, "left": left, "against": against}
    return found


def misfits(
    body: Parameters,
    rows: RigidMotion,
    rounding: Rounding,
    moving: bool = True,
    terms: Terms = NO_TERMS,
) -> dict[str, Misfit]:
    """Return the misfit of every quantity; ``moving`` if the velocity of the centre is known."""
    with numpy.errstate(all="ignore"):
        nutated = nutation(body, rows)
        nutates = float(numpy.max(nutated)) > LEAST_NUTATION
        ways, guide = tuple(w for w in WAYS if nutates or not w.nutation), moving and nutates
        parts = [
            {name: values[..., kept] for name, values in solved.items()}
            for taken, kept in chunks(len(rows.t) - 1)
            for solved in [_solve(body, rows.part(taken), moving, guide, ways, terms)]
        ]
        whole = {name: numpy.concatenate([one[name] for one in parts], -1) for name in parts[0]}
        errors = _rounding_errors(body, rows, rounding)
        h = numpy.diff(rows.t)
        families = [_polynomial(whole, nutated)]
        if guide:
            families.append(_guided(whole, nutated, _bend(body, rows)))
        found = {}
        for name in PARTS:
            if name == "position" and rows.x is None:
                continue
            per, span = (h, numpy.cumsum(h)) if name == "torque" else (1.0, 1.0)
            candidates = []
            for values, local, summed in families:
                at, moved = errors[name]
                one = (local[name] + moved + at[1:] + at[:-1]) / per
                all_ = summed[name] + at[0] + at[1:] + 2 * numpy.sqrt(numpy.cumsum(moved**2))
                part = values[PARTS[name]]
                sums = numpy.cumsum(part, axis=1)
                candidates.append(
                    Misfit(rows.t[1:], norm(part) / per, one, norm(sums) / span, all_ / span, sums)
                )
            found[name] = _sharpest(candidates)
    return found


def _sharpest(looks: Sequence[Misfit]) -> Misfit:
    """Return the sharpest of several ways to look, for each interval and each sum.

    Where none sees anything, values are 0 and bounds infinite.
    """
    first, *others = looks
    for other in others:
        one, all_ = other.bound < first.bound, other.summed_bound < first.summed_bound
        first = Misfit(
            first.t,
            numpy.where(one, other.value, first.value),
            numpy.where(one, other.bound, first.bound),
            numpy.where(all_, other.summed, first.summed),
            numpy.where(all_, other.summed_bound, first.summed_bound),
            numpy.where(all_, other.drift, first.drift),
        )
    for value, bound in ((first.value, first.bound), (first.summed, first.summed_bound)):
        lost = ~numpy.isfinite(value + bound)
        value[lost], bound[lost] = 0.0, numpy.inf
    return first


Family = tuple[Array, dict[str, Array], dict[str, Array]]


def _polynomial(found: dict[str, Array], nutated: Array) -> Family:
    """Values and bounds by interpolation: multiples of the spread of its ways."""
    others = found["others"]
    blind = nutated > BLIND
    dim = numpy.where(nutated > DIM, 3.0, 1.0)
    one_sided = _one_sided(len(nutated))
    local, summed = {}, {}
    for name, part in PARTS.items():
        apart = norm(others[:, part].swapaxes(0, 1)).max(axis=0)
        sums = norm(numpy.cumsum(others[:, part], axis=2).swapaxes(0, 1)).max(axis=0)
        apart = one_sided * spread(apart)
        walk = numpy.sqrt(numpy.cumsum(apart**2))
        # what is the same in all ways does not depend on the velocity that they interpolate
        unseen = numpy.where(blind & (apart > 0), numpy.inf, 0.0)
        local[name] = LOCAL * dim * apart + unseen
        furthest = numpy.maximum(numpy.maximum.accumulate(sums), walk)
        summed[name] = numpy.maximum.accumulate(dim) * SUMMED * furthest
        summed[name] = summed[name] + numpy.maximum.accumulate(unseen)
    return found["best"], local, summed


def _one_sided(count: int) -> Array:
    """Factors of the bounds of intervals at the ends."""
    factors = numpy.ones(count)
    factors[:ONE_SIDED] = factors[-ONE_SIDED:] = 3.0
    return factors


def _guided(found: dict[str, Array], nutated: Array, bend: dict[str, Array]) -> Family:
    """Values and bounds by guidance: multiples of what a further pass and the law change."""
    others, left, against = (found[name] for name in ("guided others", "left", "against"))
    trusted = (nutated < FARTHEST) & (spread(left) < EXPLAINED)
    local, summed = {}, {}
    for name, part in PARTS.items():
        less, plain, other = (norm(one) for one in others[:, part])
        error = _one_sided(len(left)) * spread(less + left * plain + against * other + bend[name])
        good = trusted & numpy.isfinite(error)
        local[name] = numpy.where(good, GUIDED_LOCAL * error, numpy.inf)
        total = numpy.cumsum(numpy.where(good, error, 0.0))
        summed[name] = GUIDED_SUMMED * total + (numpy.inf if not good.all() else 0.0)
    return found["guided"], local, summed


def _bend(body: Parameters, rows: RigidMotion) -> dict[str, Array]:
    """The error of the guided flow where the lift is not linear from row to row."""
    lift, h = lift_of(body, rows), numpy.diff(rows.t)
    second = abs(numpy.diff(numpy.pad(lift, 1, mode="edge"), n=2)) / 8
    bent = numpy.maximum(second[1:], second[:-1])
    omega = numpy.sqrt(dot(tuple(rows.L), tuple(rows.L)))[1:] / min(body.I1, body.I3)
    turned = h * body.m * body.R * bent / body.I1
    return {
        "spin": turned,
        "axis": turned,
        "inclination": turned,
        "torque": omega * bent * h / body.g,
        "position": h * bent / body.R * (1 + h * body.m * body.R**2 * omega / body.I1),
        "jellett": body.R * norm(rows.L)[1:] * turned,
    }


def _rounding_errors(
    body: Parameters, rows: RigidMotion, u: Rounding
) -> dict[str, tuple[Array, Array]]:
    """Errors of each quantity by rounding: of the rows (n), and what the flow makes of them."""
    h, unit = numpy.diff(rows.t), torque_unit(body)
    L, speed = norm(rows.L), norm(rows.v)
    omega = L / min(body.I1, body.I3)
    lever = body.R * body.alpha

    def both(values: Array) -> Array:
        mean: Array = (values[1:] + values[:-1]) / 2
        return mean

    attitude = 2 * u.q + omega * u.t
    turned = 1 + body.m * lever * omega * speed / unit  # rate of the momentum about the contact
    momentum = u.L + 2 * body.R * body.m * u.v + body.m * lever * speed * u.q
    turning = h * both(u.L) / min(body.I1, body.I3) + 2 * h * body.m * body.R * both(u.v) / body.I1
    turning = turning + 16 * EPS * (1 + omega[1:] * h)
    weighed = h * both(u.q) + body.m * omega[1:] * lever * both(u.v) * h / unit
    moved = h * both(u.v) + h * omega[1:] * lever * both(u.q)
    moved = moved + h * lever * both(u.L) / body.I1 + 2 * h * both(u.v)
    return {
        "spin": (attitude, turning),
        "axis": (attitude, turning),
        "inclination": (attitude, turning),
        "torque": (momentum / unit + 4 * EPS * L / unit + turned * u.t, weighed),
        "position": ((u.x + speed * u.t) / body.R + 4 * EPS, moved / body.R),
        "jellett": (2 * body.R * (u.L + L * u.q) + 32 * EPS * body.R * L, 0 * h),
    }
