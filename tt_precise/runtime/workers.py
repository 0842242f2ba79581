"""Pools that perform calls: this process, worker processes, a cluster, or any other executor.

    with local_pool(workers) as pool:
        for call, result in pool.perform(work, calls):
            ...

A process that dies or exceeds a time limit fails only its own task. A bounded number of calls is in
flight, so ``calls`` may be an endless generator.
"""

from __future__ import annotations

import inspect
import logging
import multiprocessing
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sized
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)  # fmt: skip
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from tt_precise.runtime.process import in_a_process_of_ours
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, whole_number

IN_FLIGHT_EACH = 2  # calls of a worker: one at work, one waiting
LONGEST_REASON = 500  # characters
WITHOUT_PORT = ("inproc://", "ucx://")  # dask's addresses without host and port


@dataclass(frozen=True)
class Call:
    """Arguments of the work, and a ``key`` that identifies them.

    On this machine's processes a call may have a time limit, and calls of a list a ``group``: a
    task whose calls run one after the other in one process and may share results
    (``functools.cache``). A process that dies fails all of them.
    """

    key: Any
    arguments: tuple[Any, ...]
    limit_s: float | None = None
    group: Hashable = None


@dataclass(frozen=True)
class Failure:
    """A call that did not succeed: its last exception."""

    error: BaseException

    @property
    def reason(self) -> str:
        """The exception in one line."""
        text = " ".join(f"{type(self.error).__name__}: {self.error}".split())
        return text[:LONGEST_REASON]


class WorkerDiedError(RuntimeError):
    """The process of a task ended; the message has its exit status."""


class Inline(Executor):
    """Runs every call at once in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a task at once; the returned future is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # raised where the future is asked
            future.set_exception(error)
        return future


class Processes(Executor):
    """Spawned processes of this machine; a forked one would inherit heyoka's compiled code."""

    def __init__(
        self, workers: int, recycle_after: int = 0, prepare: Callable[[], object] | None = None
    ):
        if _imports_main():
            os._exit(1)  # the parent says what to do
        from pebble import ProcessPool

        self._pool = ProcessPool(
            workers, recycle_after, _begin, (prepare,), multiprocessing.get_context("spawn")
        )

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


def _imports_main() -> bool:
    """Return whether the caller is the main module of a script that a worker is importing."""
    frame = inspect.currentframe()
    while frame is not None:
        if frame.f_globals["__name__"] == "__mp_main__" and frame.f_code.co_name == "<module>":
            return True
        frame = frame.f_back
    return False


def _begin(prepare: Callable[[], object] | None) -> None:
    os.setsid()  # what it starts ends with it
    signal.signal(signal.SIGTERM, lambda *_: os.killpg(0, signal.SIGKILL))
    threading.Thread(target=_follow, name="follows its parent", daemon=True).start()
    in_a_process_of_ours()
    if prepare is not None:
        prepare()


