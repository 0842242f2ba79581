"""The first moment: the order to which a function of the state vanishes at t = 0, and its sign.

A ball around an exact zero shows neither whether it is zero nor the sign beside it. But scenes
start from rational numbers: with s = sin theta and c = cos theta every Taylor coefficient of a
function along the solution (rational in body, state and time) is a rational function of c and s
with rational coefficients. Modulo s^2 + c^2 = 1 it is A(c) + s B(c) over C(c). For a rational
theta (or pi minus one) other than 0, c is transcendental (Lindemann, 1882), and so is
A^2 - (1 - c^2) B^2 unless it is the zero polynomial, which A = B = 0 alone makes it, 1 - c^2 being
no square. So a coefficient is zero if and only if A = B = 0, which exact arithmetic decides; and
where it is not, balls of enough bits decide its sign. At theta = 0 or pi all is rational anyway.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import flint
from flint import arb, fmpq, fmpq_poly

from tt_precise.arithmetic import Scalar
from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.jets import Jet, taylor
from tt_precise.certify.verdict import NotProved
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene import Inclination, Scene

MOST_ORDER = 6
MOST_BITS = 1 << 16
_SINE_SQUARED = fmpq_poly([1, 0, -1])


@dataclass(frozen=True)
class Onset:
    """F(t) = (c + O(t)) t^order as t comes down to 0, and ``sign`` is that of c."""

    order: int
    sign: int


class Exact:
    """An element (A(c) + s B(c))/C(c) of the field Q(c, s), s^2 + c^2 = 1."""

    __slots__ = ("a", "b", "c")

    def __init__(self, a: fmpq_poly, b: fmpq_poly, c: fmpq_poly):
        common = a.gcd(b).gcd(c)
        scale = common * (c.leading_coefficient() / common.leading_coefficient())
        self.a, self.b, self.c = a // scale, b // scale, c // scale

    @classmethod
    def of(cls, number: Scalar) -> Exact:
        """A rational number, or the element itself."""
        if isinstance(number, Exact):
            return number
        value = Fraction(number)
        one = fmpq_poly([fmpq(value.numerator, value.denominator)])
        return cls(one, fmpq_poly([]), fmpq_poly([1]))

    @property
    def is_zero(self) -> bool:
        return not self.a and not self.b

    def __add__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        return Exact(self.a * y.c + y.a * self.c, self.b * y.c + y.b * self.c, self.c * y.c)

    __radd__ = __add__

    def __neg__(self) -> Exact:
        return Exact(-self.a, -self.b, self.c)

    def __sub__(self, other: Scalar) -> Exact:
        return self + (-Exact.of(other))

    def __rsub__(self, other: Scalar) -> Exact:
        return -self + other

    def __mul__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        plain = self.a * y.a + _SINE_SQUARED * self.b * y.b
        return Exact(plain, self.a * y.b + self.b * y.a, self.c * y.c)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        norm = y.a * y.a - _SINE_SQUARED * y.b * y.b
        if not norm:
            raise NotProved("onset", "an exact division by zero")
        return self * Exact(y.c * y.a, -y.c * y.b, norm)

    def __rtruediv__(self, other: Scalar) -> Exact:
        return Exact.of(other) / self

    def sign(self, theta: Inclination) -> int:
        """The sign of a number that is not zero, at this inclination."""
        bits = 128
        while bits <= MOST_BITS:
            with flint.ctx.workprec(bits):
                sine, cosine = theta.sine_cosine(Balls, ball)
                above = _at(self.a, cosine) + sine * _at(self.b, cosine)
                value = above * _at(self.c, cosine)
            if value > 0 or value < 0:
                return 1 if value > 0 else -1
            bits *= 2
        raise NotProved("onset", f"a sign at t = 0 is undecided with {MOST_BITS} bits")


def _at(polynomial: fmpq_poly, x: arb) -> arb:
    found = arb(0)
    for coefficient in reversed(polynomial.coeffs()):
        found = found * x + arb(coefficient)
    return found


@lru_cache(maxsize=8)
def _solution(scene: Scene, order: int) -> tuple[Scalar, tuple[Jet, ...]]:
    """The body (SI, exact) and the Taylor series of the scene's solution."""
    form = formulation(scene.model, "newton")
    body = scene.body.numbers(Fraction)
    if scene.start.theta.at_pole:
        sine, cosine = Exact.of(0), Exact.of(-1 if scene.start.theta.from_pi else 1)
    else:
        sine = Exact(fmpq_poly([]), fmpq_poly([1]), fmpq_poly([1]))
        cosine = Exact(fmpq_poly([0, 1]), fmpq_poly([]), fmpq_poly([1]))
    start = {name: getattr(scene.start, name) for name in EulerState._fields[1:]}
    euler = EulerState(theta=None, **{name: Exact.of(value) for name, value in start.items()})
    vectors = vectors_from_euler(body, euler, None, sine_cosine=(sine, cosine))
    state = [Exact.of(value) for value in vectors[: len(form.columns)]]
    return body, tuple(taylor(lambda y: form.rates(body, form.State(*y), None), state, order))


def onset(scene: Scene, evaluate: Callable[[Motion], Scalar]) -> Onset | None:
    """How a function of the scene's ``Motion`` begins.

    None if its first ``MOST_ORDER`` coefficients are all zero, as they are where it vanishes
    identically.
    """
    form = formulation(scene.model, "newton")
    for order in range(MOST_ORDER + 1):
        body, series = _solution(scene, order)
        found = evaluate(form.motion(body, form.State(*series), None))
        last = found.coefficients[order] if isinstance(found, Jet) else found
        coefficient = Exact.of(last)
        if not coefficient.is_zero:
            return Onset(order, coefficient.sign(scene.start.theta))
    return None
