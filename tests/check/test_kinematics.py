"""What no friction law can excuse, on a test engine in C: fifteen faults and more, and none."""

from __future__ import annotations

import io
import random
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.check.kinematics import Windows
from tt_precise.mechanics import conserved
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion

INNER_HZ = 20_000  # of the engine's own steps
Engine = Callable[..., pandas.DataFrame]

EVERY_LAW = ("kinematics", "contact_momentum", "normal_force", "friction_power")
CAUSES = {
    "no gyroscopic term": "no gyroscopic term",
    "I1 a hundredth more": "I1 1.01 times",
    "I3 a hundredth more": "I3 1.01 times",
    "centre of mass at the centre": "the centre of mass at the centre",
    "gravity is 9": "g 0.9165 times",
    "alpha a hundredth more": "alpha 1.01 times",
    "mass a tenth more": "m 1.1 times",
    "mu a tenth more": "mu 1.1 times",
    "friction pushes": "friction of the other sign",
}
WIDE = {"I1 a hundredth more": 100, "mu a tenth more": 33}  # Hz
# the checks of which one must fail, under the scene's own law and under any
FAULTS = {
    **dict.fromkeys((*CAUSES, "torsional friction"), ("equations", "contact_momentum")),
    "normal force is the weight": ("refused", "refused"),
    "spin angle at random": ("kinematics", "kinematics"),
    "z is five metres": ("kinematics", "kinematics"),
    "position stands still": ("kinematics", "kinematics"),
    "quaternion with its scalar last": ("refused", "refused"),
    "angular velocity in the body frame": ("refused", "refused"),
    "velocity of the centre of the sphere": ("refused", "refused"),
    "friction pushes": ("energy", "energy"),
    "mu a tenth more": ("equations", ""),
}


@pytest.fixture(scope="session")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler: the engine with planted faults cannot be built")
    program = tmp_path_factory.mktemp("engine") / "engine"
    source = Path(__file__).with_name("engine.c")
    subprocess.run([compiler, "-O2", "-Wall", "-o", program, source, "-lm"], check=True)
    body = tt.load_scene("reference").body.numbers(float)
    parts = [body.m, body.R, body.alpha, body.I1, body.I3, body.g]

    def run(
        hertz: float = 500, until: float = 1.0, law: str = "viscous", fault: str = "",
        mu: float = 0.3, start: tuple[float, ...] = (0.1, 0.0, 0.0, 155.0),
    ) -> pandas.DataFrame:  # fmt: skip
        inner = max(1, round(INNER_HZ / hertz))
        numbers = map(repr, (*parts, mu, *start))
        command = [str(program), str(hertz), str(inner), str(until), law, fault or "none", *numbers]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return pandas.read_csv(io.StringIO(text))

    return run


def failures(frame: pandas.DataFrame, friction: str) -> set[str]:
    try:
        result = tt.check.conservation(frame, "reference", friction=friction, until=1.0)
    except tt.InputError:
        return {"refused"}
    return {finding.name for finding in result.failures}


def test_the_engine_is_right(engine: Engine) -> None:
    frame = engine(until=2)
    result = tt.check.conservation(frame, "reference", until=2, digits=8)
    assert result.passed, str(result)
    for name in ("kinematics", "contact_momentum"):
        assert result[name].verdict == "pass", result[name].note
    assert "friction seen: 0.3 +- " in result["friction_power"].note
    assert "as viscous" in result["friction_power"].note


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_fails(engine: Engine, fault: str, friction: str) -> None:
    expected = FAULTS[fault][friction == "other"]
    found = failures(engine(fault=fault), friction)
    assert expected in found if expected else not found


@pytest.mark.usefixtures("no_cause")
def test_a_table_that_pulls_fails(engine: Engine) -> None:
    start = (1.3, 5.0, -10.0, 190.0)
    for law in ("viscous", "stribeck"):
        pulled = engine(law=law, fault="the table pulls", start=start)
        left = engine(law=law, start=start)
        found = tt.check.conservation(pulled, "reference", friction="other")
        assert found["normal_force"].verdict == "fail"
        assert len(left) < len(pulled)
        assert tt.check.conservation(left, "reference", friction="other").passed


@pytest.mark.usefixtures("no_cause")
def test_other_friction_is_suggested_only_where_it_may_be_that(engine: Engine) -> None:
    for fault, suggested in (("mu a tenth more", True), ("I1 a hundredth more", False)):
        result = tt.check.conservation(engine(fault=fault), "reference", until=1.0)
        assert ("--friction other" in result["equations"].note) == suggested
    torsion = tt.check.conservation(engine(fault="torsional friction"), "reference", until=1.0)
    assert "torsional friction" in torsion["contact_momentum"].note


