"""The bars in double: lambda is constant, and the energy falls by the power of the law alone.

The power is integrated by Gauss' rule over bisected intervals, inside each piece. Where pieces
join the top loses nothing; where a damped table lets go it is still pressed in, and what it has
stored then is lost to the top.
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
from tt_precise.scene.scene import Scene

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
        open_ = abs(halves.sum(axis=0) - whole) > tolerance
        parts += halves[:, ~open_].ravel().tolist()
        whole = halves[:, open_].ravel()
        low, high = (
            numpy.concatenate((first[open_], last[open_]))
            for first, last in ((low, middle), (middle, high))
        )
    return math.fsum(parts)


class Law:
    """The power of a scene's friction and its table, from their definitions."""

    def __init__(self, scene: Scene, model: str):
        body = scene.body
        self.mu, self.law = float(body.mu), body.law if model in ("gliding", "contact") else ""
        given = {name: float(number) for name, number in body.numbers_by_name.items()}
        self.epsilon = given.get("epsilon", 0.0)
        # Stribeck's curve: friction falls from mu_s at rest
        self.fall, self.v_s = given.get("mu_s", self.mu) - self.mu, given.get("v_s", 1.0)
        self.spring = body.spring if model == "contact" else ""
        self.stiffness, self.damping = float(body.stiffness), float(body.damping)
        self.order = 1.0 if self.spring == "linear" else 1.5

    def power(self, rows: Any) -> Any:
        speed = numpy.hypot(rows["vx"], rows["vy"])
        found = 0 * speed
        if self.law == "viscous":
            found = -self.mu * rows["g_n"] * speed**2
        elif self.law:
            away = numpy.hypot(speed, self.epsilon)
            mu = self.mu + self.fall * numpy.exp(-((speed / self.v_s).astype(float) ** 2))
            found = -mu * rows["g_n"] * speed**2 / numpy.where(away > 0, away, 1)
        if self.spring:
            depth = numpy.maximum(-rows["height"], 0)
            factor = self.stiffness * depth**1.5 if self.spring == "hunt-crossley" else 1
            found = found - self.damping * factor * rows["rise"] ** 2
        return found.to_numpy(float)

    def stored(self, height: float) -> float:
        if not self.spring:
            return 0.0
        return self.stiffness * max(-height, 0.0) ** (self.order + 1) / (self.order + 1)


def imbalance(run: Trajectory, scene: Scene) -> float:
    """The worst change of energy that the laws of ``scene`` do not explain, over E(0).

    Of a piece, of a joint between two, and of the whole motion.
    """
    lifted = ("height", "rise") if scene.lifts else ()

    def rows(*names: str, times: Any) -> Any:
        return run.frame(*names, *lifted, times=[*map(Fraction, times)], numbers="exact")

    start, end = rows("E", times=[0, run.t_end])["E"].astype(float)
    found, explained, before = [], 0.0, start
    for piece in run.pieces:
        law = Law(scene, piece.model)

        def power(times: Any, law: Law = law) -> Any:
            return law.power(rows("vx", "vy", "g_n", times=times.tolist()))

        # a row at a bound is of the earlier piece
        after = Fraction(piece.begin) + (Fraction(1, 10**15) if piece.begin else 0)
        ends = rows("E", times=[after, piece.end])
        first, last = ends["E"].astype(float)
        held, left = (law.stored(float(row.get("height", 0))) for _, row in ends.iterrows())
        bounds = float(piece.begin), float(piece.end)
        work = integral(power, *bounds, 1e-16 * start) + held - left
        found += [abs(last - first - work), abs(first - before)]
        before, explained = last, explained + work
    return max(*found, abs(end - start - explained)) / start


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=() if one in CHEAP else pytest.mark.slow) for one in store.scenes()],
)
def test_bars_of_every_golden_scene(name: str) -> None:
    run = tt.integrate(name, events=(), record=())
    assert float(run.drift["jellett"]) <= JELLETT
    assert imbalance(run, run.scene) <= ENERGY


@pytest.mark.parametrize(
    ("name", "entries"),
    [
        ("coulomb-gliding", {"mu": "0.05000000001"}),
        ("elastic-linear", {"damping": "0.200000001"}),
        ("elastic-linear", {"stiffness": "1000.000001"}),
    ],
)
def test_another_law_does_not_explain_the_loss(name: str, entries: dict[str, str]) -> None:
    run = tt.integrate(name, events=(), record=())
    assert imbalance(run, run.scene.varied(**entries)) > ENERGY
