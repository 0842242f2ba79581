"""Motions computed in other ways: in the potential, steady, backwards, by the paper's odeint."""

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

from tt_precise.claims.evidence.motions import (
    Case,
    cases,
    growth,
    minima,
    minimum,
    paper_odeint,
    past,
    state_errors,
    swing_time,
    tumbles,
)
from tt_precise.claims.evidence.run import REFERENCE, variant
from tt_precise.exact.arithmetic import own_context
from tt_precise.exact.stability import INVERTED, UPRIGHT
from tt_precise.integration import integrate
from tt_precise.mechanics import euler, thresholds
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.quantities import effective_mass, effective_potential
from tt_precise.mechanics.thresholds import lambda_thres, lambda_up, tumbling_lambda_squared
from tt_precise.scene.scene import load_scene

SHORT = variant(until="0.3")
TOY = Case(Fraction("0.3"), Fraction(131, 140), Fraction(2, 5), Fraction(1, 7), Fraction(2))
FN: Any = own_context(40)
BODY = load_scene("reference").body.numbers(float)
LAMBDA = 6.9e-6
HALFWAY = (thresholds.D0(BODY, LAMBDA, math) + thresholds.D1(BODY, LAMBDA, math)) / 2


def test_both_searches_find_the_same_minimum_and_it_is_stationary() -> None:
    fn = own_context(70)
    body, lambda_ = REFERENCE.body(fn), fn.mpf(LAMBDA)
    z = minimum(body, fn.mpf(HALFWAY), lambda_, fn)
    (theta,) = minima(BODY, HALFWAY, LAMBDA)
    assert math.cos(theta) == pytest.approx(float(z), abs=1e-7)
    slope = fn.diff(lambda x: effective_potential(body, x, HALFWAY, lambda_, fn), z)
    assert abs(slope) < fn.mpf(10) ** -25


def test_small_swings_take_half_a_period_of_the_harmonic_oscillator() -> None:
    fn = own_context(40)
    body = REFERENCE.body(fn)

    def potential(theta: Any) -> Any:
        return effective_potential(body, fn.cos(theta), fn.mpf(HALFWAY), fn.mpf(LAMBDA), fn)

    theta = fn.findroot(lambda x: fn.diff(potential, x), minima(BODY, HALFWAY, LAMBDA)[0])
    stiffness = fn.diff(potential, theta, 2)
    expected = fn.pi / fn.sqrt(stiffness / (2 * effective_mass(body, fn.cos(theta))))
    bottom = float(potential(theta))
    small = swing_time(BODY, HALFWAY, bottom * (1 + 1e-7), LAMBDA)
    assert small == pytest.approx(float(expected), rel=1e-5)
    assert swing_time(BODY, HALFWAY, bottom * (1 - 1e-3), LAMBDA) is None  # below the minimum


def test_a_swing_is_what_a_rolling_top_does() -> None:
    run = integrate("rolling", events=("theta_min", "theta_max"))
    turns = [float(t) for t in run.events["t"][:3]]
    first = run.frame("D", "E_tilde", "lambda", times=[0], numbers="exact").iloc[0]
    body = run.scene.body.numbers(float)
    expected = swing_time(body, float(first["D"]), float(first["E_tilde"]), float(first["lambda"]))
    assert expected == pytest.approx(turns[2] - turns[1], rel=1e-8)


@pytest.mark.parametrize("share", ["1e-4", "0.3", "0.5", "0.7", "0.9999"])
def test_no_well_is_lower_than_the_minimum(share: str) -> None:
    """Against all eighths, of which the search looks at a quarter; between D0 and D1."""
    fn = own_context(70)
    body = REFERENCE.body(fn)
    lambda_ = fn.mpf(LAMBDA)
    ends = thresholds.D0(body, lambda_, fn), thresholds.D1(body, lambda_, fn)
    D = ends[0] + (ends[1] - ends[0]) * fn.mpf(share)

    def V(z: Any) -> Any:
        return effective_potential(body, z, D, lambda_, fn)

    z = minimum(body, D, lambda_, fn)
    near = [fn.atanh(z) + sign * fn.mpf(10) ** -15 for sign in (-1, 1)]
    assert V(z) < min(V(fn.tanh(u)) for u in (*near, *(fn.mpf(i) / 8 for i in range(-160, 161))))


