"""Charts: relations, derivatives, and the few roots and angles they know."""

from typing import Any

import pytest

from tt_precise.exact.chart import EulerChart, VectorChart, VectorChartAtAzimuth0
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import d


@pytest.fixture(scope="module")
def euler() -> EulerChart:
    return EulerChart()


@pytest.fixture(scope="module")
def vectors() -> VectorChart:
    return VectorChart()


def test_relations_vanish_and_neighbours_do_not(euler: EulerChart, vectors: VectorChart) -> None:
    assert euler.vanishes(euler.s**2 + euler.c**2 - 1)
    assert euler.vanishes((euler.s**2 + euler.c**2) ** 3 - 1)
    assert not euler.vanishes(euler.s**2 + euler.c**2 - 1 - euler.field.one / 10**40)
    kx, ky, kz = vectors.state.k
    assert vectors.vanishes(kz**4 - (1 - kx**2 - ky**2) ** 2)
    assert not vectors.vanishes(kz**2 - 1 + kx**2)


def test_functions_that_agree_on_the_relations_are_equal(euler: EulerChart) -> None:
    s, c, one = euler.s, euler.c, euler.field.one
    assert euler.equal((1 - c**2) / (s * (1 + c)), s / (1 + c))
    assert not euler.equal((1 - c**2 + one / 10**40) / (s * (1 + c)), s / (1 + c))
    for pair in ((s / (s**2 + c**2 - 1), s), (s, s / (s**2 + c**2 - 1))):
        with pytest.raises(ZeroDivisionError):
            euler.equal(*pair)


def test_root_of_d(euler: EulerChart, vectors: VectorChart) -> None:
    for chart, z in ((euler, euler.c), (vectors, vectors.state.kz)):
        value = d(chart.body, z)
        root = chart.sqrt(value)
        assert chart.vanishes(root**2 - value)
        assert not chart.vanishes(root - value)
        with pytest.raises(ValueError, match="no square root"):
            chart.sqrt(2 * value)


def test_unknown_lengths_and_angles_are_refused(euler: EulerChart) -> None:
    assert euler.hypot(euler.s * euler.C, euler.s * euler.S) == euler.s
    with pytest.raises(ValueError, match="horizontal length"):
        euler.hypot(euler.s, euler.S)
    assert euler.atan2(euler.s, euler.c) == euler.state.theta
    with pytest.raises(ValueError, match="no angle"):
        euler.atan2(euler.c, euler.s)
    with pytest.raises(KeyError):
        euler.sin(euler.state.theta_dot)


def test_chain_rule(euler: EulerChart) -> None:
    """With theta' = a, phi' = phi_dot: (sin^2 theta cos phi)' and the derivative of q."""
    zero, rate = euler.field.zero, euler.symbol["nu_y"]
    rates = EulerState(rate, zero, zero, zero, zero, zero)
    s, c, S, C = euler.s, euler.c, euler.S, euler.C
    found = euler.along(s**2 * C, rates)
    assert euler.vanishes(found - (2 * s * c * C * rate - s**2 * S * euler.state.phi_dot))
    q = euler.symbol["q"]
    slope = euler.along(q, rates)
    direct = euler.along(euler.body.I3**2 * d(euler.body, c), rates)
    assert euler.vanishes(2 * q * slope - direct)
    assert not euler.vanishes(q * slope - direct)


def test_charts_at_azimuth_0_differentiate_before_they_set_it() -> None:
    chart = VectorChartAtAzimuth0()
    zero, one = chart.field.zero, chart.field.one
    rates = NewtonState(zero, one, *(zero,) * 6)
    ky: Any = chart.state.ky
    assert chart.here(ky) == 0
    assert chart.along(ky, rates) == 1
    kx, kz = chart.state.kx, chart.state.kz
    assert chart.vanishes(kx**2 + kz**2 - 1)
