"""Plant faults into the example engine in C: the ladder must find each on one test."""

import json
from pathlib import Path

import pytest

from tests.engines.conftest import ENGINE_C, ORDER, compiled_c, ladder_test, measured_on
from tt_precise.cli import main

GOOD = ("converges", "rounding")
LATE = """ {
            double late[SIZE];
            memcpy(late, y, sizeof late), h /= -2, step(late), h *= -2;
            printf(",%.17g", i < 4 ? y[i] : late[i]);
        }"""
# Test that isolates the fault, text in the engine, changed text.
FAULTS = [
    ("flight", "torque[i] - (I3", "torque[i] - 0 * (I3"),
    ("flight", "torque[i] - (I3", "torque[i] + (I3"),
    # free flight and ice have no torque along the axis
    ("gliding", "(1 / I3 - 1 / I1) * dot", "0 * dot"),
    ("flight", 'number("I1")', '1.0001 * number("I1")'),
    ("flight", 'number("I3")', '1.0001 * number("I3")'),
    ("flight", 'number("gravity")', '1.0001 * number("gravity")'),
    ("ice", 'number("mass")', '1.0001 * number("mass")'),
    ("gliding", 'number("radius")', '1.0001 * number("radius")'),
    ("ice", 'number("centre_offset")', '1.0001 * number("centre_offset")'),
    ("flight", "w[0] + q[3] * w[1] - q[2]", "w[0] - q[3] * w[1] + q[2]"),
    ("ice", "{c * k[0], c * k[1], c * k[2] - R}", "{0, 0, -R}"),
    ("ice", "(driven[2] + swung[2])", "driven[2]"),  # no centripetal acceleration
    ("gliding", "-ratio * x, -ratio * z", "ratio * x, ratio * z"),
    ("gliding", "-ratio * x, -ratio", "-1.001 * ratio * x, -1.001 * ratio"),
    ("gliding", "viscous ? mu : mu / fmax(hypot(x, z), SLOW)", "mu"),
    ("gliding", "v[0] + swing[0], z = v[1] + swing[1]", "v[0], z = v[1]"),
    ("ice", "cross(a, force, torque)", "cross(force, a, torque)"),
    ("flight", 'numbers("quaternion_wxyz"', 'numbers("quaternion_xyzw"'),
    ("flight", "{1, 2, 2, 1}", "{1, 1, 2, 1}"),
    ("flight", "y[i] += h / 6", "y[i] += 1.0001 * h / 6"),
    ("flight", '            printf(",%.17g", y[i]);', LATE),
]


def plant(old: str, new: str) -> str:
    assert old in ENGINE_C
    return ENGINE_C.replace(old, new)


@pytest.mark.parametrize(("test", "old", "new"), FAULTS)
def test_the_ladder_finds_a_fault(test: str, old: str, new: str, tmp_path: Path) -> None:
    result = measured_on(
        compiled_c(tmp_path, plant(old, new), "-w"), ladder_test(test), order=ORDER
    )
    assert result.verdict not in GOOD, (result.order, result.floor, result.digits)


@pytest.mark.parametrize("name", ["flight", "ice", "gliding"])
def test_the_healthy_engine_converges(name: str, tmp_path: Path) -> None:
    result = measured_on(compiled_c(tmp_path), ladder_test(name), order=ORDER)
    assert result.verdict == "converges"
    assert result.order == pytest.approx(ORDER, abs=0.1)


def test_the_command_passes_the_healthy_engine_only(tmp_path: Path) -> None:
    words = ["engines", "--test", "flight", "--workers", "1", "--out", str(tmp_path / "out.json")]
    assert main([*words, "--run", *compiled_c(tmp_path)]) == 0
    assert json.loads((tmp_path / "out.json").read_text())["rows"][0]["verdict"] == "converges"
    assert main([*words, "--run", *compiled_c(tmp_path, plant(*FAULTS[0][1:]))]) == 1
