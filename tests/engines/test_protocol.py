"""The protocol: jobs, programs in two languages, and everything that can go wrong with them."""

from __future__ import annotations

import json
import os
import select
import sys
import threading
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import jsonschema
import numpy
import pytest

from tests.conftest import Said
from tests.engines.conftest import EXAMPLES, compiled_c, ladder_test
from tt_precise.cli import main
from tt_precise.engines.ladder import ladder_tests
from tt_precise.engines.protocol import COLUMNS, POSITION, Job, ProgramRun, run
from tt_precise.mechanics.laws import REGULARISED, VISCOUS
from tt_precise.mechanics.vectors import rotate
from tt_precise.runtime.records import json_schema
from tt_precise.runtime.values import InputError

STEP = Fraction(1, 500)


@pytest.fixture(scope="module")
def flight_job() -> dict[str, Any]:
    return ladder_test("flight").job(STEP)


@pytest.fixture
def ran(flight_job: dict[str, Any], tmp_path: Path) -> Callable[..., ProgramRun]:
    """Return a function that runs Python text as a program that has read the job."""

    def run_it(text: str, limit_s: float = 60.0, stop: threading.Event | None = None) -> ProgramRun:
        path = tmp_path / "engine.py"
        path.write_text("import json, sys\njob = json.load(sys.stdin)\n" + text)
        return run([sys.executable, "-S", str(path)], flight_job, limit_s, stop)

    return run_it


def test_the_job_is_what_the_schema_says(flight_job: dict[str, Any]) -> None:
    schema = json_schema(Job)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert flight_job["schema"] == schema["title"]
    for one in ladder_tests(VISCOUS) + ladder_tests(REGULARISED):
        jsonschema.validate(one.job(STEP), schema)
    spoiled: list[dict[str, Any]] = [
        {"step": "0.001"}, {"more": 1}, {"step": 0}, {"sample_times": []},
    ]  # fmt: skip
    for wrong in spoiled:
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(flight_job | wrong, schema)


def test_the_start_of_the_job_touches_the_table() -> None:
    job = ladder_test("gliding").job(STEP)
    body, start = job["body"], job["start"]
    w, x, y, z = start["quaternion_wxyz"]
    k = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    centre = start["position"][2] + body["centre_offset"] * k[2]
    assert centre == pytest.approx(body["radius"], rel=1e-14)
    assert start["quaternion_xyzw"] == [x, y, z, w]
    # the velocity of the contact point, nu_y along +Y
    a = numpy.array([body["centre_offset"] * c for c in k]) - [0, 0, body["radius"]]
    contact = numpy.array(start["velocity"]) + numpy.cross(start["angular_velocity"], a)
    assert contact == pytest.approx([0, 0.92, 0], abs=1e-14)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    text = (EXAMPLES / "engine.c").read_text("utf-8")
    folder = tmp_path_factory.mktemp("c")
    return compiled_c(text, folder, "-std=c99", "-Wall", "-Wextra", "-Werror")


@pytest.mark.parametrize("name", ["flight", "ice", "gliding"])
def test_the_examples_agree_and_are_near_the_reference(name: str, compiled: list[str]) -> None:
    test = ladder_test(name)
    job = test.job(STEP)
    job["sample_times"] = job["sample_times"][:11]
    in_c, in_python = (
        run(command, job) for command in (compiled, [sys.executable, str(EXAMPLES / "engine.py")])
    )
    assert (in_c.status, in_python.status) == ("done", "done"), in_c.message + in_python.message
    for part in ("k", "omega", "s_dot"):
        mine = getattr(in_c.states, part)
        # the same formulas in another order of additions
        assert mine == pytest.approx(getattr(in_python.states, part), rel=1e-10, abs=1e-10)
        truth = getattr(test.truth, part)[:11]
        # 50 steps of Runge and Kutta at 0.3 rad a step
        assert abs(mine - truth).max() < 1e-3 * test.spin


def test_a_law_that_a_program_does_not_have_is_refused(compiled: list[str]) -> None:
    job = ladder_test("gliding").job(STEP) | {
        "friction": {"law": "regularised", "mu": 1, "epsilon": 1}
    }
    found = run(compiled, job)
    assert (found.status, found.message) == ("refused", "no such friction here")


def table(row: str, *further: str) -> str:
    """A program that prints these rows."""
    header = ",".join((*COLUMNS, *further))
    return f"print({header!r})\nfor t in job['sample_times']: print(','.join(map(str, [t, {row}])))"


AT_REST, SPIN = "1, 0, 0, 0, 0, 0, 1, 0, 0, 0", "1, 0, 0, 0, 0, 0, {}, 0, 0, 0"


@pytest.mark.parametrize(
    ("text", "status", "message"),
    [
        ("sys.exit('no licence')", "failed", "exit status 1: no licence"),
        ("sys.exit(7)", "failed", "exit status 7: nothing on standard error"),
        ("pass", "unreadable", "got nothing on standard output"),
        ("print('t,qw\\n0,1')", "unreadable", "missing columns qx"),
        (f"print({','.join(COLUMNS)!r}, '\"', sep='\\n')", "unreadable", "not CSV"),
        (table(AT_REST).replace("[t,", "[t + 1e-6,"), "unreadable", "row 1"),
        (table("3" + AT_REST[1:]), "unreadable", "3, "),
        (
            table(AT_REST).replace("'sample_times']", "'sample_times'][:3]"),
            "unreadable",
            "got 3 rows, expected 51",
        ),
        (
            table(SPIN.format("'nan' if t > 0.2 else 1")),
            "diverged",
            "no numbers from t = 0.21 s on",
        ),
        (table(SPIN.format("1e200")), "diverged", "no numbers from t = 0 s on"),
        (table(f"{AT_REST}, 8, 8"), "unreadable", "more cells than the header"),
        (table(f"{AT_REST}, 1", "qw"), "unreadable", "columns qw occur twice"),
        ("while True: print('x' * 65536)", "stopped", "wrote more than 20 MB"),
        ("while True: print('x' * 65536, file=sys.stderr)", "stopped", "wrote more than 20 MB"),
        ("import time; time.sleep(60)", "stopped", "still running after 0.5 s"),
    ],
)
def test_what_a_program_does_wrong_is_said_in_one_line(
    text: str, status: str, message: str, ran: Callable[..., ProgramRun]
) -> None:
    found = ran(text, 0.5 if "0.5 s" in message else 60.0)
    assert found.status == status
    assert message in found.message
    assert "\n" not in found.message


