"""Lanes: one that produces NaN is recorded and leaves the others alone."""

import math
from typing import Any

import numpy

from tt_precise.sweep.columns import detectors
from tt_precise.sweep.lanes import Build, Departure, Flown, lanes

BUILD = Build("gliding", "unilateral", detectors((), "gliding"), 8)
INERTIA = (0.3, 131 / 350, 2 / 5, 0.3)  # alpha, I1, I3, mu
UPRIGHT = (0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
TILTED = (math.sin(0.1), 0.0, math.cos(0.1), 0.28, 0.0, 2.78, 0.0, 0.0)


def fly(*states: tuple[float, ...], until: float = 5.0) -> Flown:
    with lanes(BUILD) as lent:
        return lent.fly([Departure(state, INERTIA, until) for state in states])


def times(flown: Flown, flight: int) -> Any:
    return flown.events.time[flown.events.flight == flight]


def test_a_failed_lane_is_told_and_the_others_go_on() -> None:
    endless = (*UPRIGHT[:5], 1e200, 1e200, 0.0)  # its squares overflow
    alone = fly(*[TILTED] * 9)
    found = fly(*[TILTED] * 4, endless, *[TILTED] * 4)
    failed = found.arrivals[4]
    assert failed.status == "failed"
    assert failed.time == 0
    assert not numpy.isfinite(failed.state).all()
    for row in (0, 1, 2, 3, 5, 6, 7, 8):
        one, other = found.arrivals[row], alone.arrivals[row]
        assert one.status == "complete"
        assert (one.state == other.state).all()
        assert one.steps == other.steps
        assert len(times(found, row)) > 2
        assert (times(found, row) == times(alone, row)).all()


def test_more_starts_than_lanes_and_fewer() -> None:
    many, few = fly(*[TILTED] * 20), fly(TILTED)
    assert len(many.arrivals) == 20
    assert all((one.state == few.arrivals[0].state).all() for one in many.arrivals)
    assert all((times(many, flight) == times(few, 0)).all() for flight in range(20))
    nothing = fly()
    assert nothing.arrivals == []
    assert len(nothing.events.time) == 0


def test_no_time_is_a_start_and_an_end() -> None:
    (found,) = fly(TILTED, until=0.0).arrivals
    assert (found.status, found.time, found.steps) == ("complete", 0.0, 0)
    assert tuple(found.state) == TILTED
