"""The engine protocol: a job as JSON on standard input, rows as CSV on standard output.

``Job`` describes the simulation for an engine, all in SI. ``run`` passes a job to a program, bounds
the program's time and memory, ends all its processes, and reads the rows (``PROTOCOL.md``).
"""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import IO, Annotated, Literal

import msgspec
import numpy
import pandas
from msgspec import Meta

from tt_precise.check.conventions import Given, alternatives, convert
from tt_precise.mechanics.conversion import axis_of
from tt_precise.mechanics.laws import LAWS
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import multiplied
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Arithmetic, Array, InputError, Json
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

DOUBLE = Arithmetic(numpy, float)
# The columns that a program writes; the position of the centre of mass may be left out.
COLUMNS = ("t", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")
POSITION = ("x", "y", "z")
REFUSED = 3  # exit status of a program that cannot express the job
# about the axis: without it a quaternion read in the wrong order would be one of the same axis
TURNED = (0.8, 0.0, 0.0, 0.6)
MOST_BYTES = 20_000_000  # on standard output, and on standard error
LAST_BYTES = 10_000  # the part of standard error that is read, for its last line
SHORTEST_S, LONGEST_S = 0.001, 0.05  # between two looks at it
TIME_LIMIT_S = 60.0
TIME_SLACK = 1e-9  # s
LARGEST = 1e50  # bound of any number in SI; the square of an energy is still a double
SAME_START = 1e-3  # relative tolerance of the first row, which has to be the job's start
EXPECTED = "body to inertial frame, scalar first, velocities in the inertial frame"
NAMED = re.compile(r"^#\s*engine:\s*(\S.*)$", re.MULTILINE)

Vector = Annotated[list[float], Meta(min_length=3, max_length=3)]
Quaternion = Annotated[list[float], Meta(min_length=4, max_length=4)]


class Body(Record, frozen=True, forbid_unknown_fields=True):
    """A rigid sphere whose centre of mass lies off its centre."""

    mass: Annotated[float, means("kg", gt=0)]
    radius: Annotated[float, means("m, of the sphere", gt=0)]
    centre_offset: Annotated[
        float, means("m: the sphere's centre is at (0, 0, centre_offset) in the body frame", gt=0)
    ]
    I1: Annotated[
        float,
        means("kg m^2 about the body's first and second axis through the centre of mass", gt=0),
    ]
    I3: Annotated[float, means("kg m^2 about the axis of symmetry", gt=0)]


def friction_of(scene: Scene) -> dict[str, Json]:
    """The scene's friction in the form of a job."""
    if scene.model == "gliding" and scene.body.mu == 0:
        return dict(NO_FRICTION)
    law, numbers = scene.body.friction, scene.body.numbers_by_name
    return {"law": law.name} | {
        parameter.name: float(numbers[parameter.name]) for parameter in law.parameters
    }


NO_FRICTION: dict[str, Json] = {"law": "none", "mu": 0.0}
_PARAMETERS = {one.name: one.unit for law in LAWS.values() for one in law.parameters[1:]}
FRICTION = {
    "properties": {
        "law": {
            "enum": [NO_FRICTION["law"], *LAWS],
            "description": "; ".join(f"{law.name}: {law.force}" for law in LAWS.values()),
        },
        "mu": {"type": "number", "minimum": 0, "description": "s/m for viscous, else 1"},
        **{name: {"type": "number", "description": unit} for name, unit in _PARAMETERS.items()},
    },
    "required": ["law", "mu"],
}


class InitialPose(Record, frozen=True, forbid_unknown_fields=True):
    """Pose and twist at t = 0."""

    position: Annotated[Vector, means("m, of the centre of mass")]
    quaternion_wxyz: Annotated[Quaternion, means("body frame to inertial frame, scalar first")]
    quaternion_xyzw: Annotated[Quaternion, means("the same, scalar last")]
    velocity: Annotated[Vector, means("m/s, of the centre of mass, inertial frame")]
    angular_velocity: Annotated[Vector, means("rad/s, inertial frame")]


class Job(
    Record,
    frozen=True,
    forbid_unknown_fields=True,
    tag_field="schema",
    tag="tt_precise.engine-job/1",
):
    """A job for a physics engine: a sphere on a horizontal table at z = 0.

    SI throughout; the inertial frame has z up, the body frame has its origin at the centre of mass
    and its third axis along the axis of symmetry.
    """

    body: Body
    gravity: Annotated[float, means("m/s^2, downwards", gt=0)]
    contact: Annotated[Literal["rigid", "none"], means("none: no table, free flight")]
    friction: Annotated[dict[str, Json], Meta(extra_json_schema=FRICTION)]
    start: InitialPose
    step: Annotated[float, means("s, the fixed step to use", gt=0)]
    sample_times: Annotated[
        list[float],
        means("s, rising from 0, multiples of the step: one row of output each", min_length=1),
    ]


def job(
    scene: Scene,
    step: Fraction,
    friction: dict[str, Json],
    *,
    contact: Literal["rigid", "none"] = "rigid",
) -> dict[str, Json]:
    """The job, as plain values, to simulate ``scene`` with the fixed ``step`` (s).

    ``contact`` is "rigid" (a horizontal table at z = 0) or "none" (free flight). The sample times
    are the scene's, the start is its start with the axis at azimuth 0 and psi = 0.
    """
    start = InitialState.in_si(scene, DOUBLE)
    q: Motion = start.motion(numpy)
    body, half = start.body, start.euler.theta / 2
    tilted = (float(numpy.cos(half)), 0.0, float(numpy.sin(half)), 0.0)
    w, x, y, z = multiplied(tilted, TURNED)
    made = Job(
        Body(
            float(body.m), float(body.R), float(body.alpha * body.R), float(body.I1), float(body.I3)
        ),
        float(body.g),
        contact,
        friction,
        InitialPose(
            [0.0, 0.0, float(body.R * (1 - body.alpha * q.k[2]))],
            [w, x, y, z],
            [x, y, z, w],
            [float(x) for x in q.s_dot],
            [float(x) for x in q.omega],
        ),
        float(step),
        [float(t) for t in scene.sample_times],
    )
    plain: dict[str, Json] = msgspec.to_builtins(made)
    return plain


def as_text(content: dict[str, Json]) -> str:
    """The job as one line of JSON."""
    return msgspec.json.encode(content).decode() + "\n"


@dataclass(frozen=True)
class SampledMotion:
    """A motion at the sample times: axis, angular velocity, velocity of CM, each (rows, 3); SI."""

    k: Array
    omega: Array
    s_dot: Array

    def every(self, rows: int) -> SampledMotion:
        """Every ``rows``-th row, including the first."""
        return SampledMotion(self.k[::rows], self.omega[::rows], self.s_dot[::rows])

    def distance(self, other: SampledMotion, spin: float, radius: float) -> Array:
        """Largest of |dk|, |d omega|/spin, |d s_dot|/(radius spin), row by row."""
        return numpy.max(
            [
                numpy.linalg.norm(self.k - other.k, axis=1),
                numpy.linalg.norm(self.omega - other.omega, axis=1) / spin,
                numpy.linalg.norm(self.s_dot - other.s_dot, axis=1) / (radius * spin),
            ],
            axis=0,
        )


@dataclass(frozen=True)
class ProgramRun:
    """The result of a program for one job.

    ``status``: "done"; "refused" (exit status 3); "failed", "stopped" (it took too long or wrote
    too much) or "unreadable", with ``message`` in one line; "diverged": NaN, infinity, or absurdly
    large numbers. ``name`` is the name that the engine gives in a line ``# engine: NAME``.
    ``columns`` are its rows as written.
    """

    status: str
    message: str = ""
    states: SampledMotion | None = None
    name: str = ""
    columns: dict[str, Array] = field(default_factory=dict, repr=False)


def run(
    command: Sequence[str],
    job: dict[str, Json],
    time_limit: float = TIME_LIMIT_S,
    stop: threading.Event | None = None,
) -> ProgramRun:
    """Pass ``job`` to the program, wait at most ``time_limit`` seconds, and read its rows.

    ``stop`` ends it early. Afterwards the program and its children have ended.

    Raises ``InputError``: there is no such program, or it cannot be started.
    """
    with (
        tempfile.TemporaryFile() as source,
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as err,
    ):
        source.write(as_text(job).encode())
        source.seek(0)
        try:
            process = subprocess.Popen(
                list(command), stdin=source, stdout=out, stderr=err, start_new_session=True
            )
        except OSError as error:
            raise InputError(
                f"engines: got {command[0]!r}, which does not start ({error.strerror}); expected a "
                "program of the engine protocol"
            ) from None
        try:
            cut_short = _waited(process.pid, time_limit, (out, err), stop)
        finally:
            # not waited for yet, so that its number is still that of the group
            os.killpg(process.pid, signal.SIGKILL)
            status = process.wait()
        out.seek(0)
        err.seek(max(0, err.seek(0, os.SEEK_END) - LAST_BYTES))
        written = out.read(MOST_BYTES).decode(errors="replace")
        last = _last_line(err.read(LAST_BYTES).decode(errors="replace"))
    if cut_short:
        return ProgramRun("stopped", cut_short)
    if status == REFUSED:
        return ProgramRun("refused", last)
    if status:
        return ProgramRun("failed", f"exit status {status}: {last}")
    called = NAMED.search(written)
    name = called.group(1).strip()[:60] if called else ""
    try:
        result = _parse(written, job)
    except ValueError as error:
        result = ProgramRun("unreadable", str(error))
    return replace(result, name=name)


def _parse(text: str, job: dict[str, Json]) -> ProgramRun:
    _require_columns(text)
    try:
        frame = pandas.read_csv(io.StringIO(text), comment="#", skipinitialspace=True)
    except pandas.errors.ParserError as error:
        raise ValueError(f"not CSV: {_last_line(str(error))}") from None
    if not isinstance(frame.index, pandas.RangeIndex):
        raise ValueError("rows have more cells than the header")
    times = numpy.array(job["sample_times"])
    if len(frame) != len(times):
        raise ValueError(f"got {len(frame)} rows, expected {len(times)}: one a sample time")
    names = [*COLUMNS, *(POSITION if {*POSITION} <= {*frame.columns} else ())]
    table = frame[names].apply(pandas.to_numeric, errors="coerce").to_numpy(dtype=float)
    off = numpy.flatnonzero(~(abs(table[:, 0] - times) <= TIME_SLACK))
    if len(off):
        row = int(off[0])
        got, expected = float(table[row, 0]), float(times[row])
        raise ValueError(f"row {row + 1}: got t = {got!r}, expected {expected!r}")
    finite = (abs(table) < LARGEST).all(axis=1)
    if not finite.all():
        return ProgramRun(
            "diverged", f"no numbers from t = {times[int(numpy.argmin(finite))]:g} s on"
        )
    size = numpy.linalg.norm(table[:, 1:5], axis=1)
    if abs(size - 1).max() > 0.1:
        raise ValueError(f"quaternion of length {size[abs(size - 1).argmax()]:.3g}, expected 1")
    _require_start(table[0], job)
    k = numpy.stack(axis_of(*table[:, 1:5].T), axis=1)
    states = SampledMotion(k, table[:, 5:8], table[:, 8:11])
    return ProgramRun("done", "", states, columns=dict(zip(names, table.T, strict=True)))


def _require_start(row: Array, job: dict[str, Json]) -> None:
    """Refuse a first row that is the job's start in a wrong convention."""
    given = Given(row[:1], row[1:5, None], row[5:8, None], row[8:11, None])
    if _off_start(given, job) < SAME_START:
        return
    body = job["body"]
    alpha = body["centre_offset"] / body["radius"]
    known = Parameters(
        body["mass"], body["radius"], alpha, body["I1"], body["I3"], job["gravity"], 0.0
    )
    for convention in alternatives():
        if _off_start(convert(given, convention, known), job) < SAME_START:
            raise ValueError(
                f"row 1 is the job's start if {convention.words()}; expected {EXPECTED}"
            )


def _off_start(row: Given, job: dict[str, Json]) -> float:
    """Distance of a row from the job's start: 1 is the size of the motion."""
    start = job["start"]
    spin = float(numpy.linalg.norm(start["angular_velocity"])) or 1.0
    turned = 1 - abs(float(row.q[:, 0] @ start["quaternion_wxyz"]))
    away = numpy.abs(row.w[:, 0] - start["angular_velocity"]).max() / spin
    velocity = numpy.zeros(3) if row.v is None else row.v[:, 0]
    drift = numpy.abs(velocity - start["velocity"]).max() / (spin * job["body"]["radius"])
    return float(max(turned, away, drift))


def _require_columns(text: str) -> None:
    lines = (line.partition("#")[0].strip() for line in io.StringIO(text))
    header = next(filter(None, lines), None)
    if header is None:
        raise ValueError("got nothing on standard output, expected CSV")
    names = [name.strip(' "') for name in header.split(",")]
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise ValueError(f"missing columns {', '.join(missing)}, expected {','.join(COLUMNS)}")
    twice = [name for name in COLUMNS if names.count(name) > 1]
    if twice:
        raise ValueError(f"columns {', '.join(twice)} occur twice")


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:200] if lines else "nothing on standard error"


def _waited(
    pid: int, time_limit: float, files: Sequence[IO[bytes]], stop: threading.Event | None
) -> str:
    until, pause = time.monotonic() + time_limit, SHORTEST_S
    while os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > until:
            return f"still running after {time_limit:g} s"
        if any(os.fstat(file.fileno()).st_size > MOST_BYTES for file in files):
            return f"wrote more than {MOST_BYTES / 1e6:g} MB"
        if stop is not None and stop.is_set():
            return "interrupted"
        time.sleep(pause)
        pause = min(2 * pause, LONGEST_S)
    return ""
