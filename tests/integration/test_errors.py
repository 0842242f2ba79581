"""Errors that are stated, against the truth."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tests.integration.conftest import against, changed
from tt_precise import golden
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.errors import floats
from tt_precise.scene.scene import Scene, load_scene

EVENTS = ("theta_min", "phi_dot_zero", "extremum:g_n")
COLUMNS = ("kx", "theta", "phi_dot", "nu_x", "g_n", "E", "xi", "tau_y", "psi_dot")


def assert_errors(stated: Any, true: Any) -> None:
    """The estimates are the errors, but for those of the finer run, thirty times less."""
    stated, true = floats(stated), abs(floats(true))
    assert true.max() > 1e-13
    assert (abs(stated - true) < 0.1 * true.max()).all()


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    run, exact = integrate(short, precision), truth.precision.context.mpf
    for name, value in run.state.values.items():
        error = abs(exact(value) - truth.state.values[name])
        rounding = 1.1 * run.precision.eps * abs(value)  # of the stored value
        assert 0.99 * error <= run.error_estimate[name] <= 1.05 * error + rounding, name


def test_an_estimate_is_never_below_the_rounding_of_what_is_stored() -> None:
    """At t = 0 vy is 0.39999999999999997 in double, 0.4 exactly."""
    run = integrate("kicked", until="0.1")
    row = run.frame("vy", "error:vy").iloc[0]
    assert 0 < abs(Fraction(row["vy"]) - Fraction("0.4")) <= row["error:vy"] < 1e-16


def test_an_end_of_its_own_has_an_error_too(rough: Scene) -> None:
    lost, truth = integrate(rough), integrate(rough, "quad")
    error = abs(truth.precision.context.mpf(lost.t_end) - truth.t_end)
    assert lost.error_estimate["t_end"] == pytest.approx(float(error), abs=2e-16)
    # each run has an end of its own, and its errors are those between the ends
    last = lost.frame("error:kx", "error:vy").iloc[-1]
    ends = {"t": lost.t_end} | {f"error:{n}": lost.error_estimate[n] for n in ("kx", "vy")}
    assert last.to_dict() == ends
    coarse = integrate(rough, tolerance=1e-9)
    coarse.errors.at_end["t_end"] = coarse.t_end / 100
    assert coarse.digits_throughout == pytest.approx(2)


def test_entries_that_vanish_altogether_are_compared_with_their_unit(toppling: Scene) -> None:
    """A top without spin that falls over: phi_dot and omega_3 stay 0."""
    trajectory = integrate(toppling.varied(until="0.05"))
    assert trajectory.state.phi_dot == trajectory.state.omega_3 == 0
    assert 13 < trajectory.digits < 16


def test_two_arithmetics_that_end_differently_leave_no_digits(rough: Scene) -> None:
    """A horizon so close to the loss of contact that double cannot decide which comes first."""
    ends = [Fraction(str(integrate(rough, tolerance=size).t_end)) for size in (1e-7, 0.0)]
    torn = integrate(rough.varied(until=sum(ends) / 2), tolerance=1e-7)
    assert {torn.status, torn.errors.reference.status} == {"complete", "contact_lost"}
    assert torn.digits == torn.digits_throughout == 0
    assert torn.error_estimate["theta"] == float("inf")


@pytest.mark.parametrize("formulation", ["newton", "euler"])
@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double", 1e-9), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_errors_all_along_are_those_beside_the_truth(
    precision: str, tolerance: float, formulation: str
) -> None:
    """Errors of first order, and columns that are compared one by one, say the same."""
    scene = load_scene("reference").varied(until="0.25")
    run, truth = (
        integrate(scene, one, tolerance=size, formulation=formulation)
        for one, size in ((precision, tolerance), ("triple-double", 0.0))
    )
    names = COLUMNS if formulation == "newton" else COLUMNS[1:]
    table = against(run, truth).over_time(names)
    assert run.digits_throughout == pytest.approx(table["digits"].min(), abs=0.1)
    ours, theirs = (one.frame(*names, numbers="exact") for one in (run, truth))
    for name in names:
        worst = max(abs(ours[name] - theirs[name]))
        assert float(worst) == pytest.approx(table[name].max(), rel=0.05), name


@pytest.fixture(scope="module")
def true_run(short: Scene) -> Trajectory:
    return integrate(short, "double-double", events=EVENTS)


@pytest.fixture(scope="module")
def rough_run(short: Scene) -> Trajectory:
    return integrate(short, events=EVENTS, tolerance=1e-7)


@pytest.mark.parametrize("name", EVENTS)
def test_an_estimate_is_the_error_of_an_event(
    rough_run: Trajectory, true_run: Trajectory, name: str
) -> None:
    found, true = (run.event_frame("error:t") for run in (rough_run, true_run))
    rows = (found["name"] == name) & (true["name"] == name)
    assert_errors(found["error:t"][rows], (found["t"] - true["t"])[rows])


@pytest.mark.parametrize("name", ["g_n", "phi_dot", "E"])
def test_an_estimate_is_the_error_of_a_value_at_an_event(
    rough_run: Trajectory, true_run: Trajectory, name: str
) -> None:
    found, true = (run.event_frame(name, f"error:{name}") for run in (rough_run, true_run))
    assert list(found["name"]) == list(true["name"])
    assert_errors(found[f"error:{name}"], found[name] - true[name])


@pytest.mark.parametrize(
    ("precision", "tolerance"), [("double-double", 0.0), ("quad", 1e-20)], ids=["dd", "quad"]
)
def test_another_top_has_its_events_later(short: Scene, precision: str, tolerance: float) -> None:
    """Against the events of a top whose friction is different in the ninth digit."""
    run, other = (
        integrate(scene.varied(until="0.05"), precision, events=EVENTS, tolerance=size)
        for scene, size in ((short, tolerance), (changed(short, mu="1e-7"), 0.0))
    )
    found = against(run, other).events()
    apart = abs(floats(run.events["t"]) - floats(other.events["t"]))
    assert apart.max() > 1e-12
    assert found["error"] == pytest.approx(apart, rel=1e-3, abs=1e-15)


def test_an_event_at_the_very_end_is_looked_at_from_before(short: Scene) -> None:
    """Three points around the event do not fit before the end."""
    both, events = (short, changed(short, mu="1e-6")), ("phi_dot_zero",)
    first = [integrate(scene, events=events).events["t"][0] for scene in both]
    late = Fraction(max(first)) + Fraction(1, 10**9)
    run, other = (integrate(scene.varied(until=late), events=events) for scene in both)
    found = against(run, other).events()
    assert found["error"] == pytest.approx([abs(first[1] - first[0])], rel=1e-3)


def test_digits_hold_in_events_too(rough_run: Trajectory, reference: Scene) -> None:
    """The spike of phi_dot lies between samples, and has five digits fewer than they have."""
    spike = integrate(
        reference.varied(until="3.3"), "double-double", tolerance=1e-26, events="extremum:phi_dot"
    )
    for run in (rough_run, spike):
        least = [one("digits")["digits"].min() for one in (run.event_frame, run.frame)]
        assert 3 < run.digits_throughout == min(least)
    assert least[0] < least[1]


def test_a_reference_that_ends_before_leaves_no_digits(rough_run: Trajectory, short: Scene) -> None:
    early = integrate(short.varied(until="0.05"))
    errors = against(rough_run, early)
    found, table = errors.events(("theta",)), errors.over_time(("theta",))
    assert 0 < (found["t"] > 0.05).sum() < len(found["t"])
    for rows, names in ((found, ("theta", "error")), (table, ("theta",))):
        beyond = rows["t"] > 0.05
        assert ((rows["digits"] == 0) == beyond).all()
        for name in names:
            assert (numpy.isinf(rows[name]) == beyond).all()


@pytest.mark.parametrize("name", ["elastic-linear", "coulomb-stick-slip"])
def test_every_event_of_several_pieces_has_its_error(name: str) -> None:
    run, true = integrate(name, tolerance=1e-7), golden.load(name).events
    wanted = (*run.scene.events, "stick", "slip", "separation", "landing")
    true = true[true["name"].isin(wanted)]
    found = run.event_frame("error:t", "digits")
    assert list(found["name"]) == list(true["name"])
    assert_errors(found["error:t"], found["t"].to_numpy() - floats(true["t"]))
    assert (found["digits"] > 4).all()
