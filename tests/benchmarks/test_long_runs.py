"""Long runs: the size of the errors of short ones."""

import numpy
import pytest

from benchmarks.work_precision import long_runs
from benchmarks.work_precision.findings import GROWING


def test_short_runs_stay_within_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_runs, "LONG_SCENES", ("rolling",))
    monkeypatch.setattr(long_runs, "LANES", 2)
    found = long_runs.table((long_runs.LongRuns(long_runs.LANES, 10.0),))
    assert set(found["scene"]) == {"rolling"}
    assert len(found) == 2 * len(long_runs.log_spaced(10.0))
    for name in GROWING:
        assert 0 < found[name].abs().max() < 100 * numpy.finfo(float).eps
