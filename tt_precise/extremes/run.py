"""Running cases in worker processes: what hangs or crashes is a failed case, not a failed run."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from multiprocessing.connection import wait
from typing import Any

from tt_precise.extremes.case import Case, Observation, Outcome
from tt_precise.progress import Progress, silent

# a start of Python with its imports, which a case is not charged for
START_S = 60.0
# heyoka.real arrays leak memory, so a worker is not kept for ever
CASES_OF_A_WORKER = 200


def run_all(chosen: Iterable[Case], progress: Progress = silent, jobs: int = 2) -> list[Outcome]:
    """Run ``chosen`` in ``jobs`` processes; outcomes in the order of the cases.

    Cases of one family run in one process, one after the other, and may share what they compute
    (``functools.cache``). Processes are started afresh (a script needs the usual
    ``if __name__ == "__main__"``), and none is left behind, whatever happens.
    """
    wanted = list(chosen)
    waiting: dict[str, deque[Case]] = {}
    for one in wanted:
        waiting.setdefault(one.family, deque()).append(one)
    # the families that may take longest first, so that no core idles at the end
    queue = deque(sorted(waiting.values(), key=lambda family: -family[0].limit_s))
    found: dict[str, Outcome] = {}
    with _crew() as crew:
        while len(found) < len(wanted):
            while queue and len(crew) < jobs:
                crew.append(_Worker(queue.popleft()))
            for worker in list(crew):
                worker.advance()
            _wait(crew)
            for worker in list(crew):
                outcome = worker.outcome()
                if outcome is not None:
                    found[outcome.case.name] = outcome
                    progress(len(found) / len(wanted))
                if worker.idle and queue:
                    worker.family = queue.popleft()
                if worker.spent or (worker.idle and not queue):
                    crew.remove(worker)
                    worker.stop()
                    if worker.family:
                        queue.appendleft(worker.family)
    return [found[one.name] for one in wanted]


@dataclass
class _Running:
    case: Case
    deadline: float


class _Worker:
    """A process, the family it works on, and the case it is at."""

    def __init__(self, family: deque[Case]):
        self.family = family
        self.running: _Running | None = None
        self.done = 0
        self.dead = False
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs,))
        self.process.start()
        theirs.close()

    @property
    def idle(self) -> bool:
        return self.running is None and not self.family

    @property
    def spent(self) -> bool:
        return self.dead or (self.running is None and self.done >= CASES_OF_A_WORKER)

    def advance(self) -> None:
        """Hand over the next case, if none is running."""
        if self.running is None and self.family and not self.spent:
            one = self.family.popleft()
            grace = 0.0 if self.done else START_S
            self.running = _Running(one, time.monotonic() + one.limit_s + grace)
            with contextlib.suppress(BrokenPipeError):  # told as a crash when it is read
                # the controls are the tests' affair, and may be lambdas, which cannot be sent
                self.connection.send(replace(one, control={}))

    def outcome(self) -> Outcome | None:
        """What the running case came to; None while it runs."""
        if self.running is None:
            return None
        one, late = self.running.case, time.monotonic() >= self.running.deadline
        if self.connection.poll():
            try:
                finding: Observation = self.connection.recv()
                result = Outcome(one, finding)
            except EOFError:
                self.process.join()
                result = one.failed(f"crashed, exit status {self.process.exitcode}")
                self.dead = True
        elif late:
            result = one.failed(f"stopped after {one.limit_s:g} s without an answer")
            self.dead = True
        else:
            return None
        self.running = None
        self.done += 1
        return result

    def stop(self) -> None:
        """End the process and what it started."""
        self.connection.close()
        # its own process group (see _serve), in which a case's children are too
        if self.process.pid:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.join()


@contextlib.contextmanager
def _crew() -> Iterator[list[_Worker]]:
    crew: list[_Worker] = []
    try:
        yield crew
    finally:
        for worker in crew:
            worker.stop()


def _wait(crew: list[_Worker]) -> None:
    busy = [worker for worker in crew if worker.running]
    deadline = min((w.running.deadline for w in busy if w.running), default=time.monotonic())
    wait([worker.connection for worker in busy], max(0.0, deadline - time.monotonic()))


def _serve(connection: Any) -> None:
    os.setsid()
    while True:
        try:
            one: Case = connection.recv()
        except EOFError:
            return
        # should the run be killed, no worker outlives it for ever, even in a case that hangs
        signal.alarm(int(one.limit_s + 2 * START_S))
        finding = one.outcome().finding
        signal.alarm(0)
        connection.send(finding)
