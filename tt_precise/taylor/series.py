"""Power series in any arithmetic, whose coefficients are computed when needed.

A ``TaylorSeries`` is a scalar of functions that are generic in the arithmetic. Each coefficient
follows from earlier coefficients, so equations of motion can run on the series of their own
solution (``solution``). Coefficients are numbers of any kind: doubles, NumPy arrays over many rows,
mpmath's or MPFR's numbers, heyoka's expressions, balls, or ``Sized`` numbers.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy

from tt_precise.runtime.values import Functions, Ring, Scalar


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    products = map(operator.mul, a, b)
    return sum(products, start=next(products))


def convolution(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    """Return the coefficients of the product of two series, as many as each has."""
    return [_dot(a[: k + 1], b[k::-1]) for k in range(len(a))]


class TaylorSeries(Ring):
    """``sum(s[k] h**k)``; ``step(c, k)`` gives coefficient k from the earlier coefficients c."""

    __slots__ = ("c", "step")
    __array_ufunc__ = None  # so that array * Series is left to Series
    c: Any

    def __init__(self, step: Callable[[Any, int], Scalar], first: Sequence[Scalar] = ()):
        self.step, self.c = step, list(first)

    def new(self, step: Callable[[Any, int], Scalar]) -> TaylorSeries:
        """The series of an operation on this series."""
        return TaylorSeries(step)

    def __getitem__(self, k: int) -> Scalar:
        while len(self.c) <= k:
            self.c.append(self.step(self.c, len(self.c)))
        return self.c[k]

    def upto(self, k: int) -> Any:
        """Coefficients 0 to ``k``, and all later known coefficients."""
        if len(self.c) <= k:
            _ = self[k]
        return self.c

    def __add__(self, other: Scalar) -> TaylorSeries:
        if isinstance(other, TaylorSeries):
            return self.new(lambda c, k: self[k] + other[k])
        return self.new(lambda c, k: self[k] if k else self[0] + other)

    def __neg__(self) -> TaylorSeries:
        return self.new(lambda c, k: -self[k])

    def __mul__(self, other: Scalar) -> TaylorSeries:
        if isinstance(other, TaylorSeries):
            return self.new(lambda c, k: _dot(self.upto(k)[: k + 1], other.upto(k)[k::-1]))
        return self.new(lambda c, k: self[k] * other)

    def __abs__(self) -> TaylorSeries:
        return self.new(lambda c, k: self[k] * numpy.sign(self[0]) if k else abs(self[0]))

    def __pow__(self, power: Scalar) -> Scalar:
        if isinstance(power, int) and power > 0:
            return functools.reduce(operator.mul, [self] * power)

        def step(c: list[Scalar], k: int) -> Scalar:
            # with f = s^p, f' s = p f s'
            if not k:
                return self[0] ** power
            terms = (((power + 1) * i - k) * self[i] * c[k - i] for i in range(1, k + 1))
            return sum(terms, start=self[0] * 0) / (k * self[0])

        return self.new(step)

    def __truediv__(self, other: Scalar) -> TaylorSeries:
        if not isinstance(other, TaylorSeries):
            return self.new(lambda c, k: self[k] / other)
        return self.new(
            lambda c, k: (self[k] - _dot(c, other.upto(k)[k:0:-1]) if k else self[0]) / other[0]
        )

    def __rtruediv__(self, other: Scalar) -> TaylorSeries:
        return self.new(lambda c, k: (-_dot(c, self.upto(k)[k:0:-1]) if k else other) / self[0])


def _of_series(function: Callable[..., Scalar]) -> Callable[..., Scalar]:
    """Leave plain numbers to the arithmetic's own function of the same name."""

    @functools.wraps(function)
    def of_series(self: SeriesFunctions, *arguments: Scalar) -> Scalar:
        if not any(isinstance(value, TaylorSeries) for value in arguments):
            return getattr(self.fn, function.__name__)(*arguments)
        return function(self, *map(_as_series, arguments))

    return of_series


def _as_series(value: Scalar) -> TaylorSeries:
    return value if isinstance(value, TaylorSeries) else constant(value)


