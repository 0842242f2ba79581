"""Processes that are this package's own, its commands and their workers: fast, and tidy.

A process of somebody else's, which uses the package as a library, is left as it is.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from pathlib import Path
from types import ModuleType

THREADS = "OPENBLAS_NUM_THREADS"
COMPILED, COMPILED_PLACE = "compiled", "HEYOKA_CACHE_DIR"
COMPILED_BYTES = 256 * 2**20
_lock = threading.Lock()
_ours = False


def in_a_process_of_ours() -> None:
    """Say so, before anything heavy is imported; processes started from here inherit the settings.

    NumPy's OpenBLAS starts no threads, unless the caller wants some: no matrix here is large
    enough for two, and starting them takes a seventh of the processor time of ``import numpy``.
    heyoka keeps compiled equations in a folder of ours, unless somebody has chosen another.
    """
    global _ours
    _ours = True
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault(THREADS, "1")
    with contextlib.suppress(OSError):
        os.environ.setdefault(COMPILED_PLACE, str(user_folder() / COMPILED))


def import_heyoka() -> ModuleType:
    """heyoka; in a process of ours without SymPy, and with a bound on what it keeps on disk.

    SymPy is half of heyoka's start, and serves only to convert expressions, which nothing here
    does. What was not used for longest is dropped first.
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
            heyoka.llvm_state.set_diskcache_limit(COMPILED_BYTES)
    return heyoka


def user_folder() -> Path:
    """The user's cache folder for this package; it need not exist.

    Raises
    ------
    OSError
        The user has none.
    """
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError as error:  # a user without a home
        raise OSError(str(error)) from None
    return Path(home) / "tt-precise"
