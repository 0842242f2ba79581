"""Ctrl-C and SIGTERM, sent to processes of their own."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

HEEDED = """
import time
from tt_precise.runtime.interruption import Terminated, heeded
with heeded():
    try:
        {within}
        time.sleep(30)
    except (KeyboardInterrupt, Terminated) as left:
        print(type(left).__name__, flush=True)
        {then}
time.sleep(30)
"""
SWALLOWS = """
import sys
try:
    print("here", flush=True)
    sys.stdin.readline()  # comes after the signal
except BaseException:
    print("swallowed", flush=True)
"""
KINDS = [(signal.SIGINT, "KeyboardInterrupt"), (signal.SIGTERM, "Terminated")]


def started(
    within: str, then: str = "raise SystemExit(7)", first: str = ""
) -> "subprocess.Popen[str]":
    code = first + HEEDED.format(within=within, then=then)
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "here\n"
    return process


def ended(process: "subprocess.Popen[str]") -> tuple[int, str, str]:
    out, err = process.communicate("go on\n", timeout=60)
    return process.returncode, out, err


@pytest.mark.parametrize(("signum", "name"), KINDS)
def test_a_signal_raises(signum: int, name: str) -> None:
    process = started('print("here", flush=True)')
    process.send_signal(signum)
    assert ended(process) == (7, f"{name}\n", "")


@pytest.mark.parametrize(("signum", "name"), KINDS)
def test_a_signal_in_an_import_waits_for_its_end(tmp_path: Path, signum: int, name: str) -> None:
    (tmp_path / "swallows.py").write_text(SWALLOWS)
    process = started(f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import swallows")
    process.send_signal(signum)
    assert ended(process) == (7, f"{name}\n", "")


START = """
import multiprocessing, os, signal
from multiprocessing import util
spawn = util.spawnv_passfds
def interrupted(*given):
    child = spawn(*given)
    {interrupt}
    return child
util.spawnv_passfds = interrupted
process = multiprocessing.get_context("spawn").Process(target=print, args=("served",))
print("here", flush=True)
try:
    process.start()
except BaseException:
    print("orders lost", flush=True)
    raise
"""
INTERRUPT = "os.kill(os.getpid(), signal.SIGINT)"


def start_of_a_worker(interrupt: str) -> str:
    return START.format(interrupt=interrupt).replace("\n", "\n        ")


def test_a_signal_in_the_start_of_a_worker_waits_for_its_end() -> None:
    status, out, err = ended(started(start_of_a_worker(INTERRUPT)))
    assert (status, err) == (7, "")
    # two processes write at once, each its word and then the end of its line
    assert sorted(re.findall("KeyboardInterrupt|served|\\S", out)) == [
        "KeyboardInterrupt",
        "served",
    ]


def test_the_start_of_a_worker_that_does_not_wait_loses_its_orders() -> None:
    """The control: the test before, with an exception at once."""
    status, out, _ = ended(started(start_of_a_worker("raise KeyboardInterrupt")))
    assert status == 7
    assert "orders lost" in out
    assert "served" not in out


def test_outside_an_import_what_swallows_would_swallow(tmp_path: Path) -> None:
    """The control: the module of the test before, not imported but run."""
    (tmp_path / "swallows.py").write_text(SWALLOWS)
    process = started(f"exec(open({str(tmp_path / 'swallows.py')!r}).read()); raise SystemExit(3)")
    process.send_signal(signal.SIGINT)
    assert ended(process) == (3, "swallowed\n", "")


def test_what_is_ignored_stays_ignored() -> None:
    code = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
    within = 'print("here", flush=True); input(); raise SystemExit(5)'
    process = started(within, then="pass", first=code)
    process.send_signal(signal.SIGINT)
    assert ended(process) == (5, "", "")


def test_tidying_up_that_hangs_is_given_up() -> None:
    within = 'interruption.GRACE_S = 0.3; print("here", flush=True)'
    process = started(
        f"from tt_precise.runtime import interruption; {within}", then="time.sleep(600)"
    )
    process.send_signal(signal.SIGINT)
    assert ended(process) == (128 + signal.SIGINT, "KeyboardInterrupt\n", "")
