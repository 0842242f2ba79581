"""Worker processes of this machine, as an executor of ``concurrent.futures``.

``ProcessPoolExecutor`` does not know which task a worker is at: one that dies takes all tasks in
flight with it, and one that hangs cannot be ended. Here each worker has a pipe and a thread of its
own. So a process that dies fails its own task only, a task may have a time limit, tasks of one
group share a process, which goes on with a group of the same kind if it can, and a process is
replaced after some tasks, with all they may have leaked.

Processes are spawned: a forked one would inherit heyoka's compiled code and threads in an unknown
state. A script that uses them needs the usual ``if __name__ == "__main__"``.
"""

from __future__ import annotations

import contextlib
import inspect
import multiprocessing
import os
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.startup import hide_sympy_from_heyoka

# a start of Python with its imports, which the time limit of a task does not count
START_S = 60.0
NOTED_S = 5.0  # until a thread that has taken an exit status runs again
UNGUARDED = 78  # exit status of a process whose main module starts processes when it is imported
BEGUN, DONE, FAILED = range(3)  # what a process says of a task


class WorkerDiedError(RuntimeError):
    """The process that was at a task ended; the message says with which exit status."""


class TimeLimitError(TimeoutError):
    """A task took longer than it may, and its process was ended."""


class TaskGroup(NamedTuple):
    """A group of tasks that shares some of what it computes with other groups of its ``kind``."""

    kind: str
    name: str


@dataclass(frozen=True)
class _Task:
    future: Future[Any]
    call: tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]
    limit_s: float | None
    group: Hashable


class Processes(Executor):
    """An executor of ``workers`` processes, which are started when there are tasks for them.

    Parameters
    ----------
    recycle_after
        Tasks of a process, which is then replaced; None: it stays.
    prepare
        Called first in each process, such as a function that imports what takes long; with it
        the processes are started at once.
    """

    def __init__(
        self,
        workers: int,
        *,
        recycle_after: int | None = None,
        prepare: Callable[[], object] | None = None,
    ):
        if _imports_main():
            sys.exit(UNGUARDED)
        self._recycle_after, self._prepare = recycle_after, prepare
        self._waiting: deque[_Task] = deque()
        self._groups: set[Hashable] = set()  # those that a worker is at
        self._changed = threading.Condition()
        self._closed = self._dismissed = False
        self._running: set[_Worker] = set()
        self._threads: list[threading.Thread] = []
        try:
            for number in range(workers):
                thread = threading.Thread(target=self._work, name=f"worker {number}", daemon=True)
                thread.start()
                self._threads.append(thread)
        except BaseException:  # the system gives no more of them: those that run must end
            self.dismiss()
            raise

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Put a task at the end of the queue."""
        return self.submit_within(None, None, fn, *args, **kwargs)

    def submit_within(
        self,
        limit_s: float | None,
        group: Hashable,
        fn: Callable[..., Any],
        /,
        *args: Any,
        **kwargs: Any,
    ) -> Future[Any]:
        """Put a task at the end of the queue, with a time limit and a group.

        Tasks of one group (None: of none) run one after the other, in the same process if that
        lives, and so may share what they compute (``functools.cache``). Of the groups that wait a
        process prefers one of the kind that it was at (see ``TaskGroup``), or else one of a kind
        that no other process is at.
        """
        future: Future[Any] = Future()
        with self._changed:
            if self._closed:
                raise RuntimeError("cannot schedule new futures after shutdown")
            self._waiting.append(_Task(future, (fn, args, kwargs), limit_s, group))
            self._changed.notify_all()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when their tasks are done; those that wait are done or cancelled."""
        with self._changed:
            self._closed = True
            if cancel_futures:
                self._cancel_waiting()
            self._changed.notify_all()
        if wait:
            for thread in self._threads:
                thread.join()

    def dismiss(self) -> None:
        """End the processes at once, whatever they are doing: the caller was interrupted."""
        with self._changed:
            self._closed = self._dismissed = True
            self._cancel_waiting()
            self._changed.notify_all()
            for worker in self._running:
                worker.kill()
        for thread in self._threads:
            thread.join()

    def _cancel_waiting(self) -> None:
        for task in self._waiting:
            task.future.cancel()
        self._waiting.clear()

    def _work(self) -> None:
        """What a thread does: it has one process after the other, and hands it tasks."""
        # inherited by the processes: until one has a session of its own, Ctrl-C must not hit it
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        worker: _Worker | None = None
        group: Hashable = None
        done = 0
        try:
            if self._prepare is not None:
                with contextlib.suppress(OSError):  # raised again with the first task
                    worker = self._started()
            while (task := self._next(group)) is not None:
                group = task.group
                if not task.future.set_running_or_notify_cancel():
                    continue
                try:
                    worker = worker or self._started()
                    result = worker.perform(task)
                except BaseException as error:
                    task.future.set_exception(error)
                else:
                    task.future.set_result(result)
                done += 1
                if worker is not None and (worker.dead or done == self._recycle_after):
                    self._ended(worker)
                    worker, done = None, 0
        finally:
            if worker is not None:
                self._ended(worker)

    def _next(self, group: Hashable) -> _Task | None:
        """The next task for a worker that was at ``group``; None when there will be no more."""
        kind = _kind(group)
        with self._changed:
            while True:
                found = self._found(group, kind)
                if found is not None:
                    return found
                if group is not None:
                    self._groups.discard(group)
                    self._changed.notify_all()
                    group = None
                    continue
                if self._closed and not self._waiting:
                    return None
                self._changed.wait()

    def _found(self, group: Hashable, kind: str | None) -> _Task | None:
        """A task of ``group``; of any if that is None, preferably of ``kind``."""
        if group is not None:
            return self._taken(next((task for task in self._waiting if task.group == group), None))
        elsewhere = {_kind(one) for one in self._groups} - {None}
        best, best_rank = None, (True, True)
        for task in self._waiting:
            if task.group in self._groups:
                continue
            its_kind = _kind(task.group)
            rank = (its_kind != kind, its_kind in elsewhere)
            if best is None or rank < best_rank:
                best, best_rank = task, rank
            if not any(rank):  # there is none better in a long queue
                break
        return self._taken(best)

    def _taken(self, task: _Task | None) -> _Task | None:
        if task is not None:
            self._waiting.remove(task)
            if task.group is not None:
                self._groups.add(task.group)
        return task

    def _started(self) -> _Worker:
        worker = _Worker(self._prepare)
        with self._changed:
            self._running.add(worker)
            if self._dismissed:  # while it was being started
                worker.kill()
        return worker

    def _ended(self, worker: _Worker) -> None:
        with self._changed:
            self._running.discard(worker)
        worker.end()


