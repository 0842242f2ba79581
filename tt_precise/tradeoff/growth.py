"""The growth of rounding in long runs: errors of lambda and E against Brouwer's square-root law.

Without truncation, each step changes an integral by a rounding error. If the signs of these errors
are practically random, the sum of n errors grows as sqrt(n), so as t^(1/2) (D. Brouwer, Astron. J.
46, 1937). A systematic part grows as t.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy

from tt_precise.runtime.values import Array

if TYPE_CHECKING:
    import pandas

# The scenes and integrals of the long runs.
SCENES = ("frictionless", "rolling")
INTEGRALS_SHOWN = ("jellett", "energy")


class Exponent(NamedTuple):
    """The exponent of rms error ~ t^exponent, and its standard error over the seeds."""

    exponent: float
    error: float
    seeds: int
    rms_at_end: float


def exponent(rows: pandas.DataFrame, scene: str, integral: str, until_s: float) -> Exponent:
    """The growth of one integral's error up to ``until_s``, over all seeds that reach it.

    The slope of log rms (over the seeds) against log t by least squares; its standard error from
    leaving out one seed after the other (the jackknife), as the points of one run are correlated.
    """
    mine = rows[(rows["scene"] == scene) & (rows["t_s"] <= until_s * 1.001)]
    errors = mine.pivot(index="seed", columns="t_s", values=integral).dropna().to_numpy()
    times, seeds = numpy.unique(mine["t_s"]), len(errors)

    def steepness(chosen: Array) -> float:
        rms = numpy.sqrt((chosen**2).mean(axis=0))
        return slope(times, numpy.maximum(rms, 1e-20))

    others = numpy.array([steepness(numpy.delete(errors, i, axis=0)) for i in range(seeds)])
    spread = math.sqrt((seeds - 1) / seeds * float(((others - others.mean()) ** 2).sum()))
    rms_at_end = float(numpy.sqrt((errors[:, -1] ** 2).mean()))
    return Exponent(steepness(errors), spread, seeds, rms_at_end)


def slope(x: Array, y: Array) -> float:
    """Exponent p of y = c x^p by least squares in logarithms; at least two points."""
    return float(numpy.polyfit(numpy.log(x), numpy.log(y), 1)[0])
