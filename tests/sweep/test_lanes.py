"""Lanes: one that produces NaN is recorded and leaves the others alone."""

import math

import numpy

from tt_precise.sweep.columns import detectors
from tt_precise.sweep.lanes import Arrival, Build, Departure, lanes

BUILD = Build("gliding", "unilateral", detectors((), "gliding"), 8)
INERTIA = (0.3, 131 / 350, 2 / 5, 0.3)  # alpha, I1, I3, mu
UPRIGHT = (0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
TILTED = (math.sin(0.1), 0.0, math.cos(0.1), 0.28, 0.0, 2.78, 0.0, 0.0)


def fly(*states: tuple[float, ...], until: float = 5.0) -> dict[int, Arrival]:
    with lanes(BUILD) as lent:
        return dict(lent.fly([Departure(state, INERTIA, until) for state in states]))


def test_a_failed_lane_is_told_and_the_others_go_on() -> None:
    endless = (*UPRIGHT[:5], 1e200, 1e200, 0.0)  # its squares overflow
    alone = fly(*[TILTED] * 9)
    found = fly(*[TILTED] * 4, endless, *[TILTED] * 4)
    assert found[4].status == "failed"
    assert found[4].time == 0
    assert not numpy.isfinite(found[4].state).all()
    for row in (0, 1, 2, 3, 5, 6, 7, 8):
        assert found[row].status == "complete"
        assert (found[row].state == alone[row].state).all()
        assert (found[row].times == alone[row].times).all()
        assert found[row].steps == alone[row].steps


def test_more_starts_than_lanes_and_fewer() -> None:
    many, few = fly(*[TILTED] * 20), fly(TILTED)
    assert sorted(many) == list(range(20))
    assert all((one.state == few[0].state).all() for one in many.values())
    assert fly() == {}


def test_no_time_is_a_start_and_an_end() -> None:
    (found,) = fly(TILTED, until=0.0).values()
    assert (found.status, found.time, found.steps) == ("complete", 0.0, 0)
    assert tuple(found.state) == TILTED
