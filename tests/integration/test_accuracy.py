"""Errors that are stated, against the truth; digits that are wanted, delivered or refused."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration import Trajectory, cost_table, dense_output, integrate, to_digits
from tt_precise.integration import propagate as propagation
from tt_precise.integration.accuracy import worst_digits
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Inclination, Scene, Start


def true_errors(trajectory: Trajectory, truth: Trajectory) -> dict[str, Any]:
    exact = truth.precision.context.mpf
    return {
        name: abs(exact(value) - truth.state.values[name])
        for name, value in trajectory.state.values.items()
    }


def true_digits(trajectory: Trajectory, truth: Trajectory) -> float:
    """Digits of the worst entry."""
    return worst_digits(truth.state, true_errors(trajectory, truth), truth.start)


@pytest.fixture(scope="module")
def short(reference: Scene) -> Scene:
    """A tenth of a second: three oscillations, a tenth of a second's work for 240 bits too."""
    return replace(reference, until=Fraction(1, 10))


@pytest.fixture(scope="module")
def truth(short: Scene) -> Trajectory:
    return integrate(short, "mp", bits=240)


def test_the_estimate_in_double_is_the_error(double: Trajectory, quad: Trajectory) -> None:
    """Extended precision, which makes the estimate, errs 2,000 times less."""
    truth = true_errors(double, quad)
    assert set(double.error_estimate) == {"t_end", *truth}
    for name, error in truth.items():
        assert 0.99 * error <= double.error_estimate[name] <= 1.01 * error, name
    assert double.digits == pytest.approx(true_digits(double, quad), abs=0.01)


@pytest.mark.parametrize("precision", ["extended", "quad"])
def test_the_estimate_is_the_error(short: Scene, truth: Trajectory, precision: str) -> None:
    trajectory = integrate(short, precision)
    for name, error in true_errors(trajectory, truth).items():
        assert 0.99 * error <= trajectory.error_estimate[name] <= 1.01 * error, name


def test_an_end_of_its_own_has_an_error_too(rough: Scene) -> None:
    lost, truth = integrate(rough), integrate(rough, "quad")
    error = abs(truth.precision.context.mpf(lost.t_end) - truth.t_end)
    assert lost.error_estimate["t_end"] == pytest.approx(float(error), rel=0.01)
    # each run has an end of its own, and its errors are those between the ends
    over_time = lost.error_over_time("kx", "vy").iloc[-1]
    assert over_time["t"] == float(lost.t_end)
    for name in ("kx", "vy"):
        assert over_time[name] == float(lost.error_estimate[name])


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_the_estimate_follows_a_coarser_tolerance(
    short: Scene, truth: Trajectory, tolerance: float
) -> None:
    coarse = integrate(short, tolerance=tolerance, options={"compact_mode": True})
    found = true_digits(coarse, truth)
    # The reference run, of the same arithmetic, errs 1e-14 or so: a tenth of the error at 1e-11.
    assert coarse.digits == pytest.approx(found, abs=0.05)
    assert found < 12.5


def test_a_coarse_run_is_compared_in_its_own_arithmetic(short: Scene) -> None:
    options = {"compact_mode": True}
    coarse = integrate(short, tolerance=1e-8, options=options)
    (finer,) = coarse.reference_runs
    euler = integrate(short, tolerance=1e-8, formulation="euler", options=options)
    finest, twin = euler.reference_runs
    assert finer.precision == finest.precision == twin.precision == coarse.precision
    assert finest.tolerance < 1e-16 < finer.tolerance < twin.tolerance == coarse.tolerance
    for one in (finer, finest, twin):
        # k and L are exact in no double, so that the reference run starts on the other side of each
        assert one.start.body.alpha != coarse.start.body.alpha
        assert one.start.vectors.ky == coarse.start.vectors.ky == 0
    (wider,) = integrate(short, tolerance=1e-14, options=options).reference_runs
    assert wider.precision.name == "extended"


