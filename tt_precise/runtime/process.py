"""The process of a command or a worker: a fast start, and a tidy end on Ctrl-C and SIGTERM.

The settings of a process that uses the package as a library are not changed. heyoka, pandas, SymPy
and matplotlib take a second to import, so neither ``import tt_precise`` nor code that only reads
files imports them.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, ModuleType

THREADS = "OPENBLAS_NUM_THREADS"
COMPILED, COMPILED_PLACE = "compiled", "HEYOKA_CACHE_DIR"
COMPILED_BYTES = 64 * 2**20
_lock = threading.Lock()
_ours = False


def in_a_process_of_ours() -> None:
    """Say so, before anything heavy is imported; processes started from here inherit the settings.

    NumPy's OpenBLAS starts no threads, unless the caller wants some: no matrix here is large enough
    for two, and starting them takes a seventh of the processor time of ``import numpy``. heyoka
    keeps compiled equations in the package's cache folder, unless another one is set.
    """
    global _ours
    _ours = True
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault(THREADS, "1")
    with contextlib.suppress(OSError):
        os.environ.setdefault(COMPILED_PLACE, str(user_folder() / COMPILED))


def import_heyoka() -> ModuleType:
    """heyoka; in a command or worker without SymPy, and with a bound on its disk cache.

    SymPy takes half of heyoka's start and is only needed to convert expressions, which nothing here
    does. The cache drops the least recently used entries first.
    """
    with _lock:
        first = _ours and "heyoka" not in sys.modules
        hides = first and "sympy" not in sys.modules
        if hides:
            sys.modules["sympy"] = None  # type: ignore[assignment] # how Python marks what is absent
        try:
            import heyoka
        finally:
            if hides:
                del sys.modules["sympy"]
        if first and Path(os.environ.get(COMPILED_PLACE, "")).parts[-2:] == (
            "tt-precise",
            COMPILED,
        ):
            try:
                heyoka.llvm_state.set_diskcache_limit(COMPILED_BYTES)
            except RuntimeError:  # a full disk, or a broken file: continue without the cache
                heyoka.llvm_state.set_diskcache_enabled(False)
    return heyoka


def user_folder() -> Path:
    """The user's cache folder for this package, which may not exist yet.

    Raises ``OSError``: the user has no home folder.
    """
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError as error:  # a user without a home
        raise OSError(str(error)) from None
    return Path(home) / "tt-precise"


# ---- how it ends ----------------------------------------------------------------------------

AGAIN_S = 0.05
# for tidying up; worker processes that are hit as well, or half started, can keep it from ending
GRACE_S = 10.0
# code that must not be interrupted
WHOLE = ("<frozen importlib._bootstrap>", f"multiprocessing{os.sep}popen_spawn_posix.py")


class Terminated(BaseException):
    """Raised at SIGTERM, as KeyboardInterrupt at SIGINT."""


RAISED: dict[int, type[BaseException]] = {
    signal.SIGINT: KeyboardInterrupt,
    signal.SIGTERM: Terminated,
}


@contextmanager
def raising_signals() -> Iterator[None]:
    """A context in which SIGINT and SIGTERM raise; after it both end the process silently.

    During an import they wait until it is done: packages with optional parts, such as heyoka, take
    an exception there for a missing part and continue or fail later. They also wait while a worker
    process is started, which otherwise would stay behind. A signal that the parent process ignores
    (nohup) stays ignored.
    """
    wanted = [number for number in RAISED if signal.getsignal(number) is not signal.SIG_IGN]
    for name in wanted:
        signal.signal(name, _leave)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for name in wanted:
            signal.signal(name, signal.SIG_DFL)


def end_within(seconds: float, status: int) -> None:
    """End the process with ``status`` after ``seconds``, unless it has ended before."""
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
