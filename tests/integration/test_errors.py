"""Errors that are stated, against the truth."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tests.integration.conftest import against
from tt_precise import golden
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import Columns
from tt_precise.integration.errors import deviations
from tt_precise.mechanics.formulations import COORDINATES
from tt_precise.scene.scene import Scene, load_scene

INFINITE = float("inf")


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    run, exact = integrate(short, precision), truth.precision.context.mpf
    for name, value in run.state.values.items():
        error = abs(exact(value) - truth.state.values[name])
        rounding = 1.1 * run.precision.eps * abs(value)  # of the stored value
        assert 0.99 * error <= run.error_estimate[name] <= 1.05 * error + rounding, name


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_the_estimate_of_a_coarse_run(short: Scene, truth: Trajectory, tolerance: float) -> None:
    coarse = integrate(short, tolerance=tolerance)
    found = against(coarse, truth).digits_at_end
    # the finer run, of the same arithmetic, errs 1e-14 or so: a tenth of the error at 1e-11
    assert coarse.digits == pytest.approx(found, abs=0.05)
    assert found < 12.5


def test_an_end_of_its_own_has_an_error_too(rough: Scene) -> None:
    lost, truth = integrate(rough), integrate(rough, "quad")
    error = abs(truth.precision.context.mpf(lost.t_end) - truth.t_end)
    assert lost.error_estimate["t_end"] == pytest.approx(float(error), abs=2e-16)
    # each run has an end of its own, and its errors are those between the ends
    last = lost.frame("error:kx", "error:vy").iloc[-1]
    assert last["t"] == float(lost.t_end)
    assert [last[f"error:{name}"] for name in ("kx", "vy")] == [
        lost.error_estimate[name] for name in ("kx", "vy")
    ]
    coarse = integrate(rough, tolerance=1e-9)
    coarse.errors.at_end["t_end"] = coarse.t_end / 100
    assert coarse.digits_throughout == pytest.approx(2)


def test_two_arithmetics_that_end_differently_leave_no_digits(rough: Scene) -> None:
    """A horizon so close to the loss of contact that double cannot decide which comes first."""
    ends = [Fraction(str(integrate(rough, tolerance=size).t_end)) for size in (1e-7, 0.0)]
    torn = integrate(rough.varied(until=sum(ends) / 2), tolerance=1e-7)
    assert {torn.status, torn.errors.reference.status} == {"complete", "contact_lost"}
    assert torn.digits == torn.digits_throughout == 0
    assert torn.error_estimate["theta"] == INFINITE


@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double", 1e-9), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_digits_throughout_are_those_against_the_truth(precision: str, tolerance: float) -> None:
    scene = load_scene("reference").varied(until="0.25")
    run, truth = integrate(scene, precision, tolerance=tolerance), integrate(scene, "triple-double")
    names = ("kx", "Lx", "vx")
    found = against(run, truth).over_time(names)
    assert run.digits_throughout == pytest.approx(found["digits"].min(), abs=0.1)
    # what is compared column by column, without first order, says the same
    ours, theirs = (one.frame(*names, numbers="exact") for one in (run, truth))
    for name in names:
        worst = max(abs(ours[name] - theirs[name]))
        assert float(worst) == pytest.approx(found[name].max(), rel=0.05)


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


@pytest.mark.parametrize("name", ["t", "g_n", "phi_dot", "E"])
def test_an_error_at_an_event_is_the_error(
    rough_run: Trajectory, true_run: Trajectory, name: str
) -> None:
    found, true = (run.event_frame(name, f"error:{name}") for run in (rough_run, true_run))
    assert list(found["name"]) == list(true["name"])
    assert set(found["name"]) == set(EVENTS)
    error = numpy.array([abs(float(a - b)) for a, b in zip(found[name], true[name], strict=True)])
    assert error.max() > 1e-13
    # the finer run errs about thirty times less
    assert (numpy.abs(found[f"error:{name}"] - error) < 0.1 * error.max()).all()


@pytest.mark.evidence
def test_values_where_the_top_sticks_and_slips_have_errors() -> None:
    run, names = integrate("coulomb-stick-slip"), ("g_n", "gliding_speed")
    fine = integrate("coulomb-stick-slip", digits=20)
    found = run.event_frame(*names, "error:g_n", "error:gliding_speed")
    stick = found["name"] == "stick"
    assert stick.sum() == 2
    assert (found["error:gliding_speed"] >= found["gliding_speed"])[stick].all()
    true = fine.event_frame("g_n")["g_n"]
    apart = [abs(float(a - b)) for a, b in zip(found["g_n"], true, strict=True)]
    assert max(apart) > 1e-16
    assert (apart <= 1.1 * found["error:g_n"] + 1e-17).all()


def test_a_finer_run_that_ends_before_leaves_no_digits(rough_run: Trajectory, short: Scene) -> None:
    errors = against(rough_run, integrate(short.varied(until="0.05")))
    for found in (errors.events(("theta",)), errors.over_time(("theta",))):
        beyond = found["t"] > 0.05
        assert 0 < beyond.sum() < len(beyond)
        assert (numpy.isinf(found["theta"]) == beyond).all()
        assert ((found["digits"] == 0) == beyond).all()
        assert (found["digits"][~beyond] > 3).all()


@pytest.mark.parametrize("name", ["elastic-linear", "coulomb-stick-slip"])
def test_every_event_of_several_segments_has_its_error(name: str) -> None:
    run, true = integrate(name, tolerance=1e-7), golden.load(name).events
    names = (*run.scene.events, "stick", "slip", "separation", "landing")
    true = true[true["name"].isin(names)]
    found = run.errors.events()
    assert list(found["name"]) == list(run.events["name"]) == list(true["name"])
    error = numpy.abs(found["t"] - true["t"].to_numpy(float))
    assert error.max() > 1e-12
    # the finer run errs about thirty times less
    assert (numpy.abs(found["error"] - error) < 0.1 * error.max()).all()
    assert (found["digits"] > 4).all()


def test_digits_hold_in_the_events_too(reference: Scene) -> None:
    """The spike of phi_dot lies between samples, and has five digits fewer than they have."""
    scene = reference.varied(until="3.3")
    run = integrate(scene, "double-double", tolerance=1e-26, events=("extremum:phi_dot",))
    in_events = run.errors.events()["digits"].min()
    assert run.frame("digits")["digits"].min() > in_events
    assert run.digits_throughout == in_events
