"""Motions computed in other ways: in the potential, steady, backwards, by the paper's odeint."""

import math
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

from tt_precise.claims.evidence import motions
from tt_precise.claims.evidence.motions import Case, cases, minima, minimum, past, tumbles
from tt_precise.claims.evidence.run import REFERENCE, variant
from tt_precise.exact.stability import own_context
from tt_precise.integration import integrate
from tt_precise.mechanics import euler, thresholds
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.quantities import effective_mass, effective_potential
from tt_precise.mechanics.thresholds import tumbling_lambda_squared

SHORT = variant(until="0.3")
TOY = Case(Fraction("0.3"), Fraction(131, 140), Fraction(2, 5), Fraction(1, 7), Fraction(2))
FN: Any = own_context(70)
BODY, WIDE = (REFERENCE.loaded.body.numbers(float), REFERENCE.body(FN))
LAMBDA = 6.9e-6
HALFWAY = (thresholds.D0(BODY, LAMBDA, math) + thresholds.D1(BODY, LAMBDA, math)) / 2


def potential(theta: Any) -> Any:
    """The effective potential halfway between D0 and D1."""
    return effective_potential(WIDE, FN.cos(theta), FN.mpf(HALFWAY), FN.mpf(LAMBDA), FN)


@pytest.mark.parametrize("share", [0.001, 0.1, 0.5, 0.9, 0.999])
def test_both_searches_find_the_same_lowest_minimum(share: float) -> None:
    D0, D1 = (limit(BODY, LAMBDA, math) for limit in (thresholds.D0, thresholds.D1))
    D = D0 + share * (D1 - D0)
    lambda_ = FN.mpf(LAMBDA)
    z = minimum(WIDE, FN.mpf(D), lambda_, FN)
    lowest = min(
        minima(BODY, D, LAMBDA),
        key=lambda theta: effective_potential(BODY, math.cos(theta), D, LAMBDA, math),
    )
    assert lowest == pytest.approx(float(FN.acos(z)), abs=1e-7)
    slope = FN.diff(lambda z: effective_potential(WIDE, z, FN.mpf(D), lambda_, FN), z)
    assert abs(slope) < FN.mpf(10) ** -25


def test_small_swings_take_half_a_period_of_the_harmonic_oscillator() -> None:
    theta = FN.findroot(lambda x: FN.diff(potential, x), minima(BODY, HALFWAY, LAMBDA)[0])
    stiffness = FN.diff(potential, theta, 2)
    expected = FN.pi / FN.sqrt(stiffness / (2 * effective_mass(WIDE, FN.cos(theta))))
    bottom = float(potential(theta))
    small = motions.swing_time(BODY, HALFWAY, bottom * (1 + 1e-7), LAMBDA)
    assert small == pytest.approx(float(expected), rel=1e-5)
    assert motions.swing_time(BODY, HALFWAY, bottom * (1 - 1e-3), LAMBDA) is None


def test_cases_lie_in_the_region_and_are_the_same_each_time() -> None:
    assert cases(50) == cases(50)
    for case in cases(50):
        assert max(1 - case.alpha, Fraction(1, 2)) <= case.gamma < 1 + case.alpha
        assert 1 < case.multiple < 3


def test_tumbling_has_constant_theta_and_exists_below_the_thresholds_only() -> None:
    body, cosine, tiny = TOY.body(FN), FN.mpf("0.1"), FN.mpf(10) ** -60
    phi_dot = FN.sqrt(body.alpha / body.I3 / (body.alpha - (1 - body.gamma) * cosine))
    state = EulerState(FN.acos(cosine), 0, phi_dot, phi_dot * (cosine - body.alpha), 0, 0)
    assert max(abs(rate) for rate in euler.rates(body, state, FN)) < tiny
    assert abs(euler.normal_force(body, state, FN) - 1) < tiny
    lambda_squared = euler.jellett(body, state, FN) ** 2
    assert abs(lambda_squared - tumbling_lambda_squared(body, cosine)) < tiny
    assert tumbles(replace(TOY, multiple=Fraction("0.99")))
    assert not tumbles(replace(TOY, multiple=Fraction("1.01")))


def test_a_backward_integration_is_reversed_forward() -> None:
    scene = variant(until="0.1")
    later = integrate(scene, "double").state
    again = variant(scene, **{name: repr(getattr(later, name)) for name in EulerState._fields})
    assert past(scene).contact_lost
    assert past(again).t == pytest.approx(past(scene).t - 0.1, abs=1e-7)


def test_the_errors_of_the_paper_s_method_are_seen() -> None:
    assert 1e-13 < motions.paper_odeint(SHORT)[1] < 1e-9
    assert 1e-12 < motions.state_errors(SHORT)["theta"] < 1e-6


@pytest.mark.parametrize(
    ("solver", "answer", "method"),
    [
        ("solve_ivp", SimpleNamespace(status=-1, message="steps"), past),
        ("odeint", (numpy.zeros((1, 6)), {"message": "Excess work"}), motions.paper_odeint),
    ],
)
def test_a_solver_that_fails_raises(
    solver: str, answer: Any, method: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(motions, solver, lambda *_, **__: answer)
    with pytest.raises(ArithmeticError, match=r"gave .*up: (steps|Excess work)"):
        method(variant(until="0.31"))
