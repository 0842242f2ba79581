"""Trajectories: conserved quantities, agreement of formulations, spoiled equations, and the API."""

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

from tests.conftest import Captured, Patch, more
from tests.integration.conftest import Spoiler
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.reading import drift_over_time
from tt_precise.mechanics.conserved import conserved
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

ANY_INTEGRATE: Any = integrate  # takes arguments of wrong types
EULER = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")


def digits_between(run: Trajectory, other: Trajectory) -> float:
    """Significant digits in which the Euler states at the end agree, of the worst component."""
    context = run.precision.context
    pairs = [[context.mpf(t.state.values[name]) for t in (run, other)] for name in EULER]
    distance = max(abs(a - b) / abs(b) for a, b in pairs)
    return float(-context.log10(distance)) if distance else run.precision.decimals


def test_lambda_is_conserved(double: Trajectory, quad: Trajectory, half: Scene) -> None:
    assert 0 < double.drift["jellett"] < 1e-14  # relative, at 8 s
    assert double.drift["axis_norm"] < 1e-14
    assert 0 < quad.drift["jellett"] < quad.precision.context.mpf("1e-32")
    assert 0 < integrate(half, "mp").drift["jellett"] < 1e-58  # to half a second


def test_newton_and_euler_agree(half: Scene, half_quad: Trajectory) -> None:
    assert digits_between(integrate(half, "quad", formulation="euler"), half_quad) > 28


@pytest.mark.parametrize(
    "scene", ["rolling", more("frictionless"), more("phi-dot-195"), "upright", "inverted"]
)
def test_all_integrals_of_a_scene_are_conserved(scene: str) -> None:
    run = integrate(scene, "double-double")
    names = {integral.name for integral in conserved(run.scene.model, run.scene.body)}
    assert set(run.drift) == names >= {"jellett", "axis_norm"}
    for name, drift in run.drift.items():
        assert drift < 1000 * run.precision.eps, name  # 1,000 steps of an eps, at random


@pytest.mark.parametrize("scene", ["rolling", "frictionless"])
def test_both_formulations_conserve_and_agree(scene: str) -> None:
    vectors, angles = (
        integrate(scene, "double-double", until="0.5", formulation=form)
        for form in ("newton", "euler")
    )
    assert max(angles.drift.values()) < 1000 * angles.precision.eps
    assert set(vectors.drift) - set(angles.drift) <= {"axis_norm", "momentum_x", "momentum_y"}
    for name in EULER:
        scale = abs(vectors.frame(name)[name]).max()
        distance = abs(vectors.state.values[name] - angles.state.values[name])
        assert distance <= 1e-27 * scale, name


SPOILED = {
    "torque": lambda state, rates: rates._replace(Lx=rates.Lx * (1 + 1e-10)),
    "axis": lambda state, rates: rates._replace(kz=rates.kz * (1 + 1e-10)),
    "friction": lambda state, rates: rates._replace(s_dot_x=rates.s_dot_x * (1 + 1e-10)),
}


@pytest.mark.parametrize("term", SPOILED)
def test_a_term_off_by_1e_10_shows(
    half: Scene, half_quad: Trajectory, spoiled_rates: Spoiler, term: str
) -> None:
    run = integrate(half)
    spoiled_rates("newton", SPOILED[term])
    wrong = integrate(half)
    assert digits_between(run, half_quad) > 11 > digits_between(wrong, half_quad)
    if term == "friction":  # L does not depend on the cause of v: lambda alone does not show it
        assert wrong.drift["jellett"] < 1e-14
    else:  # 85 steps round by less than an eps each, at random
        assert 5 * run.drift["jellett"] < 5 * 10 * 2.0**-52 < wrong.drift["jellett"]


def test_a_term_of_the_euler_form_off_by_1e_27_shows(
    half: Scene, half_quad: Trajectory, spoiled_rates: Spoiler
) -> None:
    """The comparison in quad catches a factor 1 + 2^-90, which is no float but a sum of two."""
    spoiled_rates("euler", lambda _, r: r._replace(phi_dot=r.phi_dot + r.phi_dot * 2.0**-90))
    wrong = integrate(half, "quad", formulation="euler")
    assert 20 < digits_between(wrong, half_quad) < 28


def test_drifts_are_computed_in_a_finer_arithmetic(double: Trajectory) -> None:
    """In double the evaluation alone would err by some eps at each sample."""
    drifts = drift_over_time(double.run)["jellett"]
    assert (len(drifts), drifts[0] < 2.0**-52) == (801, True)
    assert max(drifts) == double.drift["jellett"] == double.drift["lambda"]
    assert all(drift == 0 or drift > 2.0**-110 for drift in drifts)


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (lambda run: run.at(9), r"t: got 9 s, expected 0 to 8 s"),
        (lambda run: run.at("now"), "t: got 'now'"),
        (lambda run: run.frame("mine"), "column: got 'mine'"),
        (lambda run: run.frame(numbers="rational"), "numbers: got 'rational'"),
        (lambda run: run.frame("error:theta", times=[1]), "times: got times with "),
        (lambda run: ANY_INTEGRATE("reference", events=["E"]), "event: got 'E'"),
        (lambda run: ANY_INTEGRATE("reference", sensitivity=True), "got True, expected names"),
        (lambda run: ANY_INTEGRATE({"model": "gliding"}), "scene: got "),
    ],
)
def test_unusable_arguments_are_refused(
    double: Trajectory, read: Callable[[Trajectory], Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        read(double)


def test_lists_are_names_too(half: Scene) -> None:
    run = integrate(half.varied(record=["phi"], events=["equator"], until="0.1"))
    assert run.setup.record == ("phi",)
    assert list(run.frame(["t", "theta"], "theta,E").columns) == ["t", "theta", "E"]


def test_the_table_of_a_notebook(short: Scene) -> None:
    """Outcome, digits, events, and the state with its units."""
    run = integrate(short, events="theta_min")
    html = run._repr_html_()
    digits = f"{run.digits:.1f}"
    for text in ("complete", digits, "theta_min", "double", run.state._repr_html_()):
        assert text in html
    slow = integrate(short, "quad")
    assert "correct digits" not in slow._repr_html_()
    assert not slow.errors.available
    assert "kg m^2/s" in run.state._repr_html_()
    assert repr(slow.at("0.05")).startswith("<State at t = 0.05 s: theta 0.")
    assert repr(run.inversion) == "<InversionTimes: theta = pi/2 is not passed>"


@pytest.mark.parametrize(("precision", "silent"), [("quad", False), ("double", True)])
def test_a_slow_precision_shows_its_progress_in_a_notebook(
    short: Scene, monkeypatch: Patch, capsys: Captured, precision: str, silent: bool
) -> None:
    """Elsewhere but on a terminal it is silent."""
    integrate(short, precision)
    assert capsys.readouterr().err == ""
    monkeypatch.setitem(sys.modules, "ipykernel", ModuleType("ipykernel"))
    integrate(short, precision)
    assert (capsys.readouterr().err == "") == silent
