"""Pools that perform calls: this process, worker processes, a dask cluster, or any executor.

    with local_pool(workers) as pool:
        for call, result in pool.perform(work, calls):
            ...

A process that dies or exceeds a time limit fails only its own calls. A bounded number of calls is
in flight, so ``calls`` may be an endless generator.
"""

from __future__ import annotations

import itertools
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Hashable, Iterable, Iterator, Sized
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from tt_precise.runtime.process import in_a_process_of_ours
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, whole_number

IN_FLIGHT_EACH = 2  # tasks of a worker: one at work, one waiting
LONGEST_REASON = 500  # characters of the reason of a failure


@dataclass(frozen=True)
class Call:
    """Arguments of the work, and a ``key`` that identifies them.

    Calls of a list with the same ``group`` are one task: they run one after the other in one
    process and may share results (``functools.cache``); a process that dies fails all of them.
    ``limit_s`` is a time limit on this machine's worker processes.
    """

    key: Any
    arguments: tuple[Any, ...]
    limit_s: float | None = None
    group: Hashable = None


@dataclass(frozen=True)
class Failure:
    """A call that did not succeed: its exception."""

    error: BaseException

    @property
    def reason(self) -> str:
        """The exception in one line."""
        text = " ".join(f"{type(self.error).__name__}: {self.error}".split())
        return text[:LONGEST_REASON]


class WorkerDiedError(RuntimeError):
    """The process of a task ended; the message has its exit status."""


class Inline(Executor):
    """Runs every task at once in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a task at once; the returned future is done."""
        future: Future[Any] = Future()
        future.set_result(fn(*args))
        return future


class Processes(Executor):
    """Spawned processes of this machine; a forked one would inherit heyoka's compiled code."""

    def __init__(self, workers: int, recycle_after: int = 0):
        from pebble import ProcessPool

        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPool(workers, recycle_after, _begin, context=context)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Put a task at the end of the queue; once begun, it may take ``limit_s``."""
        return self._pool.schedule(fn, args, timeout=kwargs.get("limit_s"))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when their tasks are done, or at once."""
        if cancel_futures:
            self._pool.stop()
        else:
            self._pool.close()
        if wait:
            self._pool.join()


class Pool:
    """An executor with ``size()`` workers.

    As a context manager it ends the processes that it has started (at once after an exception, such
    as an interruption) and calls ``leave``. It leaves somebody else's executor running.
    """

    def __init__(
        self,
        executor: Executor,
        size: Callable[[], int],
        leave: Callable[[], object] = lambda: None,
    ):
        self.executor, self.size, self._leave = executor, size, leave

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if isinstance(self.executor, Processes):
            self.executor.shutdown(cancel_futures=error is not None)
        self._leave()

    def perform(
        self, work: Callable[..., Any], calls: Iterable[Call], progress: Progress = silent
    ) -> Iterator[tuple[Call, Any]]:
        """Yield each call with the result of ``work(*call.arguments)``, or its ``Failure``.

        A worker must be able to import ``work``. Of a list of calls ``progress`` gets the completed
        fraction.

        Raises ``InputError``: the executor has cancelled a task.
        """
        tasks, performed = _tasks(calls), 0
        running: dict[Future[Any], list[Call]] = {}
        try:
            while True:
                # a task that runs inline is done as soon as it is submitted
                inline = isinstance(self.executor, Inline)
                room = 1 if inline else IN_FLIGHT_EACH * self.size()
                for task in itertools.islice(tasks, max(0, room - len(running))):
                    running[self._submit(work, task)] = task
                if not running:
                    return
                done = wait(running, return_when=FIRST_COMPLETED).done
                # successes first: a caller who stops at a failure has all that there is
                for future in sorted(done, key=_failed):
                    task = running.pop(future)
                    for call, result in zip(task, _results(future, task), strict=True):
                        yield call, result
                        performed += 1
                        if isinstance(calls, Sized):
                            progress(performed / len(calls))
        finally:
            for future in running:
                future.cancel()

    def _submit(self, work: Callable[..., Any], task: list[Call]) -> Future[Any]:
        every = [call.arguments for call in task]
        limits = [call.limit_s for call in task if call.limit_s is not None]
        if limits and isinstance(self.executor, Processes):
            return self.executor.submit(_all_of, work, every, limit_s=sum(limits))
        return self.executor.submit(_all_of, work, every)


