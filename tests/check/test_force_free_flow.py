"""The flow from row to row without a force law: exact where it should be."""

from collections.abc import Callable

import numpy
import pytest

import tt_precise as tt
from tests.check.test_force_free import motion
from tt_precise.check.force_free import differences
from tt_precise.check.force_free_flow import (
    Way,
    by_guidance,
    by_interpolation,
    gauss,
    interpolate,
    momentum_at_contact,
)


@pytest.mark.parametrize("count", [2, 5, 12])
def test_collocation_integrates_polynomials_exactly(count: int) -> None:
    nodes, matrix, weights = gauss(count)
    for power in range(count):
        assert matrix @ nodes**power == pytest.approx(nodes ** (power + 1) / (power + 1), abs=1e-14)
    assert weights @ nodes ** (2 * count - 1) == pytest.approx(1 / (2 * count), abs=1e-14)


@pytest.mark.parametrize("way", [Way(6, True), Way(4, True), Way(6, False)])
def test_interpolation_reproduces_its_shapes(way: Way) -> None:
    rng = numpy.random.default_rng(2)
    t = numpy.cumsum(rng.uniform(0.8, 1.2, 30))
    turn, at = 1.7 * numpy.diff(t), numpy.array([0.2, 0.9])
    there = t[:-1] + at[:, None] * numpy.diff(t)
    shape: Callable[[numpy.ndarray], numpy.ndarray] = (
        (lambda t: 1 + 0.3 * t + numpy.cos(1.7 * t)) if way.nutation else (lambda t: t**3 - t)
    )
    found = interpolate(t, shape(t)[None], way, turn, at)[0]
    assert found == pytest.approx(shape(there), abs=1e-6 if not way.nutation else 1e-9)


def test_a_viscous_motion_is_followed_exactly_at_60_hertz() -> None:
    """The law is in the guided family, so that nothing but rounding is left."""
    body, rows = tt.load_scene("reference").body.numbers(float), motion("reference", 60)
    guided = by_guidance(body, rows)
    off = differences(body, rows, momentum_at_contact(body, rows), guided.best)
    assert abs(off).max() < 1e-11
    assert guided.unexplained[5:-5].max() < 1e-6


def test_a_motion_on_ice_needs_no_friction() -> None:
    body, rows = tt.load_scene("frictionless").body.numbers(float), motion("frictionless", 30)
    for ends in by_interpolation(body, rows, (Way(6, True), Way(4, False))):
        off = differences(body, rows, momentum_at_contact(body, rows), ends)
        assert abs(off).max() < 1e-11
