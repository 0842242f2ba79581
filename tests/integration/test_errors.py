"""Errors that are stated, against the truth."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tt_precise import golden
from tt_precise.golden.runs import events_table
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import Columns
from tt_precise.integration.errors import deviations
from tt_precise.mechanics.formulations import COORDINATES
from tt_precise.scene.scene import Scene, load_scene


def true_errors(trajectory: Trajectory, truth: Trajectory) -> dict[str, Any]:
    exact = truth.precision.context.mpf
    return {
        name: abs(exact(value) - truth.state.values[name])
        for name, value in trajectory.state.values.items()
    }


def assert_estimated(run: Trajectory, errors: dict[str, Any]) -> None:
    for name, error in errors.items():
        rounding = 1.1 * run.precision.eps * abs(run.state.values[name])  # of the stored value
        assert 0.99 * error <= run.error_estimate[name] <= 1.05 * error + rounding, name


@pytest.fixture(scope="module")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "mp", bits=240)


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    run = integrate(short, precision)
    assert_estimated(run, true_errors(run, truth))


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_the_estimate_of_a_coarse_run(short: Scene, truth: Trajectory, tolerance: float) -> None:
    coarse = integrate(short, tolerance=tolerance)
    found = float(coarse.error_over_time(beside=truth)["digits"].iloc[-1])
    # The reference run, of the same arithmetic, errs 1e-14 or so: a tenth of the error at 1e-11.
    assert coarse.digits == pytest.approx(found, abs=0.05)
    assert found < 12.5


def test_an_end_of_its_own_has_an_error_too(rough: Scene) -> None:
    lost, truth = integrate(rough), integrate(rough, "quad")
    error = abs(truth.precision.context.mpf(lost.t_end) - truth.t_end)
    assert lost.error_estimate["t_end"] == pytest.approx(float(error), rel=0.01)
    # each run has an end of its own, and its errors are those between the ends
    over_time = lost.error_over_time("kx", "vy").iloc[-1]
    assert over_time["t"] == float(lost.t_end)
    for name in ("kx", "vy"):
        assert over_time[name] == float(lost.error_estimate[name])


def test_entries_that_vanish_altogether_are_compared_with_their_unit(toppling: Scene) -> None:
    """A top without spin that falls over: phi_dot and omega_3 stay 0."""
    trajectory = integrate(toppling.varied(until="0.05"))
    assert trajectory.state.phi_dot == trajectory.state.omega_3 == 0
    assert 13 < trajectory.digits < 16


def test_an_error_of_the_time_of_the_end_counts(rough: Scene) -> None:
    lost = integrate(rough, tolerance=1e-9)
    lost.errors.at_end["t_end"] = lost.t_end / 100
    assert lost.digits_throughout == pytest.approx(2)


def test_two_arithmetics_that_end_differently_leave_no_digits(rough: Scene) -> None:
    """A horizon so close to the loss of contact that double cannot decide which comes first."""
    ends = [Fraction(str(integrate(rough, tolerance=size).t_end)) for size in (1e-7, 0.0)]
    torn = integrate(rough.varied(until=sum(ends) / 2), tolerance=1e-7)
    assert {torn.status, torn.errors.reference.status} == {"complete", "contact_lost"}
    assert torn.digits == torn.digits_throughout == 0
    assert torn.error_estimate["theta"] == float("inf")


@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double", 1e-9), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_digits_all_along_are_those_beside_the_truth(precision: str, tolerance: float) -> None:
    scene = load_scene("reference").varied(until="0.25")
    run = integrate(scene, precision, tolerance=tolerance)
    truth = integrate(scene, "triple-double")
    right = run.error_over_time(beside=truth)["digits"].min()
    assert run.digits_throughout == pytest.approx(right, abs=0.1)
    # what is compared column by column, without first order, says the same
    names = ("kx", "Lx", "vx")
    ours, theirs = (one.frame(*names, numbers="exact") for one in (run, truth))
    at_once = run.error_over_time(*names, beside=truth)
    for name in names:
        worst = max(abs(ours[name] - theirs[name]))
        assert float(worst) == pytest.approx(at_once[name].max(), rel=0.05)


@pytest.mark.parametrize("model", ["gliding", "rolling"])
@pytest.mark.parametrize("coordinates", COORDINATES)
def test_deviations_are_finite_differences(model: str, coordinates: str) -> None:
    scene = load_scene("reference" if model == "gliding" else "rolling").varied(until="0.1")
    record = ("phi", "psi", "x", "y")
    run = integrate(scene, formulation=coordinates, record=record, events=())
    columns = Columns(run.setup, run.start)
    row = numpy.array([float(x) for x in run.run.segments[0].run.row])
    apart = numpy.random.default_rng(22).uniform(-1, 1, len(row))

    def read(h: Any, fn: Any = numpy) -> Any:
        entries = tuple((row + h * apart)[:, None])
        return columns.of_arrays(columns.names, entries, float, fn)

    found, ahead, behind = read(1e-20j, deviations()), read(1e-6), read(-1e-6)
    for name, one in found.items():
        slope, size = (ahead[name] - behind[name])[0] / 2e-6, 1 + abs(one.real[0])
        assert one.real[0] == pytest.approx(read(0)[name][0], rel=1e-15)
        assert one.imag[0] / 1e-20 == pytest.approx(slope, rel=1e-6, abs=1e-6 * size), name


EVENTS = ("theta_min", "phi_dot_zero", "extremum:g_n")


@pytest.fixture(scope="module")
def true_run(short: Scene) -> Trajectory:
    return integrate(short, "double-double", events=EVENTS)


@pytest.fixture(scope="module")
def rough_run(short: Scene) -> Trajectory:
    return integrate(short, events=EVENTS, tolerance=1e-7)


def sorted_times(run: Trajectory, name: str) -> list[float]:
    events = run.events
    return [float(t) for t in events["t"][events["name"] == name]]


def stated_and_true(run: Trajectory, other: Trajectory, name: str, **beside: Any) -> Any:
    """Errors of the events of one name, as stated and as another run has them."""
    found = run.event_errors(**beside)
    apart = numpy.subtract(sorted_times(run, name), sorted_times(other, name))
    assert len(apart) > 2
    return found["error"][found["name"] == name].to_numpy(), numpy.abs(apart)


@pytest.mark.parametrize("name", EVENTS)
def test_an_estimate_is_the_error(rough_run: Trajectory, true_run: Trajectory, name: str) -> None:
    stated, error = stated_and_true(rough_run, true_run, name)
    assert error.max() > 1e-13
    # the reference errs about thirty times less
    assert (numpy.abs(stated - error) < 0.1 * error.max()).all()


@pytest.mark.parametrize("name", EVENTS)
def test_another_top_has_its_events_later(true_run: Trajectory, short: Scene, name: str) -> None:
    """Against heyoka's own events of a top whose friction is different in the ninth digit."""
    other = short.varied(mu=short.body.mu * (1 + Fraction("1e-7")))
    run = integrate(other, "double-double", events=EVENTS)
    stated, apart = stated_and_true(true_run, run, name, beside=run)
    assert stated.max() > 1e-12
    assert stated == pytest.approx(apart, rel=1e-3, abs=1e-15)