class SeriesFunctions:
    """The functions of series whose coefficients have the functions ``fn``."""

    def __init__(self, fn: Functions):
        self.fn = fn
        if hasattr(fn, "hypot"):
            self.hypot = self._length

    def _length(self, x: Scalar, y: Scalar) -> Scalar:
        """Return the length of a plane vector that is not zero, without underflow of squares."""
        if not isinstance(x, TaylorSeries) and not isinstance(y, TaylorSeries):
            return self.fn.hypot(x, y)
        x, y = _as_series(x), _as_series(y)

        def step(c: list[Scalar], k: int) -> Scalar:
            if not k:
                return self.fn.hypot(x[0], y[0])
            # s^2 = x^2 + y^2, divided by the first coefficient of s
            squares = [
                _dot([a / c[0] for a in s[: k + 1]], s[k::-1]) for s in (x.upto(k), y.upto(k))
            ]
            inner = _dot([a / c[0] for a in c[1:]], c[:0:-1]) if k > 1 else 0
            return (sum(squares) - inner) / 2

        return TaylorSeries(step)

    @_of_series
    def sqrt(self, value: Scalar) -> Scalar:
        """The positive root; its first coefficient is not zero."""

        def step(c: list[Scalar], k: int) -> Scalar:
            if not k:
                return self.fn.sqrt(value[0])
            rest = value[k] - _dot(c[1:], c[:0:-1]) if k > 1 else value[k]
            return rest / (2 * c[0])

        return value.new(step)

    @_of_series
    def exp(self, value: Scalar) -> Scalar:
        """The exponential: e' = value' e."""

        def step(c: list[Scalar], k: int) -> Scalar:
            return _dot(_rate(value.upto(k)[: k + 1]), c[::-1]) / k

        return TaylorSeries(step, [self.fn.exp(value[0])])

    @_of_series
    def sin(self, angle: Scalar) -> Scalar:
        return self._sine_cosine(angle)[0]

    @_of_series
    def cos(self, angle: Scalar) -> Scalar:
        return self._sine_cosine(angle)[1]

    def _sine_cosine(self, angle: TaylorSeries) -> tuple[TaylorSeries, TaylorSeries]:
        def sine_step(c: list[Scalar], k: int) -> Scalar:
            return _dot(_rate(angle.upto(k)[: k + 1]), cosine.upto(k - 1)[k - 1 :: -1]) / k

        def cosine_step(c: list[Scalar], k: int) -> Scalar:
            return -_dot(_rate(angle.upto(k)[: k + 1]), sine.upto(k - 1)[k - 1 :: -1]) / k

        sine = TaylorSeries(sine_step, [self.fn.sin(angle[0])])
        cosine = TaylorSeries(cosine_step, [self.fn.cos(angle[0])])
        return sine, cosine

    @_of_series
    def log(self, value: Scalar) -> Scalar:
        """The natural logarithm: l' = value'/value."""
        slope = rate(value) / value
        return TaylorSeries(lambda c, k: slope[k - 1] / k, [self.fn.log(value[0])])

    def atan(self, value: Scalar) -> Scalar:
        """The angle between -pi/2 and pi/2 of which ``value`` is the tangent."""
        return self.atan2(value, 1)

    def tan(self, angle: Scalar) -> Scalar:
        return self.sin(angle) / self.cos(angle)

    def asin(self, value: Scalar) -> Scalar:
        """The angle between -pi/2 and pi/2 of which ``value``, between -1 and 1, is the sine."""
        return self.atan2(value, self.sqrt(1 - value * value))

    def acos(self, value: Scalar) -> Scalar:
        """The angle between 0 and pi of which ``value``, between -1 and 1, is the cosine."""
        return self.atan2(self.sqrt(1 - value * value), value)

    @_of_series
    def atan2(self, y: Scalar, x: Scalar) -> Scalar:
        """The angle of the point (x, y), which is not the origin."""
        slope = (x * rate(y) - y * rate(x)) / (x * x + y * y)
        return TaylorSeries(lambda c, k: slope[k - 1] / k, [self.fn.atan2(y[0], x[0])])


def constant(value: Scalar) -> TaylorSeries:
    """The series of a constant."""
    return TaylorSeries(lambda c, k: value * 0, [value])


def rate(series: TaylorSeries) -> TaylorSeries:
    """The series of the rate."""
    return TaylorSeries(lambda c, k: (k + 1) * series[k + 1])


def _rate(c: Sequence[Scalar]) -> list[Scalar]:
    return [k * coefficient for k, coefficient in enumerate(c) if k]


def solution(
    rates: Callable[[tuple[TaylorSeries, ...]], Sequence[Scalar]], start: Sequence[Scalar]
) -> tuple[TaylorSeries, ...]:
    """The series of the solution through ``start`` of y' = ``rates``(y), which is autonomous."""
    slopes: list[Scalar] = []

    def component(i: int, first: Scalar) -> TaylorSeries:
        def step(c: list[Scalar], k: int) -> Scalar:
            slope = slopes[i]
            if isinstance(slope, TaylorSeries):
                return slope[k - 1] / k
            return first * 0 + (slope if k == 1 else 0)

        return TaylorSeries(step, [first])

    components = tuple(component(i, first) for i, first in enumerate(start))
    slopes += rates(components)
    return components


