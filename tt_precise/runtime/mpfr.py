"""NumPy arrays of MPFR's numbers, for rows of mpmath numbers.

A sum or product of two arrays costs a quarter of the same in mpmath, and has the same bits: both
libraries round correctly, to the same precision. Arrays are read within ``Mpfr.precision()``, which
holds for one thread.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

from tt_precise.runtime.values import Array, Functions, Scalar

HYPOT_BITS = 4
EXACT_BITS = 2200  # Bits from the largest double's first to the smallest one's last.


def mpfr_of(context: Functions) -> Mpfr:
    """Arrays with the present precision of an mpmath context."""
    return _mpfr(context, context.prec)


@lru_cache(maxsize=64)
def _mpfr(context: Functions, bits: int) -> Mpfr:
    return Mpfr(context)


class Mpfr:
    """Arrays of numbers with the precision of an mpmath ``context``, and gmpy2's functions of them.

    Arrays hold Python objects; undefined values are NaN or infinite. ``nint`` is the nearest whole
    number.
    """

    def __init__(self, context: Functions):
        import gmpy2  # here, so that to import this file costs nothing
        from mpmath.libmp import from_man_exp

        self.context, self.bits = context, int(context.prec)
        self._gmpy2, self._from_man_exp = gmpy2, from_man_exp

    def __getattr__(self, name: str) -> Callable[[Scalar], Scalar]:
        """The function ``name`` of one argument, such as ``sqrt`` or ``sin``."""
        return _elementwise({"nint": "rint"}.get(name, name), 1)

    def precision(self) -> Any:
        """A context in which sums, products and functions are rounded to this precision."""
        return self._gmpy2.context(precision=self.bits)

    def number(self, value: Scalar) -> Scalar:
        """A number from mpmath (which may have more bits) or Python; NaN for None."""
        if not hasattr(value, "_mpf_"):
            return self._gmpy2.mpfr("nan" if value is None else value, self.bits)
        sign, mantissa, exponent, length = value._mpf_
        if not mantissa:
            return self._gmpy2.mpfr(float(value), self.bits)  # zero, an infinity, or NaN
        number = self._gmpy2.mpfr(-mantissa if sign else mantissa, max(length, self.bits))
        return self._gmpy2.set_exp(number, exponent + length)

    def back(self, value: Scalar) -> Scalar | None:
        """The number in mpmath; None for NaN."""
        if not self._gmpy2.is_finite(value):
            return None
        mantissa, exponent = value.as_mantissa_exp()
        return self.context.make_mpf(self._from_man_exp(int(mantissa), int(exponent)))

    def array(self, values: Iterable[Scalar]) -> Array:
        """mpmath numbers as an array."""
        return _array(list(map(self.number, values)))

    def of_fractions(self, values: Iterable[Fraction | str]) -> Array:
        """Exact numbers, also decimals as text, each rounded once."""
        return _array([self._gmpy2.mpfr(self._gmpy2.mpq(value), self.bits) for value in values])

    def from_limbs(self, limbs: Array) -> Array:
        """Return the exact sums of doubles: an array of numbers from axes (number, limb)."""
        rows = limbs.tolist()
        with self._gmpy2.context(precision=self.bits) as rounded:
            sums = list(map(self._gmpy2.fsum, rows))
        if rounded.inexact:  # bits far behind the others; mpmath takes them into the next operation
            with self._gmpy2.context(precision=EXACT_BITS):
                exact = map(self._gmpy2.fsum, rows)
                sums = [x if x == y else y for x, y in zip(sums, exact, strict=True)]
        return _array(sums)

    def to_limbs(self, values: Array, count: int) -> Array:
        """Return each number as a sum of doubles, each nearest to the rest: axes (number, limb)."""
        import numpy

        doubles = []
        with self.precision():
            for _ in range(count):
                doubles.append(values.astype(float))
                values = values - doubles[-1]
        return numpy.stack(doubles, axis=1)

    def texts(self, values: Iterable[Scalar], digits: int) -> list[str | None]:
        """Decimals with the given digits; None for NaN."""
        numbers = map(self.back, values)
        return [None if x is None else decimal_text(x, digits) for x in numbers]

    def hypot(self, x: Scalar, y: Scalar) -> Scalar:
        """Square root of the sum of squares, truncated first as in mpmath."""
        with self._gmpy2.context(precision=self.bits + HYPOT_BITS, round=self._gmpy2.RoundToZero):
            square = _elementwise("fmma", 4)(x, x, y, y)
        return self.sqrt(square)

    def atan2(self, y: Scalar, x: Scalar) -> Scalar:
        """Angle of (x, y), also whole numbers, from mpmath's function, twice as fast as MPFR's."""
        import numpy

        def angle(y: Scalar, x: Scalar) -> Scalar:
            above, right = (self.back(self._gmpy2.mpfr(1) * z) for z in (y, x))
            if above is None or right is None:
                return y * x * 0  # not a number
            return self.number(self.context.atan2(above, right))

        return numpy.frompyfunc(angle, 2, 1)(y, x)


def decimal_text(number: Scalar, digits: int) -> str:
    """Return an mpmath number as a decimal with so many significant digits."""
    return str(number.context.nstr(number, digits, min_fixed=0, max_fixed=0))


@cache
def _elementwise(name: str, arguments: int) -> Callable[..., Scalar]:
    import gmpy2
    import numpy

    return numpy.frompyfunc(getattr(gmpy2, name), arguments, 1)


def _array(values: Sequence[Scalar]) -> Array:
    import numpy

    array = numpy.empty(len(values), dtype=object)
    array[:] = values
    return array
