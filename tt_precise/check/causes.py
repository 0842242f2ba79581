"""Which one change of the scene explains a residual: fits with one parameter free at a time."""

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
FREE = (GYROSCOPIC, "I1", "I3", "alpha", "g", "m", "mu")
NAMED = {
    (GYROSCOPIC, 0): "no gyroscopic term",
    ("alpha", 0): "the centre of mass at the centre of the sphere",
    ("mu", -1): "friction of the other sign",
}

Residual = Callable[[Samples, float], Array]
"""Residual (entries, intervals) of rows made with this many times the gyroscopic term."""


def cause(residual: Residual, rows: Samples, most: float) -> str:
    """The change that explains the residual of ``rows`` best, in words; "" if none does.

    ``most`` is the part of the residual that a fit may leave.
    """
    with numpy.errstate(all="ignore"):
        here = residual(rows, 1.0)
        sizes = abs(here).max(axis=0)
        least = most * sizes.max(initial=0.0)
        if numpy.median(sizes) < least:
            return ""  # a few wrong rows, not another top
        said = ""
        for free in FREE:
            factor, left = _fitted(free, residual, rows, here.ravel())
            words = _words(free, factor)
            if left < least and words:
                least, said = left, f"fits to {left:.0e} with {words}"
    return said


def _words(free: str, factor: float) -> str:
    nearest = round(factor) if abs(factor) < FARTHEST else 2
    if abs(factor - nearest) < NEAR and (free, nearest) in NAMED:
        return NAMED[free, nearest]
    return f"{free} {factor:.4g} times the scene's" if 1 / FARTHEST < factor < FARTHEST else ""


def _fitted(free: str, residual: Residual, rows: Samples, here: Array) -> tuple[float, float]:
    """The factor of the free parameter that leaves least of the residual, and what it leaves."""
    body = rows.setup.body

    def at(factor: float) -> Array:
        if free == GYROSCOPIC:
            return residual(rows, factor).ravel()
        setup = replace(rows.setup, assumed=replace(body, **{free: factor * getattr(body, free)}))
        block = Block({**rows.given, "t": rows.t})
        return residual(setup.samples(block), 1.0).ravel()

    slope = (at(1.0 + NUDGE) - here) / NUDGE
    size = float(slope @ slope)
    if not (here @ slope) ** 2 > ALIGNED**2 * size * (here @ here):
        return 1.0, math.inf
    factor = 1.0
    for _ in range(STEPS):
        step = float(here @ slope) / size
        factor -= step
        if not abs(factor) < 10 * FARTHEST:
            return factor, math.inf
        here = at(factor)
        if abs(step) < NUDGE**2:
            break
    return factor, float(abs(here).max())