def _tasks(calls: Iterable[Call]) -> Iterator[list[Call]]:
    """Yield the tasks: single calls, and the calls of each group of a list."""
    if not isinstance(calls, Sized):
        yield from ([call] for call in calls)
        return
    groups: dict[Hashable, list[Call]] = {}
    for number, call in enumerate(calls):
        key = (number, None) if call.group is None else (0, call.group)
        groups.setdefault(key, []).append(call)
    yield from groups.values()


def _all_of(work: Callable[..., Any], every: Iterable[tuple[Any, ...]]) -> list[Any]:
    """Return the results of one task's calls, with a ``Failure`` for each exception."""
    results: list[Any] = []
    for arguments in every:
        try:
            results.append(work(*arguments))
        except Exception as error:
            results.append(Failure(error))
    return results


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None


def _results(future: Future[Any], task: list[Call]) -> list[Any]:
    try:
        results: list[Any] = future.result()
        return results
    except CancelledError:
        expected = "expected one that keeps working"
        raise InputError(f"executor: got a task that it has cancelled, {expected}") from None
    except Exception as error:  # other tasks continue after any error
        return [Failure(_worker_error(error))] * len(task)


def _worker_error(error: Exception) -> Exception:
    """Return the error of a task whose process ended or was ended, from pebble's exception."""
    if type(error).__name__ == "ProcessExpired":
        return WorkerDiedError(f"worker process ended, exit status {getattr(error, 'exitcode', 0)}")
    if error.args[:1] == ("Task timeout",):
        return TimeoutError(f"stopped after {error.args[1]:g} s without an answer")
    return error


def _begin() -> None:
    """Prepare a worker process, which ends with its parent and takes its own children along."""
    os.setsid()
    signal.signal(signal.SIGTERM, lambda *_: os.killpg(0, signal.SIGKILL))
    threading.Thread(target=_follow, name="follows its parent", daemon=True).start()
    in_a_process_of_ours()


def _follow() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.killpg(0, signal.SIGKILL)


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0))


def local_pool(workers: int | None = None, *, inline: bool = True, recycle_after: int = 0) -> Pool:
    """Return a pool of ``workers`` processes of this machine, by default one for each core.

    A single worker is this process, unless ``inline`` is False. A process is replaced after
    ``recycle_after`` tasks; 0: never. A script that uses processes needs the usual
    ``if __name__ == "__main__":``.

    Raises ``InputError``: ``workers`` is out of range.
    """
    most = max(64, 4 * cores())
    number = whole_number(cores() if workers is None else workers, "workers", 1, most)
    if number == 1 and inline:
        return Pool(Inline(), lambda: 1)
    return Pool(Processes(number, recycle_after), lambda: number)


def dask_pool(address: str) -> Pool:
    """Return the workers of the dask.distributed scheduler at ``address``.

    Raises ``InputError``: the extra ``dask`` is not installed, or the scheduler does not answer.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("dask: not installed, expected pip install 'tt-precise[dask]'") from None
    try:
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"dask: got {address}: {str(error) or 'no answer'}; expected the address of a "
            "scheduler, such as tcp://127.0.0.1:8786"
        ) from None

    def size() -> int:
        return max(1, sum(client.nthreads().values()))

    # pure=False: two equal calls are two calls; dask itself repeats those of a worker that died
    return Pool(client.get_executor(pure=False), size, leave=client.close)
