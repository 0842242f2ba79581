"""Working precisions: heyoka's number types, and exact passage to and from mpmath.

A number for heyoka is computed in mpmath with guard bits and converted once, as a decimal string
for the types wider than double; a number from heyoka is converted exactly.
"""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any, NamedTuple

import mpmath

from tt_precise.runtime.mpfr import Mpfr, mpfr_of
from tt_precise.runtime.values import (
    Arithmetic,
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


class Kind(NamedTuple):
    """The properties of an arithmetic: its bits, and the number of doubles in its numbers.

    ``steps`` is the number of heyoka's steps between two tests for Ctrl-C, 0.2 s or more; in
    software arithmetic Python may run between any two. ``coarse`` and ``rough`` are tolerances in
    eps: above ``coarse`` one reference run in the same arithmetic shows the errors, between the two
    limits two reference runs.
    """

    bits: int
    doubles: int = 0
    steps: int = 0
    in_software: bool = False
    coarse: int = 64
    rough: int = 64


# A reference run in the same arithmetic has the same rounding errors, so the run must be coarser,
# that its truncation outweighs them. Double has a finer arithmetic for ten times its price;
# extended has none below 150 times. Two and three doubles hold 106 and 159 bits, of which their
# sums and products leave these.
KINDS = {
    "double": Kind(53, steps=20_000, coarse=400, rough=1000), "extended": Kind(64, steps=2_000),
    "double-double": Kind(104, doubles=2), "quad": Kind(113, steps=200, in_software=True),
    "triple-double": Kind(155, doubles=3), "mp": Kind(200, steps=200, in_software=True),
}  # fmt: skip


@dataclass(frozen=True)
class Precision:
    """A precision: ``double``, ``extended``, ``quad`` or ``mp`` with its bits, all of heyoka.

    ``double-double`` and ``triple-double`` are precisions of ``taylor``; outside ``taylor`` their
    numbers are mpmath's.
    """

    name: str
    bits: int

    def __reduce__(self) -> tuple[type, tuple[str, int]]:
        # its context can be neither copied nor pickled
        return Precision, (self.name, self.bits)

    @property
    def fp_type(self) -> type:
        """heyoka's type of number."""
        import heyoka

        if self.name == "extended":
            import numpy

            return numpy.longdouble
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
    def in_software(self) -> bool:
        """True if its numbers are computed in software."""
        return self.kind.in_software

    @property
    def is_float(self) -> bool:
        """True if its numbers are Python's floats."""
        return self.bits == 53 and not self.doubles

    @property
    def in_long_double(self) -> bool:
        """True if NumPy's long double holds its numbers exactly."""
        return self.bits <= 64 and not self.in_software and has_long_double()

    @property
    def context(self) -> Functions:
        """An mpmath context with ``GUARD_BITS`` more than this precision, not to be changed.

        Each thread has its own context, because mpmath's functions change precision temporarily.
        """
        return _context(self.bits, threading.get_ident())

    @property
    def mpfr(self) -> Mpfr:
        """Arrays of numbers with the precision of ``context``."""
        return mpfr_of(self.context)

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
        if self.name == "mp":
            return lambda value: kind(context.nstr(value, digits), self.bits)
        return lambda value: kind(context.nstr(value, digits))

    def opposite_neighbour(self, value: Scalar) -> Scalar:
        """The neighbour, on the other side of an mpmath number, of the number to which it rounds.

        The exact value lies between the two. A value of this precision stays unchanged.
        """
        parts = 1 if self.is_float else self.doubles
        if parts:
            near, left = self.context.mpf(0), value
            for _ in range(parts - 1):
                near, left = near + float(left), left - float(left)
            last = float(left)
            towards = math.inf if last < left else -math.inf
            return value if last == left else near + math.nextafter(last, towards)
        rounded = self.with_guard_bits(self.number(value))
        if rounded == value:
            return value
        _, exponent = self.context.frexp(rounded)
        gap = self.context.ldexp(1, exponent - self.bits)
        return rounded + gap if rounded < value else rounded - gap

    @property
    def with_guard_bits(self) -> Callable[[Scalar], Scalar]:
        """The function that converts a number of heyoka's type to the equal mpmath number."""
        context, bits = self.context, self.bits
        if self.is_float:
            return lambda value: context.mpf(float(value))
        if self.doubles:
            return lambda value: value
        return lambda value: _read_back(str(value), bits, context)

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

    def carrying(self, value: Scalar, error: Callable[[], Scalar | None]) -> Scalar:
        """An mpmath number that prints as ``with_error``; results of operations print as usual.

        ``error`` is called when the number is printed.
        """
        if not hasattr(value, "_mpf_"):
            return value
        carried: Any = object.__new__(_printing_type(self, self.context))
        carried._mpf_, carried.error = value._mpf_, error
        return carried


@lru_cache(maxsize=64)
def _printing_type(precision: Precision, context: Functions) -> type:
    def text(number: Any) -> str:
        return precision.with_error(number, number.error())

    return type("mpf", (context.mpf,), {"__str__": text, "__repr__": text})


def precision_named(name: str, bits: int | None = None) -> Precision:
    """The precision called ``name``; ``bits`` only for ``mp``.

    Raises ``InputError``: unknown name, bits for a type that has its own, or ``extended`` on a
    machine without 80-bit floats.
    """
    require_name("precision", name, KINDS)
    number = KINDS[name].bits
    if bits is not None and name != "mp":
        got = shortened(bits)
        raise InputError(f"bits: got {got} with precision {name}, expected bits only with mp")
    if bits is not None:
        number = whole_number(bits, "bits", FEWEST_BITS, MOST_BITS)
    if not is_available(name):
        raise InputError(f"precision: got {name} on a machine without it, expected quad or mp")
    return Precision(name, number)


def is_available(name: str) -> bool:
    """Return whether this machine has the precision called ``name``."""
    return name != "extended" or _has_80_bit_floats()


def finer(precision: Precision) -> Precision:
    """The arithmetic of the reference run for a result in ``precision``."""
    if precision.name == "double" and _has_80_bit_floats():
        return precision_named("extended")
    if precision.name == "double-double":
        return precision_named("triple-double")
    if precision.name in ("double", "extended"):
        return precision_named("quad")
    return precision_named("mp", precision.bits + 24)


@lru_cache(maxsize=64)  # making one takes as long as a tenth of the reference run in double
def _context(bits: int, thread: int) -> Functions:
    context = mpmath.MPContext()
    context.prec = bits + GUARD_BITS
    return context


@cache
def has_long_double() -> bool:
    """Return whether NumPy's long double has the 64 bits of an extended number here."""
    import numpy

    return bool(numpy.finfo(numpy.longdouble).nmant >= 63)


@cache
def _has_80_bit_floats() -> bool:
    import numpy

    return sys.platform != "win32" and numpy.finfo(numpy.longdouble).nmant == 63


def _read_back(text: str, bits: int, context: Functions) -> Scalar:
    # a number is printed with enough digits to recover it, by rounding to its own bits
    if "nan" in text:  # a quotient of zeros has a sign
        return context.nan
    return context.make_mpf(mpmath.libmp.from_str(text, bits, "n"))
