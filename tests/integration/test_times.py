"""Exact times as doubles: rounded once, whatever their numerators and denominators."""

import random
from fractions import Fraction

import mpmath
import numpy
import pytest

from tt_precise.integration.dense_output import SampleTimes, Times
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.scene.scene import load_scene
from tt_precise.taylor.numbers import added, number


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


def test_samples_in_parts_are_exact_multiples() -> None:
    scene = load_scene("reference")
    precision = precision_named("mp", 400)
    start = InitialState.of(scene, precision.arithmetic)
    samples = SampleTimes.of(scene, start)
    for t, row in zip(samples.exact[::97], samples.parts[::97].tolist(), strict=True):
        true = precision.exact(t) / start.units.time
        assert abs(number(row, precision.context) - true) <= true * 2.0**-155


def test_sums_in_parts_are_rounded_behind_the_last() -> None:
    terms = [numpy.array([1.0]), numpy.array([2.0**-70]), numpy.array([-1.0]), numpy.array([3e-30])]
    exact = sum(Fraction(float(term[0])) for term in terms)
    total = number(added(terms, 3)[0].tolist(), mpmath.mp)
    assert float(total) == float(exact)
