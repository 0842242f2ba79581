"""Test jobs, programs in two languages, and the failures of programs."""

import json
import os
import select
import sys
import threading
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy
import pytest

from tests.conftest import Said
from tests.engines.conftest import ENGINE_C, EXAMPLES, compiled_c, ladder_test
from tt_precise.engines.protocol import COLUMNS, ProgramRun, run

STEP = Fraction(1, 500)
Program = Callable[..., ProgramRun]


@pytest.fixture
def program(tmp_path: Path) -> Program:
    """Return a function that runs Python text as a program that has read the job of a flight."""

    def run_text(text: str, limit_s: float = 60.0, stop: threading.Event | None = None) -> Any:
        path = tmp_path / "engine.py"
        path.write_text("import json, sys\njob = json.load(sys.stdin)\n" + text)
        return run(
            [sys.executable, "-S", str(path)], ladder_test("flight").job(STEP), limit_s, stop
        )

    return run_text


def test_the_start_of_the_job_touches_the_table() -> None:
    job = ladder_test("gliding").job(STEP)
    body, start = job["body"], job["start"]
    w, x, y, z = start["quaternion_wxyz"]
    k = numpy.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    centre = start["position"][2] + body["centre_offset"] * k[2]
    assert centre == pytest.approx(body["radius"], rel=1e-14)
    assert start["quaternion_xyzw"] == [x, y, z, w]
    # the velocity of the contact point, nu_y along +Y
    a = body["centre_offset"] * k - [0, 0, body["radius"]]
    contact = numpy.array(start["velocity"]) + numpy.cross(start["angular_velocity"], a)
    assert contact == pytest.approx([0, 0.92, 0], abs=1e-14)


def test_the_examples_agree_and_refuse_another_law(tmp_path: Path) -> None:
    in_c = compiled_c(tmp_path, ENGINE_C, "-std=c99", "-Wall", "-Wextra", "-Werror")
    in_python = [sys.executable, str(EXAMPLES / "engine.py")]
    job = ladder_test("gliding").job(STEP)
    job["sample_times"] = job["sample_times"][:11]
    first, second = run(in_c, job), run(in_python, job)
    assert (first.name, second.motion is None) == ("Runge and Kutta in C", False)
    for mine, other in zip(first.motion or (), second.motion or (), strict=True):
        assert mine == pytest.approx(other, rel=1e-10, abs=1e-10)  # additions in another order
    refusal = run(in_c, job | {"friction": {"law": "regularised", "mu": 1, "epsilon": 1}})
    assert (refusal.status, refusal.message) == ("refused", "no such friction here")


def rows(numbers: str = "*q, *w, *v", time: str = "t") -> str:
    """Return a program that stays at the start, or prints other numbers."""
    return f"""
start = job["start"]
q, w, v = start["quaternion_wxyz"], start["angular_velocity"], start["velocity"]
print("# a comment", {",".join(COLUMNS)!r} + ",extra", sep="\\n")
for t in job["sample_times"]: print(",".join(map(str, [{time}, {numbers}, 5])))
"""


@pytest.mark.parametrize(
    ("text", "status", "message"),
    [
        (rows(), "done", ""),
        ("sys.exit('no licence')", "failed", "exit status 1: no licence"),
        ("pass", "unreadable", "No columns"),
        ("print('t,qw\\n0,1')", "unreadable", "missing columns qx"),
        (rows("*q"), "diverged", "from t = 0 s on"),
        (rows(time="t + 1e-6"), "unreadable", "got 51 rows"),
        (rows("*q, 'nan' if t > 0.2 else w[0], *w[1:], *v"), "diverged", "from t = 0.21 s on"),
        # conventions: inverse quaternion, scalar last, another velocity
        (rows("q[0], -q[1], -q[2], -q[3], *w, *v"), "unreadable", "scalar first"),
        (rows("*q, *w[::-1], *v"), "unreadable", "inertial frame"),
        ("while True: print('x' * 65536)", "stopped", "wrote more than 20 MB"),
        ("while True: print('x' * 65536, file=sys.stderr)", "stopped", "wrote more than 20 MB"),
        ("import time; time.sleep(60)", "stopped", "still running after 0.5 s"),
    ],
)
def test_failures_have_one_line(text: str, status: str, message: str, program: Program) -> None:
    result = program(text, 0.5 if "0.5 s" in message else 60.0)
    assert (result.status, message in result.message) == (status, True), result.message
    assert "\n" not in result.message
    assert (result.motion is None) == (status != "done")


FORK = "sys.stdout.flush()\nimport os, time\nif os.fork() == 0: time.sleep(600)"


@pytest.mark.parametrize(
    ("text", "status"), [(rows() + FORK, "done"), (f"{FORK}\ntime.sleep(600)", "stopped")]
)
def test_all_processes_of_a_program_end(
    text: str, status: str, program: Program, tmp_path: Path
) -> None:
    alive = tmp_path / "alive"
    os.mkfifo(alive)
    reader = os.open(alive, os.O_RDONLY | os.O_NONBLOCK)
    result = program(f"writer = open({str(alive)!r}, 'w')\n{text}", 60.0 if status == "done" else 1)
    assert result.status == status
    closed, _, _ = select.select([reader], [], [], 60)
    os.close(reader)
    assert closed


def test_an_interruption_does_not_wait(program: Program) -> None:
    stop = threading.Event()
    stop.set()
    assert program("import time; time.sleep(600)", 600.0, stop).message == "interrupted"


def test_the_command_prints_a_job_and_refuses_in_one_line(said: Said) -> None:
    job = json.loads(said("engines --job ice --step 1/1000"))
    assert (job["step"], job["friction"]["law"]) == (0.001, "none")
    for words, message in (
        ("", "expected --run PROGRAM"),
        ("--test loop", "got 'loop'"),
        ("--step 0.003", "got 0.003"),
        ("--test flight --run ./nowhere", "nowhere"),
        ("""--run "'./nowhere\"""", "No closing quotation"),
    ):
        assert message in said("engines", words, status=2)
