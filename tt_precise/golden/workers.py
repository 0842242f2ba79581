"""The runs of golden builds and verifications: from the cache, or on worker processes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from tt_precise.golden.manifest import versions
from tt_precise.golden.runs import Run, Task, perform
from tt_precise.golden.table import Table
from tt_precise.runtime.cache import UNREADABLE, Records, source_hash
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.sources import SOURCES
from tt_precise.runtime.workers import Call, Failure, Pool

# The code that decides the digits of a run: when it changes, cached runs are void.
CODE = (
    *SOURCES, "golden/digits.py", "golden/events.py", "golden/runs.py", "golden/table.py",
)  # fmt: skip


class RunCache:
    """Finished runs of a build that was interrupted, by default in the user's cache folder.

    A run is found again only for the same task, code and versions.
    """

    def __init__(self, place: Path | None = None):
        made_by = [versions(), source_hash(*CODE)]
        if place is None:
            self.records = Records.of_user("golden-runs", made_by)
        else:
            self.records = Records(place, made_by)

    def find(self, task: Task) -> Run | None:
        """The finished run of ``task``, if it was cached whole."""
        found = self.records.get(task.name, asdict(task))
        try:
            for name in ("trajectory", "events"):
                rows = tuple(map(tuple, found[name]["rows"]))
                found[name] = Table(tuple(found[name]["columns"]), rows)
            return Run(**{**found, "suspects": tuple(found["suspects"])})
        except UNREADABLE:  # none, or not one of these
            return None

    def keep(self, task: Task, run: Run) -> None:
        """Remember the run of ``task``."""
        self.records.put(task.name, asdict(task), asdict(run))

    def forget(self) -> None:
        """Drop all runs: a build that is not interrupted computes everything."""
        self.records.clear()


def perform_all(
    pool: Pool,
    plans: dict[str, list[Task]],
    finish: Callable[[str, list[Run]], list[Task]],
    *,
    cache: RunCache | None = None,
    progress: Progress = silent,
) -> None:
    """Perform the tasks of each plan, in the order given.

    ``finish`` gets the name of a plan and its runs as soon as all are there, and returns further
    tasks of the same plan, or none. ``progress`` is called with the fraction of the tasks done.
    """
    tasks: dict[str, list[Task]] = {}
    runs: dict[str, dict[Task, Run]] = {}
    calls: deque[Call] = deque()
    arrived: list[tuple[str, Task, Run]] = []

    def start(name: str, wanted: list[Task]) -> None:
        tasks[name], runs[name] = wanted, {}
        for task in wanted:
            run = cache.find(task) if cache else None
            if run:
                arrived.append((name, task, run))
            else:
                calls.append(Call((name, task), (task,)))

    def settle() -> None:
        while arrived:
            name, task, run = arrived.pop()
            runs[name][task] = run
            if len(runs[name]) == len(tasks[name]):
                further = finish(name, [runs[name].pop(task) for task in tasks[name]])
                if further:
                    start(name, further)

    for name, wanted in plans.items():
        start(name, wanted)
    settle()
    for call, run in pool.perform(perform, calls, progress):
        name, task = call.key
        if isinstance(run, Failure):
            raise run.error
        if cache:
            cache.keep(task, run)
        arrived.append((name, task, run))
        settle()
