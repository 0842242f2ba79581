"""Working precisions, and the arithmetics of arrays in which runs are read.

A number for an integrator is computed in mpmath with guard bits and rounded once; a number from an
integrator is converted exactly.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import numpy

from tt_precise.runtime.mpfr import Mpfr, mpfr_of
from tt_precise.runtime.values import (
    Arithmetic,
    Array,
    Functions,
    InputError,
    Scalar,
    require_name,
    shortened,
    whole_number,
)
from tt_precise.scene.numerals import to_mpmath

GUARD_BITS = 64  # Additional bits of mpmath, so that its rounding never shows.
FEWEST_BITS, MOST_BITS = 54, 20_000
LARGEST_EXACT = 2**53  # Integers up to this limit are doubles; their quotient is rounded once.


class Kind(NamedTuple):
    """Bits, number of doubles in a sum, heyoka's steps between two tests for Ctrl-C (0.2 s)."""

    bits: int
    doubles: int = 0
    steps: int = 0


# Two and three doubles hold 106 and 159 bits, of which their sums and products leave these.
KINDS = {
    "double": Kind(53, steps=20_000), "double-double": Kind(104, doubles=2),
    "quad": Kind(113, steps=200), "triple-double": Kind(155, doubles=3), "mp": Kind(200, steps=200),
}  # fmt: skip


class Hardware:
    """Arrays of doubles or long doubles; times are long doubles in both."""

    def __init__(self, kind: str):
        self.kind = kind

    @staticmethod
    def precision() -> AbstractContextManager[Any]:
        """Return the context in which arrays are read, without warnings of undefined values."""
        return numpy.errstate(all="ignore")

    def number(self, value: Scalar) -> Scalar:
        """Convert a number of mpmath or Python."""
        high = math.nan if value is None else float(value)
        if self.kind == "float64" or not math.isfinite(high):  # ln v at rest
            return high
        return numpy.longdouble(high) + numpy.longdouble(float(value - high))

    def array(self, values: Sequence[Scalar]) -> Array:
        """Convert numbers to an array."""
        return numpy.array([self.number(value) for value in values], dtype=self.kind)

    def of_fractions(self, values: Any) -> Array:
        """Convert exact times, or an array of doubles, to long doubles."""
        if isinstance(values, numpy.ndarray):
            return values.astype(numpy.longdouble)
        above, below = [t.numerator for t in values], [t.denominator for t in values]
        if max(map(abs, above + below), default=0) < LARGEST_EXACT:
            numerator, denominator = (numpy.array(x, dtype=float) for x in (above, below))
            return numerator.astype(numpy.longdouble) / denominator
        high = numpy.array([float(t) for t in values])
        low = [float(t - Fraction(x)) for t, x in zip(values, high.tolist(), strict=True)]
        return high + numpy.array(low, dtype=numpy.longdouble)

    def from_limbs(self, limbs: Array) -> Array:
        """Add up sums of doubles, along the last axis."""
        total: Array = limbs[..., ::-1].astype(numpy.longdouble).sum(axis=-1)
        return total.astype(self.kind)

    def to_limbs(self, times: Array, count: int) -> Array:
        """Return times as sums of doubles: axes (time, limb)."""
        high = times.astype(float)
        limbs = [high, (times - high).astype(float), *[0 * high] * (count - 2)]
        return numpy.stack(limbs, axis=1)


DOUBLES, LONG_DOUBLES = Hardware("float64"), Hardware("longdouble")
Numbers = Hardware | Mpfr  # arithmetics of arrays


def functions_of(numbers: Numbers) -> Functions:
    """Return the elementary functions of an arithmetic of arrays."""
    return numpy if isinstance(numbers, Hardware) else numbers


def times_in(numbers: Numbers, values: Sequence[Scalar]) -> Array:
    """Convert mpmath numbers to times in an arithmetic of arrays."""
    return (LONG_DOUBLES if isinstance(numbers, Hardware) else numbers).array(values)