@pytest.mark.parametrize("name", ["g_n", "phi_dot", "E"])
def test_an_error_of_a_value_at_an_event_is_the_error(
    rough_run: Trajectory, true_run: Trajectory, name: str
) -> None:
    found, true = (run.event_frame(name, f"error:{name}") for run in (rough_run, true_run))
    assert list(found["name"]) == list(true["name"])
    error = numpy.array([abs(float(a - b)) for a, b in zip(found[name], true[name], strict=True)])
    assert error.max() > 1e-13
    # the reference errs about thirty times less
    assert (numpy.abs(found[f"error:{name}"] - error) < 0.1 * error.max()).all()


@pytest.mark.evidence
def test_values_where_the_top_sticks_and_slips_have_errors() -> None:
    run, names = integrate("coulomb-stick-slip"), ("g_n", "gliding_speed")
    fine = integrate("coulomb-stick-slip", digits=20)
    found, true = (
        run.event_frame(*names, "error:g_n", "error:gliding_speed"),
        fine.event_frame("g_n"),
    )
    stick = found["name"] == "stick"
    assert stick.sum() == 2
    assert (found["error:gliding_speed"] >= found["gliding_speed"])[stick].all()
    apart = [abs(float(a - b)) for a, b in zip(found["g_n"], true["g_n"], strict=True)]
    assert max(apart) > 1e-16
    assert (apart <= 1.1 * found["error:g_n"] + 1e-17).all()


