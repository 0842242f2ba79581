"""What an accuracy costs, from points with known answers."""

import math

import pytest

from tt_precise.tradeoff.error_growth import slope
from tt_precise.tradeoff.findings import Point, cost_of, front

# error = cost^-2, so an accuracy e costs e^(-1/2)
SQUARE = [Point(10.0 ** (-2 * n), 10.0**n) for n in range(5)]


def test_interpolation_is_exact_on_a_power_law() -> None:
    assert cost_of(SQUARE, 1e-5) == pytest.approx(10**2.5, rel=1e-14)
    assert cost_of(reversed(SQUARE), 1e-5) == pytest.approx(10**2.5, rel=1e-14)


def test_a_curve_is_not_extrapolated() -> None:
    assert math.isnan(cost_of(SQUARE, 1e-9))
    assert math.isnan(cost_of([], 1e-3))
    assert cost_of(SQUARE[1:], 1.0) == pytest.approx(10, rel=1e-14)  # the cheapest


def test_a_beaten_point_changes_nothing() -> None:
    beaten = Point(1e-3, 1e4)
    assert beaten not in front([*SQUARE, beaten])
    assert cost_of([*SQUARE, beaten], 1e-3) == cost_of(SQUARE, 1e-3)


def test_a_better_point_does() -> None:
    lucky = Point(1e-7, 50.0)
    assert cost_of([*SQUARE, lucky], 1e-6) < cost_of(SQUARE, 1e-6)


def test_slope_of_a_power_law() -> None:
    assert slope([1.0, 10.0, 40.0], [3.0, 3 * 10**1.75, 3 * 40**1.75]) == pytest.approx(
        1.75, rel=1e-14
    )
    assert slope([1.0, math.e], [1.0, math.e**-2]) == pytest.approx(-2, rel=1e-14)
