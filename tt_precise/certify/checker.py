"""A second opinion that trusts nobody: checks a certificate of golden data on its own.

It shares with the prover the mechanics, the start of a scene and the ball arithmetic, nothing else.
A piece's polynomial is the Taylor series of the equations, in integers; S1 to S4 of the theorem in
``tt_precise.certify`` are then verified for it, in the norm max |x_i|. The contact force has to be
positive throughout. ``checking`` holds the printed tables against what is verified here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import mul

import flint
import numpy
from flint import arb, arb_mat, arb_poly, arb_series, fmpz

from tt_precise.arithmetic import Arithmetic, Scalar
from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.pieces import Refused
from tt_precise.golden.manifest import scene_sha256
from tt_precise.golden.store import Stored
from tt_precise.initial_state import InitialState
from tt_precise.mechanics.formulations import integrated
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.untyped import Json

GUARD = 40  # bits of the balls beyond those of the pieces
LOW = 10  # degree of the polynomials that bound derivatives
TERMS = 30  # of the flow's polynomial
TUBE = arb(2) ** -70
EARLY, CLOSEST = arb(2) ** -30, arb(2) ** -60  # of a piece, in the search for zeros
NEWTON = 12  # steps


class Ring:
    """What follows from addition, negation and multiplication."""

    def __radd__(self: Scalar, other: Scalar) -> Scalar:
        return self + other

    def __sub__(self: Scalar, other: Scalar) -> Scalar:
        return self + (-other)

    def __rsub__(self: Scalar, other: Scalar) -> Scalar:
        return -self + other

    def __rmul__(self: Scalar, other: Scalar) -> Scalar:
        return self * other


class PowerSeries(Ring):
    """A power series with coefficients in units of 2^-bits, each computed when it is needed."""

    def __init__(self, bits: int, coefficients: list[int], rule: Callable[[int], int]):
        self.bits, self.c, self.rule = bits, coefficients, rule

    def at(self, n: int) -> int:
        """The n-th coefficient."""
        while len(self.c) <= n:
            self.c.append(self.rule(len(self.c)))
        return self.c[n]

    def _other(self, other: Scalar) -> PowerSeries:
        if isinstance(other, PowerSeries):
            return other
        return PowerSeries(self.bits, [_fixed(arb(other), self.bits)], lambda n: 0)

    def __add__(self, other: Scalar) -> PowerSeries:
        y = self._other(other)
        return PowerSeries(self.bits, [], lambda n: self.at(n) + y.at(n))

    def __neg__(self) -> PowerSeries:
        return PowerSeries(self.bits, [], lambda n: -self.at(n))

    def __mul__(self, other: Scalar) -> PowerSeries:
        if not isinstance(other, PowerSeries):
            factor = self._other(other).at(0)
            return PowerSeries(self.bits, [], lambda n: self.at(n) * factor >> self.bits)

        def rule(n: int) -> int:
            self.at(n), other.at(n)
            return sum(map(mul, self.c[: n + 1], other.c[n::-1])) >> self.bits

        return PowerSeries(self.bits, [], rule)

    def __truediv__(self, other: Scalar) -> PowerSeries:
        y = self._other(other)
        found = PowerSeries(self.bits, [], lambda n: 0)

        def rule(n: int) -> int:
            y.at(n)
            known = sum(map(mul, found.c[:n], y.c[n:0:-1]))
            return ((self.at(n) << self.bits) - known) // y.at(0)

        found.rule = rule
        return found

    def __rtruediv__(self, other: Scalar) -> PowerSeries:
        return self._other(other) / self


class Poly(Ring):
    """All functions on [0, end] within polynomials with balls as coefficients."""

    def __init__(self, p: arb_poly, room: Room):
        self.p, self.room = p, room

    def __add__(self, other: Scalar) -> Poly:
        return Poly(self.p + (other.p if isinstance(other, Poly) else other), self.room)

    def __neg__(self) -> Poly:
        return Poly(-self.p, self.room)

    def __mul__(self, other: Scalar) -> Poly:
        if isinstance(other, Poly):
            return self.room.cut(self.p * other.p)
        return Poly(self.p * other, self.room)

    def __truediv__(self, other: Scalar) -> Poly:
        return self * (_inverse(other) if isinstance(other, Poly) else 1 / arb(other))

    def __rtruediv__(self, other: Scalar) -> Poly:
        return _inverse(self) * other


def _inverse(g: Poly) -> Poly:
    """1/g: r with |1 - g r| <= e < 1 is right within e/(1 - e), relatively."""
    before, flint.ctx.cap = flint.ctx.cap, g.room.degree + 1
    found = 1 / arb_series(arb_poly([c.mid() for c in g.p.coeffs()]), g.room.degree + 1)
    flint.ctx.cap = before
    close = Poly(arb_poly([c.mid() for c in found.coeffs()]), g.room)
    error = (1 - g * close).p(g.room.interval).abs_upper()
    if not error < 1:
        raise Refused("a divisor may be zero")
    return close * (1 + arb(0, error / (1 - error)))


class Room:
    """The interval [0, end] and the degree to which polynomials on it are computed."""

    def __init__(self, end: arb, degree: int):
        self.degree, self.interval = degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def cut(self, p: arb_poly) -> Poly:
        if p.degree() > self.degree:
            tail = p.right_shift(self.degree + 1)(self.interval) * self.beyond
            p = p.truncate(self.degree + 1) + tail
        return Poly(p, self)


class Dual(Ring):
    """A value and its derivatives by the components of the state (None for zero)."""

    def __init__(self, value: Scalar, by: Sequence[Scalar]):
        self.value, self.by = value, by

    def _map(self, value: Scalar, factor: Scalar) -> Dual:
        return Dual(value, [None if d is None else d * factor for d in self.by])

    def __add__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return Dual(self.value + other, self.by)
        pairs = zip(self.by, other.by, strict=True)
        by = [b if a is None else a if b is None else a + b for a, b in pairs]
        return Dual(self.value + other.value, by)

    def __neg__(self) -> Dual:
        return self._map(-self.value, -1)

    def __mul__(self, other: Scalar) -> Dual:
        if not isinstance(other, Dual):
            return self._map(self.value * other, other)
        left, right = self._map(0, other.value), other._map(0, self.value)
        return Dual(self.value * other.value, (left + right).by)

    def __truediv__(self, other: Scalar) -> Dual:
        if isinstance(other, Dual):
            inverse = 1 / other.value
            return self * other._map(inverse, -1 * (inverse * inverse))
        return self * (1 / arb(other))

    def __rtruediv__(self, other: Scalar) -> Dual:
        inverse = 1 / self.value
        return self._map(inverse, -1 * (inverse * inverse)) * other


class Checker:
    """Goes through the pieces of a certificate; the state is then proved within the present one."""

    def __init__(self, stored: Stored, content: dict[str, Json]):
        scene = stored.scene
        if content["scene_sha256"] != scene_sha256(stored.scene_text):
            raise Refused("the certificate is about another scene")
        self.scene = scene
        self.bits, self.order = int(content["bits"]), int(content["order"])
        self.form = integrated(scene.model, "newton")
        self.start = InitialState.of(scene, Arithmetic(Balls, ball))
        self.finish = arb(0)
        n = len(self.form.columns)
        self.basis = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        self.box = arb_mat(n, 1, [arb(0)] * n)
        self.end = [*map(arb, self.start.state(self.form))]

    def _rates(self, state: Sequence[Scalar]) -> list[Scalar]:
        return list(self.form.rates(self.start.body, self.form.State(*state), None))

    def advance(self, power: int, length: arb, start: Sequence[arb]) -> None:
        """Verify S1 to S4 for the next piece, in units of time 2^power, from ``start`` on."""
        if not (length > 0 and length.is_exact() and all(x.is_exact() for x in start)):
            raise Refused("a piece that goes nowhere, or from no exact state")
        self.time, self._unit = self.finish, arb(2) ** power
        gap = arb_mat(len(start), 1, [x - y for x, y in zip(self.end, start, strict=True)])
        self.box += self.basis.inv() * gap
        self.length, self.finish = length, self.time + length * self._unit
        self.p = self._taylor(start, power)
        if not all(c.is_exact() for p in self.p for c in p.coeffs()):
            raise Refused("a polynomial that is not exact")
        before = _norm((self.basis * self.box).entries())
        room = Room(length, self.order)
        exact = self._rates([Poly(p, room) for p in self.p])
        defect = _norm(
            (f.p * self._unit - p.derivative())(room.interval)
            for f, p in zip(exact, self.p, strict=True)
        )
        low = Room(length, LOW)
        self.tube = [low.cut(p) + arb(0, TUBE) for p in self.p]
        jacobian = self._jacobian(low)
        norms = [[entry.p(low.interval) for entry in row] for row in jacobian]
        sums = (
            sum((abs(x) for j, x in enumerate(row) if j != i), row[i])
            for i, row in enumerate(norms)
        )
        rate = _top([arb(0), *(one.upper() for one in sums)])
        growth = (rate * length).exp().upper()
        self.reach = ((before + defect * length) * growth).upper()
        if not self.reach < TUBE:
            raise Refused(f"S4 fails at t = {float(self.time):.6g}: the errors leave the tube")
        flow, error = _flow(jacobian, low)
        gain = ((growth - 1) / rate).upper() if rate > 0 else length
        spread = arb(0, (error * gain).upper())
        n = len(start)
        image = arb_mat([[f(length) + spread for f in row] for row in flow]) * self.basis
        self.basis = _orthogonal(image, self.box)
        back = self.basis.inv()
        added = arb_mat(n, 1, [arb(0, (defect * gain).upper())] * n)
        self.box = (back * image) * self.box + back * added
        self.end = [p(length) for p in self.p]
        self._early: list[Poly] = []
        self._low = low
        self._seen: tuple[Sequence[Poly], Motion] = self.tube, self.motion(self.tube)
        force = QUANTITIES["g_n"].evaluate(self._seen[1]).p
        if not force(low.interval) > 0:
            raise Refused(f"the contact force may vanish near t = {float(self.time):.6g}")

    def state(self, time: arb) -> list[arb]:
        s = (time - self.time) / self._unit
        if not (s >= 0 and s <= self.length):
            raise Refused(f"t = {float(time):.6g} is not in one piece")
        return [p(s) + arb(0, self.reach) for p in self.p]

    def motion(self, state: Sequence[Scalar]) -> Motion:
        return self.form.motion(self.start.body, self.form.State(*state), Balls)

    def zeros(self, function: Callable[[Motion], Scalar], until: arb) -> list[tuple[int, arb]]:
        """Direction and time of each zero of a function in the present piece up to ``until``.

        In the first piece from ``EARLY`` of it on: at t = 0 many functions vanish.
        """
        begin, end = arb(0), min(self.length, ((until - self.time) / self._unit).mid())
        room, tube = self._low, self.tube
        if self.time == 0:
            begin, room = (self.length * EARLY).mid(), Room(self.length, self.order)
            tube = self._early = self._early or [Poly(p + arb(0, self.reach), room) for p in self.p]
        value = function(self._motion_in(tube)).p
        slope = arb_poly([])
        waiting, found = [(begin, end)] if value.length() else [], []
        while waiting:
            a, b = waiting.pop()
            where = a.union(b)
            if not value(where).contains(0):
                continue
            if not slope.length():
                rates = zip(tube, self._rates(tube), strict=True)
                moving = [Dual(y, [f * self._unit]) for y, f in rates]
                slope = function(self.motion(moving)).by[0].p
            if not slope(where).contains(0):
                before, after = (self._value(function, s) for s in (a, b))
                if before.contains(0) or after.contains(0):
                    raise Refused(f"a sign near t = {float(self.time):.6g} is undecided")
                if (before > 0) != (after > 0):
                    zero = self._refined(function, slope, where)
                    found.append((1 if after > 0 else -1, self.time + zero * self._unit))
                continue
            if not b - a > self.length * CLOSEST:
                raise Refused(f"a sign near t = {float(self.time):.6g} is undecided")
            middle = ((a + b) / 2).mid()
            waiting += [(middle, b), (a, middle)]
        return found

    def _refined(self, function: Callable[[Motion], Scalar], slope: arb_poly, zero: arb) -> arb:
        """The only zero in a part, by interval Newton."""
        for _ in range(NEWTON):
            middle = zero.mid()
            step = middle - self._value(function, middle) / slope(zero)
            zero = zero.intersection(step)
        return zero

    def _value(self, function: Callable[[Motion], Scalar], s: arb) -> arb:
        return arb(function(self.motion([p(s) + arb(0, self.reach) for p in self.p])))

    def _motion_in(self, tube: Sequence[Poly]) -> Motion:
        """The motion of the tube; functions of it share what they compute."""
        if self._seen[0] is not tube:
            self._seen = tube, self.motion(tube)
        return self._seen[1]

    def _taylor(self, start: Sequence[arb], power: int) -> list[arb_poly]:
        bits = self.bits + 8
        y = [PowerSeries(bits, [_fixed(x, bits)], lambda n: 0) for x in start]
        rates = self._rates(y)
        for n in range(self.order):
            for one, rate in zip(y, rates, strict=True):
                slope = rate.at(n)
                one.c.append((slope << power if power >= 0 else slope >> -power) // (n + 1))
        return [arb_poly([arb(fmpz(c)) * arb(2) ** -bits for c in one.c]) for one in y]

    def _jacobian(self, low: Room) -> list[list[Poly]]:
        one, zero, places = Poly(arb_poly([1]), low), Poly(arb_poly([]), low), range(len(self.tube))
        state = [
            Dual(y, [one if i == j else None for j in places]) for i, y in enumerate(self.tube)
        ]
        rows = (rate.by for rate in self._rates(state))
        return [[zero if d is None else d * self._unit for d in row] for row in rows]


def _fixed(x: arb, bits: int) -> int:
    return int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz())


def _top(numbers: list[arb]) -> arb:
    if not all(x.is_finite() for x in numbers):
        raise Refused("a bound is not finite")
    return max(numbers)


def _norm(numbers: Scalar) -> arb:
    return _top([arb(x).abs_upper() for x in numbers])


def _flow(jacobian: list[list[Poly]], low: Room) -> tuple[list[list[arb_poly]], arb]:
    """S3: polynomials P, P(0) = 1, and a bound of the norm of J P - P'."""
    n = len(jacobian)
    a = numpy.zeros((low.degree + 1, n, n))
    for i, row in enumerate(jacobian):
        for j, entry in enumerate(row):
            for k, c in enumerate(entry.p.coeffs()):
                a[k, i, j] = float(c.mid())
    terms = [numpy.eye(n)]
    for k in range(1, TERMS):
        terms.append(sum(a[i] @ terms[k - 1 - i] for i in range(min(k, len(a)))) / k)
    flow = [[arb_poly([t[i, j] for t in terms]) for j in range(n)] for i in range(n)]
    rows = []
    for i, row in enumerate(jacobian):
        found = arb(0)
        for j in range(n):
            total = -flow[i][j].derivative()
            for k, entry in enumerate(row):
                if entry.p.length():
                    total += entry.p * flow[k][j]
            found += total(low.interval).abs_upper()
        rows.append(found.upper())
    return flow, _top(rows)


def _orthogonal(image: arb_mat, box: arb_mat) -> arb_mat:
    """A basis for the next set of errors: any invertible matrix is right."""
    edges = numpy.array([float(x.abs_upper()) for x in box.entries()])
    columns = numpy.array([[float(x.mid()) for x in row] for row in image.tolist()])
    lengths = numpy.linalg.norm(columns, axis=0) * (edges / (edges.max() or 1.0) + 1e-30)
    factor, _ = numpy.linalg.qr(columns[:, numpy.argsort(-lengths, kind="stable")])
    return arb_mat(factor.tolist())
