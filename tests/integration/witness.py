"""A top integrated by other means, for tests alone: nothing here is the package's.

Newton's equations of a sphere with an axis, from the laws of linear and angular momentum, with the
contact force solved for numerically from what it has to achieve, in numbers of 113 bits. Each step
is a polynomial through Chebyshev's points, found by Picard's iteration; events are sign changes of
functions along it, between the zeros of their derivatives. In units of m = R = g = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import gmpy2
import numpy

BITS, POINTS = 113, 28
TAIL = 1e-22  # of a step's polynomials, in their last three coefficients
FIRST, LONGEST, SHORTEST = 1e-12, 0.25, 1e-14
MOST_ITERATIONS = 80
Vector = tuple[Any, Any, Any]


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def plus(*vectors: Vector) -> Vector:
    x, y, z = (sum(parts[1:], start=parts[0]) for parts in zip(*vectors, strict=True))
    return (x, y, z)


def times(c: Any, a: Vector) -> Vector:
    return (c * a[0], c * a[1], c * a[2])


@dataclass(frozen=True)
class Top:
    """A body, what acts at its lowest point, and the state: k, L, velocity of the centre, height.

    ``kind`` is "gliding", "rolling", "flight" or "spring"; ``coefficient`` is that of friction, a
    function of v_A^2.
    """

    alpha: Any
    I1: Any
    I3: Any
    kind: str = "gliding"
    coefficient: Callable[[Any], Any] = lambda square: 0 * square
    stiffness: Any = 0
    damping: Any = 0

    def spin(self, k: Vector, L: Vector) -> Vector:
        return plus(times(1 / self.I1, L), times((1 / self.I3 - 1 / self.I1) * dot(L, k), k))

    def contact(self, y: Any) -> tuple[Vector, Vector, Vector, Vector, Vector]:
        """k, L, omega, a, and the velocity of the lowest point."""
        k, L, s = tuple(y[:3]), tuple(y[3:6]), tuple(y[6:9])
        omega = self.spin(k, L)
        a = (self.alpha * k[0], self.alpha * k[1], self.alpha * k[2] - 1)
        return k, L, omega, a, plus(s, cross(omega, a))

    def acceleration(self, y: Any, force: Vector) -> Vector:
        """That of the lowest point, as a point of the body that follows it, under ``force``."""
        k, L, omega, a, _ = self.contact(y)
        torque, moving = cross(a, force), cross(omega, k)
        kappa = 1 / self.I3 - 1 / self.I1
        turning = plus(
            times(1 / self.I1, torque),
            times(kappa * (dot(torque, k) + dot(L, moving)), k),
            times(kappa * dot(L, k), moving),
        )
        x, y_, z = plus(force, cross(turning, a), cross(omega, times(self.alpha, moving)))
        return (x, y_, z - 1)

    def force(self, y: Any) -> Vector:
        zero = 0 * y[0]
        if self.kind == "flight":
            return (zero, zero, zero)
        *_, v = self.contact(y)
        if self.kind == "rolling":
            return self._holding(y)
        c = self.coefficient(v[0] * v[0] + v[1] * v[1])
        slant = (-c * v[0], -c * v[1], 1 + zero)
        if self.kind == "spring":
            return times(-self.stiffness * y[9] - self.damping * v[2], slant)
        without = self.acceleration(y, (zero, zero, zero))[2]
        return times(-without / (self.acceleration(y, slant)[2] - without), slant)

    def _holding(self, y: Any) -> Vector:
        """The force under which the lowest point is not accelerated; Cramer's rule."""
        zero = 0 * y[0]
        rest = self.acceleration(y, (zero, zero, zero))
        columns = []
        for x, y_, z in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
            moved = self.acceleration(y, (zero + x, zero + y_, zero + z))
            columns.append(plus(moved, times(-1, rest)))
        a, b, c = columns
        size = dot(a, cross(b, c))
        down = times(-1, rest)
        return (
            dot(down, cross(b, c)) / size, dot(a, cross(down, c)) / size,
            dot(a, cross(b, down)) / size,
        )  # fmt: skip

    def rates(self, y: Any) -> list[Any]:
        k, _, omega, a, v = self.contact(y)
        force = self.force(y)
        height = v[2] if self.kind in ("flight", "spring") else 0 * v[2]
        return [
            *cross(omega, k), *cross(a, force), force[0], force[1], force[2] - 1, height,
        ]  # fmt: skip

    def functions(self, y: Any) -> dict[str, Any]:
        """What is zero at an event; minima and maxima of theta have one function."""
        k, L, omega, _, v = self.contact(y)
        moving = cross(omega, k)
        spin, towards = dot(L, k), v[0] * k[0] + v[1] * k[1]
        across = v[1] * k[0] - v[0] * k[1]
        found = {
            "turning": moving[2], "phi_dot_zero": k[0] * moving[1] - k[1] * moving[0],
            "equator": k[2], "omega_3_zero": spin,
            "Lk_equals_Lz": spin - L[2], "Lk_equals_minus_Lz": spin + L[2],
        }  # fmt: skip
        if self.kind not in ("rolling", "flight"):
            found |= {"nu_x_zero": towards, "nu_y_zero": across, "nu_crossing": across - towards}
        return found | {"end": y[9] if self.kind == "flight" else self.force(y)[2]}


