"""Faults planted into the two example engines: found on the ladder, and named by the vectors.

The same twenty faults in C and in Python, as changes of their source. Each is run on the one test
that isolates it; the terms of ``vectors/states.json`` then say in which part of the engine it is.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy
import pytest

from tt_precise.engines.ladder import climb
from tt_precise.engines.rungs import rungs
from tt_precise.golden.store import home

EXAMPLES = Path(__file__).parents[2] / "examples"
GOOD = ("converges", "rounding")
pytestmark = pytest.mark.slow


class Fault(NamedTuple):
    """What is wrong, the test that isolates it, the part that it is in, and the changes."""

    rung: str
    part: str
    python: tuple[str, str]
    c: tuple[str, str]


def off(key: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """A parameter that is off by 1e-4."""
    table = 'job["gravity"]' if key == "gravity" else f'body["{key}"]'
    return (table, f"1.0001 * {table}"), (f'number("{key}")', f'1.0001 * number("{key}")')


FAULTS = {
    "no gyroscopic term": Fault("flight", "inertia", ("t - (I3", "t - 0 * (I3"),
                                ("torque[i] - (I3", "torque[i] - 0 * (I3")),
    "sign of the gyroscopic term": Fault("flight", "inertia", ("t - (I3", "t + (I3"),
                                         ("torque[i] - (I3", "torque[i] + (I3")),
    # free flight has no torque along the axis, and neither has ice
    "inertia of a ball": Fault(
        "gliding", "torque", ("(1 / I3 - 1 / I1) * along", "0 * along"),
        ("(1 / I3 - 1 / I1) * dot", "0 * dot"),
    ),
    "I1 off by 1e-4": Fault("flight", "inertia", *off("I1")),
    "I3 off by 1e-4": Fault("flight", "inertia", *off("I3")),
    "gravity off by 1e-4": Fault("flight", "gravity", *off("gravity")),
    "mass off by 1e-4": Fault("ice", "force", *off("mass")),
    "radius off by 1e-4": Fault("gliding", "force", *off("radius")),
    "offset of the centre off by 1e-4": Fault("ice", "force", *off("centre_offset")),
    "angular velocity in the body frame": Fault(
        "flight", "orientation",
        ("qw * omega[0] + qz * omega[1] - qy", "qw * omega[0] - qz * omega[1] + qy"),
        ("q[0] * w[0] + q[3] * w[1] - q[2]", "q[0] * w[0] - q[3] * w[1] + q[2]"),
    ),
    "origin for centre of mass": Fault(
        "ice", "force", ("a = [c * k[0], c * k[1], c * k[2] - R]", "a = [0, 0, -R]"),
        ("a[3] = {c * k[0], c * k[1], c * k[2] - R}", "a[3] = {0, 0, -R}"),
    ),
    "no centripetal acceleration of the centre": Fault(
        "ice", "force", (" + cross(omega, k_dot)[2]", ""), ("(driven[2] + swung[2])", "driven[2]"),
    ),
    "sign of friction": Fault(
        "gliding", "force",
        ("-ratio * slip[0], -ratio * slip[1]", "ratio * slip[0], ratio * slip[1]"),
        ("-ratio * x, -ratio * z", "ratio * x, ratio * z"),
    ),
    "mu off by 1e-3": Fault(
        "gliding", "force",
        ("-ratio * slip[0], -ratio", "-1.001 * ratio * slip[0], -1.001 * ratio"),
        ("-ratio * x, -ratio", "-1.001 * ratio * x, -1.001 * ratio"),
    ),
    "friction of another law": Fault(
        "gliding", "force", ('"coulomb": mu / max(hypot(slip[0], slip[1]), SLOW)', '"coulomb": mu'),
        ("viscous ? mu : mu / fmax(hypot(x, z), SLOW)", "mu"),
    ),
    "gliding without the spin": Fault(
        "gliding", "force",
        ("zip(v, cross(omega, a), strict=True)", "zip(v, [0, 0, 0], strict=True)"),
        ("v[0] + swing[0], z = v[1] + swing[1]", "v[0], z = v[1]"),
    ),
    "sign of the torque": Fault(
        "ice", "torque", ("omega_dot(cross(a, force))", "omega_dot(cross(force, a))"),
        ("cross(a, force, torque)", "cross(force, a, torque)"),
    ),
    "order of the quaternion": Fault(
        "flight", "integration", ('start["quaternion_wxyz"]', 'start["quaternion_xyzw"]'),
        ('numbers("quaternion_wxyz"', 'numbers("quaternion_xyzw"'),
    ),
    "weights of Runge and Kutta": Fault("flight", "integration", ("a + 2 * b", "a + 1 * b"),
                                        ("{1, 2, 2, 1}", "{1, 1, 2, 1}")),
    "step off by 1e-4": Fault("flight", "integration", ('step(job, y, job["step"])',
                                                       'step(job, y, 1.0001 * job["step"])'),
                              ("y[i] += h / 6", "y[i] += 1.0001 * h / 6")),
}  # fmt: skip


def planted(text: str, change: tuple[str, str]) -> str:
    assert text.count(change[0]) >= 1, change
    return text.replace(*change)


def program(language: str, change: tuple[str, str], folder: Path) -> list[str]:
    if language == "python":
        spoiled = folder / "engine.py"
        spoiled.write_text(planted((EXAMPLES / "engine.py").read_text("utf-8"), change))
        return [sys.executable, str(spoiled)]
    if shutil.which("cc") is None:
        pytest.skip("no C compiler on this machine")
    spoiled, made = folder / "engine.c", folder / "engine"
    spoiled.write_text(planted((EXAMPLES / "engine.c").read_text("utf-8"), change))
    subprocess.run(["cc", "-O1", "-w", "-o", str(made), str(spoiled), "-lm"], check=True)
    return [str(made)]


@pytest.mark.parametrize("language", ["c", "python"])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_where_it_is_isolated(name: str, language: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    command = program(language, getattr(fault, language), tmp_path)
    (rung,) = (one for one in rungs() if one.name == fault.rung)
    (found,) = climb(name, command, [rung])
    assert found.verdict not in GOOD, (found.floor, found.digits)


@pytest.mark.parametrize("name", ["flight", "ice", "gliding"])
@pytest.mark.parametrize("language", ["c", "python"])
def test_the_healthy_engines_are_not_flagged(name: str, language: str, tmp_path: Path) -> None:
    command = program(language, ("SLOW", "SLOW"), tmp_path)
    (rung,) = (one for one in rungs() if one.name == name)
    (found,) = climb("healthy", command, [rung])
    assert found.verdict == "converges"
    assert found.order == pytest.approx(4, abs=0.1)


def wrong_part(source: str) -> str | None:
    """The first part of an engine in Python whose terms are not those of the vectors."""
    engine: dict[str, Any] = {"__name__": "engine"}
    exec(compile(source, "engine.py", "exec"), engine)
    wrong = set()
    for case in json.loads((home() / "vectors" / "states.json").read_text("utf-8"))["cases"]:
        law = case["friction"]["law"]
        if law in ("none", "viscous", "coulomb"):
            wrong |= {(law == "none", name) for name in _terms_off(engine, case)}
    for flies, name, part in (
        (True, "k_dot", "orientation"), (True, "omega_dot", "inertia"),
        (True, "s_ddot", "gravity"), (False, "s_ddot", "force"), (False, "omega_dot", "torque"),
    ):  # fmt: skip
        if (flies, name) in wrong:
            return part
    return None


def _terms_off(engine: dict[str, Any], case: dict[str, Any]) -> list[str]:
    body = {name: float(value) for name, value in case["body"].items()}
    law = case["friction"]["law"]
    job = {
        "body": {"mass": body["m"], "radius": body["R"], "I1": body["I1"], "I3": body["I3"],
                 "centre_offset": body["alpha"] * body["R"]},
        "gravity": body["g"],
        "contact": "none" if law == "none" else "rigid",
        "friction": {"law": law, "mu": float(case["friction"].get("mu", 0))},
    }  # fmt: skip
    given = {name: [float(x) for x in value] for name, value in case["state"].items()}
    y = [*given["quaternion_wxyz"], *given["omega"], *given["s_dot"]]
    rates = engine["rates"](job, y)
    q, turning = numpy.array(y[:4]), numpy.array(rates[:4])
    found = {
        # k is quadratic in q: its rate is the central difference, exactly
        "k_dot": (_axis(q + turning) - _axis(q - turning)) / 2,
        "omega_dot": numpy.array(rates[4:7]),
        "s_ddot": numpy.array(rates[7:]),
    }
    want = {name: numpy.array(case["expected"][name], dtype=float) for name in found}
    return [
        name for name, value in found.items()
        if numpy.linalg.norm(value - want[name]) > 1e-10 * numpy.linalg.norm(want[name])
    ]  # fmt: skip


def _axis(q: Any) -> Any:
    w, x, y, z = q
    return numpy.array([2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y])


def test_the_vectors_name_the_part_that_is_wrong() -> None:
    text = (EXAMPLES / "engine.py").read_text("utf-8")
    assert wrong_part(text) is None
    named = {name: wrong_part(planted(text, fault.python)) for name, fault in FAULTS.items()}
    # where every term is right the error is in the integration, which depth 2 is for
    assert {name: part or "integration" for name, part in named.items()} == {
        name: fault.part for name, fault in FAULTS.items()
    }