@dataclass(frozen=True)
class Precision:
    """A precision by name: ``double``, ``quad`` and ``mp`` of heyoka, or a sum of doubles.

    Outside ``taylor`` the numbers of ``double-double`` and ``triple-double`` are mpmath's.
    """

    name: str
    bits: int

    @property
    def fp_type(self) -> type:
        """heyoka's type of number."""
        import heyoka

        return {"double": float, "quad": heyoka.real128, "mp": heyoka.real}[self.name]

    @property
    def kind(self) -> Kind:
        """The kind of arithmetic, without the bits."""
        return KINDS[self.name]

    @property
    def doubles(self) -> int:
        """The number of doubles in its numbers, for double-double and triple-double; else 0."""
        return self.kind.doubles

    @property
    def is_float(self) -> bool:
        """True if its numbers are Python's floats."""
        return self.name == "double"

    @property
    def context(self) -> Functions:
        """An mpmath context with ``GUARD_BITS`` more than this precision, one for each thread."""
        return _context(self.bits, threading.get_ident())

    @property
    def mpfr(self) -> Mpfr:
        """Arrays of numbers with the precision of ``context``."""
        return mpfr_of(self.context)

    @property
    def numbers(self) -> Numbers:
        """The arithmetic of arrays in which a run is read with guard bits."""
        return LONG_DOUBLES if self.is_float else self.mpfr

    @property
    def arithmetic(self) -> Arithmetic:
        """The arithmetic of mpmath numbers of this precision with guard bits."""
        return Arithmetic(self.context, self.exact)

    @property
    def eps(self) -> Scalar:
        """Distance from 1 to the next number, 2^(1 - bits), as an mpmath number."""
        return self.context.ldexp(1, 1 - self.bits)

    @property
    def decimals(self) -> int:
        """Significant decimals that distinguish any two numbers of this precision."""
        return int(self.bits * 0.30103) + 2

    def exact(self, value: Fraction) -> Scalar:
        """An exact number as an mpmath number with guard bits."""
        return to_mpmath(value, self.context)

    @property
    def number(self) -> Callable[[Scalar], Scalar]:
        """The function that rounds an mpmath number with guard bits to heyoka's type."""
        if self.is_float:
            return float
        if self.doubles:
            return lambda value: value
        kind, digits, context = self.fp_type, self.decimals + 15, self.context
        bits = (self.bits,) if self.name == "mp" else ()
        return lambda value: kind(context.nstr(value, digits), *bits)

    @property
    def with_guard_bits(self) -> Callable[[Scalar], Scalar]:
        """The function that converts a number of heyoka's type to the equal mpmath number."""
        context, bits = self.context, self.bits
        if self.is_float:
            return lambda value: context.mpf(float(value))

        def convert(value: Scalar) -> Scalar:
            text = str(value)  # with enough digits to recover the number, rounded to its bits
            if "nan" in text:  # a quotient of zeros has a sign
                return context.nan
            return context.make_mpf(mpmath.libmp.from_str(text, bits, "n"))

        return convert

    def to_user(self, value: Scalar | None) -> Scalar | None:
        """Return a float in double, else the mpmath number with guard bits."""
        return float(value) if self.is_float and value is not None else value

    def text(self, value: Scalar | None) -> Any:
        """A number in enough decimals to recover this precision; None stays None."""
        if value is None:
            return None
        number = self.context.mpf(value)
        return str(self.context.nstr(number, self.decimals, min_fixed=0, max_fixed=0))

    def with_error(self, value: Scalar, error: Scalar | None) -> str:
        """A number with the decimals that its error permits, and "+-" if the error is known."""
        context = self.context
        if value is None or value != value:
            return "undefined"
        if error is None:
            return self.text(value)
        value, error, places = context.mpf(value), context.mpf(error), self.decimals
        if value and error and context.isfinite(error):
            above = context.floor(context.log10(abs(value))) - context.floor(context.log10(error))
            places = min(places, max(1, 1 + int(above)))
        shown = context.nstr(value, places, strip_zeros=False).replace(".e", "e").rstrip(".")
        return f"{shown} +- {context.nstr(error, 2)}"


def precision_named(name: str, bits: int | None = None) -> Precision:
    """The precision called ``name``; ``bits`` only for ``mp``."""
    require_name("precision", name, KINDS)
    if bits is None:
        return Precision(name, KINDS[name].bits)
    if name != "mp":
        got = shortened(bits)
        raise InputError(f"bits: got {got} with precision {name}, expected bits only with mp")
    return Precision(name, whole_number(bits, "bits", FEWEST_BITS, MOST_BITS))


@lru_cache(maxsize=64)  # making one takes as long as a tenth of the reference run in double
def _context(bits: int, thread: int) -> Functions:
    context = mpmath.MPContext()
    context.prec = bits + GUARD_BITS
    return context
