"""Taylor models, and dual numbers over them or any other arithmetic.

A Taylor model on [0, end] is a polynomial with balls as coefficients. It stands for every function
g with g(s) in {sum c_k s^k : c_k in the k-th ball} for each s in [0, end]: the coefficients may be
chosen anew at each s. Sums and products of models contain the sums and products of their members.
A polynomial that has grown too long is cut, and the range of what was cut off goes into the
constant coefficient; so a model always contains the exact result, rounding and truncation included.

Unlike an ``arb_series``, a model bounds its functions on the whole interval, not only their
derivatives at 0, and therefore needs no estimate in the complex plane.

The power series of a solution (``taylor.series``) over models, whose members are values at each
time of a step, has as n-th coefficient the n-th derivative divided by n! at each of these times. A
``DualNumber`` carries first derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, arb_poly, arb_series

from tt_precise.certify.balls import NotProved, around, between, series_length
from tt_precise.runtime.values import Ring, Scalar


class Frame:
    """What models of one step share: the interval [0, end] and the largest degree."""

    __slots__ = ("beyond", "degree", "interval")

    def __init__(self, end: arb, degree: int):
        self.degree = degree
        self.interval = between(arb(0), end)
        self.beyond = around((end ** (degree + 1)).abs_upper())


class TaylorModel(Ring):
    """A Taylor model: ``polynomial`` (an ``arb_poly``) on the interval of ``frame``."""

    __slots__ = ("frame", "polynomial")

    def __init__(self, polynomial: arb_poly, frame: Frame):
        self.polynomial, self.frame = polynomial, frame

    @classmethod
    def cut(cls, polynomial: arb_poly, frame: Frame) -> TaylorModel:
        """The model of a polynomial of any length."""
        degree = frame.degree
        if polynomial.degree() > degree:
            tail = polynomial.right_shift(degree + 1)(frame.interval) * frame.beyond
            polynomial = polynomial.truncate(degree + 1) + tail
        return cls(polynomial, frame)

    @classmethod
    def of(cls, value: Scalar, frame: Frame) -> TaylorModel:
        """The model of a model, a polynomial or a constant."""
        if isinstance(value, TaylorModel):
            return value
        return cls(value if isinstance(value, arb_poly) else arb_poly([value]), frame)

    @property
    def range(self) -> arb:
        return self.polynomial(self.frame.interval)

    def widened(self, radius: arb) -> TaylorModel:
        """The model with everything added that stays within ``radius`` of it."""
        return TaylorModel(self.polynomial + around(radius), self.frame)

    def __add__(self, other: Scalar) -> TaylorModel:
        more = other.polynomial if isinstance(other, TaylorModel) else other
        return TaylorModel(self.polynomial + more, self.frame)

    def __neg__(self) -> TaylorModel:
        return TaylorModel(-self.polynomial, self.frame)

    def __mul__(self, other: Scalar) -> TaylorModel:
        if isinstance(other, TaylorModel):
            return TaylorModel.cut(self.polynomial * other.polynomial, self.frame)
        if isinstance(other, int | float) and other == 1:
            return self
        return TaylorModel(self.polynomial * other, self.frame)

    def inverse(self) -> TaylorModel:
        """The model of 1/g.

        With a polynomial r close to 1/g and |1 - g r| <= e < 1, g has no zero and
        1/g = r/(1 - (1 - g r)) lies within e/(1 - e) of r, relatively.

        Raises ``NotProved``: g may have a zero.
        """
        terms = self.frame.degree + 1
        middle = arb_poly([c.mid() for c in self.polynomial.coeffs()])
        if middle[0].contains(0):
            raise NotProved("division", "the divisor may be zero at the start of the step")
        with series_length(terms):
            close = arb_poly([c.mid() for c in (1 / arb_series(middle, terms)).coeffs()])
        error = (1 - self.polynomial * close)(self.frame.interval).abs_upper()
        if not error < 1:
            raise NotProved("division", "the divisor may have a zero in the step or its tube")
        return TaylorModel(close * (1 + around(error / (1 - error))), self.frame)

    def sqrt(self) -> TaylorModel:
        """The model of the square root of g.

        With a positive polynomial r close to it and |g/r^2 - 1| <= e < 1, the root lies within
        e of r, relatively, since |sqrt(1 + x) - 1| <= |x| for |x| <= 1.

        Raises ``NotProved``: g may have a zero, or be negative.
        """
        terms = self.frame.degree + 1
        middle = arb_poly([c.mid() for c in self.polynomial.coeffs()])
        if not middle[0] > 0:
            raise NotProved("square root", "the argument may be zero at the start of the step")
        with series_length(terms):
            close = arb_poly([c.mid() for c in arb_series(middle, terms).sqrt().coeffs()])
        inverse = TaylorModel(close, self.frame).inverse()
        error = (self * inverse * inverse - 1).range.abs_upper()
        if not error < 1:
            raise NotProved("square root", "the argument may have a zero in the step or its tube")
        return TaylorModel(close * (1 + around(error)), self.frame)

    def __truediv__(self, other: Scalar) -> TaylorModel:
        if isinstance(other, TaylorModel):
            return self * other.inverse()
        return TaylorModel(self.polynomial * (1 / arb(other)), self.frame)

    def __rtruediv__(self, other: Scalar) -> TaylorModel:
        return self.inverse() * other


class DualNumber(Ring):
    """A value and its partial derivatives, keyed by variable; absent ones are zero."""

    __slots__ = ("partials", "value")

    def __init__(self, value: Scalar, partials: dict[int, Scalar]):
        self.value, self.partials = value, partials

    def __add__(self, other: Scalar) -> DualNumber:
        if not isinstance(other, DualNumber):
            return DualNumber(self.value + other, self.partials)
        merged = dict(self.partials)
        for i, slope in other.partials.items():
            merged[i] = merged[i] + slope if i in merged else slope
        return DualNumber(self.value + other.value, merged)

    def __neg__(self) -> DualNumber:
        return DualNumber(-self.value, {i: -slope for i, slope in self.partials.items()})

    def __mul__(self, other: Scalar) -> DualNumber:
        if not isinstance(other, DualNumber):
            if isinstance(other, int | float) and other == 0:
                return DualNumber(self.value * 0, {})
            return DualNumber(self.value * other, {i: s * other for i, s in self.partials.items()})
        merged = {i: slope * other.value for i, slope in self.partials.items()}
        for i, slope in other.partials.items():
            term = self.value * slope
            merged[i] = merged[i] + term if i in merged else term
        return DualNumber(self.value * other.value, merged)

    def inverse(self) -> DualNumber:
        """1/value, with the derivatives -slope/value^2."""
        inverse = 1 / self.value
        outer = -(inverse * inverse)
        return DualNumber(inverse, {i: slope * outer for i, slope in self.partials.items()})

    def sqrt(self) -> DualNumber:
        """The square root, with the derivatives slope/(2 sqrt)."""
        root = self.value.sqrt()
        outer = 1 / (2 * root)
        return DualNumber(root, {i: slope * outer for i, slope in self.partials.items()})

    def __truediv__(self, other: Scalar) -> DualNumber:
        if isinstance(other, DualNumber):
            return self * other.inverse()
        # not times 1/other, which is rounded where other is an int
        return DualNumber(self.value / other, {i: s / other for i, s in self.partials.items()})

    def __rtruediv__(self, other: Scalar) -> DualNumber:
        return self.inverse() * other


def variables(values: Sequence[Scalar]) -> list[DualNumber]:
    """The values as independent variables, numbered from 0."""
    return [DualNumber(value, {i: 1}) for i, value in enumerate(values)]
