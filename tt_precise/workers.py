"""What a worker process does first, so that it never outlives its parent nor disturbs the user."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor

PARENT_GONE = 1


def serve_quietly() -> None:
    """Leave Ctrl-C to the parent, and end when the parent ends, in whatever way it does.

    For the ``initializer`` of a ``ProcessPoolExecutor``. Its workers hold both ends of the queue
    on which they wait for tasks, so when the parent is killed they would wait for ever.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is None:  # not a worker: somebody runs the tasks in the main process
        return

    def follow() -> None:
        parent.join()
        os._exit(PARENT_GONE)

    threading.Thread(target=follow, name="follows its parent", daemon=True).start()


def dismiss(executor: ProcessPoolExecutor) -> None:
    """End an executor's workers at once, whatever they are doing: the caller was interrupted."""
    # from Python 3.14 on there is terminate_workers for it
    processes = dict(getattr(executor, "_processes", None) or {})
    executor.shutdown(wait=False, cancel_futures=True)
    for process in processes.values():
        process.terminate()
