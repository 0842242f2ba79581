"""Tasks on worker processes, and the finished runs of a build that was interrupted."""

from __future__ import annotations

import gzip
import hashlib
import json
import multiprocessing
import os
import shutil
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from tt_precise.files import atomic_write
from tt_precise.golden.manifest import versions
from tt_precise.golden.runs import Run, Task, perform
from tt_precise.golden.store import PACKAGE
from tt_precise.golden.table import Table
from tt_precise.progress import Progress, silent
from tt_precise.workers import dismiss, serve_quietly

# The code that decides the digits of a run: when it changes, kept runs are void.
_SOURCES = (
    "body.py", "numerals.py", "scene.py", "mechanics", "integrate", "golden/runs.py",
    "golden/events.py",
)  # fmt: skip


class Kept:
    """Finished runs of a build that was interrupted, in the user's cache folder.

    A run is found again only for the same task, code and versions.
    """

    def __init__(self, place: Path | None = None):
        cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        self.place = place or cache / "tt-precise" / "golden-runs"
        self._recipe = json.dumps([versions(), _source_hash()])

    def _path(self, task: Task) -> Path:
        key = self._recipe + json.dumps(asdict(task), sort_keys=True)
        return self.place / f"{task.name}-{hashlib.sha256(key.encode()).hexdigest()[:24]}.json.gz"

    def find(self, task: Task) -> Run | None:
        """The finished run of ``task``, if it was kept whole."""
        try:
            told = json.loads(gzip.decompress(self._path(task).read_bytes()))
            for name in ("trajectory", "events"):
                rows = tuple(map(tuple, told[name]["rows"]))
                told[name] = Table(tuple(told[name]["columns"]), rows)
            return Run(**{**told, "suspects": tuple(told["suspects"])})
        except (OSError, EOFError, zlib.error, ValueError, KeyError, TypeError):
            return None

    def keep(self, task: Task, run: Run) -> None:
        """Remember the run of ``task``."""
        text = json.dumps(asdict(run)).encode()
        atomic_write(self._path(task), gzip.compress(text, 1, mtime=0))

    def forget(self) -> None:
        """Drop all runs: a build that is not interrupted computes everything."""
        shutil.rmtree(self.place, ignore_errors=True)


@contextmanager
def pool(workers: int, *, recycled: bool) -> Iterator[ProcessPoolExecutor]:
    """Worker processes, which end at once if the caller is interrupted.

    ``recycled`` ones do one task each: for tasks in ``mp``, whose numbers leak memory.
    """
    executor = ProcessPoolExecutor(
        workers,
        # forked processes would inherit heyoka's compiled code and threads in an unknown state
        mp_context=multiprocessing.get_context("spawn"),
        max_tasks_per_child=1 if recycled else None,
        initializer=serve_quietly,
    )
    try:
        yield executor
    except BaseException:
        dismiss(executor)
        raise
    executor.shutdown()


def perform_all(
    executor: ProcessPoolExecutor,
    plans: dict[str, list[Task]],
    finish: Callable[[str, list[Run]], list[Task]],
    *,
    kept: Kept | None = None,
    progress: Progress = silent,
) -> None:
    """Perform the tasks of each plan, in the order given.

    ``finish`` gets the name of a plan and its runs as soon as all are there, and returns further
    tasks of the same plan, or none. ``progress`` hears the fraction of the tasks done.
    """
    tasks: dict[str, list[Task]] = {}
    runs: dict[str, dict[Task, Run]] = {}
    waiting: dict[Future[Run], tuple[str, Task]] = {}
    arrived: list[tuple[str, Task, Run]] = []

    def start(name: str, wanted: list[Task]) -> None:
        tasks[name], runs[name] = wanted, {}
        for task in wanted:
            run = kept.find(task) if kept else None
            if run:
                arrived.append((name, task, run))
            else:
                waiting[executor.submit(perform, task)] = name, task

    for name, wanted in plans.items():
        start(name, wanted)
    performed = 0
    while arrived or waiting:
        while arrived:
            name, task, run = arrived.pop()
            performed += 1
            runs[name][task] = run
            if len(runs[name]) == len(tasks[name]):
                further = finish(name, [runs[name].pop(task) for task in tasks[name]])
                if further:
                    start(name, further)
        progress(performed / (performed + len(arrived) + len(waiting)))
        if waiting:
            ready, _ = wait(waiting, return_when=FIRST_COMPLETED)
            # what has succeeded is kept before a failure that came with it ends the build
            for future in sorted(ready, key=lambda one: one.exception() is not None):
                name, task = waiting.pop(future)
                arrived.append((name, task, future.result()))
                if kept:
                    kept.keep(task, arrived[-1][2])


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0))


def _source_hash() -> str:
    files: list[Path] = []
    for name in _SOURCES:
        path = PACKAGE / name
        files += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()
