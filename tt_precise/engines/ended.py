"""Run somebody's program to its end, in bounded time and memory, and leave nothing running."""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import IO

MOST_BYTES = 20_000_000  # on standard output, and on standard error
LAST_BYTES = 10_000  # of standard error, which are read
SHORTEST_S, LONGEST_S = 0.001, 0.05  # between two looks at it


@dataclass(frozen=True)
class Ended:
    """What is left of a program.

    ``cut_short``: why it had to be ended, "" if it did so itself. ``status``: its exit status, or
    minus the signal. ``out``: standard output; ``err``: the last part of standard error.
    """

    cut_short: str
    status: int
    out: str
    err: str


def ended(
    command: Sequence[str], given: str, time_limit: float, stop: threading.Event | None = None
) -> Ended:
    """Give ``given`` on standard input, wait, and end what is left of it and its children.

    ``stop`` ends it early. Raises OSError if it cannot be started.
    """
    with (
        tempfile.TemporaryFile() as source,
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as err,
    ):
        source.write(given.encode())
        source.seek(0)
        process = subprocess.Popen(
            list(command), stdin=source, stdout=out, stderr=err, start_new_session=True
        )
        try:
            cut_short = _waited(process.pid, time_limit, (out, err), stop)
        finally:
            # not waited for yet, so that its number is still that of the group
            os.killpg(process.pid, signal.SIGKILL)
            status = process.wait()
        return Ended(cut_short, status, _text(out, 0), _text(err, LAST_BYTES))


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


def _text(file: IO[bytes], last: int) -> str:
    """The content, or its last part; no more than what is allowed."""
    file.seek(-min(last, file.seek(0, os.SEEK_END)) if last else 0, os.SEEK_END if last else 0)
    return file.read(MOST_BYTES).decode(errors="replace")
