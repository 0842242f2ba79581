"""The effective potential: minima and swings against what is known of them."""

import math
from typing import Any

import pytest

from tt_precise.claims import evidence
from tt_precise.claims.evidence.potential import Swing, minima, minimum, swing
from tt_precise.exact.arithmetic import own_context
from tt_precise.integration import integrate
from tt_precise.mechanics import thresholds
from tt_precise.mechanics.quantities import effective_mass, effective_potential
from tt_precise.scene.scene import load_scene

BODY = load_scene("reference").body.numbers(float)
LAMBDA = 6.9e-6
HALFWAY = (thresholds.D0(BODY, LAMBDA, math) + thresholds.D1(BODY, LAMBDA, math)) / 2


def test_both_searches_find_the_same_minimum() -> None:
    fn = own_context(70)
    body = evidence.body_in(fn)
    z = minimum(body, fn.mpf(HALFWAY), fn.mpf(LAMBDA), fn)
    (theta,) = minima(BODY, HALFWAY, LAMBDA)
    assert math.cos(theta) == pytest.approx(float(z), abs=2e-3)  # the grid is 1e-3 wide in u


def test_the_minimum_is_stationary() -> None:
    fn = own_context(70)
    body = evidence.body_in(fn)
    z = minimum(body, fn.mpf(HALFWAY), fn.mpf(LAMBDA), fn)
    slope = fn.diff(lambda x: effective_potential(body, x, HALFWAY, fn.mpf(LAMBDA), fn), z)
    assert abs(slope) < fn.mpf(10) ** -25


def small_swing(excess: float) -> Swing:
    (theta,) = minima(BODY, HALFWAY, LAMBDA)
    bottom = effective_potential(BODY, math.cos(theta), HALFWAY, LAMBDA, math)
    found = swing(BODY, HALFWAY, bottom * (1 + excess), LAMBDA)
    assert found is not None
    return found


def test_small_swings_take_half_a_period_of_the_harmonic_oscillator() -> None:
    fn = own_context(40)
    body = evidence.body_in(fn)

    def potential(theta: Any) -> Any:
        return effective_potential(body, fn.cos(theta), fn.mpf(HALFWAY), fn.mpf(LAMBDA), fn)

    theta = fn.findroot(lambda x: fn.diff(potential, x), minima(BODY, HALFWAY, LAMBDA)[0])
    stiffness = fn.diff(potential, theta, 2)
    expected = fn.pi / fn.sqrt(stiffness / (2 * effective_mass(body, fn.cos(theta))))
    assert small_swing(1e-7).time == pytest.approx(float(expected), rel=1e-5)


def test_a_swing_is_what_a_rolling_top_does() -> None:
    run = integrate("rolling", events=("theta_min", "theta_max"))
    turns = [float(t) for t in run.events["t"][:3]]
    first = run.frame("D", "E_tilde", "lambda", times=[0]).iloc[0]
    body = run.scene.body.numbers(float)
    found = swing(body, float(first["D"]), float(first["E_tilde"]), float(first["lambda"]))
    assert found is not None
    assert found.time == pytest.approx(turns[2] - turns[1], rel=1e-8)
    assert found.lowest == pytest.approx(float(run.events["theta"][:2].min()), rel=1e-8)
    assert found.highest == pytest.approx(float(run.events["theta"][:2].max()), rel=1e-8)


def test_nothing_swings_below_the_minimum() -> None:
    (theta,) = minima(BODY, HALFWAY, LAMBDA)
    bottom = effective_potential(BODY, math.cos(theta), HALFWAY, LAMBDA, math)
    assert swing(BODY, HALFWAY, bottom * (1 - 1e-3), LAMBDA) is None


@pytest.mark.parametrize("share", ["1e-4", "0.3", "0.5", "0.7", "0.9999"])
def test_no_well_is_lower_than_the_minimum(share: str) -> None:
    """Against all eighths, of which the search looks at a quarter; between D0 and D1."""
    fn = own_context(70)
    body = evidence.body_in(fn)
    lambda_ = fn.mpf(LAMBDA)
    ends = thresholds.D0(body, lambda_, fn), thresholds.D1(body, lambda_, fn)
    D = ends[0] + (ends[1] - ends[0]) * fn.mpf(share)

    def V(z: Any) -> Any:
        return effective_potential(body, z, D, lambda_, fn)

    z = minimum(body, D, lambda_, fn)
    assert V(z) < min(V(fn.tanh(fn.mpf(i) / 8)) for i in range(-160, 161))
    assert V(z) < V(fn.tanh(fn.atanh(z) + fn.mpf(10) ** -15))
    assert V(z) < V(fn.tanh(fn.atanh(z) - fn.mpf(10) ** -15))
