"""Where tasks run: in this process, on its cores, or on any ``concurrent.futures.Executor``.

Tasks in row are bounded. A task that raises is tried again and finally given back as a
``Failure``; when worker processes die, the tasks that were in row are run one at a time, so
that the one that kills is told from its neighbours.
"""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass
from typing import Any

from tt_precise.errors import InputError
from tt_precise.workers import dismiss, serve_quietly

TRIES = 3
IN_FLIGHT_EACH = 2  # tasks per worker: one at work, one waiting beside it
RECYCLED_AFTER = 500  # tasks per worker; then new processes, with all they may have leaked


@dataclass(frozen=True)
class Failure:
    """A task that did not succeed in ``TRIES`` tries, and the last error in one line."""

    error: str


@dataclass
class Crew:
    """An executor that can be hired again when its processes die or have served long enough.

    ``rehire`` is None where the executor is somebody else's.
    """

    executor: Executor
    size: Callable[[], int]
    rehire: Callable[[], Executor] | None = None

    def renew(self, broken: bool) -> None:
        """Replace the workers by new ones."""
        if self.rehire is None:
            return
        self.executor.shutdown(wait=not broken, cancel_futures=True)
        self.executor = self.rehire()

    def leave(self) -> None:
        """End the workers at once; nobody waits any more for what they are doing."""
        if isinstance(self.executor, ProcessPoolExecutor) and self.rehire is not None:
            dismiss(self.executor)


class Inline(Executor):
    """Runs every task at once in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # it is the caller who asks the future
            future.set_exception(error)
        return future


def crew_of(workers: int) -> Crew:
    """``workers`` processes of this machine, or this process if there is one."""
    if workers < 1:
        raise InputError(f"workers: got {workers}, expected at least 1")
    if workers == 1:
        return Crew(Inline(), lambda: 1)

    def hire() -> Executor:
        # spawned, because a fork would copy the threads of LLVM and TBB in a broken state
        context = multiprocessing.get_context("spawn")
        hired = ProcessPoolExecutor(workers, mp_context=context, initializer=serve_quietly)
        for _ in range(workers):  # they get ready while the first starts are drawn
            hired.submit(_get_ready)
        return hired

    return Crew(hire(), lambda: workers, hire)


def _get_ready() -> None:
    import tt_precise.sweep.chunk  # noqa: F401


def crew_on_dask(address: str) -> tuple[Crew, Callable[[], None]]:
    """The workers of the dask.distributed scheduler at ``address``, and how to disconnect.

    Raises
    ------
    InputError
        The extra ``dask`` is not installed, or nobody answers there.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("dask: not installed, expected pip install 'tt-precise[dask]'") from None
    try:
        client = Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        reason = str(error) or "no answer"
        raise InputError(
            f"dask: got {address}: {reason}; expected the address of a scheduler, "
            "such as tcp://127.0.0.1:8786"
        ) from None
    # pure=False: two equal tasks are two tasks; dask itself repeats those of a worker that died
    executor = client.get_executor(pure=False)
    return Crew(executor, lambda: max(1, sum(client.nthreads().values()))), client.close


def performed(
    crew: Crew, work: Callable[..., Any], tasks: Iterable[tuple[int, tuple[Any, ...]]]
) -> Iterator[tuple[int, tuple[Any, ...], Any]]:
    """Run ``work(*arguments)`` for each (number, arguments); (number, arguments, result) as done.

    The result is a ``Failure`` where there is none. ``work`` has to be importable in a worker.
    """
    fresh = iter(tasks)
    again: deque[_Task] = deque()
    suspects: deque[_Task] = deque()
    flying: dict[Future[Any], _Task] = {}
    served = 0
    while True:
        due = crew.rehire is not None and served >= RECYCLED_AFTER * crew.size()
        if due and not flying:
            crew.renew(broken=False)
            served, due = 0, False
        room = 1 if suspects else IN_FLIGHT_EACH * crew.size()
        while not due and len(flying) < room:
            task = _next(suspects, again, fresh)
            if task is None:
                break
            flying[crew.executor.submit(work, *task.arguments)] = task
            served += 1
            room = 1 if task.suspect else room
        if not flying:
            return
        done, _ = wait(flying, return_when=FIRST_COMPLETED)
        broken = False
        for future in done:
            task = flying.pop(future)
            try:
                result = future.result()
            except BrokenExecutor as error:
                broken = True
                result = task.failed(error, counts=task.suspect)
            except Exception as error:  # whatever went wrong there, the sweep goes on
                result = task.failed(error, counts=True)
            if result is None:
                (suspects if broken else again).append(task)
            else:
                yield task.number, task.arguments, result
        if broken:
            if crew.rehire is None:
                raise InputError("executor: broken, expected one that survives its workers")
            for task in flying.values():
                task.suspect = True
                suspects.append(task)
            flying.clear()
            crew.renew(broken=True)


@dataclass
class _Task:
    number: int
    arguments: tuple[Any, ...]
    tries: int = 0
    suspect: bool = False

    def failed(self, error: BaseException, *, counts: bool) -> Failure | None:
        """Count a try; what to report if it was the last one."""
        self.tries += counts
        self.suspect = self.suspect or isinstance(error, BrokenExecutor)
        if self.tries < TRIES:
            return None
        text = " ".join(f"{type(error).__name__}: {error}".split())
        return Failure(text[:500])


def _next(
    suspects: deque[_Task], again: deque[_Task], fresh: Iterator[tuple[int, tuple[Any, ...]]]
) -> _Task | None:
    if suspects:
        return suspects.popleft()
    if again:
        return again.popleft()
    found = next(fresh, None)
    return None if found is None else _Task(*found)
