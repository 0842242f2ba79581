"""Bands: sets of functions of time around a polynomial, closed under arithmetic.

A band on [0, end] is a polynomial with balls as coefficients. It stands for every function g
with g(s) in {sum c_k s^k : c_k in the k-th ball} for each s in [0, end]: the coefficients may be
chosen anew at each s. Sums and products of bands contain the sums and products of their members.
A polynomial that has grown too long is cut, and the range of what was cut off goes into the
constant coefficient; so a band always contains the exact result, rounding and truncation included.

Unlike an ``arb_series``, a band bounds its functions on the whole interval, not only their
derivatives at 0, and therefore needs no estimate in the complex plane.
"""

from __future__ import annotations

from flint import arb, arb_poly, arb_series

from tt_precise.certify.balls import around, between, series_length
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar


class Frame:
    """What bands of one step share: the interval [0, end] and the largest degree."""

    __slots__ = ("beyond", "degree", "interval")

    def __init__(self, end: arb, degree: int):
        self.degree = degree
        self.interval = between(arb(0), end)
        self.beyond = around((end ** (degree + 1)).abs_upper())


class Band:
    """A band: ``polynomial`` (an ``arb_poly``) on the interval of ``frame``."""

    __slots__ = ("frame", "polynomial")

    def __init__(self, polynomial: arb_poly, frame: Frame):
        self.polynomial, self.frame = polynomial, frame

    @classmethod
    def cut(cls, polynomial: arb_poly, frame: Frame) -> Band:
        """The band of a polynomial of any length."""
        degree = frame.degree
        if polynomial.degree() > degree:
            tail = polynomial.right_shift(degree + 1)(frame.interval) * frame.beyond
            polynomial = polynomial.truncate(degree + 1) + tail
        return cls(polynomial, frame)

    @classmethod
    def of(cls, value: Scalar, frame: Frame) -> Band:
        """The band of a band, a polynomial or a constant."""
        if isinstance(value, Band):
            return value
        return cls(value if isinstance(value, arb_poly) else arb_poly([value]), frame)

    @property
    def range(self) -> arb:
        """A ball that contains all values on the interval."""
        return self.polynomial(self.frame.interval)

    def widened(self, radius: arb) -> Band:
        """The band with everything added that stays within ``radius`` of it."""
        return Band(self.polynomial + around(radius), self.frame)

    def __add__(self, other: Scalar) -> Band:
        if isinstance(other, Band):
            return Band(self.polynomial + other.polynomial, self.frame)
        return Band(self.polynomial + other, self.frame)

    __radd__ = __add__

    def __neg__(self) -> Band:
        return Band(-self.polynomial, self.frame)

    def __sub__(self, other: Scalar) -> Band:
        if isinstance(other, Band):
            return Band(self.polynomial - other.polynomial, self.frame)
        return Band(self.polynomial - other, self.frame)

    def __rsub__(self, other: Scalar) -> Band:
        return Band(other - self.polynomial, self.frame)

    def __mul__(self, other: Scalar) -> Band:
        if isinstance(other, Band):
            return Band.cut(self.polynomial * other.polynomial, self.frame)
        if isinstance(other, int | float) and other == 1:
            return self
        return Band(self.polynomial * other, self.frame)

    __rmul__ = __mul__

    def inverse(self) -> Band:
        """The band of 1/g.

        With a polynomial r close to 1/g and |1 - g r| <= e < 1, g has no zero and
        1/g = r/(1 - (1 - g r)) lies within e/(1 - e) of r, relatively.

        Raises
        ------
        NotProved
            g may have a zero.
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
        return Band(close * (1 + around(error / (1 - error))), self.frame)

    def sqrt(self) -> Band:
        """The band of the square root of g.

        With a positive polynomial r close to it and |g/r^2 - 1| <= e < 1, the root lies within
        e of r, relatively, since |sqrt(1 + x) - 1| <= |x| for |x| <= 1.

        Raises
        ------
        NotProved
            g may have a zero, or be negative.
        """
        terms = self.frame.degree + 1
        middle = arb_poly([c.mid() for c in self.polynomial.coeffs()])
        if not middle[0] > 0:
            raise NotProved("square root", "the argument may be zero at the start of the step")
        with series_length(terms):
            close = arb_poly([c.mid() for c in arb_series(middle, terms).sqrt().coeffs()])
        inverse = Band(close, self.frame).inverse()
        error = (self * inverse * inverse - 1).range.abs_upper()
        if not error < 1:
            raise NotProved("square root", "the argument may have a zero in the step or its tube")
        return Band(close * (1 + around(error)), self.frame)

    def __truediv__(self, other: Scalar) -> Band:
        if isinstance(other, Band):
            return self * other.inverse()
        return Band(self.polynomial * (1 / arb(other)), self.frame)

    def __rtruediv__(self, other: Scalar) -> Band:
        return self.inverse() * other
