"""The spin at which the upright or the inverted top changes its stability, decided in fractions.

No formula of the paper is used. The equations of motion (``newton.rates``) are linearised about the
steady spin k = +-z, L = L z, v = 0 by dual numbers, and Hurwitz's determinants decide whether every
perturbation decays. Over the rational numbers both are exact: no sign depends on rounding, for a
top of any size.

Rotations about z commute with the equations, so the six horizontal components combine to three
complex components, kx + i ky, Lx + i Ly, vx + i vy, and the linearised system to a complex 3x3
matrix; kz and Lz change only at second order. Results are rounded once, into an mpmath context.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from gmpy2 import mpq
from mpmath import MPContext

from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Arithmetic, Functions, Ring, Scalar
from tt_precise.scene.body import TippeTop
from tt_precise.scene.numerals import to_mpmath

UPRIGHT, INVERTED = 1, -1
GUARD_DIGITS = 10  # Digits to which a marginal rate is determined beyond the requested ones.


def own_context(digits: int) -> Functions:
    """A new mpmath context of ``digits`` decimal digits; the global context does not change."""
    context = MPContext()
    context.dps = digits
    return context


def arithmetic_of(context: Functions) -> Arithmetic:
    """An mpmath context as an ``Arithmetic``."""
    return Arithmetic(context, rounding_to(context))


def rounding_to(context: Functions) -> Callable[[Fraction], Scalar]:
    """The function that rounds an exact number once into ``context``."""
    return lambda value: to_mpmath(value, context)


def agreed_digits(a: Scalar, b: Scalar, most: int, context: Functions) -> int:
    """Decimal digits on which ``a`` and ``b`` agree: -log10 |a - b|/max, at most ``most``.

    0 if they differ by more than their size, or one of them is infinite or NaN.
    """
    difference = abs(a - b)
    if difference == 0:
        return most
    relative = difference / max(abs(a), abs(b))
    if not relative < 1:
        return 0
    return min(most, int(context.floor(-context.log10(relative))))


def decimal(value: Scalar, digits: int, context: Functions) -> str:
    """``value`` as a decimal string of ``digits`` significant digits."""
    return context.nstr(value, digits, strip_zeros=False)


@dataclass(frozen=True)
class MarginalMomentum:
    """The marginal angular momentum L in kg m^2/s, or None with the reason."""

    momentum: Scalar = None
    reason: str = ""


class Tangent(Ring):
    """A number and its derivative by one variable."""

    def __init__(self, value: Scalar, derivative: Scalar = 0):
        self.value, self.derivative = value, derivative

    @classmethod
    def of(cls, number: Scalar) -> Tangent:
        """A dual number, or a constant as a dual number."""
        return number if isinstance(number, Tangent) else cls(number)

    def __add__(self, other: Scalar) -> Tangent:
        y = Tangent.of(other)
        return Tangent(self.value + y.value, self.derivative + y.derivative)

    def __neg__(self) -> Tangent:
        return Tangent(-self.value, -self.derivative)

    def __mul__(self, other: Scalar) -> Tangent:
        y = Tangent.of(other)
        derivative = self.derivative * y.value + self.value * y.derivative
        return Tangent(self.value * y.value, derivative)

    def __truediv__(self, other: Scalar) -> Tangent:
        y = Tangent.of(other)
        quotient = self.value / y.value
        return Tangent(quotient, (self.derivative - quotient * y.derivative) / y.value)

    def __rtruediv__(self, other: Scalar) -> Tangent:
        return Tangent.of(other) / self


class Complex(Ring):
    """A complex number with parts of any arithmetic."""

    def __init__(self, re: Scalar, im: Scalar):
        self.re, self.im = re, im

    def __add__(self, other: Complex) -> Complex:
        return Complex(self.re + other.re, self.im + other.im)

    def __neg__(self) -> Complex:
        return Complex(-self.re, -self.im)

    def __mul__(self, other: Complex) -> Complex:
        re = self.re * other.re - self.im * other.im
        return Complex(re, self.re * other.im + self.im * other.re)


Matrix = Sequence[Sequence[Complex]]


def linearised(body: Parameters, side: int, rate: Scalar) -> Matrix:
    """Complex 3x3 matrix of the horizontal perturbations of k = ``side`` z, L = I3 ``rate`` z.

    Rows and columns are kx + i ky, Lx + i Ly, vx + i vy in SI, in the arithmetic of the viscous
    ``body``; ``rate`` is the angular velocity about z in rad/s.
    """
    spin = NewtonState(0, 0, side, 0, 0, body.I3 * rate, 0, 0)
    columns = []
    for component in ("kx", "Lx", "vx"):
        derivatives = newton.rates(body, spin._replace(**{component: Tangent(0, 1)}))
        entry = {name: Tangent.of(x).derivative for name, x in derivatives._asdict().items()}
        columns.append([Complex(entry[f"{name}x"], entry[f"{name}y"]) for name in "kLv"])
    return list(zip(*columns, strict=True))


def hurwitz(matrix: Matrix) -> tuple[Scalar, Scalar, Scalar]:
    """Hurwitz's determinants of the characteristic polynomial of a complex 3x3 matrix.

    Every perturbation decays if and only if all three are positive (for complex coefficients:
    H. Bilharz, ZAMM 24, 1944; E. Frank, Bull. Amer. Math. Soc. 52, 1946). The third is zero where
    an eigenvalue is imaginary.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    minors = a * e - b * d + a * i - c * g + e * i - f * h
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    # s^3 + (p1 + i q1) s^2 + (p2 + i q2) s + p3 + i q3
    (p1, q1), (p2, q2), (p3, q3) = ((z.re, z.im) for z in (-(a + e + i), minors, -determinant))
    second = [[p1, p3, -q2], [1, p2, -q1], [0, q2, p1]]
    third = [
        [p1, p3, 0, -q2, 0],
        [1, p2, 0, -q1, -q3],
        [0, p1, p3, 0, -q2],
        [0, q2, 0, p1, p3],
        [0, q1, q3, 1, p2],
    ]
    return p1, _determinant(second), _determinant(third)


