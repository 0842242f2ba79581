"""Long-run growth: the exponent of series that have a known one."""

import math

import numpy
import pandas
import pytest

from tt_precise.tradeoff import growth


def walks(drift: float) -> pandas.DataFrame:
    """Random walks, with a systematic part in units of their step, at log-spaced times."""
    draw = numpy.random.default_rng(20240229)
    times = [10.0 ** (i / 4) for i in range(17)]
    rows = []
    for seed in range(64):
        walk = numpy.cumsum(draw.choice([-1.0, 1.0], 10_001) + drift)
        rows += [
            {"scene": "s", "seed": seed, "t_s": t, "jellett": 1e-16 * walk[round(t)]} for t in times
        ]
    return pandas.DataFrame(rows)


def test_a_random_walk_has_exponent_one_half() -> None:
    found = growth.exponent(walks(0.0), "s", "jellett", 1e4)
    assert abs(found.exponent - 0.5) < 3 * found.error
    assert found.error < 0.05
    assert found.seeds == 64
    assert found.rms_at_end == pytest.approx(1e-14, rel=0.4)
    # a systematic error has not
    found = growth.exponent(walks(1.0), "s", "jellett", 1e4)
    assert found.exponent - 0.5 > 10 * found.error


def test_slope_of_a_power_law() -> None:
    costs = [3.0, 3 * 10**1.75, 3 * 40**1.75]
    assert growth.slope([1.0, 10.0, 40.0], costs) == pytest.approx(1.75, rel=1e-14)
    falling = growth.slope([1.0, math.e], [1.0, math.e**-2])
    assert falling == pytest.approx(-2, rel=1e-14)
