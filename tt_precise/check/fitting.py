"""One number of the body, the clock or the equations, fitted until the rows' residuals vanish.

Residuals are smooth in every number, so that Gauss-Newton steps converge. Only the few numbers are
fitted whose derivative has the direction of the residual. A number is named only if its fitted
value brings every residual within its own bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy

from tt_precise.check.conventions import LIMITS, Given, fit
from tt_precise.check.force_free import differences, norm
from tt_precise.check.force_free_flow import (
    NO_TERMS,
    Terms,
    Way,
    axis_of,
    by_guidance,
    by_interpolation,
    by_law,
    interpolate,
    lift_of,
    momentum_at_contact,
    nutation,
    torque_unit,
)
from tt_precise.check.movement import CLEAR
from tt_precise.check.result import Cause
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Array

# At half and at double of each the same causes are named of eleven files: other m, I1, g and alpha,
# clocks off by 1e-4 to 5e-2, an engine's centre of mass, two faults (``AHEAD`` has to be above 1).
ROWS = 160  # Rows from which a number is fitted.
RELATIVE_CHANGE = 1e-5  # Change of a number for its derivative.
ITERATIONS = 8  # Steps of Gauss and Newton.
TRIED = 5  # Numbers that are fitted, the best aligned first.
FALLS = 0.9  # Part of the square of the residual that a step may leave.
FAR = 1e-3  # Step of a number from which on its derivative is computed again.
ALIGNED = 0.3  # Cosine between residual and derivative below which a number explains nothing.
WEIGHT = 30.0  # Weight of lift and height among the residuals that are fitted.
AHEAD = 1.5  # Factor by which the next best number has to leave more.
NONE = 0.02  # Part of a number that counts as none of it.
LARGE = 1e-9  # Change of a number that is none.


class TrialMotion(NamedTuple):
    """The effect of a number: the body, the rows, the terms of the equations."""

    body: Parameters
    given: Given
    terms: Terms = NO_TERMS


FROM_CENTRE = "alpha, of states of the sphere's centre"
Change = Callable[[TrialMotion, float], TrialMotion]


def _body(name: str) -> Change:
    def change(motion: TrialMotion, p: float) -> TrialMotion:
        body = motion.body
        return motion._replace(body=replace(body, **{name: (1 + p) * getattr(body, name)}))

    return change


def _term(name: str) -> Change:
    return lambda motion, p: motion._replace(terms=motion.terms._replace(**{name: p}))


def _drag(motion: TrialMotion, p: float) -> TrialMotion:
    """Damp both velocities alike, as Bullet and Jolt do by default: none damps v alone."""
    return motion._replace(terms=motion.terms._replace(damping=p, drag=p))


def _clock(motion: TrialMotion, p: float) -> TrialMotion:
    return motion._replace(given=motion.given._replace(t=(1 + p) * motion.given.t))


def _late(motion: TrialMotion, p: float) -> TrialMotion:
    given = motion.given
    v = None if given.v is None else _shifted(given.v, p)
    return motion._replace(given=given._replace(w=_shifted(given.w, p), v=v))


def _shifted(values: Array, p: float) -> Array:
    """Interpolate rows ``p`` rows later, through six rows."""
    rows = numpy.arange(float(values.shape[1]))
    still, at = numpy.zeros(len(rows) - 1), numpy.array([p, 1 + p])
    moved = interpolate(rows, values, Way(6, False), still, at)
    return numpy.append(moved[:, 0], moved[:, 1, -1:], axis=1)


def _alpha(motion: TrialMotion, p: float) -> TrialMotion:
    """Another alpha, where v and x were taken from the sphere's centre with the scene's."""
    body, given = motion.body, motion.given
    k = numpy.array(axis_of(given.q))
    apart = -p * body.R * body.alpha * k
    swing = numpy.cross(given.w, apart, axis=0)
    v = None if given.v is None else given.v + swing
    x = None if given.x is None else given.x + apart
    return TrialMotion(
        replace(body, alpha=(1 + p) * body.alpha), given._replace(v=v, x=x), motion.terms
    )


BODY = ("m", "R", "alpha", "I1", "I3", "g")
NUMBERS: dict[str, Change] = {
    **{name: _body(name) for name in BODY},
    FROM_CENTRE: _alpha,
    "clock": _clock,
    **{name: _term(name) for name in Terms._fields},
    "drag": _drag,
    "late": _late,
}


def in_words(name: str, p: float) -> Cause:
    """Return the cause that a number has changed by ``p``."""
    if name == "clock":
        return Cause("clock", f"t runs {factor(1 / (1 + p) - 1)} times as fast as the motion")
    if name == "late":
        late = "late" if p > 0 else "early"
        return Cause("clock", f"the velocities are {abs(p):.2g} rows {late}")
    texts = {
        "damping": f"the angular momentum is damped at {p:.3g} 1/s",
        "drag": f"the velocity and the angular momentum are damped at {p:.3g} 1/s",
        "torsion": f"a torque of {p:.3g} m g R alpha about the vertical, as torsional friction is",
        "gyroscopic": "no gyroscopic term"
        if abs(p - 1) < 0.02
        else f"the gyroscopic term is {factor(-p)} times what it should be",
    }
    if name in texts:
        return Cause("parameter", texts[name])
    if name.startswith("alpha") and abs(p + 1) < NONE:
        return Cause("parameter", "the centre of mass is at the centre of the sphere")
    return Cause("parameter", f"{name.split(',')[0]} is {factor(p)} times the scene's")


def factor(p: float) -> str:
    """Return 1 + p with two digits of p."""
    digits = max(1, 1 - math.floor(math.log10(abs(p)))) if p else 1
    return f"{1 + p:.{digits}f}"


def law_of(motion: TrialMotion) -> bool | None:
    """Return whether friction guides as Coulomb's; None where rows are close enough without."""
    rows = motion.given.rows(motion.body)
    if float(nutation(motion.body, rows).max()) <= CLEAR:
        return None
    return bool(by_guidance(motion.body, rows).viscous.mean() < 0.5)


