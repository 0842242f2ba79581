"""The bars in double: lambda is constant, and the energy falls by the power of contact alone.

The power is integrated by Gauss' rule over bisected intervals, inside each piece; where pieces join
the top loses nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.golden import store
from tt_precise.integration import Trajectory

NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(12)
WIDEST_S = 2e-3
JELLETT, ENERGY = 1e-14, 1e-13
CHEAP = ("contact-lost", "coulomb-gliding", "coulomb-small-top", "elastic-linear", "flight")


def integral(power: Callable[[Any], Any], begin: float, end: float, tolerance: float) -> float:
    def over(low: Any, high: Any) -> Any:
        half = (high - low)[:, None] / 2
        x = low[:, None] + half * (1 + NODES)
        return (half * power(x.ravel()).reshape(x.shape)) @ WEIGHTS

    edges = numpy.linspace(begin, end, max(1, math.ceil((end - begin) / WIDEST_S)) + 1)
    low, high, parts = edges[:-1], edges[1:], list[float]()
    whole = over(low, high)
    while len(low):
        assert min(high - low) > 1e-15, f"no convergence at {low[0]} s"
        middle = (low + high) / 2
        halves = numpy.array([over(low, middle), over(middle, high)])
        wide = abs(halves.sum(axis=0) - whole) > tolerance
        parts += halves[:, ~wide].ravel().tolist()
        whole = halves[:, wide].ravel()
        low, high = numpy.r_[low[wide], middle[wide]], numpy.r_[middle[wide], high[wide]]
    return math.fsum(parts)


def imbalance(run: Trajectory, pieces: Any, factor: float = 1.0) -> float:
    """The worst change of energy that the power does not explain, over E(0).

    Of a piece, of a joint between two, and of the whole motion; ``factor`` multiplies the power.
    """

    def rows(name: str, times: Any) -> Any:
        frame = run.frame(name, times=[*map(Fraction, times)], numbers="exact")
        return frame[name].to_numpy(float)

    start, end = rows("E", [0, run.t_end])
    found, explained, before = [], 0.0, start
    for piece in pieces:
        # a row at a bound is of the earlier piece
        after = Fraction(piece.begin) + (Fraction(1, 10**15) if piece.begin else 0)
        first, last = rows("E", [after, piece.end])
        bounds = float(piece.begin), float(piece.end)
        work = factor * integral(lambda t: rows("E_dot", t.tolist()), *bounds, 1e-16 * start)
        found += [abs(last - first - work), abs(first - before)]
        before, explained = last, explained + work
    return float(max(*found, abs(end - start - explained)) / start)


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=() if one in CHEAP else pytest.mark.slow) for one in store.scenes()],
)
def test_bars_of_every_golden_scene(name: str) -> None:
    """Controls: a power off by 1e-10, and a piece that is left out."""
    run = tt.integrate(name, events=(), record=())
    assert float(run.drift["jellett"]) <= JELLETT
    assert imbalance(run, run.pieces) <= ENERGY
    if name == "elastic-linear":
        assert imbalance(run, run.pieces, factor=1 + 1e-10) > ENERGY
        assert imbalance(run, (*run.pieces[:4], *run.pieces[5:])) > ENERGY
