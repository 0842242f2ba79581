"""One number of the body, the clock or the equations, fitted until the rows' residuals vanish.

Residuals are smooth in every number, so that Gauss-Newton steps converge. Only the few numbers are
fitted whose derivative has the direction of the residual. A number is named only if its fitted
value brings every residual within its own bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy

from tt_precise.check.conventions import LIMITS, Fit, Given, fit
from tt_precise.check.force_free import differences, norm
from tt_precise.check.force_free_flow import (
    NO_TERMS,
    Terms,
    Way,
    axis_of,
    by_guidance,
    by_interpolation,
    interpolate,
    lift_of,
    momentum_at_contact,
    nutation,
    torque_unit,
)
from tt_precise.check.result import Cause
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import cross
from tt_precise.runtime.values import Array

ROWS = 160  # Rows from which a number is fitted.
RELATIVE_CHANGE = 1e-5  # Change of a number for its derivative.
ITERATIONS = 8  # Steps of Gauss and Newton.
TRIED = 5  # Numbers that are fitted, the best aligned first.
FALLS = 0.9  # Part of the square of the residual that a step may leave.
FAR = 1e-3  # Step of a number from which on its derivative is computed again.
ALIGNED = 0.3  # Cosine between residual and derivative below which a number explains nothing.
CLOSE = 1.5  # rad of nutation from row to row above which the guided flow is needed.
WEIGHT = 30.0  # Of lift and height among the residuals that are fitted.
AHEAD = 1.5  # Times that the next best number has to leave more.
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
        "drag": f"the velocity is damped at {p:.3g} 1/s",
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


def residuals_of(motion: TrialMotion, unit: float) -> Array:
    """Return residuals of rows, without the ends, as one vector; smooth in every number.

    Torques are in the ``unit`` (N m), which no number changes.
    """
    rows = motion.given.rows(motion.body)
    Q, h = momentum_at_contact(motion.body, rows), numpy.diff(rows.t)
    if float(nutation(motion.body, rows).max()) > CLOSE:
        ends = by_guidance(motion.body, rows, motion.terms).best
    else:
        (ends,) = by_interpolation(motion.body, rows, (Way(6, True),), motion.terms)
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
    """A number, its change, how the rows then fit, and the size of what ``residuals_of`` leaves."""

    name: str
    p: float
    fit: Fit
    left: float


def fitted(
    body: Parameters,
    given: Given,
    half: Mapping[str, float],
    again: Callable[[Parameters], Given] | None = None,
) -> list[Fitted]:
    """Return the numbers that explain some of the residual.

    ``again`` reads the columns for another body where their convention needs one.
    """
    start, unit = TrialMotion(body, given), torque_unit(body)

    def at(name: str, p: float) -> TrialMotion:
        motion = NUMBERS[name](start, p)
        if again and motion.body != body:
            motion = motion._replace(given=again(motion.body))
        return motion

    def slope_at(name: str, p: float, here: Array) -> Array:
        return (residuals_of(at(name, p + RELATIVE_CHANGE), unit) - here) / RELATIVE_CHANGE

    here = residuals_of(start, unit)
    size = float(numpy.sqrt(here @ here)) or 1.0
    along = []
    numbers = [n for n in NUMBERS if not (given.vectors and n == FROM_CENTRE)]
    for name in numbers:
        slope = slope_at(name, 0.0, here)
        steep = float(numpy.sqrt(slope @ slope)) or 1.0
        along.append((abs(float(here @ slope)) / steep / size, name, slope))
    found = []
    for cosine, name, slope in sorted(along, key=lambda one: -one[0])[:TRIED]:
        if not cosine > ALIGNED:
            continue
        p, left = 0.0, here
        lifted = alpha_by_lift(body, given) if name == "alpha" and given.v is not None else 0.0
        if lifted and not given.vectors:
            p, left = lifted, residuals_of(at(name, lifted), unit)
            slope = slope_at(name, p, left)
        for _ in range(ITERATIONS):
            step = float(left @ slope) / (float(slope @ slope) or 1.0)
            p -= step
            if not possible(name, p):
                break
            before, left = left, residuals_of(at(name, p), unit)
            if not float(left @ left) < FALLS * float(before @ before) or abs(step) < LARGE:
                break
            slope = slope_at(name, p, left) if abs(step) > FAR else slope
        if possible(name, p):
            motion = at(name, p)
            fits = fit(motion.body, motion.given, half, motion.terms)
            if "torque" in fits.parts:
                fits.parts["torque"] *= torque_unit(motion.body) / unit
            found.append(Fitted(name, p, fits, float(norm(left))))
    return found


def possible(name: str, p: float) -> bool:
    """Test a change: of one and a half at most, and no number of the body but alpha becomes 0."""
    return abs(p) < 1.5 and (p > -1 or name not in BODY or name == "alpha")


def alpha_by_lift(body: Parameters, given: Given) -> float:
    """Return the relative change of alpha with which the contact point stays on the table."""
    rows = given.rows(body)
    swing = numpy.array(cross(tuple(rows.L), axis_of(rows.q)))[2] * body.R * body.alpha / body.I1
    return float(-(rows.v[2] @ swing) / ((swing @ swing) or numpy.nan)) - 1


# Lift and height up to which a number explains the rest: a soft contact leaves them.
SOFT = {"lift": 1e-4, "height": 1e-4}


def unheld_by(one: Fitted) -> tuple[str, ...]:
    """The residuals that say nothing of a number: their unit goes with it."""
    return ("torque",) if one.name.startswith("alpha") and abs(one.p + 1) < NONE else ()


def number(
    body: Parameters,
    given: Given,
    half: Mapping[str, float],
    again: Callable[[Parameters], Given] | None = None,
    verified: Callable[[Fitted], bool] = lambda one: True,
) -> list[Cause]:
    """Return the one number that explains the residuals, and equally good other numbers.

    ``verified`` tests a number by all checks.
    """
    found = fitted(body, given, half, again)
    as_given = fit(body, given, half).failing(LIMITS)
    soft = SOFT if as_given.keys() - SOFT.keys() else {}
    named = []
    for one in found:
        unheld = unheld_by(one)
        failing = {
            name: value
            for name, value in one.fit.failing(LIMITS).items()
            if name not in unheld and not value < soft.get(name, 0.0)
        }
        if abs(one.p + 1) < NONE and one.name in ("m", "R", "I1", "I3", "g"):
            continue
        # where alpha vanishes, so does the unit of the torque's bounds, not that of the axis
        resolved = not (one.fit.axis_open if "torque" in unheld else one.fit.open)
        if abs(one.p) > LARGE and resolved and not failing and verified(one):
            named.append(one)
    if not named:
        return []
    least = min(one.fit.remainder for one in named)
    equal = [one for one in named if one.fit.remainder <= AHEAD * least]
    # within their bounds all are equal: the right number leaves the error of the flow alone
    best = min(one.left for one in equal)
    tied = sorted((one for one in equal if one.left <= AHEAD * best), key=lambda one: one.left)
    causes = [in_words(one.name, one.p) for one in tied]
    text = ", or ".join(cause.text for cause in causes)
    return [Cause(causes[0].kind, text + ": these rows cannot tell" * (len(tied) > 1))]
