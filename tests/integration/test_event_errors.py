"""Errors of events: what a reference run without events says, against one that looks for them."""

from fractions import Fraction

import numpy
import pytest

import tt_precise as tt
from tt_precise import golden
from tt_precise.golden.runs import events_table
from tt_precise.integration import Trajectory, integrate
from tt_precise.scene.scene import Scene

EVENTS = ("theta_min", "phi_dot_zero", "extremum:g_n")


@pytest.fixture(scope="module")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "extended", events=EVENTS)


@pytest.fixture(scope="module")
def coarse(short: Scene) -> Trajectory:
    return integrate(short, events=EVENTS, tolerance=1e-7)


def sorted_times(run: Trajectory, name: str) -> list[float]:
    events = run.events
    return [float(t) for t in events["t"][events["name"] == name]]


@pytest.mark.parametrize("name", EVENTS)
def test_the_estimate_is_the_error(coarse: Trajectory, truth: Trajectory, name: str) -> None:
    found = coarse.event_errors()
    stated = found["error"][found["name"] == name].to_numpy()
    error = numpy.abs(numpy.subtract(sorted_times(coarse, name), sorted_times(truth, name)))
    assert len(error) > 2
    assert error.max() > 1e-13
    # the reference errs about thirty times less
    assert (numpy.abs(stated - error) < 0.1 * error.max()).all()


@pytest.mark.parametrize("name", EVENTS)
def test_another_top_has_its_events_later(truth: Trajectory, short: Scene, name: str) -> None:
    """Against heyoka's own events of a top whose friction is different in the ninth digit."""
    other = integrate(short.perturbed(mu="1e-7"), "extended", events=EVENTS)
    found = truth.event_errors(beside=[other])
    apart = numpy.subtract(sorted_times(other, name), sorted_times(truth, name))
    stated = found["error"][found["name"] == name].to_numpy()
    assert stated.max() > 1e-12
    assert stated == pytest.approx(numpy.abs(apart), rel=1e-3, abs=1e-15)


def test_an_event_at_the_very_end_is_looked_at_from_before(short: Scene) -> None:
    """Where three points around it do not fit before the end."""
    another = short.perturbed(mu="1e-6")
    first = [
        sorted_times(integrate(one, events=EVENTS[1:2]), EVENTS[1])[0] for one in (short, another)
    ]
    late = Fraction(max(first)) + Fraction(1, 10**9)
    run, other = (integrate(one.varied(until=late), events=EVENTS[1:2]) for one in (short, another))
    found = run.event_errors(beside=[other])
    assert found["error"].to_numpy() == pytest.approx([abs(first[1] - first[0])], rel=1e-3)


def test_digits_hold_in_events_too(coarse: Trajectory) -> None:
    events = coarse.event_errors()
    assert 3 < coarse.digits_throughout <= events["digits"].min()
    assert coarse.digits_throughout <= coarse.error_over_time()["digits"].min()


def test_a_reference_that_ends_before_leaves_no_digits(coarse: Trajectory, short: Scene) -> None:
    early = integrate(short.varied(until="0.05"))
    found = coarse.event_errors(beside=[early])
    beyond = found["t"] > 0.05
    assert numpy.isinf(found["error"][beyond]).all()
    assert (found["digits"][beyond] == 0).all()
    assert (found["digits"][~beyond] > 3).all()
    assert 0 < beyond.sum() < len(found)


def test_in_mpmath_too(short: Scene) -> None:
    scene = short.varied(until="0.05")
    run = integrate(scene, "quad", events=("theta_min",), tolerance=1e-20)
    finer = integrate(scene, "quad", events=("theta_min",))
    found = run.event_errors(beside=[finer])
    true = abs(run.events["t"].iloc[0] - finer.events["t"].iloc[0])
    assert found["error"][0] == pytest.approx(float(true), rel=1e-3)
    assert 15 < found["digits"].min() < 25


@pytest.mark.parametrize("name", ["elastic-linear", "coulomb-stick-slip"])
def test_every_event_of_several_pieces_has_its_error(name: str) -> None:
    run, true = integrate(name, tolerance=1e-7), golden.load(name).events
    wanted = (*run.scene.events, "stick", "slip", "separation", "landing")
    true = true[true["name"].isin(wanted)]
    found = run.event_errors()
    assert list(found["name"]) == list(run.events["name"]) == list(true["name"])
    error = numpy.abs(found["t"].to_numpy() - true["t"].to_numpy(float))
    assert error.max() > 1e-12
    # the reference run errs about thirty times less
    assert (numpy.abs(found["error"] - error) < 0.1 * error.max()).all()
    assert (found["digits"] > 4).all()


def test_another_top_has_its_pieces_at_other_times() -> None:
    run = integrate("coulomb-stick-slip")
    other = integrate(run.scene.varied(mu="0.0500001"), events=run.setup.events)
    found = run.event_errors(beside=[other])
    apart = (run.events["t"] - other.events["t"]).abs().to_numpy()
    assert apart.max() > 1e-9
    assert found["error"].to_numpy() == pytest.approx(apart, rel=1e-2, abs=1e-13)
    rolls = integrate(run.scene.varied(mu="0.5"))
    late = run.event_errors(beside=[rolls])
    stuck = late["t"] > late["t"][late["name"] == "slip"].min() * (1 - 1e-12)
    assert numpy.isinf(late["error"][stuck]).all()


def test_digits_hold_in_the_events_of_several_doubles_too(reference: Scene) -> None:
    """The spike of phi_dot lies between samples, and has five digits fewer than they have."""
    scene = reference.varied(until="3.3")
    run = integrate(scene, "double-double", tolerance=1e-26, events=("extremum:phi_dot",))
    in_events = run.event_errors()["digits"].min()
    assert run.error_over_time()["digits"].min() > in_events
    assert run.digits_throughout == in_events


def test_a_touch_is_no_event_and_claims_no_digits() -> None:
    """At the cusps of a top on ice phi_dot only touches zero; the extrema of theta cross it."""
    names = ("phi_dot_zero", "theta_max")
    scene = tt.load_scene("rolling").varied(until="0.07")
    run = tt.integrate(scene, "triple-double", events=names)
    found = run.event_errors()
    assert found["name"].tolist() == ["theta_max"] * 2
    assert found["digits"].min() > 40
    assert [row[0] for row in events_table(run, ("t", "kx")).rows] == ["theta_max"] * 2
