"""What no friction law can excuse, on a test engine in C: fifteen faults and more, and none."""

import random
from collections.abc import Sequence

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, Engine, check
from tests.conftest import more
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Check

# What explains a failure is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

EVERY_LAW = ("kinematics", "contact_momentum", "normal_force", "friction_power")
# the checks of which one must fail, under the scene's own law and under any
FAULTS = {
    **dict.fromkeys(
        (
            "I1 a hundredth more", "I3 a hundredth more", "centre of mass at the centre",
            "gravity is 9", "alpha a hundredth more", "mass a tenth more", "no gyroscopic term",
            "torsional friction", "quaternion with its scalar last",
            "velocity of the centre of the sphere",
        ),
        ("equations", "contact_momentum"),
    ),
    "normal force is the weight": ("contact_velocity", "contact_velocity"),
    "spin angle at random": ("kinematics", "kinematics"),
    "z is five metres": ("kinematics", "kinematics"),
    "position stands still": ("kinematics", "kinematics"),
    "angular velocity in the body frame": ("kinematics", "kinematics"),
    "friction pushes": ("energy", "energy"),
    "mu a tenth more": ("equations", ""),
}  # fmt: skip


def kinematics(frame: pandas.DataFrame, friction: str = "other") -> tt.check.Result:
    return check(frame, "reference", friction=friction, until=1.0)


def test_the_engine_is_right(engine: Engine) -> None:
    result = check(engine(until=2), "reference", until=2, digits=8)
    assert result.passed, str(result)
    for name in ("kinematics", "contact_momentum"):
        assert result[name].verdict == "pass", result[name].note


@pytest.mark.parametrize("friction", [more("scene"), "other"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_fails(engine: Engine, fault: str, friction: str) -> None:
    expected = FAULTS[fault][friction == "other"]
    found = {finding.name for finding in kinematics(engine(fault=fault), friction).failures}
    assert expected in found if expected else not found


@pytest.mark.parametrize("law", ["viscous", "stribeck"])
def test_a_table_that_pulls_fails(engine: Engine, law: str) -> None:
    start = (1.3, 5.0, -10.0, 190.0)
    pulled = engine(law=law, fault="the table pulls", start=start)
    left = engine(law=law, start=start)
    assert check(pulled, "reference", friction="other")["normal_force"].verdict == "fail"
    assert len(left) < len(pulled)
    assert not check(left, "reference", friction="other", start="other").failures


def test_a_small_error_that_goes_on_fails(engine: Engine) -> None:
    """The attitude turns a thousandth of the spin too fast; positions are a hundredth too large."""
    frame = engine(1000)
    c, s = numpy.cos(0.155 / 2 * frame.t), numpy.sin(0.155 / 2 * frame.t)
    fast = frame.assign(
        qw=frame.qw * c - frame.qz * s, qx=frame.qx * c + frame.qy * s,
        qy=frame.qy * c - frame.qx * s, qz=frame.qz * c + frame.qw * s,
    )  # fmt: skip
    spoilt = {"": frame, "spin": fast, "x": frame.assign(x=1.01 * frame.x)}
    for name, given in spoilt.items():
        found = kinematics(given)
        assert found.passed == (name == "")
        assert f"{name} does not follow" in found["kinematics"].note or not name


def test_what_was_not_looked_at_is_said(engine: Engine) -> None:
    found = kinematics(engine().drop(columns=["x", "y", "z"]))
    assert "not at x, y, z (columns missing)" in found["kinematics"].note
    coarse = kinematics(engine(20))
    for name in ("kinematics", "contact_momentum"):
        assert coarse[name].verdict == "open"
        assert coarse[name].note.startswith("rows too far apart")
    raised = kinematics(engine(60).assign(z=5.0))["kinematics"]
    assert (raised.verdict, raised.note[:24]) == ("fail", "height does not follow; ")
    far = tt.integrate("reference").frame(
        *NewtonState._fields, times=[0.05 * i for i in range(161)]
    )
    assert "does not follow" not in check(far, "reference")["kinematics"].note
    euler = tt.integrate("contact-lost").frame(*EULER[1:5])
    note = check(euler, "contact-lost")["kinematics"].note
    assert "checked inclination, not at spin, x, y, z" in note


def healthy_runs(engine: Engine, seeds: Sequence[int]) -> list[str]:
    """Return the runs with other laws that fail ``kinematics`` or ``contact_momentum``."""
    flagged = []
    for seed in seeds:
        rng = random.Random(seed)
        law = rng.choice(["viscous", "coulomb", "regularised", "stribeck", "soft"])
        hertz = round(10 ** rng.uniform(numpy.log10(60), numpy.log10(4000)), 3)
        start = (rng.uniform(0.02, 1.5), rng.uniform(-5, 5), rng.uniform(-10, 10),
                 rng.choice([-1, 1]) * rng.uniform(60, 200))  # fmt: skip
        result = kinematics(engine(hertz, 1.0, law, "", rng.uniform(0.05, 0.4), start))
        flagged += [
            f"seed {seed}: {law} at {hertz} Hz: {result[name].sentence()}"
            for name in EVERY_LAW
            if result[name].verdict == "fail"
        ]
    return flagged


@pytest.mark.parametrize(
    "seeds", [(*range(6), 161), pytest.param(range(100, 200), marks=pytest.mark.slow)], ids=len
)
def test_healthy_runs_with_other_laws_are_not_flagged(engine: Engine, seeds: Sequence[int]) -> None:
    assert healthy_runs(engine, seeds) == []


def test_jellett_is_allowed_a_force_within_the_depth_of_a_soft_table(engine: Engine) -> None:
    """Fifty times less than another I1 changes it."""

    def found(fault: str, limit: float = 1e-6) -> Check:
        frame = engine(500, 0.5, law="soft", fault=fault)
        return check(frame, "reference", friction="other", limits={"jellett": limit})["jellett"]

    assert found("").value == pytest.approx(0, abs=1e-12)  # at the lowest point
    assert found("the force at the table", 2e-9).verdict == "pass"  # 4e-8 without
    other_side = found("the force below the lowest point", 2e-9)
    assert other_side.verdict == "fail"
    assert other_side.value == pytest.approx(4e-8, rel=0.1)
    wrong = found("I1 a hundredth more")
    assert wrong.verdict == "fail"
    assert wrong.value == pytest.approx(2.1e-6, rel=0.1)


def test_a_pass_says_what_it_would_not_notice(engine: Engine) -> None:
    """The bound is that of the rows, above a limit that they do not reach too."""
    limits = {"kinematics": 1e-12, "contact_momentum": 1e-12}
    found = check(engine(100), "reference", friction="other", limits=limits)
    for name in limits:
        assert found[name].verdict == "pass"
        assert (found[name].bound or 0) > 1e-9
        assert "detects " in found[name].note