def residuals_of(motion: TrialMotion, unit: float, law: bool | None) -> Array:
    """Return residuals of rows, without the ends, as one vector; smooth in every number.

    Torques are in the ``unit`` (N m), which no number changes; ``law`` is that of the rows as they
    are, see ``law_of``.
    """
    rows = motion.given.rows(motion.body)
    Q, h = momentum_at_contact(motion.body, rows), numpy.diff(rows.t)
    if law is None:
        (ends,) = by_interpolation(motion.body, rows, (Way(6, True),), motion.terms)
    else:
        ends = by_law(motion.body, rows, law, motion.terms)
    off = differences(motion.body, rows, Q, ends)[:-1]  # all but Jellett's integral
    off[4:7] *= torque_unit(motion.body) / unit / h
    if motion.given.vectors:
        off = off[1:]
    scale = motion.body.R * float(norm(rows.L)[0]) / motion.body.I1
    parts = [off[:, 3:-3].ravel(), WEIGHT * lift_of(motion.body, rows)[3:-3] / scale]
    if rows.x is not None:
        k = axis_of(rows.q)
        tall = 1 - motion.body.alpha * k[2]
        parts.append(WEIGHT * (rows.x[2] / motion.body.R - tall)[3:-3])
    return numpy.nan_to_num(numpy.concatenate(parts))


class Fitted(NamedTuple):
    """A number, its change, and the size of what is left of the residuals."""

    name: str
    p: float
    left: float


