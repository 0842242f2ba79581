"""Worker processes: one that dies or hangs fails alone, and none outlives its parent."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.popen_spawn_posix import Popen
from pathlib import Path
from typing import Any

import pytest

from tt_precise.runtime.processes import Processes, TaskGroup, TimeLimitError, WorkerDiedError

PARENT = """
import os, signal, sys, time
from concurrent.futures import ProcessPoolExecutor
from tt_precise.runtime.processes import Processes

def work():
    print(os.getpid(), flush=True)
    time.sleep(60)

if __name__ == "__main__":
    kind, end = sys.argv[1:]
    pool = Processes(1) if kind == "own" else ProcessPoolExecutor(1)
    worker = pool.submit(os.getpid).result()
    if end == "wait":
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    print(worker, flush=True)
    if end == "dismiss":
        pool.submit(time.sleep, 60)
        begin = time.monotonic()
        pool.dismiss()
        sys.exit(time.monotonic() - begin > 30)
    elif end == "exit":
        pool.submit(time.sleep, 60)
        pool.shutdown(wait=False)
        os._exit(0)
    else:
        time.sleep(600)
"""


@pytest.fixture
def noted_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of every process that ended another thread took the status, and notes it a while later."""
    poll = Popen.poll
    taken: dict[int, tuple[int, int]] = {}

    def late(process: Popen, flag: int = os.WNOHANG) -> int | None:
        if process.pid in taken:
            known, looks = taken[process.pid]
            taken[process.pid] = known, looks - 1
            process.returncode = None if looks > 0 else known
        elif (status := poll(process, flag)) is not None:
            taken[process.pid] = status, 3
            process.returncode = None
        return process.returncode

    monkeypatch.setattr(Popen, "poll", late)


def test_a_status_that_another_thread_takes_ends_no_worker(noted_late: None) -> None:
    """The thread of that worker died, and the other tasks of its group waited for ever."""
    executor = Processes(1, recycle_after=1)
    first = executor.submit_within(None, "group", os._exit, 3)
    second = executor.submit_within(None, "group", abs, -2)
    with pytest.raises(WorkerDiedError, match="exit status 3"):
        first.result(timeout=60)
    assert second.result(timeout=60) == 2
    executor.shutdown()


@pytest.fixture
def two() -> Iterator[Processes]:
    executor = Processes(2)
    yield executor
    executor.dismiss()