@cache
def _tables() -> tuple[Any, Any, Any]:
    """Chebyshev's points on 0 to 1, the matrix of integrals from 0, that of coefficients."""
    n = POINTS - 1
    pi = gmpy2.const_pi()
    angles = [pi * (n - i) / n for i in range(POINTS)]
    x = numpy.array([gmpy2.cos(a) for a in angles], dtype=object)
    ends = [gmpy2.mpfr(1) if 0 < j < n else gmpy2.mpfr("0.5") for j in range(POINTS)]
    cosines = [[gmpy2.cos(j * a) for a in angles] for j in range(POINTS)]
    to_c = numpy.array(
        [[2 * ends[i] * ends[j] * cosines[j][i] / n for i in range(POINTS)] for j in range(POINTS)],
        dtype=object,
    )
    integral = []
    for t in range(POINTS):
        row = []
        for j in range(POINTS):

            def whole(m: int, t: int = t) -> Any:
                return gmpy2.cos(m * angles[t]) - (-1) ** m

            if j == 0:
                row.append(whole(1))
            elif j == 1:
                row.append(whole(2) / 4)
            else:
                row.append(whole(j + 1) / (2 * (j + 1)) - whole(j - 1) / (2 * (j - 1)))
        integral.append(row)
    to_integral = numpy.array(integral, dtype=object).dot(to_c) / 2
    return (x + 1) / 2, to_integral, to_c


def _value(c: Any, u: Any) -> Any:
    """The Chebyshev series ``c`` at 0 <= u <= 1; Clenshaw."""
    x, after, last = 2 * u - 1, 0 * u, 0 * u
    for one in c[:0:-1]:
        after, last = one + 2 * x * after - last, after
    return c[0] + x * after - last


def _step(top: Top, y: Any, h: Any) -> Any | None:
    """The states at the points of a step, axes (point, entry), or None where it is too long."""
    _, integral, to_c = _tables()
    points = numpy.array([y] * POINTS, dtype=object)
    before = numpy.inf
    for _ in range(MOST_ITERATIONS):
        rates = numpy.array(top.rates(points.T), dtype=object).T
        found = y + h * integral.dot(rates)
        moved = float(max(abs(found - points).ravel()))
        points = found
        if not moved < 1e6:
            return None
        if moved < 1e-30 or (moved >= before and moved < 1e-26):
            break
        before = moved
    else:
        return None
    tail = abs(to_c.dot(points)[-3:]).max()
    return points if tail < TAIL * max(1, abs(points).max()) else None


def _zeros(values: Any, to_c: Any) -> Iterator[tuple[Any, int]]:
    """Places in 0 to 1 where the interpolant of ``values`` changes sign, and how."""
    c = to_c.dot(values)
    size = abs(c).max()
    if size < 1e-25:  # rounding of what vanishes identically
        return
    rough = numpy.array([float(one / size) for one in c])
    slope = numpy.polynomial.chebyshev.chebder(rough)
    turns = numpy.polynomial.chebyshev.chebroots(numpy.trim_zeros(slope, "b"))
    inner = sorted(t.real for t in turns if abs(t.imag) < 1e-6 and -1 < t.real < 1)
    ends = [gmpy2.mpfr(0), *((gmpy2.mpfr(t) + 1) / 2 for t in inner), gmpy2.mpfr(1)]
    heights = [_value(c, u) for u in ends]
    for low, high, a, b in zip(ends, ends[1:], heights, heights[1:], strict=False):
        if (a > 0) == (b > 0) or not a or not b:
            continue
        sign = 1 if b > a else -1
        for _ in range(BITS):
            middle = (low + high) / 2
            if (_value(c, middle) > 0) == (sign > 0):
                high = middle
            else:
                low = middle
        yield (low + high) / 2, sign


def follow(top: Top, start: Any, until: float) -> tuple[list[tuple[str, Any, int]], Any, bool]:
    """Events (name, time, direction), the time of the end, or up to which it could be followed.

    And whether that is the end.
    """
    with gmpy2.context(precision=BITS):
        _, _, to_c = _tables()
        y = numpy.array([gmpy2.mpfr(one) for one in start], dtype=object)
        t, h = gmpy2.mpfr(0), gmpy2.mpfr(FIRST)
        events: list[tuple[str, Any, int]] = []
        silent = {name for name, f in top.functions(y).items() if abs(f) < 1e-28}
        while t < until:
            h = min(h, gmpy2.mpfr(until) - t)
            states = _step(top, y, h)
            if states is None:
                h = h / 2
                if h < max(SHORTEST, t / 1000):  # as where Coulomb's friction comes to rest
                    break
                continue
            found = []
            for name, values in top.functions(states.T).items():
                if not t and name in silent:
                    continue  # its zero at the start; there is no other one so soon
                found += [(name, t + u * h, sign) for u, sign in _zeros(values, to_c)]
            for name, time, sign in sorted(found, key=lambda one: one[1]):
                if name == "end" and sign < 0:
                    return events, time, True
                if name != "end":
                    events.append((name, time, sign))
            t, y, h = t + h, states[-1], min(2 * h, gmpy2.mpfr(LONGEST))
        return events, t, t >= until