def test_friction_is_seen_as_what_it_is(engine: Engine) -> None:
    frame = engine(1000, law="coulomb", mu=0.02)
    found = tt.check.conservation(frame, "reference", friction="other", until=1.0)
    assert "friction seen: 0.02 +- " in found["friction_power"].note
    assert "as Coulomb's" in found["friction_power"].note


@pytest.mark.parametrize("fault", CAUSES)
def test_the_cause_is_named(engine: Engine, fault: str) -> None:
    hertz = WIDE.get(fault, 500)
    result = tt.check.conservation(engine(hertz, 0.5, fault=fault), "reference", until=0.5)
    notes = {name: result[name].note for name in ("equations", "contact_momentum")}
    named = {name: note for name, note in notes.items() if "fits to" in note}
    assert named
    assert all(CAUSES[fault] in note for note in named.values())


def test_what_was_not_looked_at_is_said(engine: Engine) -> None:
    frame = engine().drop(columns=["x", "y", "z"])
    found = tt.check.conservation(frame, "reference", friction="other", until=1.0)
    assert "not at x, y, z (no columns)" in found["kinematics"].note
    coarse = tt.check.conservation(engine(60), "reference", friction="other", until=1.0)
    for name in ("kinematics", "contact_momentum"):
        assert coarse[name].verdict == "skipped"
        assert coarse[name].note.startswith("rows too far apart")
    euler = tt.integrate("contact-lost").frame("theta", "theta_dot", "phi_dot", "omega_3")
    assert tt.check.conservation(euler, "contact-lost")["kinematics"].verdict == "skipped"


def healthy_runs(engine: Engine, seeds: range) -> list[str]:
    """Which of these runs with other laws fail ``kinematics`` or ``contact_momentum``."""
    flagged = []
    for seed in seeds:
        rng = random.Random(seed)
        law = rng.choice(["viscous", "coulomb", "regularised", "stribeck", "soft"])
        hertz = round(10 ** rng.uniform(numpy.log10(60), numpy.log10(4000)), 3)
        start = (rng.uniform(0.02, 1.5), rng.uniform(-5, 5), rng.uniform(-10, 10),
                 rng.choice([-1, 1]) * rng.uniform(60, 200))  # fmt: skip
        frame = engine(hertz, 1.0, law, "", rng.uniform(0.05, 0.4), start)
        result = tt.check.conservation(frame, "reference", friction="other", until=1.0)
        flagged += [
            f"seed {seed}: {law} at {hertz} Hz: {result[name].sentence()}"
            for name in EVERY_LAW
            if result[name].verdict == "fail"
        ]
    return flagged


@pytest.mark.parametrize(
    "seeds", [range(6), pytest.param(range(100, 200), marks=pytest.mark.slow)], ids=len
)
def test_healthy_runs_with_other_laws_are_not_flagged(engine: Engine, seeds: range) -> None:
    assert healthy_runs(engine, seeds) == []


def test_windows_integrate_quartics_exactly() -> None:
    rng = numpy.random.default_rng(3)
    t = numpy.cumsum(rng.uniform(0.5, 1.5, 23))
    windows = Windows(t, 0.0)
    assert windows.rows[0, 0] == 0
    assert windows.rows[-1, -1] == 22
    exact = (t[windows.rows[:, -1]] ** 5 - t[windows.rows[:, 0]] ** 5) / 5
    assert windows.integral(t**4) == pytest.approx(exact, rel=1e-12)
    assert windows.middle_rate(t**4)[0] == pytest.approx(4 * t[windows.rows[:, 2]] ** 3, rel=1e-9)
    value, bound = windows.unexplained([t**5 / 5], [t**4 + 1e-3])
    assert -value[0] == pytest.approx(1e-3 * windows.spans, rel=1e-6)
    assert (bound > 0).all()


@pytest.mark.parametrize("scene", ["reference", "rolling", "frictionless"])
def test_the_rate_of_momentum_is_that_of_the_equations(scene: str) -> None:
    """dQ/dt by finite differences of the solution, to every force law."""
    step = 1e-4
    times = [1.0 - step, 1.0, 1.0 + step]
    frame = tt.integrate(scene, digits=13).frame(*NewtonState._fields, times=times, numbers="float")
    body = tt.load_scene(scene).body.numbers(float)
    model = tt.load_scene(scene).model
    q = Motion(body, NewtonState(*(frame[n].to_numpy() for n in NewtonState._fields)), numpy, model)
    Q, rate = (
        numpy.array(conserved.contact_momentum(q)),
        numpy.array(conserved.contact_momentum_rate(q)),
    )
    slope = (Q[:, 2] - Q[:, 0]) / (2 * step)
    unit = conserved.torque_unit(body)
    assert abs(slope - rate[:, 1]).max() < 1e-4 * unit
    assert abs(rate[:, 1]).max() > 1e-2 * unit