def fitted(numbers: Sequence[str], left_at: Callable[[str, float], Array]) -> list[Fitted]:
    """Return the numbers that explain some of the residual, that which leaves least of it first.

    ``left_at(name, p)`` is the residual with a number changed by ``p``.
    """
    here = left_at(numbers[0], 0.0)
    size = float(norm(here)) or 1.0

    def slope_at(name: str, p: float, here: Array) -> Array:
        return (left_at(name, p + RELATIVE_CHANGE) - here) / RELATIVE_CHANGE

    along = []
    for name in numbers:
        slope = slope_at(name, 0.0, here)
        along.append((abs(float(here @ slope)) / (float(norm(slope)) or 1.0) / size, name, slope))
    found = []
    for cosine, name, slope in sorted(along, key=lambda one: -one[0])[:TRIED]:
        if not cosine > ALIGNED:
            continue
        p, left = 0.0, here
        for _ in range(ITERATIONS):
            step = float(left @ slope) / (float(slope @ slope) or 1.0)
            p -= step
            if not possible(name, p):
                break
            before, left = left, left_at(name, p)
            if not float(left @ left) < FALLS * float(before @ before) or abs(step) < LARGE:
                break
            slope = slope_at(name, p, left) if abs(step) > FAR else slope
        none = abs(p + 1) < NONE and name in BODY and name != "alpha"
        if possible(name, p) and abs(p) > LARGE and not none:
            found.append(Fitted(name, p, float(norm(left))))
    return sorted(found, key=lambda one: one.left)


def possible(name: str, p: float) -> bool:
    """Test a change: of one and a half at most, and no number of the body but alpha becomes 0."""
    return abs(p) < 1.5 and (p > -1 or name not in BODY or name == "alpha")


# Lift and height up to which a number explains the rest: a soft contact leaves them.
SOFT = {"lift": 1e-4, "height": 1e-4}


def unheld_by(one: Fitted) -> tuple[str, ...]:
    """The residuals that say nothing of a number: their unit goes with it."""
    return ("torque",) if one.name.startswith("alpha") and abs(one.p + 1) < NONE else ()


def number(
    body: Parameters,
    given: Given,
    half: Mapping[str, float],
    verified: Callable[[Fitted], bool] = lambda one: True,
) -> list[Cause]:
    """Return the one number that explains the residuals, and equally good other numbers.

    ``verified`` tests a number by all checks.
    """
    start, unit = TrialMotion(body, given), torque_unit(body)
    law = law_of(start)

    def at(name: str, p: float) -> TrialMotion:
        return NUMBERS[name](start, p)

    numbers = [name for name in NUMBERS if not (given.vectors and name == FROM_CENTRE)]
    remainders: dict[str, float] = {}

    @cache
    def soft() -> Mapping[str, float]:
        failing = fit(body, given, half).failing(LIMITS)
        return SOFT if failing.keys() - SOFT.keys() else {}

    def holds(one: Fitted) -> bool:
        unheld, motion = unheld_by(one), at(one.name, one.p)
        found = fit(motion.body, motion.given, half, motion.terms)
        if "torque" in found.parts:
            found.parts["torque"] *= torque_unit(motion.body) / unit
        remainders[one.name] = found.remainder
        failing = {
            name: value
            for name, value in found.failing(LIMITS).items()
            if name not in unheld and not value < soft().get(name, 0.0)
        }
        # where alpha vanishes, so does the unit of the torque's bounds, not that of the axis
        resolved = not (found.axis_open if "torque" in unheld else found.open)
        return resolved and not failing and verified(one)

    tied = alike(fitted(numbers, lambda n, p: residuals_of(at(n, p), unit, law)), holds)
    least = min((remainders[one.name] for one in tied), default=0.0)
    return in_doubt([one for one in tied if remainders[one.name] <= AHEAD * least])


def alike(found: Sequence[Fitted], holds: Callable[[Fitted], bool]) -> list[Fitted]:
    """Return the numbers that hold and leave least.

    Within their bounds many may hold; the right one leaves the error of the flow alone.
    """
    tied: list[Fitted] = []
    for one in found:
        if tied and one.left > AHEAD * tied[0].left:
            break
        if holds(one):
            tied.append(one)
    return tied


def in_doubt(tied: Sequence[Fitted]) -> list[Cause]:
    """Return the cause that one of several numbers has changed; none without a number."""
    if not tied:
        return []
    causes = [in_words(one.name, one.p) for one in tied]
    text = ", or ".join(cause.text for cause in causes)
    return [Cause(causes[0].kind, text + ": these rows cannot tell" * (len(causes) > 1))]
