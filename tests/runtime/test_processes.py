"""Worker processes: one that dies or hangs fails alone, and none outlives its parent."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool

PARENT = """
import os, signal, sys, time
from tt_precise.runtime.workers import Call, local_pool

if __name__ == "__main__":
    end = sys.argv[1]
    with local_pool(1, inline=False) as pool:
        ((_, worker),) = pool.perform(os.getpid, [Call(0, ())])
        if end == "wait":
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        print(worker, flush=True)
        if end == "wait":
            time.sleep(600)
        for _ in pool.perform(time.sleep, [Call(0, (0,)), Call(1, (60,))]):
            raise SystemExit(3)
"""
UNGUARDED = """
from tt_precise.runtime.workers import Call, local_pool
with local_pool(2) as pool:
    print(list(pool.perform(abs, [Call(0, (-1,))])))
"""
# what a worker evaluates: it need not find this file, which is no part of an installed package
FIRST_SEEN = """(
    __import__("os").getpid(),
    __import__("builtins").__dict__.setdefault("seen " + name, __import__("time").monotonic_ns()),
)"""


@pytest.fixture(scope="module")
def two() -> Iterator[Pool]:
    with local_pool(2) as pool:
        yield pool


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
    """Whether the process still runs after that time; a zombie does not."""
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


def test_a_worker_ends_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    process, worker = parent(tmp_path, "wait")
    process.kill()
    process.wait()
    assert not runs(worker, 20.0)


def test_workers_end_at_once_where_the_pool_is_left(tmp_path: Path) -> None:
    process, worker = parent(tmp_path, "leave")
    assert process.wait(timeout=30) == 3
    assert not runs(worker, 20.0)


def test_an_interruption_is_left_to_the_parent(tmp_path: Path) -> None:
    """Ctrl-C goes to all processes of the terminal's foreground group, and to no other."""
    process, worker = parent(tmp_path, "wait")
    os.killpg(process.pid, signal.SIGINT)
    assert runs(worker, 0.5)
    process.kill()
    process.wait()
    assert not runs(worker, 20.0)


def test_a_script_without_a_main_guard_is_told_so(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(UNGUARDED)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    (line,) = [line for line in done.stderr.splitlines() if InputError.__name__ in line]
    assert '__name__ == "__main__"' in line


def test_what_goes_wrong_fails_alone(two: Pool) -> None:
    calls = [Call(n, ("2 ** n", {"n": n})) for n in range(10)]
    calls[3] = Call(3, ("__import__('os')._exit(3)",))
    calls[5] = Call(5, ("__import__('time').sleep(600)",), limit_s=0.2)
    calls[7] = Call(7, ("int('no number')",))
    found = {call.key: result for call, result in two.perform(eval, calls)}
    dead, late, raised = (found.pop(n).error for n in (3, 5, 7))
    assert found == {n: 2**n for n in found}
    assert isinstance(dead, WorkerDiedError)
    assert str(dead).endswith("exit status 3")
    assert isinstance(late, TimeoutError)
    assert "0.2 s" in str(late)
    assert isinstance(raised, ValueError)


@pytest.mark.parametrize(
    ("work", "arguments"), [(threading.Lock, ()), (id, (threading.Lock(),))],
    ids=["result not sent", "argument not sent"],
)  # fmt: skip
def test_what_cannot_be_sent_is_a_failure_of_its_task(two: Pool, work: Any, arguments: Any) -> None:
    ((_, failed),) = two.perform(work, [Call(0, arguments)])
    assert isinstance(failed, Failure)
    assert "pickle" in failed.reason
    ((_, result),) = two.perform(pow, [Call(0, (2, 5))])
    assert result == 32


def test_a_group_shares_a_process_and_what_it_computed(two: Pool) -> None:
    calls = [
        Call((name, n), (FIRST_SEEN, {"name": name}), group=name)
        for n in range(4)
        for name in "abc"
    ]
    found: dict[str, set[Any]] = {}
    for call, result in two.perform(eval, calls):
        found.setdefault(call.key[0], set()).add(result)
    assert [len(seen) for seen in found.values()] == [1, 1, 1]


def test_a_group_that_dies_fails_alone(two: Pool) -> None:
    code = "1 // 0 if n else __import__('os')._exit(3)"
    calls = [Call(n, (code, {"n": n}), group="g") for n in range(2)]
    found = {call.key: result for call, result in two.perform(eval, [*calls, Call(2, ("1",))])}
    assert all(isinstance(found[n].error, WorkerDiedError) for n in range(2))
    assert found[2] == 1


def test_a_process_is_replaced_after_some_tasks() -> None:
    calls = [Call(n, ()) for n in range(6)]
    with local_pool(1, inline=False, recycle_after=2) as pool:
        assert len({pid for _, pid in pool.perform(os.getpid, calls)}) == 3
