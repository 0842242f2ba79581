"""Conventions of columns of vectors: units, exchanged or mirrored components, the point of v.

Every force keeps Jellett's integral, in any units: it tells which arrangement of the components of
k and L is meant. The free motion from both rows of an interval to its middle tells the units of t
and L, the momentum about the lowest point the arrangement and the unit of v. What is left is judged
by all residuals.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy

from tt_precise.check.conventions import (
    INTERVALS,
    LENGTH,
    LIMITS,
    LINEAR_MOMENTUM,
    LOOKED_AT,
    PART,
    ROUGH,
    TIME,
    Given,
    fit,
    largest,
    rotated,
    rotation_by,
    time_in_words,
    units_of_time,
)
from tt_precise.check.force_free import EPS, norm
from tt_precise.check.force_free_flow import (
    FARTHEST,
    Way,
    axis_of,
    gauss,
    interpolate,
    momentum_at_contact,
    nutation,
    rates_of,
)
from tt_precise.check.movement import shortest_rotation
from tt_precise.mechanics.newton import NewtonState, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array

MOST_CHANGES = 2  # Changes that are tried at once.
# Part of the misfit of the momentum that another v may leave, and the rows through which its rate
# is interpolated; half and double of both name the same in eight files.
NEARER, SIX = 0.5, 6
Arrangement = tuple[int, ...]
"""For each of our components the file's, from 1 on, with its sign: (2, 1, -3) is (y, x, -z)."""
SPACE, PLANE = (1, 2, 3), (1, 2)


class VectorConvention(NamedTuple):
    """Units of t, L and v, the arrangement of the components, and the point of the velocity."""

    time: str = "s"
    momentum: str = ""
    length: str = "m"
    k: Arrangement = SPACE
    L: Arrangement = SPACE
    v: Arrangement = PLANE
    centre: bool = False

    @property
    def words(self) -> list[str]:
        """The differences from our convention."""
        said = [time_in_words(self.time)] * (self.time != "s")
        said += [f"the angular momentum is in {self.momentum}"] * bool(self.momentum)
        said += [f"the velocities are in {self.length}/s"] * (self.length != "m")
        if self.k == (-1, -2, -3):
            said.append("the axis points from the other end")
        else:
            said += _arranged("k", self.k)
        said += [*_arranged("L", self.L), *_arranged("v", self.v)]
        return said + ["the velocity is that of the centre of mass"] * self.centre

    def convert(self, given: Given, body: Parameters) -> Given:
        """Return the columns as ours."""
        k = _in_order(numpy.array(axis_of(given.q)), self.k)
        L = LINEAR_MOMENTUM[self.momentum] * _in_order(given.w, self.L)
        v = None if given.v is None else LENGTH[self.length] * _in_order(given.v, (*self.v, 3))
        t = TIME[self.time] * given.t
        ours = Given(t, shortest_rotation(k), L, v, given.x, vectors=True)
        if self.centre and v is not None:
            swing = -ours._replace(v=None).rows(body).v
            ours = ours._replace(v=v + swing * numpy.array([[1.0], [1.0], [0.0]]))
        return ours

    def rounding(self, half: Mapping[str, float]) -> dict[str, float]:
        """Return half units of the last places of t, L and v in SI."""
        unit = {
            "t": TIME[self.time], "w": LINEAR_MOMENTUM[self.momentum], "v": LENGTH[self.length],
        }  # fmt: skip
        return {name: value * unit.get(name, 1.0) for name, value in half.items()}


OURS = VectorConvention()


def columns_of(given: Given) -> dict[str, Array]:
    """Return the columns of vectors, by name."""
    k = axis_of(given.q)
    values = [*k, *given.w, *(() if given.v is None else given.v[:2])]
    return {"t": given.t, **dict(zip(NewtonState._fields, values, strict=False))}


def _in_order(vectors: Array, arrangement: Arrangement) -> Array:
    found: Array = numpy.array([math.copysign(1, i) * vectors[abs(i) - 1] for i in arrangement])
    return found


def _arranged(vector: str, arrangement: Arrangement) -> list[str]:
    """Say which columns hold which components, or have the other sign."""
    ours = {abs(i): (f"{vector}{'xyz'[n]}", i < 0) for n, i in enumerate(arrangement)}
    theirs = {i: f"{vector}{'xyz'[i - 1]}" for i in ours}
    differ = [i for i in sorted(ours) if ours[i] != (theirs[i], False)]
    if not differ:
        return []
    names, many = ", ".join(theirs[i] for i in differ), len(differ) > 1
    if all(ours[i] == (theirs[i], True) for i in differ):
        return [f"{names} {'have' if many else 'has'} the other sign"]
    held = ", ".join("-" * ours[i][1] + ours[i][0] for i in differ)
    return [f"{names} {'hold' if many else 'holds'} {held}"]


@cache
def arrangements(count: int) -> tuple[Arrangement, ...]:
    """Return all orders and signs of so many components but ours, the fewest signs first."""
    signs = itertools.product((1, -1), repeat=count)
    every = (
        tuple(s * i for s, i in zip(sign, order, strict=True))
        for sign in signs
        for order in itertools.permutations(range(1, count + 1))
    )
    return tuple(one for one in every if one != tuple(range(1, count + 1)))


