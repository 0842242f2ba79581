"""Pools that perform calls: this process, worker processes, a dask cluster, or any executor.

    with local_pool(workers) as pool:
        for call, result in pool.perform(work, calls):
            ...

A process that dies fails only its own calls.
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
from typing import Any

from tt_precise.runtime.files import needed
from tt_precise.runtime.terminal import Progress, in_a_process_of_ours, silent
from tt_precise.runtime.values import InputError, whole_number

IN_FLIGHT_EACH = 2  # tasks of a worker: one at work, one waiting


@dataclass(frozen=True)
class Call:
    """Arguments of the work, and a ``key`` that identifies them.

    Calls of a list with the same ``group`` are one task: they run one after the other in one
    process and may share results (``functools.cache``); a process that dies fails all of them.
    """

    key: Any
    arguments: tuple[Any, ...]
    group: Hashable = None


@dataclass(frozen=True)
class Failure:
    """A call that did not succeed: its exception."""

    error: BaseException

    @property
    def reason(self) -> str:
        """The exception in one line of at most 500 characters."""
        return " ".join(f"{type(self.error).__name__}: {self.error}".split())[:500]


class WorkerDiedError(RuntimeError):
    """The process of a task ended, or the executor has cancelled the task."""


class Inline(Executor):
    """Runs every task at once in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a task at once; the returned future is done."""
        future: Future[Any] = Future()
        future.set_result(fn(*args))
        return future


@dataclass(frozen=True)
class Pool:
    """An executor, the number of its workers, and a function that ends it.

    As a context manager it calls ``end`` with True after an exception, such as an interruption.
    """

    executor: Executor
    size: Callable[[], int]
    end: Callable[[bool], object] = lambda failed: None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        self.end(kind is not None)

    def perform(
        self, work: Callable[..., Any], calls: Iterable[Call], progress: Progress = silent
    ) -> Iterator[tuple[Call, Any]]:
        """Yield each call with the result of ``work(*call.arguments)``, or its ``Failure``.

        A worker must be able to import ``work``. A bounded number of calls is in flight, so
        ``calls`` may be an endless generator; of a list ``progress`` gets the completed fraction.
        """
        tasks, performed = _tasks(calls), 0
        running: dict[Future[Any], list[Call]] = {}
        # a task that runs inline is done as soon as it is submitted
        inline = isinstance(self.executor, Inline)
        try:
            while True:
                room = 1 if inline else IN_FLIGHT_EACH * self.size()
                for task in itertools.islice(tasks, max(0, room - len(running))):
                    every = [call.arguments for call in task]
                    running[self.executor.submit(_all_of, work, every)] = task
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    task = running.pop(future)
                    for call, result in zip(task, _results(future, len(task)), strict=True):
                        yield call, result
                        performed += 1
                        if isinstance(calls, Sized):
                            progress(performed / len(calls))
        finally:
            for future in running:
                future.cancel()


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


def _results(future: Future[Any], count: int) -> list[Any]:
    """Return the results of a task, or ``count`` failures."""
    try:
        error = future.exception()
    except CancelledError:
        error = WorkerDiedError("the executor has cancelled the task")
    if type(error).__name__ == "ProcessExpired":  # of pebble, imported where processes are used
        error = WorkerDiedError(
            f"worker process ended, exit status {getattr(error, 'exitcode', 0)}"
        )
    return [Failure(error)] * count if error else future.result()


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
    from pebble import ProcessPool

    # a forked process would inherit heyoka's compiled code
    context = multiprocessing.get_context("spawn")
    processes = ProcessPool(number, recycle_after, _begin, context=context)

    def end(failed: bool) -> None:
        (processes.stop if failed else processes.close)()
        processes.join()

    class Processes(Executor):
        def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            return processes.schedule(fn, args)

    return Pool(Processes(), lambda: number, end)


def dask_pool(address: str) -> Pool:
    """Return the workers of the dask.distributed scheduler at ``address``.

    Raises ``InputError``: the extra ``dask`` is not installed, or the scheduler does not answer.
    """
    distributed = needed("distributed")
    try:
        client = distributed.Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"dask: got {address}: {str(error) or 'no answer'}; expected the address of a "
            "scheduler, such as tcp://127.0.0.1:8786"
        ) from None

    def size() -> int:
        return max(1, sum(client.nthreads().values()))

    # pure=False: two equal calls are two calls; dask itself repeats those of a worker that died
    return Pool(client.get_executor(pure=False), size, lambda failed: client.close())


def _begin() -> None:
    """Prepare a worker process, which ends with its parent and takes its own children along."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os.killpg(0, signal.SIGKILL)

    os.setsid()
    signal.signal(signal.SIGTERM, lambda *_: os.killpg(0, signal.SIGKILL))
    threading.Thread(target=follow, daemon=True).start()
    in_a_process_of_ours()
