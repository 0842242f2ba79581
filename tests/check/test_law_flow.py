"""The flow of the Newton-Euler equations: closed forms, the package's own runs, mode switches."""

from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import check, rows_of, trajectory, vectors
from tt_precise.check import law_flow, residuals
from tt_precise.check.law_flow import MOST_TURN, TURN, FlowEnd, propagate
from tt_precise.check.residuals import flow_state

ONES = numpy.ones(2)


def turned(spans: numpy.ndarray, tolerance: float, **words: Any) -> FlowEnd:
    """Return oscillators after their spans."""
    start = numpy.tile([[1.0], [0.0]], len(spans))
    return propagate(lambda y: numpy.array([y[1], -y[0]]), start, spans, ONES, tolerance, **words)


def test_an_oscillator_turns_as_its_closed_form() -> None:
    """Up to the largest angle of one extrapolation the error is that of rounding."""
    spans = numpy.linspace(0.01, TURN, 50)
    end = turned(spans, 1e-13)
    assert abs(end.state - [numpy.cos(spans), -numpy.sin(spans)]).max() < 1e-13
    assert end.error.max() <= 1e-13


def test_spans_are_halved_as_often_as_they_may_be_and_no_more() -> None:
    spans = numpy.array([MOST_TURN, 100 * MOST_TURN])
    for turn in (0.0, MOST_TURN):  # halved where it fails, or at once
        end = turned(spans, 1e-12, turn=turn)
        assert end.error[0] <= 64e-12
        assert abs(end.state[0, 0] - numpy.cos(spans[0])) < 1e-10
        assert end.error[1] == numpy.inf  # out of reach of the halvings
    assert turned(spans, 1e-12, halvings=0).error[0] > 1


SMOOTH = ("reference", "rolling", "frictionless", "regularised-1e-2", "stribeck", "flight")


@pytest.mark.parametrize("scene", [*SMOOTH, "elastic-linear"])
def test_the_flow_follows_the_packages_runs(scene: str) -> None:
    steps = residuals.by_law(rows_of(scene))
    assert abs(steps.state).max() < 1e-10
    seen = numpy.isfinite(steps.bounds["state"])
    assert seen.mean() > 0.9
    assert (abs(steps.state[:, seen]).max(axis=0) < 20 * steps.bounds["state"][seen] + 1e-12).all()


@pytest.mark.parametrize(
    ("scene", "largest"), [("coulomb-stick-slip", 1.77e-13), ("elastic-hunt-crossley", 7.1e-15)]
)
def test_changes_of_the_phase_are_integrated(scene: str, largest: float) -> None:
    """The bound is two roundings a step, times the growth of the distance from a neighbour."""
    rows = rows_of(scene)
    steps, law, y = residuals.by_law(rows), residuals.law_of(rows), flow_state(rows.motion)
    assert abs(steps.state).max() < 1e-9
    switches = law.may_change(y, steps.least)[0]
    errors, bounds = abs(steps.state[:, switches]).max(axis=0), steps.bounds["state"][switches]
    assert (errors < bounds).all()
    assert bounds.max() == pytest.approx(largest, rel=0.1, abs=0)
    # the friction of another law is seen in these intervals
    other = residuals.by_law(rows_of(scene, of=tt.load_scene(scene).varied(mu="0.31")))
    assert abs(other.state).max() > 1e-4


def test_a_row_behind_the_end_of_the_motion_is_infinitely_wrong() -> None:
    """Up to the angle LATE of the spin the row is at the end: here the top lands."""
    rows, end = rows_of("flight"), float(trajectory("flight").t_end)
    law, y = residuals.law_of(rows), flow_state(rows.motion)[:, 15:16]
    for late, finite in ((0.5e-9, True), (2e-9, False)):
        span = numpy.array([end - rows.t[15] + late / rows.spin_rate])
        state, bound = law_flow.integrate_scene(law, y, span)
        assert numpy.isfinite(state.kz).all() == finite
        assert (bound < 1e-9).all()


def test_phases_are_told_apart() -> None:
    rows = rows_of("coulomb-stick-slip")
    law, y = residuals.law_of(rows), flow_state(rows.motion)
    names, counts = numpy.unique(law.phases(y), return_counts=True)
    assert [*zip(names, counts, strict=True)] == [("gliding", 43), ("resting", 8)]
    # up to 256 roundings of R omega the contact point rests
    still = y[:, law.phases(y) == "resting"][:, -1:]
    for speed, name in ((128, "resting"), (512, "gliding")):
        here = still.copy()
        here[7:9] += speed * law_flow.EPS * law.speed / numpy.sqrt(2)
        assert law.phases(here) == name


@pytest.mark.parametrize(("off", "follows"), [(0.0, True), (0.9e-3, True), (1.1e-3, False)])
def test_a_dip_of_the_normal_force_between_rows_is_found(off: float, follows: bool) -> None:
    """Ten milliseconds apart the rows show 0.31 of the weight, the motion between them 0.287.

    Between rows that are off the equations by more than 1e-3 the motion is not the equations'.
    """
    frame = vectors()
    frame["vx"] += off * 0.02 * 155 * (frame.index >= 537)
    contact = check(frame, "reference")["contact"]
    times = numpy.linspace(5.37, 5.38, 1001).tolist()
    between = trajectory("reference").frame("g_n", times=times, numbers="float")["g_n"]
    least = between.min() / (0.02 * 9.82)
    assert (contact.value == pytest.approx(least, abs=2e-3 if off else 2e-4)) == follows
    assert (contact.value or 0) < 0.32
