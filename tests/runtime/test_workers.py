"""Pools: a worker that dies or hangs fails alone, and none outlives its parent."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import (
    IN_FLIGHT_EACH,
    Call,
    Failure,
    Inline,
    Pool,
    WorkerDiedError,
    dask_pool,
    local_pool,
)

SLEEP = f"600.{os.getpid()}"  # seconds, and how to find the process among those of other runs
IN_FLIGHT = 2 * IN_FLIGHT_EACH  # calls of two workers
FIRST_SEEN = """(
    __import__("os").getpid(),
    __import__("builtins").__dict__.setdefault("seen " + name, __import__("time").monotonic_ns()),
)"""


def square(number: int) -> int:
    return number * number


def calls(count: int, taken: list[int] | None = None) -> Iterator[Call]:
    """Calls with a number, which is noted in ``taken`` when a call is made."""
    for number in range(count):
        if taken is not None:
            taken.append(number)
        yield Call(number, (number,))


@pytest.fixture(scope="module")
def two() -> Iterator[Pool]:
    with local_pool(2) as pool:
        yield pool


@pytest.mark.parametrize("executor", [Inline(), ThreadPoolExecutor(2)], ids=["inline", "threads"])
@pytest.mark.parametrize("kind", [iter, list])
def test_every_call_is_performed_once(executor: Executor, kind: Any) -> None:
    fractions: list[float] = []
    pairs = list(Pool(executor, lambda: 2).perform(square, kind(calls(50)), fractions.append))
    assert fractions == ([] if kind is iter else [n / 50 for n in range(1, 51)])
    assert sorted((call.key, result) for call, result in pairs) == [(n, n**2) for n in range(50)]


def test_a_failing_call_is_reported() -> None:
    def work(number: int) -> int:
        if number == 3:
            raise ValueError("three is not\nto be had")
        return number

    results = {call.key: r for call, r in Pool(Inline(), lambda: 1).perform(work, calls(6))}
    assert results.pop(3).reason == "ValueError: three is not to be had"
    assert results == {number: number for number in (0, 1, 2, 4, 5)}


def test_flight_is_bounded_and_successes_come_before_failures() -> None:
    class Late(Executor):
        """Answers when as many calls wait as may be in flight; call 1 fails."""

        def __init__(self) -> None:
            self.futures: list[Future[Any]] = []

        def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            self.futures.append(Future())
            if len(self.futures) % IN_FLIGHT == 0:
                for number, future in list(enumerate(self.futures))[-IN_FLIGHT:]:
                    if number == 1:
                        future.set_exception(ArithmeticError())
                    else:
                        future.set_result([number])
            return self.futures[-1]

    taken: list[int] = []
    stream = Pool(Late(), lambda: 2).perform(square, calls(40, taken))
    keys = [next(stream)[0].key for _ in range(IN_FLIGHT)]
    assert (sorted(keys), keys[-1]) == ([0, 1, 2, 3], 1)
    assert len(taken) == IN_FLIGHT  # the other calls are not even made yet
    assert len(list(stream)) == 40 - IN_FLIGHT


def test_this_process_performs_one_call_at_a_time() -> None:
    taken: list[int] = []
    for done, _ in enumerate(local_pool(1).perform(square, calls(5, taken)), start=1):
        assert len(taken) == done


def test_a_cancelled_task_is_bad_input() -> None:
    class Cancels(Executor):
        def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            future: Future[Any] = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    with pytest.raises(InputError, match="executor: got a task that it has cancelled"):
        list(Pool(Cancels(), lambda: 1).perform(square, calls(2)))


@pytest.mark.parametrize("workers", [0, -1, 100_000])
def test_a_number_of_workers_out_of_range_is_refused(workers: int) -> None:
    with pytest.raises(InputError, match="workers: got"):
        local_pool(workers)


@pytest.mark.parametrize("address", ["nonsense", "foo://a:1", "tcp://127.0.0.1:1"])
def test_a_wrong_address_of_a_scheduler_is_refused(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")

    def refuse(*_: object, **__: object) -> None:
        raise OSError("no answer")

    monkeypatch.setattr(distributed, "Client", refuse)
    with pytest.raises(InputError, match=r"dask: got .*expected the address of a scheduler"):
        dask_pool(address)


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


def test_a_process_that_dies_hangs_or_raises_fails_alone(two: Pool) -> None:
    # pebble gives up the pool where a process ends before it has read that its task began
    dies = "__import__('time').sleep(0.5) or os._exit(3)"
    code = {
        3: dies,
        5: f"subprocess.run(['sleep', '{SLEEP}'])",
        7: "int('no number')",
        8: "1 // 0",
        9: dies,
    }
    modules = "os := __import__('os'), subprocess := __import__('subprocess')"
    tasks = [
        Call(
            n,
            (f"({modules}, {code.get(n, f'2 ** {n}')})[-1]",),
            limit_s=0.2 if n == 5 else None,
            group="dies" if n > 7 else None,
        )
        for n in range(10)
    ]
    results = {call.key: result for call, result in two.perform(eval, tasks)}
    dead, late, raised, *group = (results.pop(n).error for n in code)
    assert results == {n: 2**n for n in (0, 1, 2, 4, 6)}
    assert str(dead).endswith("exit status 3")
    assert all(isinstance(error, WorkerDiedError) for error in (dead, *group))
    assert isinstance(late, TimeoutError)
    assert "0.2 s" in str(late)
    assert isinstance(raised, ValueError)
    listing = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    assert f"sleep {SLEEP}" not in listing.stdout  # what a worker has started ends with it


@pytest.mark.parametrize(
    ("work", "arguments"), [(threading.Lock, ()), (id, (threading.Lock(),))],
    ids=["result not sent", "argument not sent"],
)  # fmt: skip
def test_a_value_that_cannot_be_sent_fails_its_task(two: Pool, work: Any, arguments: Any) -> None:
    ((_, failure),) = two.perform(work, [Call(0, arguments)])
    assert isinstance(failure, Failure)
    assert "pickle" in failure.reason
    assert [result for _, result in two.perform(pow, [Call(0, (2, 5))])] == [32]


def test_a_group_shares_a_process_and_its_results(two: Pool) -> None:
    tasks = [
        Call((name, n), (FIRST_SEEN, {"name": name}), group=name)
        for n in range(4)
        for name in "abc"
    ]
    results: dict[str, set[Any]] = {}
    for call, result in two.perform(eval, tasks):
        results.setdefault(call.key[0], set()).add(result)
    assert [len(values) for values in results.values()] == [1, 1, 1]


def test_a_process_is_replaced_after_some_tasks() -> None:
    tasks = [Call(n, ()) for n in range(6)]
    with local_pool(1, inline=False, recycle_after=2) as pool:
        assert len({pid for _, pid in pool.perform(os.getpid, tasks)}) == 3