def parent(tmp_path: Path, *words: str) -> tuple["subprocess.Popen[str]", int]:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    process = subprocess.Popen(
        [sys.executable, str(script), *words],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    with process.stdout as output:
        return process, int(output.readline())


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


def wait_until(reached: Callable[[], bool]) -> None:
    """Look again and again, for a minute."""
    until = time.monotonic() + 60
    while not reached():
        assert time.monotonic() < until
        time.sleep(0.01)


# what a worker evaluates: it need not find this file, which is no part of an installed package
FIRST_SEEN = """(
    __import__("os").getpid(),
    __import__("builtins").__dict__.setdefault("seen " + name, __import__("time").monotonic_ns()),
)"""
UNREADABLE = "type('Odd', (), {'__reduce__': lambda _: (int, ('no number',))})()"


class Unreadable:
    """What can be sent, but not read again."""

    def __reduce__(self) -> Any:
        return int, ("no number",)


@pytest.mark.parametrize(("kind", "survives"), [("own", False), ("ordinary", True)])
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


@pytest.mark.parametrize("end", ["dismiss", "exit"])
def test_workers_end_at_once(tmp_path: Path, end: str) -> None:
    process, worker = parent(tmp_path, "own", end)
    assert process.wait(timeout=60) == 0
    assert not runs(worker, 20.0)


def test_an_interruption_is_left_to_the_parent(tmp_path: Path) -> None:
    """Ctrl-C goes to all processes of the terminal's foreground group, and to no other."""
    process, worker = parent(tmp_path, "own", "wait")
    os.killpg(process.pid, signal.SIGINT)
    assert runs(worker, 0.5)
    process.kill()
    process.wait()
    assert not runs(worker, 20.0)


def test_what_goes_wrong_fails_alone(two: Processes) -> None:
    waits = [two.submit(pow, 2, n) for n in range(5)]
    dies, hangs = two.submit(os._exit, 3), two.submit_within(0.2, None, time.sleep, 600)
    raises = two.submit(int, "no number")
    more = [two.submit(pow, 3, n) for n in range(5)]
    assert [one.result(60) for one in waits] == [2**n for n in range(5)]
    assert [one.result(60) for one in more] == [3**n for n in range(5)]
    with pytest.raises(WorkerDiedError, match="exit status 3"):
        dies.result(60)
    with pytest.raises(TimeLimitError, match=r"stopped after 0\.2 s"):
        hangs.result(60)
    with pytest.raises(ValueError, match="invalid literal") as error:
        raises.result(60)
    assert "in a worker process" in error.value.__notes__[0]


@pytest.mark.parametrize(
    ("work", "arguments", "why"),
    [
        (threading.Lock, (), "cannot pickle"),
        (id, (Unreadable(),), "no number"),
        (eval, (UNREADABLE,), "no number"),
        (id, (threading.Lock(),), "cannot pickle"),
    ],
    ids=["result not sent", "argument not read", "result not read", "argument not sent"],
)
def test_what_cannot_be_sent_is_a_failure_of_its_task(
    two: Processes, work: Any, arguments: Any, why: str
) -> None:
    with pytest.raises(Exception, match=why):
        two.submit(work, *arguments).result(60)
    assert two.submit(pow, 2, 5).result(60) == 32


def test_a_group_shares_a_process_and_what_it_computed(two: Processes) -> None:
    asked = [name for _ in range(4) for name in "abc"]
    futures = [two.submit_within(None, name, eval, FIRST_SEEN, {"name": name}) for name in asked]
    found: dict[str, set[tuple[int, int]]] = {}
    for name, future in zip(asked, futures, strict=True):
        found.setdefault(name, set()).add(future.result(60))
    assert {name: len(some) for name, some in found.items()} == {"a": 1, "b": 1, "c": 1}
    assert len({pid for some in found.values() for pid, _ in some}) == 2


def test_a_process_goes_on_with_groups_of_its_kind_and_another_with_another_kind(
    two: Processes, tmp_path: Path
) -> None:
    """``begun`` gives the order, whatever the machine's load: all wait before any may begin."""
    gates = [tmp_path / name for name in ("first", "second", "a1")]
    for gate in gates:
        os.mkfifo(gate)
    held = [two.submit(gate.read_text) for gate in gates[:2]]
    a1 = two.submit_within(None, TaskGroup("a", "1"), gates[2].read_text)
    begun = {
        kind + name: two.submit_within(None, TaskGroup(kind, name), time.monotonic)
        for kind, name in ("a2", "a3", "b1", "a4", "b2")
    }
    gates[0].write_text("")  # this process takes a1, and is held there
    held[0].result(60)
    until = time.monotonic() + 60
    while not a1.running() and time.monotonic() < until:
        time.sleep(0.01)
    gates[1].write_text("")
    order = sorted(begun, key=lambda name: begun[name].result(60))
    gates[2].write_text("")
    assert a1.result(60) == ""
    assert order == ["b1", "b2", "a2", "a3", "a4"]


def test_a_process_is_replaced_after_some_tasks() -> None:
    executor = Processes(1, recycle_after=3)
    pids = [executor.submit(os.getpid).result(60) for _ in range(7)]
    executor.shutdown()
    assert [pids.count(pid) for pid in dict.fromkeys(pids)] == [3, 3, 1]


def test_shutdown_finishes_what_waits() -> None:
    executor = Processes(1)
    futures = [executor.submit(pow, 2, n) for n in range(5)]
    executor.shutdown()
    assert [one.result(0) for one in futures] == [2**n for n in range(5)]
    with pytest.raises(RuntimeError, match="after shutdown"):
        executor.submit(pow, 2, 2)


def test_shutdown_cancels_what_waits_and_not_what_runs(tmp_path: Path) -> None:
    executor = Processes(1)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    running = executor.submit(pipe.read_text)  # until somebody writes
    rest = [executor.submit(pow, 2, n) for n in range(5)]
    wait_until(running.running)
    closing = threading.Thread(target=executor.shutdown, kwargs={"cancel_futures": True})
    closing.start()
    wait_until(lambda: all(one.cancelled() for one in rest))
    pipe.write_text("done")
    closing.join()
    assert running.result(0) == "done"


def test_too_many_threads_leave_none_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    left = [2]
    start = threading.Thread.start

    def scarce(thread: threading.Thread) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise RuntimeError("can't start new thread")
        start(thread)

    before = threading.active_count()
    with monkeypatch.context() as patch, contextlib.suppress(RuntimeError):
        patch.setattr(threading.Thread, "start", scarce)
        Processes(5)
    assert threading.active_count() == before