CONVENTIONS = {
    "inverse": "q[0], -q[1], -q[2], -q[3], *w, *v",
    "scalar last": "*q[1:], q[0], *w, *v",
    "body frame": "*q, *body, *v",
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_first_row_in_another_convention_is_named(
    convention: str, flight_job: dict[str, Any], ran: Callable[..., ProgramRun]
) -> None:
    start = flight_job["start"]
    q, w, v = (start[name] for name in ("quaternion_wxyz", "angular_velocity", "velocity"))
    body = list(rotate((q[0], -q[1], -q[2], -q[3]), w))
    text = f"q, w, v, body = {q}, {w}, {v}, {body}\n"
    assert ran(text + table("*q, *w, *v")).status == "done"
    found = ran(text + table(CONVENTIONS[convention]))
    assert found.status == "unreadable"
    assert convention in found.message


def test_comments_and_further_columns_are_passed_over_but_for_the_engines_name(
    ran: Callable[..., ProgramRun],
) -> None:
    for comment, name in (("engine: Mine 1.0", "Mine 1.0"), ("Mine 1.0", "")):
        found = ran(f"print('# {comment}')\n{table(f'{AT_REST}, 5', 'extra')}")
        assert (found.status, found.name) == ("done", name)
        assert found.states is not None
        assert found.states.k[-1].tolist() == [0, 0, 1]


@pytest.mark.parametrize("given", [(), ("x", "y"), POSITION])
def test_a_position_is_kept_where_all_of_it_is_there(
    given: tuple[str, ...], ran: Callable[..., ProgramRun]
) -> None:
    found = ran(table(", ".join([AT_REST, *"234"[: len(given)]]), *given))
    kept = POSITION if given == POSITION else ()
    assert tuple(found.columns) == (*COLUMNS, *kept), found.message
    assert [found.columns[name][3] for name in kept] == [2, 3, 4][: len(kept)]


FORKS = "sys.stdout.flush()\nimport os, time\nif os.fork() == 0: time.sleep(600)"


@pytest.mark.parametrize(
    ("text", "status"),
    [(f"{table(AT_REST)}\n{FORKS}", "done"), (f"{FORKS}\ntime.sleep(600)", "stopped")],
)
def test_nothing_that_a_program_started_stays(
    text: str, status: str, ran: Callable[..., ProgramRun], tmp_path: Path
) -> None:
    alive = tmp_path / "alive"
    os.mkfifo(alive)
    reading = os.open(alive, os.O_RDONLY | os.O_NONBLOCK)
    found = ran(f"kept = open({str(alive)!r}, 'w')\n{text}", 60.0 if status == "done" else 1.0)
    assert found.status == status
    ended, _, _ = select.select([reading], [], [], 60)
    os.close(reading)
    assert ended  # nobody has it open any more


def test_who_interrupts_does_not_wait(ran: Callable[..., ProgramRun]) -> None:
    stop = threading.Event()
    stop.set()
    found = ran("import time; time.sleep(600)", 600.0, stop)
    assert (found.status, found.message) == ("stopped", "interrupted")


def test_no_such_program(flight_job: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"engines: got '\./nowhere', which does not start"):
        run(["./nowhere"], flight_job)


def test_the_command_prints_job_and_schema(said: Said) -> None:
    job = json.loads(said("engines --job ice --step 1/1000"))
    assert (job["step"], job["friction"]["law"]) == (0.001, "none")
    assert json.loads(said("engines --schema")) == json_schema(Job)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("", "run: got no program, expected --run PROGRAM"),
        ("--test loop", "test: got 'loop', expected one of: flight"),
        ("--step 0.003", "step: got 0.003, expected a whole fraction"),
        ("""--run "'./nowhere\"""", "No closing quotation"),
        ("--law viscous", "run: got no program"),
    ],
)
def test_the_command_refuses_in_one_line(arguments: str, message: str, said: Said) -> None:
    error = said("engines", arguments, status=2)
    assert message in error
    assert error.count("\n") == 1


def test_a_healthy_program_passes_and_a_spoiled_one_does_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], compiled: list[str]
) -> None:
    out = tmp_path / "mine.json"
    arguments = ["engines", "--test", "flight", "--workers", "1", "--run"]
    assert main([*arguments, compiled[0], "--out", str(out)]) == 0
    (row,) = json.loads(out.read_text())["rows"]
    assert row["verdict"] == "converges"
    assert row["order"] == pytest.approx(4, abs=0.1)
    # the sign of the gyroscopic term
    text = (EXAMPLES / "engine.c").read_text()
    spoiled = text.replace("torque[i] - (I3 - I1)", "torque[i] + (I3 - I1)")
    capsys.readouterr()
    assert main([*arguments, *compiled_c(spoiled, tmp_path)]) == 1
    assert "floor" in capsys.readouterr().out
