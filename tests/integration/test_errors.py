"""Errors that are stated, against the truth."""

from typing import Any

import numpy
import pytest

from tt_precise.integration import Trajectory, heyoka_backend, integrate
from tt_precise.integration.columns import Columns, worst_digits
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
        assert 0.99 * error <= run.error_estimate[name] <= 1.01 * error, name


@pytest.fixture(scope="module")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "mp", bits=240)


def test_the_estimate_in_double_is_the_error(double: Trajectory, quad: Trajectory) -> None:
    """Extended precision, which makes the estimate, errs 2,000 times less."""
    errors = true_errors(double, quad)
    assert set(double.error_estimate) == {"t_end", *errors}
    assert_estimated(double, errors)
    true_digits = worst_digits(quad.state, errors, quad.start)
    assert double.digits == pytest.approx(true_digits, abs=0.01)


@pytest.mark.parametrize("precision", ["extended", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    run = integrate(short, precision)
    assert_estimated(run, true_errors(run, truth))


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_the_estimate_of_a_coarse_run(short: Scene, truth: Trajectory, tolerance: float) -> None:
    coarse = integrate(short, tolerance=tolerance)
    found = worst_digits(truth.state, true_errors(coarse, truth), truth.start)
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


def test_a_coarse_run_is_compared_in_its_own_arithmetic(short: Scene) -> None:
    coarse = integrate(short, tolerance=1e-8)
    (finer,) = coarse.errors.references
    euler = integrate(short, tolerance=1e-8, formulation="euler")
    finest, twin = euler.errors.references
    assert finer.precision == finest.precision == twin.precision == coarse.precision
    assert finest.tolerance < 1e-16 < finer.tolerance < twin.tolerance == coarse.tolerance
    for one in (finer, finest, twin):
        # k and L are exact in no double, so that the reference run starts on the other side of each
        assert one.start.body.alpha != coarse.start.body.alpha
        assert one.start.vectors.ky == coarse.start.vectors.ky == 0
    (wider,) = integrate(short, tolerance=1e-14).errors.references
    assert wider.precision.name == "extended"


def test_errors_at_samples_need_no_second_run(
    short: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = integrate(short, tolerance=1e-8)
    assert len(coarse.errors.references) == 1
    monkeypatch.setattr(heyoka_backend, "propagate", None)  # that a second propagation calls
    assert 5 < coarse.digits_throughout < 10


def test_an_error_that_rounding_makes_is_seen_too(reference: Scene) -> None:
    """A start that is rounded, in a scene that stands still: nothing else can err."""
    spinning = reference.varied(theta="0", omega_3="1/3", until="0.1")
    coarse = integrate(spinning, "quad", tolerance=1e-6)
    truth = coarse.precision.exact(spinning.body.I3 / 3)
    error = abs(truth - coarse.state.Lz)
    assert 0 < error <= coarse.error_estimate["Lz"] < 2 * coarse.precision.eps * truth


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
    at_the_edge = rough.varied(until="0.65771882639144194")
    torn = integrate(at_the_edge)
    assert (torn.status, integrate(at_the_edge, "quad").status) == ("complete", "contact_lost")
    assert torn.digits == 0
    assert torn.error_estimate["theta"] == float("inf")


@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double", 1e-9), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_digits_all_along_are_those_beside_the_truth(precision: str, tolerance: float) -> None:
    scene = load_scene("reference").varied(until="0.25")
    run = integrate(scene, precision, tolerance=tolerance)
    truth = integrate(scene, "triple-double")
    right = run.error_over_time(beside=[truth])["digits"].min()
    assert run.digits_throughout == pytest.approx(right, abs=0.1)
    # what is compared column by column, without first order, says the same
    names = ("kx", "Lx", "vx")
    ours, theirs = (one.frame(*names, numbers="exact") for one in (run, truth))
    at_once = run.error_over_time(*names, beside=[truth])
    for name in names:
        worst = max(abs(ours[name] - theirs[name]))
        assert float(worst) == pytest.approx(at_once[name].max(), rel=0.05)


def test_a_scene_at_rest_in_v_a_loses_nothing_beside_itself() -> None:
    """Planar motion: all rates vanish where it turns back; and v_A decays to nothing."""
    rocking = integrate("rocking", tolerance=1e-10, events=("theta_max",))
    assert rocking.digits_throughout > 6
    decayed = integrate(load_scene("reference").varied(until="60"), tolerance=1e-10)
    assert decayed.digits_throughout > 5
    assert max(abs(decayed.state.vx), abs(decayed.state.vy)) < 1e-8


@pytest.mark.parametrize("model", ["gliding", "rolling"])
@pytest.mark.parametrize("coordinates", COORDINATES)
def test_deviations_are_finite_differences(model: str, coordinates: str) -> None:
    scene = load_scene("reference" if model == "gliding" else "rolling").varied(until="0.1")
    record = ("phi", "psi", "x", "y")
    run = integrate(scene, formulation=coordinates, record=record, events=())
    columns, row = (
        Columns(run.setup, run.start),
        numpy.array(run.run.segments[0].output.propagation.state),
    )
    apart = numpy.random.default_rng(22).uniform(-1, 1, len(row))

    def read(h: Any, fn: Any = numpy) -> Any:
        entries = tuple((row + h * apart)[:, None])
        return columns.of_arrays(columns.names, entries, float, fn)

    found, ahead, behind = read(1e-20j, deviations()), read(1e-6), read(-1e-6)
    for name, one in found.items():
        slope, size = (ahead[name] - behind[name])[0] / 2e-6, 1 + abs(one.real[0])
        assert one.real[0] == pytest.approx(read(0)[name][0], rel=1e-15)
        assert one.imag[0] / 1e-20 == pytest.approx(slope, rel=1e-6, abs=1e-6 * size), name
