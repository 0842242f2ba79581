"""Run a program of the engine protocol once, and read what it wrote."""

from __future__ import annotations

import io
import threading
from collections.abc import Sequence
from dataclasses import dataclass

import numpy

from tt_precise.engines.ended import ended
from tt_precise.engines.job import as_text
from tt_precise.engines.program import COLUMNS, REFUSED
from tt_precise.engines.rungs import States
from tt_precise.mechanics.conversion import axis_of
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json

TIME_LIMIT_S = 60.0
TIME_SLACK = 1e-9  # s
LARGEST = 1e50  # in SI; the square of an energy is still a number


@dataclass(frozen=True)
class ProgramRun:
    """How a program did on one job.

    ``status``: "done"; "refused" (exit status 3); "failed", "stopped" (it took too long or wrote
    too much) or "unreadable", with ``message`` in one line; "diverged": numbers that are no
    numbers, or out of all proportion.
    """

    status: str
    message: str = ""
    states: States | None = None


def run(
    command: Sequence[str],
    job: dict[str, Json],
    time_limit: float = TIME_LIMIT_S,
    stop: threading.Event | None = None,
) -> ProgramRun:
    """Give ``job`` to the program, wait at most ``time_limit`` seconds, and read its rows.

    ``stop`` ends it early.

    Raises
    ------
    InputError
        There is no such program, or it cannot be started.
    """
    try:
        done = ended(command, as_text(job), time_limit, stop)
    except OSError as error:
        raise InputError(
            f"engines: got {command[0]!r}, which cannot be started ({error.strerror}); expected a "
            "program of the engine protocol"
        ) from None
    if done.cut_short:
        return ProgramRun("stopped", done.cut_short)
    last = _last_line(done.err)
    if done.status == REFUSED:
        return ProgramRun("refused", last)
    if done.status:
        return ProgramRun("failed", f"exit status {done.status}: {last}")
    try:
        return _read(done.out, job)
    except ValueError as error:
        return ProgramRun("unreadable", str(error))


def _read(text: str, job: dict[str, Json]) -> ProgramRun:
    import pandas

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
    table = frame[list(COLUMNS)].apply(pandas.to_numeric, errors="coerce").to_numpy(dtype=float)
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
    k = numpy.stack(axis_of(*table[:, 1:5].T), axis=1)
    return ProgramRun("done", "", States(k, table[:, 5:8], table[:, 8:11]))


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
        raise ValueError(f"columns {', '.join(twice)} stand there twice")


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:200] if lines else "nothing on standard error"