def test_neither_a_run_nor_its_reference_is_integrated_twice_for_errors_at_samples(
    short: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = integrate(short, tolerance=1e-8)
    assert len(coarse.reference_runs) == 1
    monkeypatch.setattr(dense_output, "propagate", None)  # that a second propagation calls
    assert 5 < coarse.digits_throughout < 10


def test_an_error_that_rounding_makes_is_seen_too(reference: Scene) -> None:
    """A start that is rounded, in a scene that stands still: nothing else can err."""
    spin = Fraction(1, 3)
    spinning = replace(
        reference, start=Start(Inclination.parse("0"), omega_3=spin), until=Fraction(1, 10)
    )
    coarse = integrate(spinning, "quad", tolerance=1e-6)
    truth = coarse.precision.exact(spinning.body.I3 * spin)
    error = abs(truth - coarse.state.Lz)
    assert 0 < error <= coarse.error_estimate["Lz"] < 2 * coarse.precision.eps * truth


def test_digits_never_exceed_what_the_numbers_hold(reference: Scene) -> None:
    still = integrate(replace(reference, until=Fraction(0)))
    assert still.error_estimate["vx"] == 0
    assert 15 < still.digits < 53 * 0.30104


def test_entries_that_vanish_altogether_are_compared_with_their_unit(reference: Scene) -> None:
    """A top without spin that falls over: phi_dot and omega_3 stay 0."""
    falling = replace(
        reference, start=Start(Inclination.parse("1"), Fraction(0)), until=Fraction(1, 20)
    )
    trajectory = integrate(falling)
    assert trajectory.state.phi_dot == trajectory.state.omega_3 == 0
    assert 13 < trajectory.digits < 16


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        (3, "double"),
        (11, "double"),
        (15, "double-double"),
        (28, "double-double"),
        (31, "triple-double"),
        (40, "triple-double"),
        (50, "mp"),
    ],
)
def test_wanted_digits_are_delivered_by_the_cheapest_arithmetic(
    short: Scene, truth: Trajectory, wanted: int, expected: str
) -> None:
    trajectory = integrate(short, digits=wanted)
    assert trajectory.precision.name == expected
    assert true_digits(trajectory, truth) >= wanted
    assert trajectory.digits >= wanted


def test_a_rung_that_does_not_deliver_is_passed(
    short: Scene, truth: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the table promises too much (here 7 digits, then 10) is added to the next request."""
    promised = {"double": 20.5, "extended": 28.0, "quad": 40.0}
    ladder = [cost_table.Setting("newton", name, 0, 0.0, d, 1.0) for name, d in promised.items()]
    monkeypatch.setattr(to_digits, "settings", lambda *_: list(ladder))
    trajectory = integrate(short, digits=20)
    assert trajectory.precision.name == "quad"
    assert true_digits(trajectory, truth) >= 20


def test_a_machine_without_80_bit_floats_and_llvmlite_goes_on_to_quad(
    short: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tt_precise.integration.precision._has_80_bit_floats", lambda: False)
    monkeypatch.setattr("tt_precise.integration.precision._has_llvmlite", lambda: False)
    assert integrate(short, digits=18).precision.name == "quad"


@pytest.mark.parametrize("wanted", [0, -3, 3001, 2.5, "12", True, float("nan")])
def test_what_is_no_number_of_digits_is_refused(short: Scene, wanted: Any) -> None:
    with pytest.raises(InputError, match=r"digits: got .*, expected a whole number from 1 to 3000"):
        integrate(short, digits=wanted)


def test_digits_that_are_not_reached_are_refused(
    short: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(to_digits, "settings", lambda *_: [])
    monkeypatch.setattr(Trajectory, "digits_throughout", 29.96)
    reached = r"digits: got 30, but triple-double with \d+ bits reaches 30\.0"
    with pytest.raises(InputError, match=reached):
        integrate(short, digits=30)


def test_digits_of_a_hopeless_start_are_refused(
    reference: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(propagation.STEPS_IN_A_PIECE, "mp", 5)
    monkeypatch.setattr(to_digits, "settings", lambda *_: [])
    hopeless = replace(reference, body=replace(reference.body, mu="1e300"))
    with pytest.raises(InputError, match="digits: got 10, but the integration of reference fails"):
        integrate(hopeless, digits=10)


def test_two_arithmetics_that_end_differently_leave_no_digits(rough: Scene) -> None:
    """A horizon so close to the loss of contact that double cannot decide which comes first."""
    at_the_edge = replace(rough, until=Fraction("0.65771882639144194"))
    torn = integrate(at_the_edge)
    assert (torn.status, integrate(at_the_edge, "quad").status) == ("complete", "contact_lost")
    assert torn.digits == 0
    assert torn.error_estimate["theta"] == float("inf")
