"""The flow of the Newton-Euler equations: closed forms, the package's own runs, mode switches."""

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import rows_of
from tt_precise.check import law_flow, residuals
from tt_precise.check.law_flow import HALVINGS, MOST_TURN, TURN, propagate
from tt_precise.check.residuals import flow_state
from tt_precise.mechanics.flight import fly
from tt_precise.mechanics.vectors import RigidBodyState


def oscillator(y: numpy.ndarray) -> numpy.ndarray:
    return numpy.array([y[1], -y[0]])


def test_an_oscillator_turns_as_its_closed_form() -> None:
    """Up to the largest angle of one extrapolation the error is that of rounding."""
    spans = numpy.linspace(0.01, TURN, 50)
    start = numpy.tile([[1.0], [0.0]], 50)
    end = propagate(oscillator, start, spans, numpy.ones(2), 1e-13)
    assert abs(end.state - [numpy.cos(spans), -numpy.sin(spans)]).max() < 1e-13
    assert end.error.max() <= 1e-13


def test_spans_are_halved_as_often_as_they_may_be_and_no_more() -> None:
    spans = numpy.array([MOST_TURN, 100 * MOST_TURN])
    start = numpy.tile([[1.0], [0.0]], 2)
    for turn in (0.0, MOST_TURN):  # halved where it fails, or at once
        end = propagate(oscillator, start, spans, numpy.ones(2), 1e-12, turn=turn)
        assert end.error[0] <= 64e-12
        assert abs(end.state[0, 0] - numpy.cos(spans[0])) < 1e-10
        assert end.error[1] == numpy.inf  # out of reach of the halvings
    assert propagate(oscillator, start, spans, numpy.ones(2), 1e-12, halvings=0).error[0] > 1
    assert TURN * 2**HALVINGS == MOST_TURN


def test_a_dip_between_two_rows_is_bounded_from_below() -> None:
    start, spans = numpy.array([[1.0], [0.0]]), numpy.array([numpy.pi])
    end = propagate(oscillator, start, spans, numpy.ones(2), 1e-12, watch=lambda y: y[0] + 0.5)
    assert -1.5 < end.least[0] < -0.5


def test_a_flight_is_a_free_rotation_and_a_parabola() -> None:
    rows = rows_of("flight")
    law, y = residuals.law_of(rows), flow_state(rows.motion)
    spans = numpy.full(y.shape[1], 0.05)
    end = law.flow(y, spans, residuals.flow_sizes(rows), 1e-13)
    for row in range(0, y.shape[1], 5):
        start = RigidBodyState(*y[:4, row], *rows.omega[:, row], *y[7:10, row])
        true = fly(rows.body, start, 0.05, numpy)
        assert abs(end.state[:4, row] - numpy.array(true[:4])).max() < 1e-12
        assert abs(end.state[7:10, row] - numpy.array(true[7:])).max() < 1e-13


@pytest.mark.parametrize(
    "scene",
    ["reference", "rolling", "frictionless", "regularised-1e-2", "stribeck", "elastic-linear"],
)
def test_the_flow_follows_the_packages_runs(scene: str) -> None:
    steps = residuals.by_law(rows_of(scene))
    assert steps.state is not None
    assert abs(steps.state).max() < 1e-10
    seen = numpy.isfinite(steps.bounds["state"])
    assert seen.mean() > 0.9
    assert (abs(steps.state[:, seen]).max(axis=0) < 20 * steps.bounds["state"][seen] + 1e-12).all()


@pytest.mark.parametrize("scene", ["coulomb-stick-slip", "elastic-hunt-crossley"])
def test_changes_of_the_phase_are_integrated(scene: str) -> None:
    rows = rows_of(scene)
    steps, law, y = residuals.by_law(rows), residuals.law_of(rows), flow_state(rows.motion)
    assert steps.state is not None
    assert steps.least is not None
    assert law.may_change(y, steps.least).any()
    assert numpy.isfinite(steps.bounds["state"]).all()
    assert abs(steps.state).max() < 1e-9
    # the friction cone of another law is seen in these intervals
    scene_ = tt.load_scene(scene)
    if scene_.may_stick:
        other = residuals.by_law(rows_of(scene, of=scene_.varied(mu="0.31")))
        assert other.state is not None
        assert abs(other.state).max() > 1e-4


def test_a_row_behind_the_end_of_the_motion_is_infinitely_wrong() -> None:
    """Up to the angle LATE of the spin the row is at the end: here the top lands."""
    run = tt.integrate("flight", events=())
    rows, end = rows_of("flight"), float(run.t_end)
    law, y = residuals.law_of(rows), flow_state(rows.motion)[:, 15:16]
    for late, seen in ((0.5, True), (2.0, False)):
        span = numpy.array([end - rows.t[15] + late * law_flow.LATE / rows.spin_rate])
        state, bound = law_flow.integrate_scene(law, y, span)
        assert numpy.isfinite(state.kz).all() == seen
        assert (bound < 1e-9).all()


def test_phases_are_told_apart() -> None:
    rows = rows_of("coulomb-stick-slip")
    law, y = residuals.law_of(rows), flow_state(rows.motion)
    names, counts = numpy.unique(law.phases(y), return_counts=True)
    assert [*zip(names, counts, strict=True)] == [("gliding", 43), ("resting", 8)]
    # up to a few hundred roundings of R omega the contact point rests
    still = y[:, law.phases(y) == "resting"][:, -1:]
    for speed, name in ((0.5, "resting"), (2.0, "gliding")):
        here = still.copy()
        here[7:9] += speed * law_flow.AT_REST * law.speed / numpy.sqrt(2)
        assert law.phases(here) == name
    elastic = rows_of("elastic-linear")
    names = numpy.unique(residuals.law_of(elastic).phases(flow_state(elastic.motion)))
    assert {*names} <= {"elastic", "flight"}


def test_a_dip_of_the_normal_force_between_rows_is_found() -> None:
    """Ten milliseconds apart the rows show 0.31 of the weight, the motion between them 0.287."""
    rows = rows_of("reference")
    law, y, spans = residuals.law_of(rows), flow_state(rows.motion), numpy.diff(rows.t)
    least = law.least_margins(y[:, :-1], spans, residuals.flow_sizes(rows))
    lowest = int(numpy.argmin(least))
    times = numpy.linspace(rows.t[lowest], rows.t[lowest + 1], 1001).tolist()
    between = tt.integrate("reference", events=()).frame("g_n", times=times, numbers="float")["g_n"]
    assert least.min() == pytest.approx(between.min() / rows.body.m / rows.body.g, abs=3e-4)
    assert law.margins(law.phases(y), y).min() > least.min() + 0.02
