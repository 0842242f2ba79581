"""Trajectories: what must be conserved is, what must agree does, and spoiled equations show."""

import itertools
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.conserved import conserved
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

NEWTON = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
Spoiler = Callable[[str, Callable[[Any, Any], Any]], None]


def digits_between(one: Trajectory, other: Trajectory) -> float:
    """Significant digits in which the Euler states at the end agree, at the worst entry."""
    context = one.precision.context
    pairs = [[context.mpf(t.state.values[name]) for t in (one, other)] for name in EULER]
    apart = max(abs(a - b) / abs(b) for a, b in pairs)
    return float(-context.log10(apart)) if apart else one.precision.decimals


def test_lambda_holds(double: Trajectory, quad: Trajectory, half: Scene) -> None:
    assert 0 < double.drift["jellett"] < 1e-14  # the bars, relative, at 8 s
    assert double.drift["axis_norm"] < 1e-14
    assert 0 < quad.drift["jellett"] < quad.precision.context.mpf("1e-32")
    assert 0 < integrate(half, "mp").drift["jellett"] < 1e-58  # to half a second


def test_newton_and_euler_agree(half: Scene, half_quad: Trajectory) -> None:
    angles = integrate(half, "quad", formulation="euler")
    assert digits_between(angles, half_quad) > 28


@pytest.mark.slow
def test_the_bars_to_the_end(reference: Scene, quad: Trajectory) -> None:
    assert 0 < integrate(reference, "mp").drift["jellett"] < 1e-56
    assert digits_between(integrate(reference, "quad", formulation="euler"), quad) > 28


@pytest.mark.parametrize(
    "scene", ["rolling", more("frictionless"), more("phi-dot-195"), "upright", "inverted"]
)
def test_everything_that_a_scene_conserves_holds(scene: str) -> None:
    trajectory = integrate(scene, "extended")
    assert trajectory.status == "complete"
    top = trajectory.scene
    names = {integral.name for integral in conserved(top.model, top.body)}
    assert set(trajectory.drift) == names >= {"jellett", "axis_norm"}
    for name, drift in trajectory.drift.items():
        # 1,400 steps of eps 1.1e-19, at random
        assert drift < 100 * trajectory.precision.eps, name


@pytest.mark.parametrize("scene", ["rolling", "frictionless"])
def test_both_formulations_conserve_and_agree(scene: str) -> None:
    vectors, angles = (
        integrate(scene, "extended", until="0.5", formulation=form) for form in ("newton", "euler")
    )
    assert max(angles.drift.values()) < 100 * angles.precision.eps
    assert set(vectors.drift) - set(angles.drift) <= {"axis_norm", "momentum_x", "momentum_y"}
    for name in EULER:
        scale = abs(vectors.frame(name, numbers="float")[name]).max()
        apart = abs(vectors.state.values[name] - angles.state.values[name])
        assert apart < 1e-15 * scale or apart == 0, name


SPOILED = {
    "torque": lambda state, rates: rates._replace(Lx=rates.Lx * (1 + 1e-10)),
    "axis": lambda state, rates: rates._replace(kz=rates.kz * (1 + 1e-10)),
    "friction": lambda state, rates: rates._replace(s_dot_x=rates.s_dot_x * (1 + 1e-10)),
}


@pytest.mark.parametrize("term", SPOILED)
def test_a_term_off_by_1e_10_shows(
    half: Scene, half_quad: Trajectory, spoiled_rates: Spoiler, term: str
) -> None:
    honest = integrate(half)
    spoiled_rates("newton", SPOILED[term])
    wrong = integrate(half)
    assert digits_between(honest, half_quad) > 11
    assert digits_between(wrong, half_quad) < 11
    if term == "friction":
        # L does not feel how v came about: lambda alone would not have noticed
        assert wrong.drift["jellett"] < 1e-14
    else:
        # 85 steps round by less than an eps each, at random
        assert honest.drift["jellett"] < 10 * 2.0**-52
        assert wrong.drift["jellett"] > 5 * 10 * 2.0**-52


