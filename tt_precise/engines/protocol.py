"""The engine protocol: a job as JSON on standard input, rows as CSV on standard output.

``job`` describes a simulation for an engine, all in SI. ``run`` passes a job to a program, bounds
the program's time and output, ends all its processes, and reads the rows (``PROTOCOL.md``).
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from fractions import Fraction
from typing import IO, NamedTuple

import numpy
import pandas

from tt_precise.mechanics.vectors import axis_of, multiplied
from tt_precise.runtime.values import Arithmetic, Array, InputError, Json
from tt_precise.scene.scene import InitialState, Scene

DOUBLE = Arithmetic(numpy, float)
COLUMNS = ("t", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")
NAME = re.compile(r"^#\s*engine:\s*(\S.*)$", re.MULTILINE)
REFUSED = 3  # Exit status of a program that cannot express the job.
# A rotation about the axis: without it a quaternion in the wrong order would have the same axis.
ROTATION = (0.8, 0.0, 0.0, 0.6)
TIME_LIMIT_S = 120.0
MOST_BYTES = 20_000_000  # Limit of standard output and of standard error; a motion has 0.2 MB.
PAUSE_S = 0.002  # Interval at which a running program is inspected.
LARGEST = 1e50  # A larger number in SI counts as diverged; the square of an energy is a double.
START_TOLERANCE = 1e-3  # Relative tolerance of the first row, which is the start of the job.
NO_FRICTION: dict[str, Json] = {"law": "none", "mu": 0.0}


def friction_of(scene: Scene) -> dict[str, Json]:
    """Return the friction of a scene in the form of a job."""
    if scene.model == "gliding" and scene.body.mu == 0:
        return dict(NO_FRICTION)
    law, numbers = scene.body.friction, scene.body.numbers_by_name
    return {"law": law.name} | {p.name: float(numbers[p.name]) for p in law.parameters}


def job(
    scene: Scene, step: Fraction, friction: dict[str, Json], contact: str = "rigid"
) -> dict[str, Json]:
    """Return the job to simulate ``scene`` with the fixed ``step`` (s), in SI.

    ``contact`` is "rigid" (a horizontal table at z = 0) or "none" (free flight). The sample times
    are the scene's, the start is its start with the axis at azimuth 0 and psi = 0.
    """
    start = InitialState.in_si(scene, DOUBLE)
    q, body, half = start.motion(numpy), start.body, start.euler.theta / 2
    w, x, y, z = multiplied((float(numpy.cos(half)), 0.0, float(numpy.sin(half)), 0.0), ROTATION)
    sizes = {"mass": body.m, "radius": body.R, "centre_offset": body.alpha * body.R}
    sizes |= {"I1": body.I1, "I3": body.I3}
    return {
        "schema": "tt_precise.engine-job/1",
        "body": {name: float(value) for name, value in sizes.items()},
        "gravity": float(body.g),
        "contact": contact,
        "friction": friction,
        "start": {
            "position": [0.0, 0.0, float(body.R * (1 - body.alpha * q.k[2]))],
            "quaternion_wxyz": [w, x, y, z],
            "quaternion_xyzw": [x, y, z, w],
            "velocity": [float(v) for v in q.s_dot],
            "angular_velocity": [float(v) for v in q.omega],
        },
        "step": float(step),
        "sample_times": [float(t) for t in scene.sample_times],
    }


class SampledMotion(NamedTuple):
    """A motion at the sample times: axis, angular velocity, velocity of CM, each (rows, 3); SI."""

    k: Array
    omega: Array
    s_dot: Array


class ProgramRun(NamedTuple):
    """The result of a program for one job.

    ``status``: "done"; "refused" (exit status 3); "failed", "stopped" (beyond the limits) or
    "unreadable"; "diverged": NaN, infinity, or absurdly large numbers. ``message`` is one line.
    ``name`` is the name that the engine gives in a line ``# engine: NAME``.
    """

    status: str
    message: str = ""
    motion: SampledMotion | None = None
    name: str = ""


def run(
    command: Sequence[str],
    job: dict[str, Json],
    time_limit: float = TIME_LIMIT_S,
    stop: threading.Event | None = None,
) -> ProgramRun:
    """Pass ``job`` to the program, wait at most ``time_limit`` seconds, and read its rows.

    ``stop`` ends it early. Afterwards the program and its children have ended.

    Raises ``InputError``: the program cannot be started.
    """
    file = tempfile.TemporaryFile
    with file() as jobs, file() as out, file() as err:
        jobs.write(json.dumps(job).encode() + b"\n")
        jobs.seek(0)
        try:
            process = subprocess.Popen(
                list(command), stdin=jobs, stdout=out, stderr=err, start_new_session=True
            )
        except OSError as error:
            message = f"engines: got {command[0]!r} ({error.strerror}), expected a program"
            raise InputError(message) from None
        try:
            limit = _wait(process.pid, time_limit, (out, err), stop)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        if limit:
            return ProgramRun("stopped", limit)
        text, last = _text(out), _text(err).rpartition("\n")[2][:200]
    if process.returncode == REFUSED:
        return ProgramRun("refused", last)
    if process.returncode:
        return ProgramRun("failed", f"exit status {process.returncode}: {last}")
    try:
        return _parse_rows(text, job)
    except ValueError as error:
        return ProgramRun("unreadable", str(error).splitlines()[0])


def _text(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read().decode("utf-8", "replace").strip()


def _wait(
    pid: int, time_limit: float, outputs: Sequence[IO[bytes]], stop: threading.Event | None
) -> str:
    """Return the reason to end the process, or "" once it has ended and its id is still taken."""
    deadline = time.monotonic() + time_limit
    while os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > deadline:
            return f"still running after {time_limit:g} s"
        if any(os.fstat(file.fileno()).st_size > MOST_BYTES for file in outputs):
            return f"wrote more than {MOST_BYTES / 1e6:g} MB"
        if stop is not None and stop.is_set():
            return "interrupted"
        time.sleep(PAUSE_S)
    return ""


def _parse_rows(text: str, job: dict[str, Json]) -> ProgramRun:
    """Read the rows of a program. Raises ``ValueError``: these are not rows of the job."""
    table = pandas.read_csv(io.StringIO(text), comment="#", skipinitialspace=True)
    table.columns = table.columns.str.strip()
    missing = [name for name in COLUMNS if name not in table]
    if missing:
        raise ValueError(f"missing columns {', '.join(missing)}, expected {','.join(COLUMNS)}")
    rows, times = table[list(COLUMNS)].to_numpy(dtype=float), numpy.array(job["sample_times"])
    if len(rows) != len(times) or abs(rows[:, 0] - times).max() > 1e-9:
        raise ValueError(f"got {len(rows)} rows, expected one at each of {len(times)} sample times")
    valid = (abs(rows) < LARGEST).all(axis=1)
    if not valid.all():
        return ProgramRun("diverged", f"no numbers from t = {times[valid.argmin()]:g} s on")
    start = job["start"]
    spin = float(numpy.linalg.norm(start["angular_velocity"])) or 1.0
    speed = spin * job["body"]["radius"]
    distances = (
        1 - abs(rows[0, 1:5] @ start["quaternion_wxyz"]),
        abs(rows[0, 5:8] - start["angular_velocity"]).max() / spin,
        abs(rows[0, 8:11] - start["velocity"]).max() / speed,
    )
    if max(distances) > START_TOLERANCE:
        raise ValueError(
            "row 1: got another motion, expected the start of the job: quaternions are scalar "
            "first, from the body to the inertial frame; angular velocity and velocity of the "
            "centre of mass are in the inertial frame"
        )
    k = numpy.stack(axis_of(*rows[:, 1:5].T), axis=1)
    name = NAME.search(text)
    motion = SampledMotion(k, rows[:, 5:8], rows[:, 8:11])
    return ProgramRun("done", "", motion, name[1].strip() if name else "")
