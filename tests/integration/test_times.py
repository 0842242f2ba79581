"""Exact times as doubles: rounded once, whatever their numerators and denominators."""

import random
from fractions import Fraction

import mpmath
import numpy
import pytest

from tt_precise.integration.precision import precision_named
from tt_precise.integration.times import SampleTimes, Times
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.scene.scene import load_scene


@pytest.mark.parametrize("bits", [10, 52, 53, 54, 60, 80, 200])
def test_times_are_the_nearest_doubles(bits: int) -> None:
    drawn = random.Random(bits)
    times = sorted(
        Fraction(drawn.getrandbits(bits) | 1 << bits - 1, drawn.getrandbits(bits) | 1 << bits - 1)
        for _ in range(300)
    )
    found = Times.of(times, mpmath.mpf(1))
    assert found.seconds.tolist() == [float(t) for t in times]
    whole = found.rounded.astype(numpy.longdouble) + found.delay
    for t, rounded, delay in zip(times, found.rounded, found.delay, strict=True):
        left = t - Fraction(float(rounded)) - Fraction(float(delay))
        assert abs(left) < t * Fraction(1, 2**61)
    assert (abs(found.delay) <= numpy.spacing(found.rounded)).all()
    assert (numpy.diff(whole) >= 0).all()


def test_the_last_sample_is_the_horizon_to_the_last_bit() -> None:
    scene = load_scene("reference")
    start = InitialState.of(scene, precision_named("extended").arithmetic)
    doubles = SampleTimes.of(scene, start).doubles
    assert doubles.rounded[-1] == float(start.until)
    assert doubles.delay[-1] == float(start.until - float(start.until)) != 0
    others = Times.of(scene.sample_times, start.units.time)
    assert (doubles.delay[:-1] == others.delay[:-1]).all()


def test_no_times_are_no_times() -> None:
    assert Times.of([], mpmath.mpf(1)).seconds.tolist() == []
