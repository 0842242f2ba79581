"""The process of a command or a worker: a fast start, and a tidy end on SIGTERM.

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
from pathlib import Path
from types import ModuleType

# Bytes of heyoka's compiled equations in the cache folder, which drops the least recently used.
COMPILED_BYTES = 64 * 2**20
_lock = threading.Lock()
_ours = False


class Terminated(BaseException):
    """Raised at SIGTERM, as KeyboardInterrupt at SIGINT."""


def in_a_process_of_ours() -> None:
    """Set up the process of a command or a worker, before anything heavy is imported.

    NumPy's OpenBLAS starts no threads, unless the caller wants some: no matrix here is large enough
    for two, and starting them takes a seventh of the processor time of ``import numpy``. heyoka
    keeps compiled equations in the package's cache folder, unless another one is set. Pictures are
    drawn into files, whatever backend a notebook has set for its children.
    """
    global _ours
    _ours = True
    os.environ["MPLBACKEND"] = "agg"
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with contextlib.suppress(RuntimeError):
        os.environ.setdefault("HEYOKA_CACHE_DIR", str(user_folder() / "compiled"))


def import_heyoka() -> ModuleType:
    """Import heyoka; in a command or worker without SymPy, and with a bound on its disk cache.

    SymPy takes half of heyoka's start and is only needed to convert expressions, which nothing here
    does.
    """
    with _lock:
        first = _ours and "heyoka" not in sys.modules
        if hidden := first and "sympy" not in sys.modules:
            sys.modules["sympy"] = None  # type: ignore[assignment] # how Python marks what is absent
        try:
            import heyoka
        finally:
            if hidden:
                del sys.modules["sympy"]
        heyoka.set_logger_level_critical()  # statuses and unresolved events say what it would log
        if first and os.environ.get("HEYOKA_CACHE_DIR", "").endswith("tt-precise/compiled"):
            try:
                heyoka.llvm_state.set_diskcache_limit(COMPILED_BYTES)
            except RuntimeError:  # a full disk, or a broken file: continue without the cache
                heyoka.llvm_state.set_diskcache_enabled(False)
    return heyoka


def user_folder() -> Path:
    """Return the user's cache folder for this package, which may not exist yet.

    Raises ``RuntimeError``: the user has no home folder.
    """
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tt-precise"


def raise_at_sigterm() -> None:
    """Make SIGTERM raise ``Terminated``, so that files and worker processes are tidied up."""

    def leave(*_: object) -> None:
        raise Terminated

    signal.signal(signal.SIGTERM, leave)