class _Worker:
    """A process and the pipe to it."""

    def __init__(self, prepare: Callable[[], object] | None):
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, prepare))
        self._process.start()
        theirs.close()
        self.dead = False

    def perform(self, task: _Task) -> Any:
        """The result of a task, or its exception."""
        limit_s = task.limit_s
        try:
            self._pipe.send((limit_s, *task.call))
            for within_s in (START_S, limit_s):  # until it begins, and until it is done
                if limit_s is not None and not self._pipe.poll(within_s):
                    self.dead = True
                    raise TimeLimitError(f"stopped after {within_s:g} s without an answer")
                state, result = self._pipe.recv()
                if state != BEGUN:
                    break
        except (EOFError, ConnectionError):
            self.dead = True
            status = self._exit_status()
            if status == UNGUARDED:
                raise InputError(
                    "workers: got more than 1 in a script that each of them runs too, expected "
                    'what it does below a line `if __name__ == "__main__":`'
                ) from None
            raise WorkerDiedError(f"worker process ended, exit status {status}") from None
        if state == FAILED:
            raise result
        return result

    def kill(self) -> None:
        """End the process and what it has started."""
        # its own process group (see _serve), in which its children are too
        if self._process.pid:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()

    def end(self) -> None:
        """Let an idle process end, one that is not idle at once, and wait for it."""
        self._pipe.close()
        self.kill()
        if self._exit_status() is not None:
            self._process.close()

    def _exit_status(self) -> int | None:
        """Wait for the end of the process.

        Another thread that starts a process looks after all others as well (``_cleanup`` of
        multiprocessing): it may have taken the status, and not have noted it yet.
        """
        self._process.join()
        until = time.monotonic() + NOTED_S
        while (status := self._process.exitcode) is None and time.monotonic() < until:
            time.sleep(0.001)
        return status


def _imports_main() -> bool:
    """Whether the caller is the main module of a script that a worker is importing."""
    frame = inspect.currentframe()
    while frame is not None:
        if frame.f_globals["__name__"] == "__mp_main__" and frame.f_code.co_name == "<module>":
            return True
        frame = frame.f_back
    return False


def _kind(group: Hashable) -> str | None:
    return group.kind if isinstance(group, TaskGroup) else None


def _serve(pipe: Connection, prepare: Callable[[], object] | None) -> None:
    """What a process does: tasks from the pipe, one at a time, until nobody holds its other end."""
    os.setsid()  # Ctrl-C is the parent's affair
    hide_sympy_from_heyoka()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # with one that has come already
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_follow, name="follows its parent", daemon=True).start()
    if prepare is not None:
        prepare()
    while True:
        try:
            limit_s, work, arguments, keywords = pipe.recv()  # with the imports that this takes
        except EOFError:
            return
        except Exception as error:  # what was sent cannot be read here: a failure of that task
            pipe.send((FAILED, _noted(error)))
            continue
        pipe.send((BEGUN, None))
        if limit_s is not None:
            # should the parent be killed while code holds the interpreter's lock for ever
            signal.alarm(int(limit_s + 2 * START_S))
        try:
            reply = (DONE, work(*arguments, **keywords))
        except BaseException as error:
            reply = (FAILED, _noted(error))
        signal.alarm(0)
        try:
            pipe.send(reply)
        except Exception as error:  # it cannot be pickled
            pipe.send((FAILED, RuntimeError(f"result: {type(error).__name__}: {error}")))


def _noted(error: BaseException) -> BaseException:
    """The exception with its traceback here as a note, as a pickle has none."""
    error.add_note("in a worker process:\n" + "".join(traceback.format_exception(error)))
    return error


def _follow() -> None:
    """End with the parent, in whatever way it ends; and with all that this process has started."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.killpg(0, signal.SIGKILL)
