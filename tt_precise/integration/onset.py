"""How gliding begins from rest under Coulomb's law: power series in the time since.

At v_A = 0 the equations are singular, and tau of ``polar`` would begin at -infinity. The solution
that glides from there is v(t), e(t), k(t), L(t) as power series, found coefficient by coefficient:
(v e')_k = (n.v_A_dot)_k is linear in the next coefficient of e, whose factor v_1 k - N is not zero,
N < 0 being what turning e changes of n.v_A_dot. Where rolling reaches the cone v_1 = 0 (``cone``
in exact.identities): v begins with t^2, and the series is asymptotic, its terms growing like
factorials in the end; its error is then below the least of them. Where the force of rolling lies
outside the cone from the first v_1 > 0, and the series converges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy

from tt_precise.mechanics import friction, newton, rolling
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Functions, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.taylor.series import Series

DIRECTIONS = 64  # in which gliding may begin, looked at for changes of sign


class _Registered(Series):
    """A series that is listed in ``all``, as are those that are made of it."""

    __slots__ = ("all",)

    def __init__(
        self, every: list[Series], step: Callable[[Any, int], Scalar], first: Sequence[Scalar] = ()
    ):
        super().__init__(step, first)
        self.all = every

    def made(self, step: Callable[[Any, int], Scalar]) -> Series:
        self.all.append(_Registered(self.all, step))
        return self.all[-1]


@dataclass(frozen=True)
class OnsetSeries:
    """Series of k, L, v, e in the time t >= 0 since rest, valid up to ``until``.

    ``coefficients`` has shape (9, terms): kx ... Lz, v, ex, ey, numbers of one arithmetic.
    """

    coefficients: numpy.ndarray
    until: Scalar

    def at(self, t: Scalar, fn: Functions) -> tuple[Scalar, ...]:
        """kx ... Lz, v, ex, ey at the time t."""
        powers = [t**k for k in range(self.coefficients.shape[1])]
        return tuple(fn.fdot(row, powers) for row in self.coefficients)


def direction_on_the_cone(
    body: Parameters, state: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """The direction in which gliding begins where rolling reaches the cone: against the force."""
    x, y, _ = rolling.constraint_force(body, state)
    size = fn.hypot(x, y)
    return -x / size, -y / size


def directions_from_rest(
    body: Parameters, state: NewtonState, fn: Functions
) -> list[tuple[Scalar, Scalar]]:
    """Unit directions e in which v_A can grow from zero: v_A_dot is along e, and not against it."""

    def accelerations(angle: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """v_A_dot along and across a direction, times the denominator of g_n, and that itself."""
        e = fn.cos(angle), fn.sin(angle)
        pushed = state._replace(vx=e[0], vy=e[1])
        rate = friction.along_direction(body, pushed)
        _, size = newton.contact_terms(body, pushed)
        x, y = size * rate.vx, size * rate.vy
        return e[0] * x + e[1] * y, e[0] * y - e[1] * x, size

    def across(angle: Scalar) -> Scalar:
        return accelerations(angle)[1]

    step = 2 * fn.pi / DIRECTIONS
    # an offset, so that no direction of symmetry lies on a bound
    angles = [step * (fn.mpf(i) + fn.mpf(1) / 3) for i in range(DIRECTIONS + 1)]
    values = [across(angle) for angle in angles]
    found = []
    for i in range(DIRECTIONS):
        if (values[i] > 0) != (values[i + 1] > 0):
            angle = fn.findroot(across, (angles[i], angles[i + 1]), solver="anderson")
            along, _, size = accelerations(angle)
            if along > 0 and size > 0:
                found.append((fn.cos(angle), fn.sin(angle)))
    return found


def onset(
    body: Parameters,
    state: NewtonState,
    e: tuple[Scalar, Scalar],
    terms: int,
    eps: Scalar,
    fn: Functions,
    on_the_cone: bool,
) -> OnsetSeries:
    """The series of ``terms`` coefficients, and up to which time its last ones stay below eps.

    ``state`` is at rest, of mpmath numbers of the context ``fn``; e is its first direction.
    """
    operations: list[Series] = []
    # the next coefficients are known before they are asked for
    entries = [_Registered(operations, lambda c, k: None, [x]) for x in (*state[:6], *e)]
    rate = friction.along_direction(body, NewtonState(*entries))
    ex, ey = entries[6:]
    along = ex * rate.vx + ey * rate.vy
    across = ex * rate.vy - ey * rate.vx
    v = [fn.mpf(0)]
    turning: list[Scalar] = []  # coefficients of the rate of e's angle

    def turned(k: int, known: tuple[Scalar, Scalar], angle: Scalar) -> Scalar:
        """across_k where coefficient k of e is the known part turned by an angle."""
        for operation in operations:
            del operation.c[k:]
        ex.c[k:], ey.c[k:] = [known[0] - angle * e[1]], [known[1] + angle * e[0]]
        return across[k]

    slope = None
    for k in range(terms):
        if k:
            # e' = w n: the part of e_k that former coefficients of w give, then the newest one's
            x, y = (
                sum((turning[j] * m.c[k - 1 - j] for j in range(k - 1)), fn.mpf(0)) / k
                for m in (ey, ex)
            )
            known = -x, y
            rest = turned(k, known, 0)
            if slope is None:
                slope = turned(k, known, 1) - rest
            former = sum((v[j] * turning[k - j] for j in range(2, k + 1)), fn.mpf(0))
            turning.append((rest - former) / (v[1] - slope / k))
            turned(k, known, turning[-1] / k)
        # on the cone v_A_dot vanishes but for rounding
        v.append(fn.mpf(0) if not k and on_the_cone else along[k] / (k + 1))
        for entry, part in zip(entries[:6], rate[:6], strict=True):
            entry.c.append(part[k] / (k + 1))
    columns = [entry.c[:terms] for entry in entries]
    found = [*columns[:6], v[:terms], *columns[6:]]
    return OnsetSeries(numpy.array(found, dtype=object), _valid_until(found, eps, fn))


def _valid_until(columns: list[list[Scalar]], eps: Scalar, fn: Functions) -> Scalar:
    """Where the last two terms of each series are eps of it; v is compared with its first term."""
    bounds = []
    for i, c in enumerate(columns):
        first = next((k for k, x in enumerate(c) if x), 0) if i == 6 else 0
        size = abs(c[first]) if i == 6 else 1
        last = [(k, abs(c[k])) for k in (len(c) - 2, len(c) - 1) if c[k]]
        bounds += [fn.root(eps * size / term, k - first) for k, term in last]
    return min(bounds)
