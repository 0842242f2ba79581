"""Long-run growth: the exponent of series that have a known one, and of short real runs."""

import math

import numpy
import pandas
import pytest

from tt_precise.scene.scene import load_scene
from tt_precise.tradeoff import error_growth


def walks(drift: float) -> pandas.DataFrame:
    """Random walks, with a systematic part in units of their step, at log-spaced times."""
    draw = numpy.random.default_rng(20240229)
    times = error_growth.log_spaced(1e4)
    rows = []
    for seed in range(64):
        walk = numpy.cumsum(draw.choice([-1.0, 1.0], 10_001) + drift)
        rows += [
            {"scene": "s", "seed": seed, "t_s": t, "jellett": 1e-16 * walk[round(t)]} for t in times
        ]
    return pandas.DataFrame(rows)


def test_a_random_walk_has_exponent_one_half() -> None:
    found = error_growth.exponent(walks(0.0), "s", "jellett", 1e4)
    assert abs(found.exponent - 0.5) < 3 * found.error
    assert found.error < 0.05
    assert found.seeds == 64
    assert found.rms_at_end == pytest.approx(1e-14, rel=0.4)
    # a systematic error has not
    found = error_growth.exponent(walks(1.0), "s", "jellett", 1e4)
    assert found.exponent - 0.5 > 10 * found.error


def test_slope_of_a_power_law_and_times_that_are_log_spaced() -> None:
    costs = [3.0, 3 * 10**1.75, 3 * 40**1.75]
    assert error_growth.slope([1.0, 10.0, 40.0], costs) == pytest.approx(1.75, rel=1e-14)
    falling = error_growth.slope([1.0, math.e], [1.0, math.e**-2])
    assert falling == pytest.approx(-2, rel=1e-14)
    times = error_growth.log_spaced(1e3)
    assert times[0] == error_growth.FIRST_S
    assert times[-1] == pytest.approx(1e3)
    assert len(times) == 3 * error_growth.TIMES_A_DECADE + 1


def test_seeds_differ_and_repeat() -> None:
    scene = load_scene("frictionless")
    one, again, other = (error_growth.seeded(scene, seed) for seed in (1, 1, 2))
    assert one == again
    assert one.start != other.start
    assert abs(one.start.omega_3 / scene.start.omega_3 - 1) <= error_growth.SPREAD


def test_short_runs_stay_within_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_growth, "SCENES", ("rolling",))
    monkeypatch.setattr(error_growth, "LANES", 2)
    found = error_growth.table((error_growth.LongRuns(error_growth.LANES, 10.0),))
    assert set(found["scene"]) == {"rolling"}
    assert len(found) == 2 * len(error_growth.log_spaced(10.0))
    for name in error_growth.INTEGRALS_SHOWN:
        assert 0 < found[name].abs().max() < 100 * numpy.finfo(float).eps