def _determinant(rows: list[list[Scalar]]) -> Scalar:
    """The determinant, expanded along the first row."""
    if not rows:
        return 1
    minors = ([row[:j] + row[j + 1 :] for row in rows[1:]] for j in range(len(rows)))
    terms = zip(rows[0], minors, strict=True)
    return sum((-1) ** j * x * _determinant(minor) for j, (x, minor) in enumerate(terms) if x)


def is_stable(matrix: Matrix) -> bool:
    """True if every perturbation decays."""
    return min(hurwitz(matrix)) > 0


def marginal_momentum(
    body: TippeTop, side: int, digits: int, context: Functions, mu: Fraction | None = None
) -> MarginalMomentum:
    """The angular momentum L at which the spin k = ``side`` z, L z changes its stability.

    ``mu`` is the friction (s/m, above 0) in the linearised equations; by default an auxiliary
    friction, whose drag is comparable with the inertia of the top. Stability is proved to differ
    on both sides of the result, ``digits`` digits from it.
    """
    top = body.numbers(mpq)
    comparable = top.I3 / (top.I3 + top.m * top.R**2) / top.g

    def matrix(rate: Scalar) -> Matrix:
        friction = rate * comparable if mu is None else mpq(mu)
        viscous = Parameters(top.m, top.R, top.alpha, top.I1, top.I3, top.g, friction)
        return linearised(viscous, side, rate)

    # rates are 2^n unit, with the unit between sqrt(g/R)/2 and 2 sqrt(g/R)
    ratio = body.g / body.R
    unit = mpq(2) ** ((ratio.numerator.bit_length() - ratio.denominator.bit_length()) // 2)
    decades = fineness(body, mu)
    low, high = -2 * decades, 2 * decades  # 16^n > 4 10^n covers the decades of omega_3^2
    slow, fast = (is_stable(matrix(unit * mpq(2) ** n)) for n in (low, high))
    if slow == fast:
        verb = "decay" if slow else "grow"
        reason = f"perturbations {verb} at every omega_3^2 R/g from 1e-{decades} to 1e{decades}"
        return MarginalMomentum(None, reason)
    while high - low > 1:
        middle = (low + high) // 2
        if is_stable(matrix(unit * mpq(2) ** middle)) == slow:
            low = middle
        else:
            high = middle
    near, far = unit * mpq(2) ** low, unit * mpq(2) ** high
    width = mpq(10) ** -(digits + GUARD_DIGITS)
    rate = _zero(lambda x: hurwitz(matrix(x))[2], near, far, near * width / 100)
    if [is_stable(matrix(rate * (1 + x))) for x in (-width, width)] != [slow, fast]:
        raise ArithmeticError(f"no change of stability at {float(rate):.6g} rad/s")
    momentum = Fraction(*map(int, (top.I3 * rate).as_integer_ratio()))
    return MarginalMomentum(rounding_to(context)(momentum))


def _zero(f: Callable[[Scalar], Scalar], a: Scalar, b: Scalar, grid: Scalar) -> Scalar:
    """The zero of ``f`` between a and b to within ``grid``, by the Illinois rule.

    Each iterate is rounded to a multiple of ``grid``, so that its digits do not double.
    """
    f_a, f_b, before = f(a), f(b), b
    while True:
        x = grid * int((a * f_b - b * f_a) / (f_b - f_a) / grid)
        f_x = f(x)
        if f_x == 0 or abs(x - before) <= grid:
            return x
        if f_x * f_b < 0:
            a, f_a = b, f_b
        else:
            f_a /= 2
        b, f_b, before = x, f_x, x


def fineness(body: TippeTop, mu: Fraction | None = None) -> int:
    """A bound on the decades between a threshold and its unit, from the body's fractions alone.

    A threshold has differences such as 1 - alpha, up to the fourth power. Each is zero or at least
    one over its denominator, so the bound also counts the digits that cancel in it.
    """
    inertia = body.I3 / (body.m * body.R**2)
    sizes = [inertia, body.gamma, *[Fraction(1, body.alpha.denominator)] * 5]
    if mu is not None:
        sizes.append(mu**2 * body.g * body.R)
    bits = sum(size.numerator.bit_length() + size.denominator.bit_length() - 2 for size in sizes)
    return int(bits * 0.30103) + 4