def test_an_event_at_the_very_end_is_looked_at_from_before(short: Scene) -> None:
    """Three points around the event do not fit before the end."""
    changed = short.varied(mu=short.body.mu * (1 + Fraction("1e-6")))
    both, events = (short, changed), ("phi_dot_zero",)
    first = [integrate(scene, events=events).events["t"][0] for scene in both]
    late = Fraction(max(first)) + Fraction(1, 10**9)
    run, other = (integrate(scene.varied(until=late), events=events) for scene in both)
    found = run.event_errors(beside=other)
    assert found["error"].to_numpy() == pytest.approx([abs(first[1] - first[0])], rel=1e-3)


def test_digits_hold_in_events_too(rough_run: Trajectory) -> None:
    events = rough_run.event_errors()
    assert 3 < rough_run.digits_throughout <= events["digits"].min()
    assert rough_run.digits_throughout <= rough_run.error_over_time()["digits"].min()


def test_a_reference_that_ends_before_leaves_no_digits(rough_run: Trajectory, short: Scene) -> None:
    early = integrate(short.varied(until="0.05"))
    found = rough_run.event_errors("theta", beside=early)
    beyond = found["t"] > 0.05
    assert numpy.isinf(found["theta"][beyond]).all()
    assert numpy.isinf(found["error"][beyond]).all()
    assert (found["digits"][beyond] == 0).all()
    assert (found["digits"][~beyond] > 3).all()
    assert 0 < beyond.sum() < len(found)
    table = rough_run.error_over_time("theta", beside=early)
    assert (numpy.isinf(table["theta"]) == (table["t"] > 0.05)).all()
    assert ((table["digits"] == 0) == (table["t"] > 0.05)).all()
    assert table["t"].iloc[-1] > 0.05


def test_errors_of_events_in_mpmath_too(short: Scene) -> None:
    scene = short.varied(until="0.05")
    run = integrate(scene, "quad", events=("theta_min",), tolerance=1e-20)
    finer = integrate(scene, "quad", events=("theta_min",))
    found = run.event_errors(beside=finer)
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
    found = run.event_errors(beside=other)
    apart = (run.events["t"] - other.events["t"]).abs().to_numpy()
    assert apart.max() > 1e-9
    assert found["error"].to_numpy() == pytest.approx(apart, rel=1e-2, abs=1e-13)
    rolls = integrate(run.scene.varied(mu="0.5"))
    late = run.event_errors("theta", beside=rolls)
    stuck = late["t"] > late["t"][late["name"] == "slip"].min() * (1 - 1e-12)
    assert numpy.isinf(late["error"][stuck]).all()
    assert numpy.isinf(late["theta"][stuck]).all()


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
    scene = load_scene("rolling").varied(until="0.07")
    run = integrate(scene, "triple-double", events=names)
    found = run.event_errors()
    assert found["name"].tolist() == ["theta_max"] * 2
    assert found["digits"].min() > 40
    assert [row[0] for row in events_table(run, ("t", "kx")).rows] == ["theta_max"] * 2
