"""Pools: a worker that dies fails alone, and none outlives its parent."""

import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import (
    IN_FLIGHT_EACH,
    Call,
    Inline,
    Pool,
    WorkerDiedError,
    dask_pool,
    local_pool,
)

SLEEP = f"600.{os.getpid()}"  # seconds, and how to find the process among those of other runs


CALLS = [Call(number, (6, number)) for number in range(50)]


@pytest.fixture(scope="module")
def two() -> Iterator[Pool]:
    with local_pool(2) as pool:
        yield pool


@pytest.mark.parametrize("executor", [Inline(), ThreadPoolExecutor(2)], ids=["inline", "threads"])
@pytest.mark.parametrize("kind", [iter, list])
def test_every_call_is_performed_once(executor: Executor, kind: Any) -> None:
    fractions: list[float] = []
    pairs = Pool(executor, lambda: 2).perform(divmod, kind(CALLS), fractions.append)
    results = {call.key: result for call, result in pairs}
    assert fractions == ([] if kind is iter else [n / 50 for n in range(1, 51)])
    assert results.pop(0).reason.startswith("ZeroDivisionError: ")
    assert results == {n: divmod(6, n) for n in range(1, 50)}


def test_flight_is_bounded() -> None:
    two = Pool(ThreadPoolExecutor(2), lambda: 2)
    for pool, most in ((local_pool(1), 1), (two, 2 * IN_FLIGHT_EACH)):
        numbers = itertools.count()
        next(pool.perform(divmod, (Call(n, (6, n)) for n in numbers)))
        assert next(numbers) == most


def test_a_cancelled_task_is_a_failure() -> None:
    future: Future[Any] = Future()
    future.cancel()
    future.set_running_or_notify_cancel()
    executor: Any = Mock(submit=lambda *_: future)
    ((_, failure),) = Pool(executor, lambda: 1).perform(divmod, CALLS[:1])
    assert isinstance(failure.error, WorkerDiedError)


def test_wrong_numbers_of_workers_and_addresses_are_refused() -> None:
    for workers in (0, -1, 100_000):
        with pytest.raises(InputError, match="workers: got"):
            local_pool(workers)
    pytest.importorskip("distributed", reason="needs the extra dask")
    with pytest.raises(InputError, match=r"dask: got .*expected the address of a scheduler"):
        dask_pool("foo://a:1")


PARENT = """
import os, signal, sys, time
from tt_precise.runtime.workers import Call, local_pool

if __name__ == "__main__":
    with local_pool(1, inline=False) as pool:
        ((_, worker),) = pool.perform(os.getpid, [Call(0, ())])
        if sys.argv[1] == "wait":
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        print(worker, flush=True)
        if sys.argv[1] == "wait":
            time.sleep(600)
        for _ in pool.perform(time.sleep, [Call(0, (0,)), Call(1, (60,))]):
            raise SystemExit(3)
"""


def runs(pid: int, within_s: float) -> bool:
    """Test that the process still runs after that time; a zombie does not."""
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


@pytest.mark.parametrize("end", ["leave", "wait"])
def test_workers_end_with_their_parent_and_leave_interruptions_to_it(
    tmp_path: Path, end: str
) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    process = subprocess.Popen(
        [sys.executable, str(script), end],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    with process.stdout as output:
        worker = int(output.readline())
    if end == "leave":
        assert process.wait(timeout=30) == 3
    else:  # Ctrl-C goes to all processes of the terminal's foreground group, and to no other
        os.killpg(process.pid, signal.SIGINT)
        assert runs(worker, 0.5)
        process.kill()
        process.wait()
    assert not runs(worker, 20.0)


def test_a_process_that_dies_or_raises_fails_alone(two: Pool) -> None:
    # pebble gives up the pool where a process ends before it has read that its task began
    dies = "__import__('time').sleep(0.5) or "
    child = f"__import__('subprocess').Popen(['sleep', '{SLEEP}'], stdout=-3) and "
    code = {
        3: f"{dies}os._exit(3)", 5: f"{child}{dies}os.kill(os.getpid(), 15)",
        7: "int('no number')", 8: "1 // 0", 9: f"{dies}os._exit(3)",
    }  # fmt: skip
    texts = [f"(os := __import__('os'), {code.get(n, f'2 ** {n}')})[-1]" for n in range(10)]
    tasks = [Call(n, (text,), group="dies" if n > 7 else None) for n, text in enumerate(texts)]
    results = {call.key: result for call, result in two.perform(eval, tasks)}
    dead, stopped, raised, *group = (results.pop(n).error for n in code)
    assert results == {n: 2**n for n in (0, 1, 2, 4, 6)}
    assert str(dead).endswith("exit status 3")
    assert all(isinstance(error, WorkerDiedError) for error in (dead, stopped, *group))
    assert isinstance(raised, ValueError)
    listing = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    assert f"sleep {SLEEP}" not in listing.stdout  # what a worker has started ends with it


def test_a_result_or_an_argument_that_cannot_be_sent_fails_its_task(two: Pool) -> None:
    works: list[tuple[Any, Any]] = [(threading.Lock, ()), (id, (threading.Lock(),))]
    for work, arguments in works:
        ((_, failure),) = two.perform(work, [Call(0, arguments)])
        assert "pickle" in failure.reason
    assert [result for _, result in two.perform(pow, [Call(0, (2, 5))])] == [32]


def test_a_group_shares_a_process_which_is_replaced_after_some_tasks(two: Pool) -> None:
    tasks = [Call(n, (), group=n % 3) for n in range(12)]
    results = {(call.group, pid) for call, pid in two.perform(os.getpid, tasks)}
    assert len(results) == 3
    with local_pool(1, inline=False, recycle_after=2) as pool:
        pids = {pid for _, pid in pool.perform(os.getpid, [Call(n, ()) for n in range(6)])}
    assert len(pids) == 3
