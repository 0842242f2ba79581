"""Faults planted into the two example engines: found on the ladder, and named by the vectors.

The same faults in C and in Python, as changes of their source. Each is run on the one test that
isolates it; the terms of ``vectors/states.json`` then say in which part of the engine it is. The
healthy engines are run on a hundred tops and starts drawn by lot.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy
import pytest

from benchmarks.random_scenes import gliding_scenes
from tests.engines.conftest import EXAMPLES, ORDER, compiled_c, ladder_test, measured_on
from tt_precise.engines.ladder import EVERY_LAW
from tt_precise.engines.protocol import as_text
from tt_precise.golden.store import home
from tt_precise.mechanics.laws import VISCOUS

GOOD = ("converges", "rounding")
FLYING, LAWS = "none", ("none", "viscous", "coulomb")
# before it writes its header, the engine in C writes the rates at the start, and is done
RATES = """
    double r[SIZE];
    rates(y, r);
    for (int i = 0; i < SIZE; i++)
        printf("%.17g ", r[i]);
    return 0;
"""
pytestmark = pytest.mark.slow


class Fault(NamedTuple):
    """A fault: the test that isolates it, the part that it is in, and the changes.

    ``part_in_c`` is another part, where the engine in C makes the mistake elsewhere.
    """

    test: str
    part: str
    python: tuple[str, str]
    c: tuple[str, str]
    part_in_c: str = ""


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
        ('numbers("quaternion_wxyz"', 'numbers("quaternion_xyzw"'), part_in_c="orientation",
    ),
    "weights of Runge and Kutta": Fault("flight", "integration", ("a + 2 * b", "a + 1 * b"),
                                        ("{1, 2, 2, 1}", "{1, 1, 2, 1}")),
    "step off by 1e-4": Fault("flight", "integration", ('step(job, y, job["step"])',
                                                       'step(job, y, 1.0001 * job["step"])'),
                              ("y[i] += h / 6", "y[i] += 1.0001 * h / 6")),
    "velocities half a step late": Fault(
        "flight", "integration",
        ("[t, *y]", '[t, *y[:4], *step(job, y, -job["step"] / 2)[4:]]'),
        ('            printf(",%.17g", y[i]);', """ {
            double late[SIZE];
            memcpy(late, y, sizeof late), h /= -2, step(late), h *= -2;
            printf(",%.17g", i < 4 ? y[i] : late[i]);
        }"""),
    ),
}  # fmt: skip


def planted(text: str, change: tuple[str, str]) -> str:
    assert text.count(change[0]) >= 1, change
    return text.replace(*change)


NOTHING = ("SLOW", "SLOW")  # a change that is none
SEEDED = 50
Rates = Callable[[Any], list[float]]


def program(language: str, change: tuple[str, str], folder: Path, first: str = "") -> list[str]:
    """The changed engine; the one in C does ``first`` before it writes anything."""
    if language == "c":
        text = planted((EXAMPLES / "engine.c").read_text("utf-8"), change)
        return compiled_c(text.replace("    puts(", f"{first}    puts(", 1), folder, "-w")
    spoiled = folder / "engine.py"
    spoiled.write_text(planted((EXAMPLES / "engine.py").read_text("utf-8"), change))
    return [sys.executable, str(spoiled)]


both = pytest.mark.parametrize("language", ["c", "python"])


@both
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_where_it_is_isolated(name: str, language: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    command = program(language, getattr(fault, language), tmp_path)
    found = measured_on(command, ladder_test(fault.test), order=ORDER)
    assert found.verdict not in GOOD, (found.order, found.floor, found.digits)


@pytest.mark.parametrize("name", ["flight", "ice", "gliding"])
@both
def test_the_healthy_engines_are_not_flagged(name: str, language: str, tmp_path: Path) -> None:
    found = measured_on(program(language, NOTHING, tmp_path), ladder_test(name), order=ORDER)
    assert found.verdict == "converges"
    assert found.order == pytest.approx(ORDER, abs=0.1)
    checks = {} if name == "flight" else dict.fromkeys(EVERY_LAW, "pass")
    assert {name: one["verdict"] for name, one in found.checks.items()} == checks


@both
def test_what_no_friction_law_can_excuse_is_named(language: str, tmp_path: Path) -> None:
    command = program(language, getattr(FAULTS["no gyroscopic term"], language), tmp_path)
    momentum = measured_on(command, ladder_test("gliding")).checks["contact_momentum"]
    assert momentum["verdict"] == "fail"
    assert "no gyroscopic term" in momentum["note"]
    assert min(momentum["values"]) > 100 * momentum["limit"]  # at no step is it smaller


@both
def test_no_healthy_engine_is_flagged_in_fifty_seeded_runs(language: str, tmp_path: Path) -> None:
    """A hundred, with both: tops and starts by lot, flying, on ice and gliding in turn."""
    command = program(language, NOTHING, tmp_path)
    flagged = {}
    scenes = itertools.islice(gliding_scenes(Fraction(1, 4)), SEEDED)
    for scene, name in zip(scenes, itertools.cycle(("flight", "ice", "gliding"))):
        test = ladder_test(name, VISCOUS)
        drawn = scene.varied(mu="0") if name == "ice" else scene
        found = measured_on(command, replace(test, scene=drawn), order=ORDER)
        if found.verdict not in GOOD:
            flagged[scene.name, name] = found
    assert flagged == {}


def wrong_part(rates: Rates) -> str | None:
    """The first part of an engine whose terms are not those of the vectors."""
    wrong = set()
    for case in json.loads((home() / "vectors" / "states.json").read_text("utf-8"))["cases"]:
        law = case["friction"]["law"]
        invalid = case["result"] == "invalid"  # its terms have a mistake
        if law in LAWS and "-sticks-" not in case["name"] and not invalid:  # neither can stick
            wrong |= {(law == FLYING, name) for name in _terms_off(rates, case)}
    for flies, name, part in (
        (True, "k_dot", "orientation"), (True, "omega_dot", "inertia"),
        (True, "s_ddot", "gravity"), (False, "s_ddot", "force"), (False, "omega_dot", "torque"),
    ):  # fmt: skip
        if (flies, name) in wrong:
            return part
    return None


def _terms_off(rates_of: Rates, case: Any) -> list[str]:
    body = {name: float(value) for name, value in case["body"].items()}
    law = case["friction"]["law"]
    given = {name: [float(x) for x in value] for name, value in case["state"].items()}
    job = {
        "body": {"mass": body["m"], "radius": body["R"],
                 "centre_offset": body["alpha"] * body["R"], "I1": body["I1"], "I3": body["I3"]},
        "gravity": body["g"],
        "contact": "none" if law == FLYING else "rigid",
        "friction": {"law": law, "mu": float(case["friction"].get("mu", 0))},
        "start": {name: given[name] for name in ("quaternion_wxyz", "quaternion_xyzw")}
        | {"velocity": given["s_dot"], "angular_velocity": given["omega"]},
        "step": 1e-3,
        "sample_times": [0.0],
    }  # fmt: skip
    rates = rates_of(job)
    q, turning = numpy.array(given["quaternion_wxyz"]), numpy.array(rates[:4])
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


def rates_in_python(change: tuple[str, str], folder: Path) -> Rates:
    source = planted((EXAMPLES / "engine.py").read_text("utf-8"), change)
    engine: dict[str, Any] = {"__name__": "engine"}
    exec(compile(source, "engine.py", "exec"), engine)

    def rates(job: Any) -> list[float]:
        start = job["start"]
        y = start["quaternion_wxyz"] + start["angular_velocity"] + start["velocity"]
        found: list[float] = engine["rates"](job, y)
        return found

    return rates


def rates_in_c(change: tuple[str, str], folder: Path) -> Rates:
    (command,) = program("c", change, folder, RATES)

    def rates(job: Any) -> list[float]:
        done = subprocess.run([command], input=as_text(job), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return [float(word) for word in done.stdout.split()]

    return rates


@pytest.mark.parametrize("rates_in", [rates_in_python, rates_in_c])
def test_the_vectors_name_the_part_that_is_wrong(rates_in: Any, tmp_path: Path) -> None:
    assert wrong_part(rates_in(NOTHING, tmp_path)) is None
    c = rates_in is rates_in_c
    named = {
        name: wrong_part(rates_in(fault.c if c else fault.python, tmp_path))
        for name, fault in FAULTS.items()
    }
    # where every term is right the error is in the integration, which depth 2 is for
    assert {name: part or "integration" for name, part in named.items()} == {
        name: (c and fault.part_in_c) or fault.part for name, fault in FAULTS.items()
    }
