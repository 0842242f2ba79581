"""Trajectories that other people's engines wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.bench import engines
from tt_precise.cli import main

pytestmark = pytest.mark.clients


@pytest.fixture(scope="module")
def exudyn() -> Any:
    return pytest.importorskip("exudyn", reason="the engine Exudyn is not installed")


@pytest.fixture(scope="module")
def mujoco() -> Any:
    return pytest.importorskip("mujoco", reason="the engine MuJoCo is not installed")


def drift(run: engines.EngineRun, name: str = "jellett", **keywords: Any) -> float:
    value = tt.check.conservation(run.frame, "reference", **keywords)[name].value
    assert value is not None
    return value


def test_mujoco_keeps_jellett_and_its_energy_falls_until_the_peg_touches(mujoco: Any) -> None:
    run = engines.mujoco_run(1e-4)
    assert run.t_peg is not None
    assert run.t_peg > 1
    result = tt.check.assert_conserves(
        run.frame, "reference", friction="other", until=run.t_peg, jellett=1e-4, energy=1e-2,
        contact_velocity=0.1,
    )  # fmt: skip
    assert result.t_last <= run.t_peg
    # it has climbed: the axis points down
    k_z = 1 - 2 * (run.frame["qx"] ** 2 + run.frame["qy"] ** 2)
    assert k_z.iloc[0] > 0.9
    assert k_z.iloc[-1] < 0


def test_mujocos_drift_falls_with_the_step(mujoco: Any) -> None:
    for integrator, order in (("Euler", 1), ("RK4", 2)):
        # a contact that rattles costs Runge and Kutta two of their four orders
        one, other = (
            drift(engines.mujoco_run(step, integrator, until=0.5), friction="other")
            for step in (4e-4, 1e-4)
        )
        assert numpy.log2(one / other) / 2 > order - 0.5, integrator


def test_a_wrong_centre_of_mass_is_caught(mujoco: Any) -> None:
    healthy, spoiled = (
        drift(engines.mujoco_run(1e-4, until=1, lever=lever), friction="other")
        for lever in (1, 1.001)
    )
    assert healthy < 5e-6
    assert spoiled > 1e-5


def test_mujocos_own_convention_is_recognised(mujoco: Any) -> None:
    run = engines.mujoco_run(2e-4, until=0.5)
    frame = run.frame.copy()
    k = numpy.array(
        [
            2 * (frame.qx * frame.qz + frame.qw * frame.qy),
            2 * (frame.qy * frame.qz - frame.qw * frame.qx),
            1 - 2 * (frame.qx**2 + frame.qy**2),
        ]
    )
    # qvel of a free joint: the angular velocity in the body's frame
    turned = numpy.array([frame.wx, frame.wy, frame.wz])
    q = -numpy.array([frame.qx, frame.qy, frame.qz]).T
    half = numpy.cross(q, turned.T)
    own = turned.T + 2 * frame[["qw"]].to_numpy() * half + 2 * numpy.cross(q, half)
    assert own[:, 2] == pytest.approx((turned * k).sum(axis=0))
    frame[["wx", "wy", "wz"]] = own
    with pytest.raises(tt.InputError, match="angular velocity is in the body frame"):
        tt.check.conservation(frame, "reference", friction="other")


def test_exudyn_approaches_the_golden_data_as_its_contact_hardens(exudyn: Any) -> None:
    digits, jellett = [], []
    for stiffness in (1e4, 1e5, 1e6):
        run = engines.exudyn_run(5e-5, stiffness)
        result = tt.check.conservation(run.frame, "reference", limits={"contact_velocity": 1e-3})
        assert result["jellett"].verdict == "pass"
        assert result["energy"].verdict == "pass"
        digits.append(result["golden"].value)
        jellett.append(result["jellett"].value)
    # another code, another contact model, the paper's friction: one digit a decade of stiffness
    assert numpy.diff(numpy.array(digits, float)) == pytest.approx([1, 1], abs=0.1)
    assert numpy.log10(numpy.array(jellett, float)) == pytest.approx([-6.4, -7.4, -8.4], abs=0.2)


def test_a_wrong_friction_is_caught(exudyn: Any) -> None:
    limits = {"contact_velocity": 1e-3, "equations": 1e-4, "energy_balance": 1e-6}
    healthy = engines.exudyn_run(1e-4, 1e6)
    assert tt.check.conservation(healthy.frame, "reference", limits=limits).passed
    run = engines.exudyn_run(1e-4, 1e6, friction=1.01)
    wrong = tt.check.conservation(run.frame, "reference", limits=limits)
    assert {finding.name for finding in wrong.failures} == {"energy_balance", "equations"}


def test_the_command_as_a_user_would_call_it(mujoco: Any, tmp_path: Path) -> None:
    path = tmp_path / "top.csv"
    engines.mujoco_run(2e-4, until=0.5).frame.to_csv(path, index=False)
    arguments = ["check", str(path), "--scene", "reference", "--friction", "other"]
    assert main(arguments) == 1  # a soft contact gives way
    limits = [
        "--limit",
        "contact_velocity=0.1",
        "--limit",
        "jellett=1e-4",
        "--limit",
        "energy=1e-2",
    ]
    assert main([*arguments, *limits]) == 0
