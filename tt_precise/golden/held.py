"""Rows of golden tables of which every number surely meets its enclosure, many at once.

``proof_checks`` asks that of each number, in intervals. Here it is seen from one number inside the
enclosure, in arrays: where that rounds to what is printed, the two meet. Rows that are not as
plain as that are left to the intervals: empty cells, axes that are vertical, numbers whose
enclosure only touches them, and all that is damaged.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from functools import cache

from tt_precise.golden.digits import DIGITS, PRINTED, ZERO
from tt_precise.golden.enclosures import LABELS, Enclosures
from tt_precise.golden.outward import FIGURES
from tt_precise.golden.store import TRAJECTORY
from tt_precise.golden.tails import BEYOND, STORED, last_place
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.mpfr import Mpfr, mpfr_of

STORED_DIGITS = re.compile(rf"\d{{{STORED}}}", re.ASCII)
MODULUS = 10**STORED
PRINTED_DIGITS = STORED - BEYOND
# In units of the last stored digit: half a unit of the last printed one, and the reach of an
# enclosure. What is printed as 0 has to be inside it.
MOST_APART, REACH = 10**BEYOND // 2 + 1, 1
OUT_OF_REACH = MODULUS
LAST_PLACES = range(-250, 250)  # of printed digits whose units are doubles, and those behind them
NEARLY = 1 - 1e-9  # of half a unit of the last printed digit, which is computed in double
NEARLY_ONE = 0.999, 1.001  # a square of the axis that intervals take for 1
GUARD_BITS = 40


def surely_held(enclosures: Enclosures, file: str) -> Array:
    """For each row of the golden ``file`` that has enclosures, whether all its numbers meet them.

    Where it is false, intervals have to say.
    """
    import numpy

    printed, stored = enclosures.stored.table(file), enclosures.table(file)
    rows, wide = min(len(printed.rows), len(stored.rows)), _wide()
    _, *names = stored.columns
    if not {*names} <= {*printed.columns} or not {*NewtonState._fields[:6]} <= {*names}:
        return numpy.zeros(rows, bool)

    def column(name: str) -> _Column:
        return _Column(printed.column(name)[:rows], enclosures.scales[name])

    sure = numpy.ones(rows, bool)
    inside: dict[str, Array] = {}
    with wide.precision():
        for name in names:
            own = column(name)
            apart = own.apart(stored.column(name)[:rows])
            sure &= abs(apart) <= numpy.where(own.zero, REACH, MOST_APART)
            inside[name] = own.numbers(wide) + apart * own.units
        state = NewtonState(*(inside.get(name, 0) for name in NewtonState._fields))
        square = dot(state.k, state.k).astype(float)
        sure &= (square > NEARLY_ONE[0]) & (square < NEARLY_ONE[1])
        sure &= ~(column("kx").zero & column("ky").zero)
        euler = _euler(enclosures, state, wide)
        for name in printed.columns:
            if name in LABELS or name in inside or (name == "t" and file == TRAJECTORY):
                continue
            own = column(name)
            derived = getattr(euler, name, 0)  # what is neither stored nor derived is zero
            off = abs(derived - own.numbers(wide)).astype(float)
            sure &= own.plain & (off <= NEARLY * own.halves)
    return sure


def _euler(enclosures: Enclosures, state: NewtonState, wide: Mpfr) -> EulerState:
    def exact(number: Fraction) -> Scalar:
        return wide.of_fractions([number])[0]

    return euler_from_vectors(enclosures.stored.scene.body.numbers(exact), state, wide)


class _Column:
    """Printed numbers of a column with this scale.

    ``plain`` says which of them are written as golden data are, ``zero`` which are 0. ``units`` are
    those of the last digit that is stored of each, ``halves`` what rounding to the printed digits
    may have taken from it; both in double.
    """

    def __init__(self, cells: Sequence[str], scale: Decimal):
        import numpy

        plain = [PRINTED.fullmatch(cell) is not None for cell in cells]
        places = [
            last_place(cell, scale) if good else 0 for cell, good in zip(cells, plain, strict=True)
        ]
        plain = [good and place in LAST_PLACES for good, place in zip(plain, places, strict=True)]
        self._cells = [cell if good else ZERO for cell, good in zip(cells, plain, strict=True)]
        self.plain = numpy.array(plain, bool)
        self.zero = numpy.array([cell == ZERO for cell in self._cells], bool)
        last = 10.0 ** numpy.where(self.plain, places, 0)
        self.units = last / 10**BEYOND
        self.halves = numpy.where(self.zero, float(scale) / 10.0**DIGITS, last / 2)

    def numbers(self, wide: Mpfr) -> Array:
        """The printed numbers; 0 for what is not plain."""
        return wide.of_texts(self._cells)

    def apart(self, tails: Sequence[str]) -> Array:
        """By how many ``units`` what is stored is larger; far away where it is not plain."""
        import numpy

        found = []
        for cell, tail, good in zip(self._cells, tails, self.plain.tolist(), strict=True):
            if not (good and STORED_DIGITS.fullmatch(tail)):
                found.append(OUT_OF_REACH)
                continue
            mantissa, _, _ = cell.partition("e")
            last = int(mantissa.lstrip("-").replace(".", "")[-PRINTED_DIGITS:]) * 10**BEYOND
            near = -last if cell[0] == "-" else last
            found.append((int(tail) - near + MODULUS // 2) % MODULUS - MODULUS // 2)
        return numpy.array(found, numpy.int64)


@cache
def _wide() -> Mpfr:
    import mpmath

    context = mpmath.MPContext()
    context.dps = FIGURES
    context.prec += GUARD_BITS
    return mpfr_of(context)
