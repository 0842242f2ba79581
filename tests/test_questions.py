"""Forty questions that a physicist asks of her own top, in Python and at the command line."""

import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import tt_precise as tt
from tt_precise import InputError

BODY = {"m_g": 15, "R_mm": 17, "centre_mm": 4, "I1": "0.38", "I3": "0.4", "g": "9.81", "mu": "0.3"}
START = {"theta": "10 deg", "omega_3": "150"}


def top(**changes: Any) -> tt.Scene:
    tables: dict[str, Any] = {
        "model": "gliding", "body": BODY, "start": START,
        "run": {"until": "0.3", "sample_every": "0.01"},
    }  # fmt: skip
    return tt.Scene.of(**tables | changes)


@pytest.fixture(scope="module")
def run() -> tt.Trajectory:
    return tt.integrate(top(), events="theta_max, theta_min, zero:nu_x")


def friction(law: str, **keys: str) -> str:
    body = {key: value for key, value in BODY.items() if key != "mu"}
    return tt.integrate(top(body=body, friction={"law": law, "mu": "0.3"} | keys)).status


OF_A_SCENE: dict[str, tuple[Callable[[tt.Scene], Any], Any]] = {
    "alpha of 4 mm in 17 mm": (lambda one: one.body.alpha, Fraction(4, 17)),
    "kilograms of 15 g": (lambda one: one.body.m, Fraction(15, 1000)),
    "gamma": (lambda one: one.body.gamma, Fraction(19, 20)),
    "moments in kg m^2": (lambda one: top(body=BODY | {"I3": "2/5"}).body.I3 == one.body.I3, True),
    "ten degrees": (lambda one: float(one.start.theta.offset), pytest.approx(math.pi / 18)),
    "a share of pi": (lambda one: top(start=START | {"theta": "pi/18"}).start == one.start, True),
    "another horizon": (lambda one: replace(one, until=Fraction(2)).until, 2),
    "lambda decides": (lambda one: tt.thresholds(one, digits=10).inverts, True),
}  # fmt: skip

OF_A_RUN: dict[str, tuple[Callable[[tt.Trajectory], Any], Any]] = {
    "is it complete": (lambda run: run.status, "complete"),
    "when did it end": (lambda run: run.t_end, 0.3),
    "the state there": (lambda run: 0 < run.state.theta < math.pi, True),
    "the state then": (lambda run: run.at("0.1").theta, pytest.approx(0.17, abs=0.1)),
    "at many times": (lambda run: run.at(np.linspace(0, 0.3, 7)).theta.shape, (7,)),
    "no extrapolation": (lambda run: run.at(0.4), InputError),
    "a table": (lambda run: list(run.frame("theta", "E", "g_n")), ["t", "theta", "E", "g_n"]),
    "of floats": (lambda run: set(run.frame().dtypes.astype(str)), {"float64"}),
    "for NumPy": (lambda run: np.cos(run.frame("theta")["theta"]).max() < 1, True),
    "as text": (lambda run: type(run.frame("theta", numbers="text")["theta"][0]), str),
    "a quantity of mine": (
        lambda run: math.acos(run.motion("0.1").state.kz), pytest.approx(0.17, abs=0.1)),
    "a name that is none": (lambda run: run.frame("thetta"), InputError),
    "the pose": (lambda run: "qw" in run.frame(pose=True), True),
    "does lambda drift": (lambda run: run.drift["jellett"] < 1e-13, True),
    "friction takes energy": (lambda run: run.frame("E_dot")["E_dot"].max() <= 0, True),
    "how many digits": (lambda run: run.digits > 9, True),
    "and everywhere": (lambda run: run.digits_throughout > 9, True),
    "the error of theta": (lambda run: 0 < run.error_estimate["theta"] < 1e-9, True),
    "over time": (lambda run: (run.error_over_time("theta")["theta"] < 1e-9).all(), True),
    "turning points": (lambda run: {"theta_max", "theta_min"} <= {*run.events["name"]}, True),
    "events in order": (lambda run: run.events["t"].is_monotonic_increasing, True),
    "their errors": (lambda run: (run.event_errors()["error"] < 1e-9).all(), True),
    "it has not climbed": (lambda run: run.inversion.A.t_end, None),
    "go on from there": (
        lambda run: tt.integrate(run.scene.from_state(run.state, until="0.1")).status, "complete"),
    "a picture": (lambda run: len(run.plot("theta").axes), 1),
}  # fmt: skip

IN_PYTHON: dict[str, tuple[Callable[[], Any], Any]] = {
    "20 digits": (lambda: tt.integrate(top(), digits=20, until="0.05").digits >= 20, True),
    "no digits and precision": (lambda: tt.integrate(top(), "quad", digits=5), InputError),
    "Coulomb": (lambda: friction("coulomb"), "complete"),
    "regularised": (lambda: friction("regularised", epsilon="0.01"), "complete"),
    "no epsilon": (lambda: friction("regularised"), InputError),
    "degrees for radians": (lambda: top(start={"theta": "10"}), InputError),
    "SI moments for ratios": (lambda: top(body=BODY | {"I1": "1.2e-6"}), InputError),
    "a misspelt scene": (lambda: tt.load_scene("refrence"), InputError),
    "a sweep": (
        lambda: len(tt.sweep(top(), vary={"mu": "0.2,0.3"}, until="0.05")), 2),
    "a sweep of Coulomb's law": (lambda: tt.sweep("coulomb-gliding", until="0.05"), InputError),
    "an event that is none": (lambda: tt.integrate(top(), events="thetta_max"), InputError),
    "is my table physics": (
        lambda: tt.check.conservation(tt.integrate(top()).frame(), top()).verdict, "pass"),
    "golden data": (lambda: len(tt.golden.load("reference")), 801),
}  # fmt: skip


def answer(question: Callable[[], Any], expected: Any) -> None:
    if expected is InputError:
        with pytest.raises(InputError, match=r"got|missing") as caught:
            question()
        assert "\n" not in str(caught.value)
    else:
        assert question() == expected


@pytest.mark.parametrize("name", OF_A_SCENE)
def test_a_question_about_a_scene(name: str) -> None:
    question, expected = OF_A_SCENE[name]
    answer(lambda: question(top()), expected)


@pytest.mark.parametrize("name", OF_A_RUN)
def test_a_question_about_a_run(name: str, run: tt.Trajectory) -> None:
    question, expected = OF_A_RUN[name]
    answer(lambda: question(run), expected)


@pytest.mark.parametrize("name", IN_PYTHON)
def test_a_question_in_python(name: str) -> None:
    answer(*IN_PYTHON[name])


@pytest.mark.slow
@pytest.mark.parametrize(("argument", "status"), [("digits", 0), ("digit", 1)])
def test_mypy_sees_the_signatures(argument: str, status: int) -> None:
    code = f"import tt_precise as tt\ntt.integrate('reference', {argument}=6)"
    words = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stdout
    assert ('"digit"' in done.stdout) == bool(status)
