"""Steady motions: their stability, and tumbling, against the equations of motion."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.claims.evidence.steady_motions import (
    Case,
    cases,
    growth,
    tumbles,
    tumbling_lambda_squared,
)
from tt_precise.exact.arithmetic import own_context
from tt_precise.exact.stability import INVERTED, UPRIGHT
from tt_precise.mechanics import euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.thresholds import lambda_thres, lambda_up

TOY = Case(Fraction("0.3"), Fraction(131, 140), Fraction(2, 5), Fraction(1, 7), Fraction(2))
FN: Any = own_context(40)


def test_cases_lie_in_the_region_and_are_the_same_each_time() -> None:
    drawn = cases(50)
    assert drawn == cases(50)
    for one in drawn:
        assert 1 - one.alpha < one.gamma < 1 + one.alpha
        assert one.gamma >= Fraction(1, 2)
        assert 1 < one.multiple < 3


@pytest.mark.parametrize(("multiple", "sign"), [("0.99", 1), ("1.01", -1)])
def test_the_inverted_spin_changes_its_stability_at_the_threshold(multiple: str, sign: int) -> None:
    assert growth(replace(TOY, multiple=Fraction(multiple)), INVERTED) == sign


@pytest.mark.parametrize(("share", "sign"), [("0.99", -1), ("1.01", 1)])
def test_the_upright_spin_changes_its_stability_at_lambda_up(share: str, sign: int) -> None:
    body = TOY.body(FN)
    ratio = lambda_up(body, FN) / lambda_thres(body, FN)
    multiple = Fraction(share) * Fraction(str(ratio))
    assert growth(replace(TOY, multiple=multiple), UPRIGHT) == sign


@pytest.mark.parametrize("z", ["-0.6", "0.1", "0.8"])
def test_tumbling_is_a_motion_with_constant_theta(z: str) -> None:
    body = TOY.body(FN)
    cosine = FN.mpf(z)
    phi_dot = FN.sqrt(body.alpha / body.I3 / (body.alpha - (1 - body.gamma) * cosine))
    state = EulerState(FN.acos(cosine), 0, phi_dot, phi_dot * (cosine - body.alpha), 0, 0)
    rates = euler.rates(body, state, FN)
    assert max(abs(rate) for rate in rates) < FN.mpf(10) ** -35
    assert abs(euler.normal_force(body, state, FN) - 1) < FN.mpf(10) ** -35
    lambda_ = euler.jellett(body, state, FN)
    assert abs(lambda_**2 - tumbling_lambda_squared(body, cosine)) < FN.mpf(10) ** -35


def test_tumbling_ends_at_the_thresholds() -> None:
    body = TOY.body(FN)
    for z, threshold in ((-1, lambda_thres), (1, lambda_up)):
        limit = tumbling_lambda_squared(body, FN.mpf(z))
        assert abs(limit - threshold(body, FN) ** 2) < FN.mpf(10) ** -35


@pytest.mark.parametrize(("multiple", "found"), [("0.99", True), ("1.01", False)])
def test_tumbling_is_found_below_the_thresholds_only(multiple: str, found: bool) -> None:
    assert tumbles(replace(TOY, multiple=Fraction(multiple))) is found
