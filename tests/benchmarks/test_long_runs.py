"""Long runs: seeds, times, and the size of the errors of short ones."""

import numpy
import pytest

from benchmarks.work_precision import long_runs
from benchmarks.work_precision.findings import GROWING
from tt_precise.scene.scene import load_scene


def test_times_are_log_spaced_and_seeds_repeat() -> None:
    times = long_runs.log_spaced(1e3)
    assert times[0] == long_runs.FIRST_S
    assert times[-1] == pytest.approx(1e3)
    assert len(times) == 3 * long_runs.TIMES_A_DECADE + 1
    scene = load_scene("frictionless")
    first, again, other = (long_runs.seeded(scene, seed) for seed in (1, 1, 2))
    assert first == again
    assert 0 < abs(first.start.omega_3 / other.start.omega_3 - 1) <= 2.1 * long_runs.SPREAD


def test_short_runs_stay_within_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_runs, "LONG_SCENES", ("rolling",))
    monkeypatch.setattr(long_runs, "LANES", 2)
    found = long_runs.table((long_runs.LongRuns(long_runs.LANES, 10.0),))
    assert set(found["scene"]) == {"rolling"}
    assert len(found) == 2 * len(long_runs.log_spaced(10.0))
    for name in GROWING:
        assert 0 < found[name].abs().max() < 100 * numpy.finfo(float).eps
