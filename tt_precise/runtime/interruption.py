"""Ctrl-C and SIGTERM: the command that runs is left by an exception, and tidies up behind it."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

AGAIN_S = 0.05
# for tidying up; worker processes that are hit as well, or half started, can keep it from ending
GRACE_S = 10.0
# code that is not left half done
WHOLE = ("<frozen importlib._bootstrap>", f"multiprocessing{os.sep}popen_spawn_posix.py")


class Terminated(BaseException):
    """SIGTERM has come: what KeyboardInterrupt is for SIGINT."""


RAISED: dict[int, type[BaseException]] = {
    signal.SIGINT: KeyboardInterrupt,
    signal.SIGTERM: Terminated,
}


@contextmanager
def heeded() -> Iterator[None]:
    """Within it SIGINT and SIGTERM raise; after it they end the process at once, in silence.

    Within an import they wait until it is done: packages with optional parts, heyoka among them,
    take an exception there for a missing part, and go on or fail later in an odd place. So they do
    while a worker process is started, which would be left behind with half of its orders. A signal
    that the parent has set to be ignored (nohup) stays ignored.
    """
    wanted = [one for one in RAISED if signal.getsignal(one) is not signal.SIG_IGN]
    for one in wanted:
        signal.signal(one, _leave)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for one in wanted:
            signal.signal(one, signal.SIG_DFL)


def end_within(seconds: float, status: int) -> None:
    """End the process with ``status`` after that time, if it has not ended by then."""
    last_resort = threading.Timer(seconds, os._exit, [status])
    last_resort.daemon = True
    with contextlib.suppress(RuntimeError):  # the system gives no more threads
        last_resort.start()


def _leave(signum: int, frame: FrameType | None) -> None:
    if _within_whole(frame):
        signal.signal(signal.SIGALRM, lambda _, where: _leave(signum, where))
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
        return
    end_within(GRACE_S, 128 + signum)
    raise RAISED[signum]


def _within_whole(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.endswith(WHOLE):
            return True
        frame = frame.f_back
    return False