def _follow() -> None:
    """End with the parent, however it ends, together with all processes started from here."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.killpg(0, signal.SIGKILL)


class Pool:
    """An executor with ``size()`` workers, which tries each call up to ``tries`` times.

    As a context manager it ends the processes that it has started (at once after an exception, such
    as an interruption) and calls ``leave``. It leaves somebody else's executor running.
    """

    def __init__(
        self,
        executor: Executor,
        size: Callable[[], int],
        *,
        tries: int = 1,
        leave: Callable[[], object] = lambda: None,
    ):
        self.executor, self.size, self.tries = executor, size, tries
        self._leave = leave

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
        self,
        work: Callable[..., Any],
        calls: Iterable[Call],
        progress: Progress = silent,
    ) -> Iterator[tuple[Call, Any]]:
        """Each call with the result of ``work(*call.arguments)``, or its ``Failure``, as done.

        A worker must be able to import ``work``. Of a list of calls ``progress`` gets the fraction
        done.

        Raises ``InputError``: the executor no longer works.
        """
        rest = self._tasks(calls)
        again: list[tuple[Call, ...]] = []
        in_flight: dict[Future[Any], tuple[Call, ...]] = {}
        tried: Counter[Any] = Counter()
        performed = 0
        try:
            while True:
                # an inline call is done as soon as it is submitted
                room = 1 if isinstance(self.executor, Inline) else IN_FLIGHT_EACH * self.size()
                while len(in_flight) < room and (task := again.pop() if again else next(rest, ())):
                    in_flight[self._submitted(work, task)] = task
                if not in_flight:
                    return
                done = wait(in_flight, return_when=FIRST_COMPLETED).done
                # successes first: a caller who stops at a failure has all that there is
                finished = [item for item in in_flight if item in done]
                for future in sorted(finished, key=lambda f: f.cancelled() or bool(f.exception())):
                    task = in_flight.pop(future)
                    results = self._results(future, task)
                    errors = [item.error for item in results if isinstance(item, Failure)]
                    tried[task[0].key] += 1
                    # unusable input stays unusable
                    helps = errors and not isinstance(errors[0], InputError)
                    if helps and tried[task[0].key] < self.tries:
                        again.append(task)
                        continue
                    for call, result in zip(task, results, strict=True):
                        yield call, result
                        performed += 1
                        if isinstance(calls, Sized):
                            progress(performed / len(calls))
        finally:
            for future in in_flight:
                future.cancel()

    def _tasks(self, calls: Iterable[Call]) -> Iterator[tuple[Call, ...]]:
        if not isinstance(calls, Sized) or not isinstance(self.executor, Processes):
            return ((call,) for call in calls)
        grouped: dict[Hashable, list[Call]] = {}
        for number, call in enumerate(calls):
            key = (number, None) if call.group is None else (0, call.group)
            grouped.setdefault(key, []).append(call)
        return map(tuple, grouped.values())

    def _submitted(self, work: Callable[..., Any], task: tuple[Call, ...]) -> Future[Any]:
        try:
            if not isinstance(self.executor, Processes):
                return self.executor.submit(work, *task[0].arguments)
            limits = [call.limit_s for call in task if call.limit_s is not None]
            every = [call.arguments for call in task]
            return self.executor.submit(_all_of, work, every, limit_s=sum(limits) or None)
        except (BrokenExecutor, RuntimeError) as error:
            raise _unusable(error) from None

    def _results(self, future: Future[Any], task: tuple[Call, ...]) -> list[Any]:
        try:
            results = future.result()
        except (BrokenExecutor, CancelledError) as error:
            raise _unusable(error) from None
        except Exception as error:  # other tasks continue after any error
            return [Failure(self._worker_error(error))] * len(task)
        return results if isinstance(self.executor, Processes) else [results]

    def _worker_error(self, error: Exception) -> Exception:
        """The error for a task whose process ended or was ended, from pebble's exception."""
        if isinstance(self.executor, Processes):
            from pebble import ProcessExpired

            if isinstance(error, ProcessExpired):
                return WorkerDiedError(f"worker process ended, exit status {error.exitcode}")
            if error.args[:1] == ("Task timeout",):
                return TimeoutError(f"stopped after {error.args[1]:g} s without an answer")
        return error


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0))


def most_workers() -> int:
    """The largest number of worker processes that is accepted."""
    return max(64, 4 * cores())


def local_pool(
    workers: int | None = None,
    *,
    inline: bool = True,
    tries: int = 1,
    recycle_after: int = 0,
    prepare: Callable[[], object] | None = None,
) -> Pool:
    """``workers`` processes of this machine, by default one for each core.

    A single worker is this process, unless ``inline`` is False.

    A process is replaced after ``recycle_after`` tasks; 0: never. ``prepare`` is called first in
    each process, for example to import slow modules.

    Raises ``InputError``: ``workers`` is out of range.
    """
    workers = whole_number(cores() if workers is None else workers, "workers", 1, most_workers())
    if workers == 1 and inline:
        return Pool(Inline(), lambda: 1, tries=tries)
    return Pool(Processes(workers, recycle_after, prepare), lambda: workers, tries=tries)


def dask_pool(address: str, *, tries: int = 1) -> Pool:
    """The workers of the dask.distributed scheduler at ``address``.

    Raises ``InputError``: the extra ``dask`` is not installed, or the scheduler does not answer.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError("dask: not installed, expected pip install 'tt-precise[dask]'") from None
    try:
        # a client that fails because of its address complains again when it is deleted
        if not address.startswith(WITHOUT_PORT):
            get_address_host_port(address)
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error) or "no answer"
        raise InputError(
            f"dask: got {address}: {reason}; expected the address of a scheduler, "
            "such as tcp://127.0.0.1:8786"
        ) from None
    # pure=False: two equal calls are two calls; dask itself repeats those of a worker that died
    executor = client.get_executor(pure=False)
    # the error below says what it would log of a scheduler that has gone
    log = logging.getLogger("distributed")
    level = log.level
    log.setLevel(logging.CRITICAL)

    def size() -> int:
        try:
            return max(1, sum(client.nthreads().values()))
        except OSError as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(
                f"dask: {address} no longer answers ({reason}); finished rows are stored, run it "
                "again"
            ) from None

    def leave() -> None:
        client.close()
        log.setLevel(level)

    return Pool(executor, size, tries=tries, leave=leave)


def _all_of(work: Callable[..., Any], every: Iterable[tuple[Any, ...]]) -> list[Any]:
    """The results of one task's calls, including failures, computed in a worker."""
    results: list[Any] = []
    for arguments in every:
        try:
            results.append(work(*arguments))
        except Exception as error:
            results.append(Failure(error))
    return results


def _unusable(error: BaseException) -> InputError:
    if "All workers expired" in str(error):
        return InputError(
            "workers: got processes that end as they begin, expected that they stay; a script has "
            'to start them below a line `if __name__ == "__main__":`'
        )
    reason = " ".join(str(error).split()) or type(error).__name__
    return InputError(f"executor: {reason}; expected one that keeps working")
