"""The bars in double: lambda is constant, and the energy falls by the power of contact alone.

The power is integrated by tanh-sinh quadrature over short intervals, inside each segment; where
segments join the top loses nothing.
"""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy
import pytest
from scipy.integrate import tanhsinh

import tt_precise as tt
from tt_precise.golden import store
from tt_precise.integration import Trajectory

WIDEST_S = 1e-2
JELLETT, ENERGY = 1e-14, 1e-13
CHEAP = ("contact-lost", "coulomb-gliding", "coulomb-small-top", "elastic-linear", "flight")


def imbalance(run: Trajectory, pieces: Sequence[Any], factor: float = 1.0) -> float:
    """The worst change of energy that the power does not explain, over E(0).

    Of a piece, of a joint between two, and of the whole motion; ``factor`` multiplies the power.
    """
    exact = numpy.vectorize(Fraction, otypes="O")

    def rows(name: str, times: Sequence[Any]) -> Any:
        return run.frame(name, times=times, numbers="exact")[name].to_numpy(float)

    def power(after: Any, begin: Any) -> Any:
        times = exact(begin) + exact(after)  # no double, beside the width of an interval
        return rows("E_dot", times.ravel().tolist()).reshape(times.shape).copy()

    start, end = rows("E", [0, run.t_end])
    changes, explained, before = [], 0.0, start
    for piece in pieces:
        count = max(1, math.ceil((piece.end - piece.begin) / WIDEST_S))
        edges, width = numpy.linspace(piece.begin, piece.end, count + 1, retstep=True)
        parts = tanhsinh(power, 0.0, width, args=(edges[:-1],), atol=1e-16 * start, rtol=0)
        assert parts.success.all()
        work = factor * math.fsum(parts.integral)
        # a row at a bound is of the earlier piece
        after = Fraction(piece.begin) + (Fraction(1, 10**15) if piece.begin else 0)
        first, last = rows("E", [after, piece.end])
        changes += [abs(last - first - work), abs(first - before)]
        before, explained = last, explained + work
    return float(max(*changes, abs(end - start - explained)) / start)


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
