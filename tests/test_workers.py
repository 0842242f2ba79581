"""Worker processes: gone with their parent, and at once when they are dismissed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

PARENT = """
import multiprocessing, os, sys, time
from concurrent.futures import ProcessPoolExecutor
from tt_precise.workers import dismiss, serve_quietly

if __name__ == "__main__":
    context = multiprocessing.get_context("spawn")
    initializer = serve_quietly if sys.argv[1] == "quiet" else None
    pool = ProcessPoolExecutor(1, mp_context=context, initializer=initializer)
    print(pool.submit(os.getpid).result(), flush=True)
    if sys.argv[2] == "dismiss":
        pool.submit(time.sleep, 60)
        begin = time.monotonic()
        dismiss(pool)
        pool.shutdown()
        sys.exit(time.monotonic() - begin > 30)
    else:
        time.sleep(60)
"""


def parent(tmp_path: Path, *words: str) -> tuple["subprocess.Popen[str]", int]:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    process = subprocess.Popen(
        [sys.executable, str(script), *words], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    with process.stdout as told:
        return process, int(told.readline())


def runs(pid: int, within_s: float) -> bool:
    """Whether the process still runs after that time; one that nobody buries does not."""
    until = time.monotonic() + within_s
    while time.monotonic() < until:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return False
        if state == "Z":
            return False
        time.sleep(0.05)
    return True


@pytest.mark.parametrize(("kind", "survives"), [("quiet", False), ("ordinary", True)])
def test_a_worker_ends_with_a_parent_that_is_killed(
    tmp_path: Path, kind: str, survives: bool
) -> None:
    process, worker = parent(tmp_path, kind, "wait")
    process.kill()
    process.wait()
    found = runs(worker, 1.0 if survives else 20.0)
    if found:
        os.kill(worker, signal.SIGKILL)
    assert found == survives


def test_dismissed_workers_end_at_once(tmp_path: Path) -> None:
    process, worker = parent(tmp_path, "quiet", "dismiss")
    assert process.wait(timeout=60) == 0
    assert not runs(worker, 20.0)


def test_an_interruption_is_left_to_the_parent(tmp_path: Path) -> None:
    process, worker = parent(tmp_path, "quiet", "wait")
    os.kill(worker, signal.SIGINT)
    assert runs(worker, 0.5)
    process.kill()
    process.wait()
