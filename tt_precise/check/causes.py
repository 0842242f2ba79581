"""The single change of the scene that explains a residual: fits of one parameter at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy

from tt_precise.check.columns import Block, Samples
from tt_precise.runtime.values import Array

NUDGE = 1e-4  # of the free parameter, for the slope
STEPS = 6  # of Newton's method with the first slope
ALIGNED = 0.5  # cosine between residual and slope from which on a parameter is worth the steps
FARTHEST = 5.0  # factor by which a parameter may be off
NEAR = 0.02  # to a factor that has a name

GYROSCOPIC = "the gyroscopic term"
FREE = ("I1", "I3", "alpha", "g", "m", "mu")
NAMED = {
    (GYROSCOPIC, 0): "no gyroscopic term",
    ("alpha", 0): "the centre of mass at the centre of the sphere",
    ("mu", -1): "friction of the other sign",
}

Residual = Callable[[Samples], Array]


def cause(
    residual: Residual,
    rows: Samples,
    most: float,
    gyroscopic: Callable[[float], Array] | None = None,
) -> str:
    """The change that explains the ``residual`` (entries, intervals) of ``rows``; "" if none does.

    ``most`` is the part of the residual that a fit may leave; ``gyroscopic`` makes it with so many
    times the gyroscopic term.
    """
    body = rows.setup.body
    block = Block({**rows.given, "t": rows.t})

    def changed(name: str) -> Callable[[float], Array]:
        def at(factor: float) -> Array:
            other = replace(body, **{name: factor * getattr(body, name)})
            return residual(replace(rows.setup, assumed=other).samples(block))

        return at

    with numpy.errstate(all="ignore"):
        here = residual(rows)
        sizes = abs(here).max(axis=0)
        least = most * sizes.max(initial=0.0)
        if numpy.median(sizes) < least:
            return ""  # a few wrong rows, not another top
        at = {name: changed(name) for name in FREE}
        if gyroscopic:
            at[GYROSCOPIC] = gyroscopic
        slopes = {
            name: (residual_at(1.0 + NUDGE) - here) / NUDGE for name, residual_at in at.items()
        }
        along = {
            name: float(abs(numpy.vdot(here, slope)) / math.sqrt(numpy.vdot(slope, slope) or 1.0))
            for name, slope in slopes.items()
        }
        for name in sorted(at, key=along.__getitem__, reverse=True):
            if not along[name] > ALIGNED * math.sqrt(numpy.vdot(here, here)):
                continue
            factor, left = _fitted(at[name], slopes[name], here)
            words = _words(name, factor)
            if left < least and words:
                return f"fits to {left:.0e} with {words}"
    return ""


def _words(free: str, factor: float) -> str:
    nearest = round(factor) if abs(factor) < FARTHEST else 2
    if abs(factor - nearest) < NEAR and (free, nearest) in NAMED:
        return NAMED[free, nearest]
    return f"{free} {factor:.4g} times the scene's" if 1 / FARTHEST < factor < FARTHEST else ""


def _fitted(at: Callable[[float], Array], slope: Array, here: Array) -> tuple[float, float]:
    """The factor that minimises the residual, and the remaining residual."""
    factor = 1.0
    for _ in range(STEPS):
        step = float(numpy.vdot(here, slope) / numpy.vdot(slope, slope))
        factor -= step
        if not abs(factor) < 10 * FARTHEST:
            return factor, math.inf
        here = at(factor)
        if abs(step) < NUDGE**2:
            break
    return factor, float(abs(here).max())
