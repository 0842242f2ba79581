"""The first moment: the order to which a function of the state vanishes at t = 0, and its sign.

A ball around an exact zero shows neither that it is zero nor the sign next to it. But scenes start
from rational numbers: with t = tan(theta/2) every Taylor coefficient of a function along the
solution is (A(t) + r B(t))/C(t) with polynomials of rational coefficients. Here r is the square
root of the rational number v^2 + epsilon^2 (v^2) that regularised friction (Coulomb's) contains, B
is zero if there is none or it is rational. For a rational theta (or pi minus one) other than 0 t is
transcendental (Lindemann, 1882): exp(i theta) = (1 + i t)/(1 - i t) is. So the field Q(t) contains
no algebraic number but those of Q, not r, and a coefficient is zero if and only if A = B = 0, which
exact arithmetic decides; where it is not, balls of enough bits decide its sign. At theta = 0 or pi
sine and cosine are rational, and so is all but r.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import isqrt
from typing import Any

import flint
from flint import arb, fmpq, fmpq_poly

from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.certify.prover_problem import form_of
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.parameters import Units
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Ring, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Inclination, Scene
from tt_precise.scene.start import LIFTED, LiftedStart
from tt_precise.taylor.series import Series, SeriesFunctions, solution

MOST_ORDER = 6
MOST_BITS = 1 << 16


@dataclass(frozen=True)
class Onset:
    """F(t) = (c + O(t)) t^order as t comes down to 0, and ``sign`` is that of c."""

    order: int
    sign: int


class Exact(Ring):
    """An element (A(t) + r B(t))/C(t), r^2 = ``square``, of the field Q(t)[r]."""

    __slots__ = ("a", "b", "c", "square")

    def __init__(self, a: fmpq_poly, b: fmpq_poly, c: fmpq_poly, square: Fraction | None = None):
        common = a.gcd(b).gcd(c)
        scale = common * (c.leading_coefficient() / common.leading_coefficient())
        self.a, self.b, self.c, self.square = a // scale, b // scale, c // scale, square

    @classmethod
    def of(cls, number: Scalar) -> Exact:
        """A rational number, or the element itself."""
        if isinstance(number, Exact):
            return number
        return cls(_constant(Fraction(number)), fmpq_poly([]), fmpq_poly([1]))

    @classmethod
    def sine_cosine(cls) -> tuple[Exact, Exact]:
        """Those of theta."""
        zero, below = fmpq_poly([]), fmpq_poly([1, 0, 1])
        return cls(fmpq_poly([0, 2]), zero, below), cls(fmpq_poly([1, 0, -1]), zero, below)

    @property
    def is_zero(self) -> bool:
        return not self.a and not self.b

    def _root_squared(self, other: Exact) -> fmpq_poly:
        return _constant(self.square or other.square or Fraction(0))

    def __add__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        square = self.square or y.square
        return Exact(self.a * y.c + y.a * self.c, self.b * y.c + y.b * self.c, self.c * y.c, square)

    def __neg__(self) -> Exact:
        return Exact(-self.a, -self.b, self.c, self.square)

    def __mul__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        plain = self.a * y.a + self._root_squared(y) * self.b * y.b
        crossed = self.a * y.b + self.b * y.a
        return Exact(plain, crossed, self.c * y.c, self.square or y.square)

    def __truediv__(self, other: Scalar) -> Exact:
        y = Exact.of(other)
        norm = y.a * y.a - y._root_squared(y) * y.b * y.b
        if not norm:
            raise NotProved("onset", "an exact division by zero")
        return self * Exact(y.c * y.a, -y.c * y.b, norm, y.square)

    def __rtruediv__(self, other: Scalar) -> Exact:
        return Exact.of(other) / self

    def sqrt(self) -> Exact:
        """The square root of a rational number; of others ``NotProved`` is raised."""
        if self.b or self.a.degree() > 0 or self.c.degree() > 0 or self.a[0] < 0:
            raise NotProved("onset", "a root that is not that of a rational number")
        square = Fraction(int(self.a[0].p), int(self.a[0].q)) / int(self.c[0])
        root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
        if root * root == square:
            return Exact.of(root)
        return Exact(fmpq_poly([]), fmpq_poly([1]), fmpq_poly([1]), square)

    def sign(self, theta: Inclination) -> int:
        """The sign of a number that is not zero, at this inclination.

        Raises ``NotProved``: ``MOST_BITS`` do not show it.
        """
        bits = 128
        while bits <= MOST_BITS:
            with flint.ctx.workprec(bits):
                sine, cosine = theta.sine_cosine(Balls, ball)
                t = arb(0) if theta.at_pole else (1 - cosine) / sine
                above = _at(self.a, t) + ball(self.square or Fraction(0)).sqrt() * _at(self.b, t)
                value = above * _at(self.c, t)
            if value != 0:
                return 1 if value > 0 else -1
            bits *= 2
        raise NotProved("onset", f"a sign at t = 0 is undecided with {MOST_BITS} bits")


def _constant(number: Fraction) -> fmpq_poly:
    return fmpq_poly([fmpq(number.numerator, number.denominator)])


def _at(polynomial: fmpq_poly, x: arb) -> arb:
    value = arb(0)
    for coefficient in reversed(polynomial.coeffs()):
        value = value * x + arb(coefficient)
    return value


@lru_cache(maxsize=8)
def _motion(scene: Scene) -> Motion:
    """The scene's solution as power series with exact coefficients, SI."""
    form = form_of(scene)
    body, fn = scene.body.numbers(Fraction), SeriesFunctions(Balls)
    if scene.start.theta.at_pole:
        sine, cosine = Exact.of(0), Exact.of(-1 if scene.start.theta.from_pi else 1)
    else:
        sine, cosine = Exact.sine_cosine()
    given = {name: Exact.of(getattr(scene.start, name)) for name in EulerState._fields[1:]}
    euler = EulerState(theta=None, **given)
    vectors: Any = vectors_from_euler(body, euler, None, sine_cosine=(sine, cosine))
    if isinstance(scene.start, LiftedStart):
        vectors = LiftedState(*vectors, *(getattr(scene.start, name) for name in LIFTED))
    begins = InitialState(scene.model, body, Units(1, 1, 1), vectors, euler, Exact.of(0))
    if scene.body.spring:
        begins = begins.pressed_in(fn)
    state = [Exact.of(value) for value in begins.state(form)]
    series = solution(lambda y: form.rates(body, form.State(*y), fn), state)
    return form.motion(body, form.State(*series), fn)


def onset(scene: Scene, evaluate: Callable[[Motion], Scalar]) -> Onset | None:
    """How a function of the scene's ``Motion`` begins.

    None if its coefficients up to t^``MOST_ORDER`` are all zero, as they are where it vanishes
    identically.
    """
    result = evaluate(_motion(scene))
    for order in range(MOST_ORDER + 1):
        last = result[order] if isinstance(result, Series) else result
        coefficient = Exact.of(last)
        if not coefficient.is_zero:
            return Onset(order, coefficient.sign(scene.start.theta))
    return None
