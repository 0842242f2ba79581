"""Where calls run; a worker that dies or hangs fails alone, and none outlives its parent."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from unittest.mock import Mock

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

TRIES = 3
SLEEP = f"600.{os.getpid()}"  # seconds, and how to find the process among those of other runs
IN_FLIGHT = 2 * IN_FLIGHT_EACH  # calls of two workers


def square(number: int) -> int:
    return number * number


# what a worker evaluates: it need not find this file, which is no part of an installed package
KILLS = "number if number != 3 else os.kill(os.getpid(), 9)"
# not in the instant in which the task begins: pebble has not heard of it then, and gives up
KILLS_ONCE = (
    "number if number != 3 or mark.exists() else "
    "mark.touch() or __import__('time').sleep(0.3) or os.kill(os.getpid(), 9)"
)
FIRST_SEEN = """(
    __import__("os").getpid(),
    __import__("builtins").__dict__.setdefault("seen " + name, __import__("time").monotonic_ns()),
)"""


def evaluated(code: str, **names: Any) -> list[Call]:
    code = code.replace("os.", "__import__('os').")
    return [Call(number, (code, {"number": number, **names})) for number in range(12)]


def calls(count: int, taken: list[int] | None = None) -> Iterator[Call]:
    """Calls with a number, which is noted in ``taken`` when a call is made."""
    for number in range(count):
        if taken is not None:
            taken.append(number)
        yield Call(number, (number,))


def results(pool: Pool, work: Callable[..., Any], some: Any, *progress: Any) -> dict[int, Any]:
    found = list(pool.perform(work, some, *progress))
    assert len({call.key for call, _ in found}) == len(found)  # nothing doubled
    return {call.key: result for call, result in found}


@pytest.mark.parametrize("executor", [Inline(), ThreadPoolExecutor(2)], ids=["inline", "threads"])
@pytest.mark.parametrize("kind", [iter, list])
def test_every_task_is_performed_once(executor: Executor, kind: Any) -> None:
    heard: list[float] = []
    found = results(Pool(executor, lambda: 2), square, kind(calls(50)), heard.append)
    assert heard == ([] if kind is iter else [n / 50 for n in range(1, 51)])
    assert found == {number: number**2 for number in range(50)}


def test_a_failing_task_is_tried_again_and_then_reported() -> None:
    tried: list[int] = []

    def work(number: int) -> int:
        tried.append(number)
        if number == 3:
            raise ValueError("three is not\nto be had")
        return number

    found = results(Pool(Inline(), lambda: 1, tries=TRIES), work, calls(6))
    assert tried.count(3) == TRIES
    assert found.pop(3).reason == "ValueError: three is not to be had"
    assert found == {number: number for number in (0, 1, 2, 4, 5)}


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
                        future.set_result(number)
            return self.futures[-1]

    taken: list[int] = []
    stream = Pool(Late(), lambda: 2).perform(square, calls(40, taken))
    assert [next(stream)[0].key for _ in range(IN_FLIGHT)] == [0, 2, 3, 1]
    assert len(taken) == IN_FLIGHT  # the rest is not even made yet
    assert len(list(stream)) == 40 - IN_FLIGHT


def test_one_process_does_one_task_at_a_time() -> None:
    taken: list[int] = []
    for done, _ in enumerate(local_pool(1).perform(square, calls(5, taken)), start=1):
        assert len(taken) == done


@pytest.mark.parametrize("workers", [0, -1, 100_000])
def test_refuses_as_many_workers(workers: int) -> None:
    with pytest.raises(InputError, match="workers: got"):
        local_pool(workers)


def test_a_killed_worker_loses_and_doubles_nothing(tmp_path: Path) -> None:
    with local_pool(2, tries=TRIES) as pool:
        found = results(pool, eval, evaluated(KILLS_ONCE, mark=tmp_path / "3"))
    assert found == {number: number for number in range(12)}
    assert (tmp_path / "3").exists()


def test_a_scheduler_that_goes_is_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")
    client = Mock()
    client.get_executor.return_value = Inline()
    client.nthreads.side_effect = [{"one": 2}, OSError("connection reset\nby peer")]
    monkeypatch.setattr(distributed, "Client", Mock(return_value=client))
    with dask_pool("tcp://somewhere:8786") as pool:
        assert pool.size() == 2
        with pytest.raises(
            InputError, match=r"tcp://somewhere:8786 no longer answers \(connection reset by"
        ):
            pool.size()
        client.close.assert_not_called()
    client.close.assert_called_once_with()


@pytest.mark.parametrize("address", ["nonsense", "tcp://a:b", "foo://a:1", ""])
def test_a_wrong_address_is_refused_before_a_client_is_made(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A client that fails says so a second time, in ten lines, when it is collected."""
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")
    monkeypatch.setattr(distributed, "Client", lambda *_, **__: pytest.fail("a client was made"))
    with pytest.raises(InputError, match=r"dask: got .*expected the address of a scheduler"):
        dask_pool(address)


def test_an_executor_that_breaks_is_bad_input() -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        pool = Pool(executor, lambda: 1, tries=TRIES)
        with pytest.raises(InputError, match=r"executor: .*expected one that keeps working"):
            results(pool, eval, evaluated(KILLS))
    with pytest.raises(InputError, match="executor: "):
        results(pool, square, calls(2))


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


def test_a_script_without_a_main_guard_is_told_so(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(PARENT.replace('if __name__ == "__main__":', "if True:"))
    words = [sys.executable, str(script), "leave"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    (line,) = [line for line in done.stderr.splitlines() if InputError.__name__ in line]
    assert '__name__ == "__main__"' in line


def test_what_goes_wrong_fails_alone(two: Pool) -> None:
    # pebble gives up the pool where a process ends before it has read that its task began
    dies = "__import__('time').sleep(0.5) or os._exit(3)"
    code = {
        3: dies,
        5: f"subprocess.run(['sleep', '{SLEEP}'])",
        7: "int('no number')",
        8: "1 // 0",
        9: dies,
    }
    calls = [
        Call(
            n,
            (
                f"(os := __import__('os'), subprocess := __import__('subprocess'), "
                f"{code.get(n, f'2 ** {n}')})[-1]",
            ),
            limit_s=0.2 if n == 5 else None,
            group="dies" if n > 7 else None,
        )
        for n in range(10)
    ]
    found = {call.key: result for call, result in two.perform(eval, calls)}
    dead, late, raised, *group = (found.pop(n).error for n in code)
    assert found == {n: 2**n for n in (0, 1, 2, 4, 6)}
    assert str(dead).endswith("exit status 3")
    assert all(isinstance(error, WorkerDiedError) for error in (dead, *group))
    assert isinstance(late, TimeoutError)
    assert "0.2 s" in str(late)
    assert isinstance(raised, ValueError)
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    assert f"sleep {SLEEP}" not in listed.stdout  # what a worker has started ends with it


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


def test_a_process_is_replaced_after_some_tasks() -> None:
    calls = [Call(n, ()) for n in range(6)]
    with local_pool(1, inline=False, recycle_after=2) as pool:
        assert len({pid for _, pid in pool.perform(os.getpid, calls)}) == 3
