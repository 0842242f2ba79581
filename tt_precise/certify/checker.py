"""A second opinion that trusts nobody: checks a certificate of golden data on its own.

It shares with the prover the mechanics, the start of a scene and the ball arithmetic, nothing else.
A piece's polynomial is the Taylor series of the equations, in integers; S1 to S4 of the theorem in
``tt_precise.certify`` are then verified for it, in the norm max |x_i|. ``checked_zeros`` finds all
zeros of a function in a piece, and ``checking`` holds the printed tables against all that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isqrt
from operator import mul

import flint
import numpy
from flint import arb, arb_mat, arb_poly, arb_series, fmpz

from tt_precise.certify.balls import Balls, ball, series_length
from tt_precise.certify.pieces import Refused
from tt_precise.golden.store import Stored, scene_sha256
from tt_precise.integration.quadratures import extended_rates
from tt_precise.mechanics.formulations import integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Arithmetic, Scalar
from tt_precise.runtime.untyped import Json

GUARD = 40  # bits of the balls beyond those of the pieces
LOW, LOW_BITS = 10, 80  # degree and bits of the polynomials that bound derivatives
TERMS = 30  # of the flow's polynomial
TUBE = arb(2) ** -70


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

    def sqrt(self) -> PowerSeries:
        found = PowerSeries(self.bits, [isqrt(self.at(0) << self.bits)], lambda n: 0)

        def rule(n: int) -> int:
            known = sum(map(mul, found.c[1:n], found.c[n - 1 : 0 : -1]))
            return ((self.at(n) << self.bits) - known) // (2 * found.at(0))

        found.rule = rule
        return found


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

    def sqrt(self) -> Poly:
        """Where |g/r^2 - 1| <= e < 1 the root is r within e, relatively."""
        close = self.room.near(self, lambda series: series.sqrt())
        inverse = _inverse(close)
        return close * (1 + arb(0, _less_than_one(self * inverse * inverse - 1)))


def _inverse(g: Poly) -> Poly:
    """1/g: r with |1 - g r| <= e < 1 is right within e/(1 - e), relatively."""
    close = g.room.near(g, lambda series: 1 / series)
    error = _less_than_one(1 - g * close)
    return close * (1 + arb(0, error / (1 - error)))


def _less_than_one(f: Poly) -> arb:
    error = f.p(f.room.interval).abs_upper()
    if not error < 1:
        raise Refused("a divisor, or what has a root, may be zero")
    return error


class Room:
    """The interval [0, end] and the degree to which polynomials on it are computed."""

    def __init__(self, end: arb, degree: int):
        self.degree, self.interval = degree, arb(0).union(end)
        self.beyond = arb(0).union(end ** (degree + 1))

    def near(self, g: Poly, function: Callable[[arb_series], arb_series]) -> Poly:
        """A polynomial, exact, near a function of one: nothing more is known of it."""
        middle = arb_poly([c.mid() for c in g.p.coeffs()])
        with series_length(self.degree + 1):
            found = function(arb_series(middle, self.degree + 1))
        return Poly(arb_poly([c.mid() for c in found.coeffs()]), self)

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

    def sqrt(self) -> Dual:
        root = self.value.sqrt()
        return self._map(root, 1 / (2 * root))


class Checker:
    """Goes through the pieces of a certificate; the state is then proved within the present one.

    There, from ``time`` to ``finish``, |y - p(s)| <= reach for t = time + unit s; ``tube`` are
    bands of y of low degree. Components that are not ``free`` are zero, exactly.
    """

    def __init__(self, stored: Stored, content: dict[str, Json]):
        self.scene = scene = stored.scene
        named = content["scene"], content["scene_sha256"]
        if named != (stored.name, scene_sha256(stored.scene_text)):
            raise Refused("the certificate is about another scene")
        self.bits, self.order = int(content["bits"]), int(content["order"])
        self.form = integrated(scene.model, "newton", scene.body.friction)
        self.start = InitialState.of(scene, Arithmetic(Balls, ball))
        self.finish = arb(0)
        self.end = [arb(x) for x in self.start.first_row(self.form, scene.record)]
        self.free = self._moving(self.end)
        n = len(self.free)
        self.basis = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        self.box = arb_mat(n, 1, [arb(0)] * n)

    def _moving(self, start: Sequence[arb]) -> list[int]:
        """Components that do not stay zero. ``advance`` verifies that the others do."""
        free = [i for i, x in enumerate(start) if not x.is_zero()]
        while True:
            state = [x + arb(0, TUBE) if i in free else arb(0) for i, x in enumerate(start)]
            rates = enumerate(self.rates(state))
            found = [i for i, rate in rates if i in free or not arb(rate).is_zero()]
            if found == free:
                return free
            free = found

    def rates(self, state: Sequence[Scalar]) -> list[Scalar]:
        record = self.scene.record
        return extended_rates(self.form, record, self.start.body, tuple(state), Balls)

    def near(self, polynomials: Sequence[Scalar], radius: arb) -> list[Scalar]:
        """Polynomials, or their values, with this error; none where a component stays zero."""
        return [p + arb(0, radius) if i in self.free else p for i, p in enumerate(polynomials)]

    def advance(self, power: int, length: arb, start: Sequence[arb]) -> None:
        """Verify S1 to S4 for the next piece, in units of time 2^power, or raise ``Refused``."""
        if not (length > 0 and length.is_exact() and all(x.is_exact() for x in start)):
            raise Refused("a piece that goes nowhere, or from no exact state")
        self.time, self.unit = self.finish, arb(2) ** power
        gaps = [x - y for x, y in zip(self.end, start, strict=True)]
        if any(not gap.is_zero() for i, gap in enumerate(gaps) if i not in self.free):
            raise Refused("a component that is zero begins elsewhere")
        n = len(self.free)
        self.box += self.basis.inv() * arb_mat(n, 1, [gaps[i] for i in self.free])
        self.length, self.finish = length, self.time + length * self.unit
        self.p = self._taylor(start, power)
        if not all(c.is_exact() for p in self.p for c in p.coeffs()):
            raise Refused("a polynomial that is not exact")
        before = _norm((self.basis * self.box).entries())
        room = Room(length, self.order)
        exact = self.rates([Poly(p, room) for p in self.p])
        defect = _norm(
            (f.p * self.unit - p.derivative())(room.interval)
            for f, p in zip(exact, self.p, strict=True)
        )
        self.low = low = Room(length, LOW)
        with flint.ctx.workprec(LOW_BITS):
            self.tube = self.near([low.cut(p) for p in self.p], TUBE)
            jacobian = self._jacobian(low)
            flow, error = _flow(jacobian, low)
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
        gain = ((growth - 1) / rate).upper() if rate > 0 else length
        spread = arb(0, (error * gain).upper())
        image = arb_mat([[f(length) + spread for f in row] for row in flow]) * self.basis
        self.basis = _orthogonal(image, self.box)
        back = self.basis.inv()
        added = arb_mat(n, 1, [arb(0, (defect * gain).upper())] * n)
        self.box = (back * image) * self.box + back * added
        self.end = [p(length) for p in self.p]

    def at(self, s: arb) -> list[arb]:
        """The state at local times."""
        return self.near([p(s) for p in self.p], self.reach)

    def state(self, time: arb) -> list[arb]:
        """The state at a time within the piece; ``Refused`` where it is not."""
        s = (time - self.time) / self.unit
        if not (s >= 0 and s <= self.length):
            raise Refused(f"t = {float(time):.6g} is not in one piece")
        return self.at(s)

    def motion(self, state: Sequence[Scalar]) -> Motion:
        vectors = state[: len(self.form.columns)]
        return self.form.motion(self.start.body, self.form.State(*vectors), Balls)

    def _taylor(self, start: Sequence[arb], power: int) -> list[arb_poly]:
        bits, finer = self.bits + 8, max(0, -_exponent(self.length))
        y = [PowerSeries(bits, [_fixed(x, bits)], lambda n: 0) for x in start]
        rates = self.rates(y)
        for n in range(self.order):
            for one, rate in zip(y, rates, strict=True):
                slope = rate.at(n) << max(power - finer, 0) >> max(finer - power, 0)
                one.c.append(slope // (n + 1))
        return [
            arb_poly([arb(fmpz(c)) * arb(2) ** (finer * n - bits) for n, c in enumerate(one.c)])
            for one in y
        ]

    def _jacobian(self, low: Room) -> list[list[Poly]]:
        """Derivatives of the rates; those of components that stay zero have to be zero."""
        one, zero, places = Poly(arb_poly([1]), low), Poly(arb_poly([]), low), self.free
        state = [
            Dual(y, [one if i == j else None for j in places]) for i, y in enumerate(self.tube)
        ]
        rates = self.rates(state)
        moves = [p.length() or rate.value.p.length() for p, rate in zip(self.p, rates, strict=True)]
        if any(length for i, length in enumerate(moves) if i not in places):
            raise Refused("a component does not stay zero")
        rows = (rates[i].by for i in places)
        return [[zero if d is None else d * self.unit for d in row] for row in rows]


def _fixed(x: arb, bits: int) -> int:
    return int((x.mid() * arb(2) ** bits).mid().floor().unique_fmpz())


def _exponent(x: arb) -> int:
    """The power of two next above a number."""
    mantissa, exponent = x.man_exp()
    return int(exponent) + int(mantissa).bit_length()


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