def test_cases_lie_in_the_region_and_are_the_same_each_time() -> None:
    drawn = cases(50)
    assert drawn == cases(50)
    for one in drawn:
        assert 1 - one.alpha < one.gamma < 1 + one.alpha
        assert one.gamma >= Fraction(1, 2)
        assert 1 < one.multiple < 3


@pytest.mark.parametrize(
    ("side", "threshold", "share", "sign"),
    [
        (INVERTED, lambda_thres, "0.99", 1),
        (INVERTED, lambda_thres, "1.01", -1),
        (UPRIGHT, lambda_up, "0.99", -1),
        (UPRIGHT, lambda_up, "1.01", 1),
    ],
)
def test_spins_change_their_stability_at_the_thresholds(
    side: int, threshold: Any, share: str, sign: int
) -> None:
    body = TOY.body(FN)
    ratio = threshold(body, FN) / lambda_thres(body, FN)
    multiple = Fraction(share) * Fraction(str(ratio))
    assert growth(replace(TOY, multiple=multiple), side) == sign


@pytest.mark.parametrize("z", ["-0.6", "0.1", "0.8"])
def test_tumbling_is_a_motion_with_constant_theta_between_the_thresholds(z: str) -> None:
    body, cosine, tiny = TOY.body(FN), FN.mpf(z), FN.mpf(10) ** -35
    phi_dot = FN.sqrt(body.alpha / body.I3 / (body.alpha - (1 - body.gamma) * cosine))
    state = EulerState(FN.acos(cosine), 0, phi_dot, phi_dot * (cosine - body.alpha), 0, 0)
    assert max(abs(rate) for rate in euler.rates(body, state, FN)) < tiny
    assert abs(euler.normal_force(body, state, FN) - 1) < tiny
    lambda_ = euler.jellett(body, state, FN)
    assert abs(lambda_**2 - tumbling_lambda_squared(body, cosine)) < tiny
    for end, threshold in ((-1, lambda_thres), (1, lambda_up)):
        limit = tumbling_lambda_squared(body, FN.mpf(end))
        assert abs(limit - threshold(body, FN) ** 2) < tiny


@pytest.mark.parametrize(("multiple", "exists"), [("0.99", True), ("1.01", False)])
def test_tumbling_exists_below_the_thresholds_only(multiple: str, exists: bool) -> None:
    assert tumbles(replace(TOY, multiple=Fraction(multiple))) is exists


def test_a_backward_integration_is_reversed_forward() -> None:
    scene = variant(until="0.1")
    later = integrate(scene, "double").state
    again = variant(scene, **{name: repr(getattr(later, name)) for name in EulerState._fields})
    back, origin = past(again), past(scene)
    assert origin.contact_lost
    assert back.t == pytest.approx(origin.t - 0.1, abs=1e-7)


def test_the_own_way_is_close_and_its_errors_are_seen() -> None:
    assert 1e-13 < paper_odeint(SHORT)[1] < 1e-9
    assert 1e-12 < state_errors(SHORT)["theta"] < 1e-6


@pytest.mark.parametrize(
    ("solver", "answer", "given_up"),
    [
        ("solve_ivp", SimpleNamespace(status=-1, message="steps"), past),
        ("odeint", (numpy.zeros((1, 6)), {"message": "Excess work"}), paper_odeint),
    ],
)
def test_a_solver_that_fails_raises(
    solver: str, answer: Any, given_up: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(f"tt_precise.claims.evidence.motions.{solver}", lambda *_, **__: answer)
    with pytest.raises(ArithmeticError, match=r"gave .*up: (steps|Excess work)"):
        given_up(variant(until="0.31"))
