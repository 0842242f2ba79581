"""Columns that leave the scene's solution while the others follow it: which, since when, how.

Every column that a state determines is compared with the solution at the rows' times. A few that
are off by far more than the rest are wrong by themselves if the rows pass every check, under the
scene's equations, once the solution stands in their place. A motion that is wrong as a whole leaves
the solution in all columns, and nothing is said of it here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy

from tt_precise.check.agreement import DERIVED, sizes_of_derived
from tt_precise.check.columns import COLUMN_SETS, Block, Samples
from tt_precise.check.equations import APART
from tt_precise.check.fitting import factor
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Array, Check

# Times what else is left from which on a wrong column or row stands out; at 15 and at 60 the same
# causes are named of nineteen files with wrong columns or rows.
OUTSTANDING = 30.0
KNOWN = 1e-12  # Error of the solution, relative to the sizes of the rule of digits.
FAR_FROM_ONE = 0.5  # Distance of a factor from 1 from which on it is printed with six digits.
# Part by which a factor may differ from a sign, or from a unit; half and double name the same.
SAME_FACTOR = 1e-6
# Columns that can stand in each other's place.
ALIKE = ("kx ky kz", "Lx Ly Lz", "vx vy", "wx wy wz", "vcx vcy vcz", "nu_x nu_y",
         "theta_dot phi_dot omega_3 psi_dot")  # fmt: skip


class Departure(NamedTuple):
    """Columns that leave the solution: in words, and each with its factor, None where none is.

    ``throughout`` says that they are off from the first rows on, as another convention is.
    """

    text: str
    throughout: bool
    factors: dict[str, float | None]


class _Wrong(NamedTuple):
    """A wrong column: how it differs, in words, its factor, and the rows in which it does.

    ``instead`` is the column of the solution that it holds, with its sign; "" for its own.
    """

    how: str
    factor: float | None
    first: int
    last: int
    instead: str = ""


def departure_of(
    rows: Samples, solution: Array, judge: Callable[[Samples], list[Check]]
) -> Departure | None:
    """Return the columns that leave the solution, None if all do, or none.

    ``solution`` has its vectors (8, rows) at the rows' times; ``judge`` makes all checks.
    """
    vectors = dict(zip(NewtonState._fields, solution, strict=True))
    setup = replace(rows.setup, friction="scene", columns=COLUMN_SETS["vectors"])
    truth = setup.samples(Block({"t": rows.t, **vectors}))
    given = {name: values for name, values in rows.given.items() if name in DERIVED}
    derived = {name: DERIVED[name](truth) for name in given}
    if "qw" in rows.given:  # the attitude, as far as the vectors determine it
        given |= {f"q: {name}": getattr(rows.state, name) for name in ("kx", "ky", "kz")}
        derived |= {f"q: {name}": vectors[name] for name in ("kx", "ky", "kz")}
    sizes = sizes_of_derived(truth, {name: derived[name] for name in given if name in DERIVED})
    off = {
        name: _beyond(rows, name, values - derived[name]) / sizes.get(name, 1.0)
        for name, values in given.items()
        if name in sizes or name not in DERIVED
    }
    worst = {name: float(numpy.fmax.reduce(values, initial=KNOWN)) for name, values in off.items()}
    names = sorted(worst, key=lambda name: -worst[name])
    gaps = [worst[one] / worst[other] for one, other in itertools.pairwise(names)]
    count = 1 + int(numpy.argmax(gaps)) if gaps else 0
    apart = count > 0 and gaps[count - 1] > OUTSTANDING and worst[names[count]] < APART
    if not apart:  # all are off: each may be another column
        count = len(names)
    rest = worst[names[count]] if apart else SAME_FACTOR
    allowed = math.sqrt(OUTSTANDING) * rest
    wrong = [name for name in names[:count] if worst[name] > allowed]
    if not wrong or any(name not in sizes for name in wrong):
        return None
    found = {
        name: _difference(name, given[name], derived, sizes[name], off[name] > allowed, allowed)
        for name in sorted(wrong, key=[*given].index)
    }
    if 2 * len(wrong) > len(names) and any(one.factor is None for one in found.values()):
        return None
    repaired = {name: derived[name] for name in wrong}
    own = rows.changed(repaired, replace(rows.setup, friction="scene"))
    if any(one.verdict == "fail" for one in judge(own)):
        return None
    said = _in_words(rows.t, found)
    if apart:
        said.append(f"every other column is right to {math.floor(-math.log10(rest))} digits")
    throughout = all(one.first <= 1 and one.last == len(rows.t) - 1 for one in found.values())
    factors = {name: one.factor for name, one in found.items()}
    return Departure("; ".join(said), throughout, factors)


def _beyond(rows: Samples, name: str, difference: Array) -> Array:
    """Differences beyond half a unit of the last place; angles but for whole turns."""
    if name == "phi":
        difference = (difference + math.pi) % (2 * math.pi) - math.pi
    written = rows.resolution.get(name, rows.resolution.get("qw", 0.0))
    return numpy.maximum(abs(difference) - 2 * written, 0.0)


def _difference(
    name: str, given: Array, derived: Mapping[str, Array], size: Array, wrong: Array, allowed: float
) -> _Wrong:
    """Say how a column differs from the solution's where it is ``wrong``.

    It is a multiple of it, off by a constant, late by a row, or another column, if then no more is
    left than ``allowed``.
    """
    at = numpy.flatnonzero(wrong)
    first, last = int(at[0]), int(at[-1])
    part = slice(first, last + 1)
    true = derived[name]

    def explains(other: Array, unit: float = 1.0) -> bool:
        left = abs(given - other)[part] / (unit * numpy.broadcast_to(size, given.shape)[part])
        return bool(numpy.fmax.reduce(left) <= allowed)

    x, y = numpy.nan_to_num(true[part]), numpy.nan_to_num(given[part])
    ratio = float(x @ y) / (float(x @ x) or math.nan)
    if explains(ratio * true, max(abs(ratio), 1.0)):
        if abs(ratio + 1) < SAME_FACTOR:
            return _Wrong("the other sign", -1.0, first, last)
        times = (
            factor(float(f"{ratio - 1:.6e}")) if abs(ratio - 1) < FAR_FROM_ONE else f"{ratio:.6g}"
        )
        return _Wrong(f"{times} times the solution's", ratio, first, last)
    offset = float((y - x).mean())
    if explains(true + offset):
        return _Wrong(f"{offset:.3g} above the solution's", None, first, last)
    for other in next((group.split() for group in ALIKE if name in group.split()), []):
        for sign, word in ((1, ""), (-1, "-")):
            if other != name and other in derived and explains(sign * derived[other]):
                return _Wrong("the solution's", float(sign), first, last, f"{word}{other}")
    for shift, word in ((1, "before"), (-1, "after")):
        moved = numpy.roll(true, shift)
        moved[0 if shift > 0 else -1] = given[0 if shift > 0 else -1]
        if explains(moved):
            return _Wrong(f"the solution's of the row {word}", 1.0, first, last)
    return _Wrong("wrong", None, first, last)


def _in_words(t: Array, found: Mapping[str, _Wrong]) -> list[str]:
    """Return a clause for the columns that differ alike, and since when."""
    alike: dict[tuple[str, str], list[str]] = {}
    for name, one in found.items():
        since, until = t[one.first], t[one.last]
        if one.last < len(t) - 1:
            when = f"in the row at t = {since:.6g} s (number {one.first + 1}) alone "
            if one.last > one.first:
                when = f"from t = {since:.6g} to {until:.6g} s "
        else:
            when = f"from t = {since:.6g} s on " if one.first > 1 else ""
        alike.setdefault((when, one.how), []).append(name)
    clauses = []
    for (when, how), names in alike.items():
        many = len(names) > 1
        verb = ("have" if many else "has") if how == "the other sign" else "are" if many else "is"
        instead = ", ".join(filter(None, (found[name].instead for name in names)))
        clauses.append(f"{when}{', '.join(names)} {verb} {how} {instead}".rstrip())
    return clauses