def candidates(given: Given) -> Iterator[VectorConvention]:
    """Conventions that differ from ours in one group, then those that differ in two."""
    # k and L together but for z: they are turned, or else v is
    arranged = [("k", one) for one in arrangements(3)] + [("L", one) for one in arrangements(3)]
    arranged += [("k L", one) for one in arrangements(3) if one[2] != 3]
    groups: list[list[tuple[str, object]]] = []
    if given.v is not None:
        groups.append([("v", one) for one in arrangements(2)])
        groups.append([("length", name) for name in LENGTH if name != "m"])
        groups.append([("centre", True)])
    groups.append([("time", name) for name in units_of_time(given.t) if name != "s"])
    groups.append([("momentum", name) for name in LINEAR_MOMENTUM if name])
    groups.append([*arranged])
    for count in range(1, MOST_CHANGES + 1):
        for chosen in itertools.combinations(groups, count):
            for changes in itertools.product(*chosen):
                changed: dict[str, Any] = {}
                for names, value in changes:
                    changed |= dict.fromkeys(names.split(), value)
                yield OURS._replace(**changed)


def conventions_of_vectors(
    given: Given, body: Parameters, half: Mapping[str, float]
) -> Iterator[VectorConvention]:
    """Conventions in which the first rows obey the laws of every force, fewest changes first."""
    few = given.part(slice(0, LOOKED_AT))
    k = numpy.array(axis_of(few.q))

    @cache
    def keeps_jellett(order_k: Arrangement, order_L: Arrangement) -> bool:
        vectors = _in_order(k, order_k), _in_order(few.w, order_L)
        return _jellett_drift(body, *vectors, 4 * half["w"], 4 * half["q"]) <= LIMITS["jellett"]

    @cache
    def moves(order_k: Arrangement, order_L: Arrangement, scale: float) -> bool:
        return _moves(few.t, _in_order(k, order_k), _in_order(few.w, order_L) / body.I1, scale)

    @cache
    def momentum(turning: VectorConvention) -> _MomentumByVelocity:
        return _MomentumByVelocity(body, turning.convert(few, body))

    for one in candidates(few):
        scale = TIME[one.time] * LINEAR_MOMENTUM[one.momentum]
        if not keeps_jellett(one.k, one.L) or not moves(one.k, one.L, scale):
            continue
        # an axis at rest, or one that turns more than is seen: a fit costs seconds, tells nothing
        w, dt = LINEAR_MOMENTUM[one.momentum] * few.w, TIME[one.time] * numpy.diff(few.t)
        if not 1e-6 < float(norm(w)[0]) / body.I3 * float(dt.max()) < FARTHEST:
            continue
        if few.v is not None:
            misfit = momentum(one._replace(length="m", v=PLANE, centre=False)).misfit(one)
            if not misfit < NEARER * momentum(OURS).misfit(OURS):
                continue
        if fit(body, one.convert(few, body), one.rounding(half)).passes:
            yield one


def _jellett_drift(body: Parameters, k: Array, L: Array, u_L: float, u_q: float) -> float:
    """Return the relative drift of Jellett's integral beyond the rounding of two rows' L and k."""
    spin = norm(L) / min(body.I1, body.I3)
    jellett = (L * numpy.array(contact_arm(body, (k[0], k[1], k[2])))).sum(axis=0)
    inertia = max(body.I1, body.I3)
    slack = 2 * body.R * (u_L + inertia * spin * (u_q + 32 * EPS))
    return largest((abs(jellett - jellett[0]) - slack) / abs(jellett[0]))


def _moves(t: Array, k: Array, rate: Array, scale: float) -> bool:
    """Test that the axes of both rows, turned at ``scale * rate``, meet in an interval's middle."""
    count = len(t) - 1
    i = numpy.unique(numpy.linspace(0, count - 1, min(INTERVALS, count)).astype(int))
    h = t[i + 1] - t[i]

    def middle(rows: Array, way: float) -> Array:
        return rotated(rotation_by(way * scale * rate[:, rows] * h / 2), k[:, rows])

    off = float(numpy.sqrt((norm(middle(i, 1.0) - middle(i + 1, -1.0)) ** 2).mean()))
    moved = float(numpy.sqrt((norm(k[:, i + 1] - k[:, i]) ** 2).mean()))
    return off < min(ROUGH, PART * moved)


class _MomentumByVelocity:
    """The change of the momentum about the lowest point, and what is left of it, by the velocity.

    Both depend linearly on the velocity's components: each is a sum of those of a contact point at
    rest, of the swing about it, and of each column in the place of each component.
    """

    def __init__(self, body: Parameters, given: Given):
        assert given.v is not None
        velocities = numpy.zeros((6, 3, len(given.t)))
        velocities[1, :2] = -given._replace(v=None).rows(body).v[:2]
        velocities[2:4, 0] = velocities[4:6, 1] = given.v[:2]
        several = [given._replace(v=v).rows(body) for v in velocities]
        rates = numpy.concatenate([rates_of(body, rows).Q for rows in several])
        nodes, _, whole = gauss(SIX)
        turn, h = nutation(body, several[0]), numpy.diff(given.t)
        rate = interpolate(given.t, rates, Way(SIX, True), turn, nodes)
        integral = h * numpy.einsum("p,cpn->cn", whole, rate)
        change = numpy.diff(numpy.concatenate([momentum_at_contact(body, r) for r in several]))
        change, left = (values.reshape(len(several), -1) for values in (change, change - integral))
        change[1:] -= change[0]
        left[1:] -= left[0]
        self._change, self._left = change @ change.T, left @ left.T

    def misfit(self, one: VectorConvention) -> float:
        """Return the part of its changes that the momentum misses; NaN if it does not change."""
        parts = numpy.zeros((2, 2))
        for i, entry in enumerate(one.v):
            parts[i, abs(entry) - 1] = math.copysign(LENGTH[one.length], entry)
        by = numpy.array([1.0, float(one.centre), *parts.ravel()])
        left, change = (float(by @ products @ by) for products in (self._left, self._change))
        return math.sqrt(max(left, 0.0) / (change or math.nan))  # a top upright does not tell
