"""Lanes: one that produces NaN is recorded and leaves the others alone."""

import math
from typing import Any

import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.sweeps import events
from tt_precise.sweeps.columns import detectors, extremes
from tt_precise.sweeps.lanes import Build, LaneResults, LaneStart, lanes

BUILD = Build("gliding", "unilateral", 4, detectors((), "gliding"), extremes(()))
INERTIA = (0.3, 131 / 350, 2 / 5, 0.3)  # alpha, I1, I3, mu
UPRIGHT = (0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
TILTED = (math.sin(0.1), 0.0, math.cos(0.1), 0.28, 0.0, 2.78, 0.0, 0.0)


def integrated(*states: tuple[float, ...], until: float = 5.0) -> LaneResults:
    with lanes(BUILD) as lent:
        return lent.integrate([LaneStart(state, INERTIA, until) for state in states])


def times(found: LaneResults, row: int) -> Any:
    return found.events.time[found.events.row == row]


def test_a_failed_lane_is_reported_and_the_others_go_on() -> None:
    endless = (*UPRIGHT[:5], 1e200, 1e200, 0.0)  # its squares overflow
    alone = integrated(*[TILTED] * 9)
    found = integrated(*[TILTED] * 4, endless, *[TILTED] * 4)
    failed = found.results[4]
    assert failed.status == "failed"
    assert failed.time == 0
    assert not numpy.isfinite(failed.state).all()
    for row in (0, 1, 2, 3, 5, 6, 7, 8):
        one, other = found.results[row], alone.results[row]
        assert one.status == "complete"
        assert (one.state == other.state).all()
        assert one.steps == other.steps
        assert len(times(found, row)) > 2
        assert (times(found, row) == times(alone, row)).all()


def test_more_starts_than_lanes_and_fewer() -> None:
    many, few = integrated(*[TILTED] * 20), integrated(TILTED)
    assert len(many.results) == 20
    assert all((one.state == few.results[0].state).all() for one in many.results)
    assert all((times(many, row) == times(few, 0)).all() for row in range(20))
    nothing = integrated()
    assert nothing.results == []
    assert len(nothing.events.time) == 0


def test_more_events_than_memory_has_room_for_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row of 1e6 s rocked through the pole some ten million times, which took 4.7 GB."""
    before = integrated(*[TILTED] * 3)
    with monkeypatch.context() as scarce:
        scarce.setattr(events, "MOST_EVENTS", len(before.events.time) - 1)
        scarce.setattr(events, "EVENTS_OF_A_ROW", 0)
        with pytest.raises(InputError, match=r"until: got a time in which 3 rows have more than"):
            integrated(*[TILTED] * 3)
        scarce.setattr(events, "EVENTS_OF_A_ROW", 1)
        after = integrated(*[TILTED] * 3)
    assert (after.events.time == before.events.time).all()


def test_no_time_is_a_start_and_an_end() -> None:
    (found,) = integrated(TILTED, until=0.0).results
    assert (found.status, found.time, found.steps) == ("complete", 0.0, 0)
    assert tuple(found.state) == TILTED
