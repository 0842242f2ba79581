"""A fast start of processes that are this package's own: its commands and their workers.

``import heyoka`` imports SymPy where it is installed, only to be able to convert to its expressions
and back: half of a command's start. Nothing here converts. A process of somebody else's may, so
nothing is hidden there.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.abc import Loader

HIDDEN = "sympy"
THREADS = "OPENBLAS_NUM_THREADS"
COMPILED, COMPILED_PLACE = "compiled", "HEYOKA_CACHE_DIR"
COMPILED_BYTES = 256 * 2**20


def keep_linear_algebra_to_one_thread() -> None:
    """Let NumPy's OpenBLAS, whenever it comes, start no threads, unless the caller wants some.

    They are a seventh of the processor time of ``import numpy`` on two cores, more on more, and no
    matrix here is large enough for two of them. Processes started from here inherit it.
    """
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault(THREADS, "1")


def hide_sympy_from_heyoka() -> None:
    """Let ``import heyoka``, whenever it comes, find no SymPy; everybody else finds it."""
    if not any(isinstance(finder, _Heyoka) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Heyoka())


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


def keep_compiled() -> None:
    """Compiled equations of this process, and of those that it starts, are kept in our own folder.

    heyoka reads the place when it is imported; somebody else's choice stays.
    """
    try:
        folder = user_folder() / COMPILED
    except OSError:
        return
    os.environ.setdefault(COMPILED_PLACE, str(folder))


def bound_compiled() -> None:
    """What is kept in a folder of ours stays small; heyoka drops what was not used for longest."""
    if Path(os.environ.get(COMPILED_PLACE, "")).parts[-2:] == ("tt-precise", COMPILED):
        import heyoka

        heyoka.llvm_state.set_diskcache_limit(COMPILED_BYTES)


# no classes of importlib.abc: it imports tempfile, zipfile, random and more
class _Heyoka:
    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        if fullname != "heyoka":
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            spec.loader = _Hiding(spec.loader)  # type: ignore[assignment]
        return spec


class _Hiding:
    """Loads as another loader does, while the hidden package cannot be imported."""

    def __init__(self, loader: Loader):
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        if HIDDEN in sys.modules:
            self._loader.exec_module(module)
            return
        sys.modules[HIDDEN] = None  # type: ignore[assignment] # how Python marks what is not there
        try:
            self._loader.exec_module(module)
        finally:
            del sys.modules[HIDDEN]