def test_a_term_of_the_euler_form_off_by_1e_27_shows(
    half: Scene, half_quad: Trajectory, spoiled_rates: Spoiler
) -> None:
    """The comparison in quad catches a factor 1 + 2^-90, which is no float but a sum of two."""
    spoiled_rates("euler", lambda _, r: r._replace(phi_dot=r.phi_dot + r.phi_dot * 2.0**-90))
    wrong = integrate(half, "quad", formulation="euler")
    assert 20 < digits_between(wrong, half_quad) < 28


def test_a_wrong_constant_conserves_but_does_not_agree(half: Scene, half_quad: Trajectory) -> None:
    trajectory = integrate(half.perturbed(alpha="1e-25"), "quad")
    assert trajectory.drift["jellett"] < 1e-32
    assert digits_between(trajectory, half_quad) < 27


def test_drift_is_computed_finer_than_the_numbers_are(double: Trajectory) -> None:
    """In double the evaluation alone would err by some eps at each sample."""
    at_start = double.drift_over_time()["jellett"]
    assert len(at_start) == 801
    assert at_start[0] < 2.0**-52
    assert max(at_start) == double.drift["jellett"]
    assert all(drift == 0 or drift > 2.0**-110 for drift in at_start)


def test_drift_counts_the_state_at_the_end(half: Scene, spoiled_rates: Spoiler) -> None:
    spoiled_rates("newton", SPOILED["torque"])
    wrong = integrate(half, sample_every=1)
    assert list(wrong.sample_times) == [0, Fraction(1, 2)]
    assert wrong.drift["jellett"] > 1e-14


def test_what_a_trajectory_says_of_itself(double: Trajectory, rough: Scene) -> None:
    assert "reference: complete, t_end = 8.0 s, double" in repr(double)
    assert (double.precision.name, double.formulation, double.order) == ("double", "newton", 21)
    assert 1000 < double.steps < 2000
    assert isinstance(double.state.theta, float)
    assert double.dimension("g_n").unit == "N"
    lost = integrate(rough)
    assert float(lost.sample_times[-1]) == lost.t_end
    assert list(double.events) == ["name", "t", "direction", *NEWTON, *EULER]
    assert double.events["t"].is_monotonic_increasing
    assert set(double.events["direction"]) == {-1, 1}


def test_several_times_at_once(double: Trajectory, half_quad: Trajectory) -> None:
    times = [0, 0.25, 0.5]
    for trajectory, kind in ((double, float), (half_quad, object)):
        several = trajectory.at(numpy.array(times))
        assert several.theta.shape == several.t.shape == (3,)
        assert several.theta.dtype == kind
        for one, name in itertools.product(range(3), ("t", "theta", "vx")):
            assert getattr(several, name)[one] == getattr(trajectory.at(times[one]), name)
        assert several.as_text()["kz"] == [trajectory.at(t).as_text()["kz"] for t in times]
    for single in (0.25, "0.25"):
        assert double.frame("theta", times=single)["theta"].tolist() == [double.at(single).theta]
    with pytest.raises(InputError, match=r"t: got 9 s, expected 0 to 8 s"):
        double.at([1, 9])
    with pytest.raises(InputError, match="t: got 'now'"):
        double.at(["now"])


def test_what_people_try_first_works_or_says_what_to_write(half: Scene) -> None:
    run = tt.integrate(half, until="0.1")
    assert list(run.frame("t", "theta,E").columns) == ["t", "theta", "E"]
    assert run.drift["lambda"] == run.drift["jellett"]
    with pytest.raises(KeyError, match="drift:E"):
        run.drift["E"]
    with pytest.raises(InputError, match=r"event: got 'E', .* such as extremum:E,"):
        tt.integrate(half, events=["E"])
    with pytest.raises(InputError, match=r"column: got 'mine', .*tt\.quantity\(function, unit\)"):
        run.frame("mine")
    with pytest.raises(InputError, match="got True, expected names, such as"):
        tt.integrate(half, sensitivity=True)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"conservation\(\) missing"):
        tt.check.conservation("mine.csv")  # type: ignore[call-arg]
    with pytest.raises(AttributeError, match="did you mean 'omega_3'"):
        run.state.omega3  # noqa: B018
