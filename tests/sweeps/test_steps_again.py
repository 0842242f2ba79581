"""Steps taken again are those that were taken, to the last bit."""

from array import array
from typing import Any

import numpy
import pytest

from tt_precise.mechanics.formulations import integrated
from tt_precise.sweeps.columns import detectors
from tt_precise.sweeps.step_polynomials import horner
from tt_precise.sweeps.steps_again import Begun, LaneStart, StepsAgain, compiled, noted

WIDTH = 8
BODY = (0.3, 131 / 350, 2 / 5, 0.3)  # alpha, I1, I3, mu
UNTIL = 20.0


def starts() -> list[LaneStart]:
    draws = numpy.random.default_rng(1)
    found = []
    for theta, turn in zip(draws.uniform(0.05, 2, WIDTH), draws.normal(size=WIDTH), strict=True):
        k = (numpy.sin(theta), 0.0, numpy.cos(theta))
        state = (*k, 0.1 * turn, 0.05, 2.8, 0.0, 0.0)
        found.append(LaneStart(tuple(map(float, state)), BODY, UNTIL))
    return found


@pytest.fixture(scope="module")
def flown() -> tuple[StepsAgain, Any, Any, Any]:
    """Eight rows with all events found on the way: states and times of steps, series, events."""
    form, rows = integrated("gliding", "newton"), starts()
    found = [(n, one) for n, one in enumerate(detectors((), "gliding")) if one.side is not None]
    hits = array("d")
    batch, _ = compiled(form, "unilateral", WIDTH, found, hits)
    batch.state[:] = numpy.array([one.state for one in rows]).T
    batch.pars[:] = numpy.array([one.parameters for one in rows]).T
    series, times = [], [numpy.zeros((2, WIDTH))]

    def record(_: Any) -> bool:
        series.append(batch.tc.copy())
        times.append(numpy.array(batch.dtime))
        return True

    batch.propagate_until([UNTIL] * WIDTH, callback=record)
    again = StepsAgain(form, "unilateral", WIDTH, found)
    again.open(rows)
    return again, numpy.array(series), numpy.array(times), noted(hits)


def test_series_are_the_same_in_any_company(flown: Any) -> None:
    again, series, _, _ = flown
    draws = numpy.random.default_rng(2)
    for count in (1, 7, 8, 50):
        step, lane = draws.integers(0, 30, count), draws.integers(0, WIDTH, count)
        expected = series[step, :, :, lane]
        found = again.series(lane, expected[:, :, 0].T)
        assert numpy.array_equal(found, expected.transpose(1, 2, 0))
    nudged = again.series(lane, numpy.nextafter(expected[:, :, 0].T, 9))
    assert not numpy.array_equal(nudged[:, 1:], found[:, 1:])


def test_states_are_on_the_series(flown: Any) -> None:
    again, series, _, _ = flown
    lane, since = numpy.arange(5), numpy.linspace(0, 0.1, 5)
    one = series[3, :, :, :5]
    expected = [[horner(one[entry, :, n], since[n]) for entry in range(8)] for n in range(5)]
    assert again.states(lane, one[:, 0], since) == pytest.approx(numpy.array(expected), rel=1e-14)


def test_events_are_those_found_on_the_way(flown: Any) -> None:
    again, series, times, on_the_way = flown
    assert len(on_the_way.time) > 30
    without_low_parts = 0
    for lane in range(WIDTH):
        mine = on_the_way.only(on_the_way.place == lane)
        steps = len(series)
        rows, (high, low) = numpy.full(steps, lane), times[:-1, :, lane].T
        found = again.zeros(Begun(rows, high, low, series[:, :, 0, lane].T))
        taken = times[1:, 0, lane] > high
        found = found.only(taken[found.place])  # a lane that has ended waits for the others
        for detector in numpy.unique(mine.detector):
            one, other = mine.detector == detector, found.detector == detector
            assert list(mine.time[one]) == list(found.time[other])
            assert list(mine.direction[one]) == list(found.direction[other])
        other = again.zeros(Begun(rows, high, 0 * low, series[:, :, 0, lane].T))
        without_low_parts += list(other.only(taken[other.place]).time) == list(found.time)
    assert without_low_parts < WIDTH
