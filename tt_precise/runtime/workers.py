"""Where calls run: in this process, on its cores, on a cluster, or on any other executor.

    with local_pool(workers) as pool:
        for call, result in pool.perform(work, calls):
            ...

Calls in flight are bounded, so that ``calls`` may be a generator without end. A call that raises
is tried again where that is asked for, and given back as a ``Failure`` after that.
"""

from __future__ import annotations

import logging
import math
import os
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sized
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass
from queue import SimpleQueue
from types import TracebackType
from typing import Any

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.processes import Processes
from tt_precise.runtime.progress import Progress, silent

IN_FLIGHT_EACH = 2  # calls of a worker: one at work, one waiting beside it
LONGEST_REASON = 500  # characters
MOST_WORKERS, MOST_EACH_CORE = 64, 4
WITHOUT_PORT = ("inproc://", "ucx://")  # addresses of dask's that are no host and port


@dataclass(frozen=True)
class Call:
    """Arguments of the work, and a ``key`` that says which they are.

    ``limit_s`` and ``group`` (see ``Processes.submit_within``) count on this machine's processes
    only.
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


class Inline(Executor):
    """Runs every call at once in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run it; the future is done already."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # raised where the future is asked
            future.set_exception(error)
        return future


class Pool:
    """An executor, how many workers it has, and what leaving it means.

    As a context manager it ends the processes it has started: at once if it is left by an
    exception, such as an interruption. An executor of somebody else's is left running.

    Parameters
    ----------
    executor, size
        Any executor, and a function that gives the number of its workers now.
    tries
        How often a call that raises is tried.
    leave
        Called at the end.
    """

    def __init__(
        self,
        executor: Executor,
        size: Callable[[], int],
        *,
        tries: int = 1,
        leave: Callable[[], object] | None = None,
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
            if error is None:
                self.executor.shutdown()
            else:
                self.executor.dismiss()
        if self._leave is not None:
            self._leave()

    def perform(
        self,
        work: Callable[..., Any],
        calls: Iterable[Call],
        progress: Progress = silent,
    ) -> Iterator[tuple[Call, Any]]:
        """Each call with the result of ``work(*call.arguments)``, or its ``Failure``, as done.

        ``work`` has to be importable in a worker. A ``deque`` of calls is emptied, and may be
        given more meanwhile. Where calls can be counted ``progress`` gets the fraction done.

        Raises
        ------
        InputError
            The executor does not work any more.
        """
        listed = isinstance(calls, Sized)
        rest: deque[Call] | Iterator[Call]
        rest = calls if isinstance(calls, deque) else deque(calls) if listed else iter(calls)
        again: deque[_Attempt] = deque()
        in_flight: dict[Future[Any], _Attempt] = {}
        done: SimpleQueue[Future[Any]] = SimpleQueue()
        performed = 0
        try:
            while True:
                room = self._room(listed)
                while len(in_flight) < room and (one := _next(again, rest)) is not None:
                    future = self._submitted(work, one.call)
                    in_flight[future] = one
                    future.add_done_callback(done.put)
                if not in_flight:
                    return
                # what succeeded first: a caller who ends at a failure has all that there is
                for future in sorted(_all_in(done), key=_failed):
                    one = in_flight.pop(future)
                    result = self._result(future, one)
                    if result is one:
                        again.append(one)
                        continue
                    yield one.call, result
                    performed += 1
                    if isinstance(rest, deque):
                        progress(performed / (performed + len(in_flight) + len(again) + len(rest)))
        finally:
            for future in in_flight:
                future.cancel()

    def _room(self, listed: bool) -> float:
        """How many calls may be in flight."""
        if isinstance(self.executor, Inline):
            return 1  # done as soon as it is handed over
        # those of a list all at once, so that those of one group find each other
        return math.inf if listed else IN_FLIGHT_EACH * self.size()

    def _submitted(self, work: Callable[..., Any], call: Call) -> Future[Any]:
        try:
            if isinstance(self.executor, Processes):
                return self.executor.submit_within(call.limit_s, call.group, work, *call.arguments)
            return self.executor.submit(work, *call.arguments)
        except (BrokenExecutor, RuntimeError) as error:
            raise _unusable(error) from None

    def _result(self, future: Future[Any], one: _Attempt) -> Any:
        """The result, a failure, or ``one`` if it is to be tried again."""
        try:
            return future.result()
        except (BrokenExecutor, CancelledError) as error:
            raise _unusable(error) from None
        except Exception as error:  # whatever went wrong there, the others go on
            one.tries += 1
            # what cannot be used cannot be used the next time either
            again = one.tries < self.tries and not isinstance(error, InputError)
            return one if again else Failure(error)


def cores() -> int:
    """Processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def most_workers() -> int:
    """As many processes as anybody's machine has use for, and the system can live with."""
    return max(MOST_WORKERS, MOST_EACH_CORE * cores())


def local_pool(
    workers: int | None = None,
    *,
    inline: bool = True,
    tries: int = 1,
    recycle_after: int | None = None,
    prepare: Callable[[], object] | None = None,
) -> Pool:
    """So many processes of this machine, by default one for each core.

    A single one is this process, unless ``inline`` is False. For the others see ``Processes``.

    Raises
    ------
    InputError
        Too few or too many, or the system does not let so many run.
    """
    workers = cores() if workers is None else workers
    if not 1 <= workers <= most_workers():
        raise InputError(f"workers: got {workers}, expected 1 to {most_workers()}")
    if workers == 1 and inline:
        return Pool(Inline(), lambda: 1, tries=tries)
    try:
        processes = Processes(workers, recycle_after=recycle_after, prepare=prepare)
    except (RuntimeError, OSError) as error:
        raise InputError(
            f"workers: got {workers}: {error}; expected fewer, or a higher limit of the system's"
        ) from None
    return Pool(processes, lambda: workers, tries=tries)


def dask_pool(address: str, *, tries: int = 1) -> Pool:
    """The workers of the dask.distributed scheduler at ``address``.

    Raises
    ------
    InputError
        The extra ``dask`` is not installed, or nobody answers there.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError("dask: not installed, expected pip install 'tt-precise[dask]'") from None
    try:
        # a client that fails for its address is half made, and complains again when it is deleted
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
    # what it logs of a scheduler that has gone is said by the error below
    logging.getLogger("distributed").setLevel(logging.CRITICAL)

    def size() -> int:
        try:
            return max(1, sum(client.nthreads().values()))
        except OSError as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(
                f"dask: {address} answers no more ({reason}); what is done is stored, run it again"
            ) from None

    return Pool(executor, size, tries=tries, leave=client.close)


@dataclass(eq=False)
class _Attempt:
    call: Call
    tries: int = 0


def _next(again: deque[_Attempt], rest: deque[Call] | Iterator[Call]) -> _Attempt | None:
    if again:
        return again.popleft()
    if isinstance(rest, deque):
        return _Attempt(rest.popleft()) if rest else None
    found = next(rest, None)
    return None if found is None else _Attempt(found)


def _all_in(done: SimpleQueue[Future[Any]]) -> list[Future[Any]]:
    """All that is done by now, at least one."""
    found = [done.get()]
    while not done.empty():
        found.append(done.get())
    return found


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None


def _unusable(error: BaseException) -> InputError:
    reason = " ".join(str(error).split()) or type(error).__name__
    return InputError(f"executor: {reason}; expected one that goes on working")