class Sized(Ring):
    """A number or array, and the size of its summands.

    What relative errors of ``eps`` in those make of it is at most about ``eps * size``.
    """

    __slots__ = ("size", "value")

    def __init__(self, value: Scalar, size: Scalar):
        self.value, self.size = value, size

    def result(self, value: Scalar, size: Scalar) -> Self:
        """The result of an operation; what it makes of the operands' sizes is ``size``."""
        return type(self)(value, size)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Scalar, **options: Any) -> Self:
        """Apply NumPy's operations, and its functions of one argument by the slope of a secant."""
        if len(inputs) == 2 and ufunc.__name__ in OPERATIONS:
            a, b = (x if isinstance(x, Sized) else type(self)(x, abs(x)) for x in inputs)
            result: Self = OPERATIONS[ufunc.__name__](a, b)
            return result
        if len(inputs) != 1 or method != "__call__":
            raise TypeError(f"numpy.{ufunc.__name__} of several numbers")
        value, aside = ufunc(self.value), abs(self.value) * SECANT + (self.value == 0) * SECANT
        return self.result(value, self.size * abs(ufunc(self.value + aside) - value) / aside)

    def __add__(self, other: Scalar) -> Self:
        if isinstance(other, Sized):
            return self.result(self.value + other.value, self.size + other.size)
        return self.result(self.value + other, self.size + abs(other))

    def __neg__(self) -> Self:
        return type(self)(-self.value, self.size)

    def __abs__(self) -> Self:
        return type(self)(abs(self.value), self.size)

    def __mul__(self, other: Scalar) -> Self:
        if isinstance(other, Sized):
            size = abs(self.value) * other.size + self.size * abs(other.value)
            return self.result(self.value * other.value, size)
        return self.result(self.value * other, self.size * abs(other))

    def __truediv__(self, other: Scalar) -> Self:
        if isinstance(other, Sized):
            quotient = self.value / other.value
            size = (self.size + abs(quotient) * other.size) / abs(other.value)
            return self.result(quotient, size)
        return self.result(self.value / other, self.size / abs(other))

    def __rtruediv__(self, other: Scalar) -> Self:
        return type(self)(other, abs(other)) / self

    def __pow__(self, power: Scalar) -> Self:
        slope = power * self.value ** (power - 1)
        return self.result(self.value**power, self.size * abs(slope))


class Rounded(Sized):
    """A number or array with its error in roundings, to first order: Wilkinson's running errors.

    Where each operation has a relative rounding of u, the value is wrong by at most u times
    ``size``.
    """

    __slots__ = ()

    def result(self, value: Scalar, size: Scalar) -> Self:
        """The result of an operation, with its own rounding."""
        return type(self)(value, size + abs(value))


OPERATIONS = {
    "add": operator.add, "subtract": operator.sub, "multiply": operator.mul,
    "divide": operator.truediv,
}  # fmt: skip
SECANT = 2.0**-26  # distance of the points of a secant, relative to the argument


class SizedFunctions:
    """The functions of ``Sized`` doubles and arrays."""

    # by a secant, see ``Sized.__array_ufunc__``
    log, atan, tan = numpy.log, numpy.arctan, numpy.tan
    asin, acos = numpy.arcsin, numpy.arccos

    def sqrt(self, value: Scalar) -> Scalar:
        """The positive root."""
        return _propagate(numpy.sqrt, lambda x: [0.5 / numpy.sqrt(x)], value)

    def exp(self, value: Scalar) -> Scalar:
        return _propagate(numpy.exp, lambda x: [numpy.exp(x)], value)

    def sin(self, value: Scalar) -> Scalar:
        return _propagate(numpy.sin, lambda x: [numpy.cos(x)], value)

    def cos(self, value: Scalar) -> Scalar:
        return _propagate(numpy.cos, lambda x: [numpy.sin(x)], value)

    def hypot(self, x: Scalar, y: Scalar) -> Scalar:
        """The length of a plane vector, without underflow of squares."""
        return _propagate(numpy.hypot, lambda x, y: [c / numpy.hypot(x, y) for c in (x, y)], x, y)

    def atan2(self, y: Scalar, x: Scalar) -> Scalar:
        return _propagate(numpy.arctan2, lambda y, x: [c / (x * x + y * y) for c in (x, y)], y, x)


def _propagate(
    function: Callable[..., Scalar], slopes: Callable[..., list[Scalar]], *arguments: Scalar
) -> Scalar:
    """The function of numbers, of which some are ``Sized``; ``slopes`` are its partial ones."""
    numbers = [x.value if isinstance(x, Sized) else x for x in arguments]
    value, sized = function(*numbers), [x for x in arguments if isinstance(x, Sized)]
    if not sized:
        return value
    pairs = zip(arguments, slopes(*numbers), strict=True)
    terms = [x.size * abs(slope) for x, slope in pairs if isinstance(x, Sized)]
    return sized[0].result(value, sum(terms[1:], start=terms[0]))
