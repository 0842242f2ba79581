"""A fast start of processes that are this package's own: its commands and their workers.

``import heyoka`` imports SymPy where it is installed, only to be able to convert to its expressions
and back: half of a command's start. Nothing here converts. A process of somebody else's may, so
nothing is hidden there.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType

HIDDEN = "sympy"


def hide_sympy_from_heyoka() -> None:
    """Let ``import heyoka``, whenever it comes, find no SymPy; everybody else finds it."""
    if not any(isinstance(finder, _Heyoka) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Heyoka())


class _Heyoka(MetaPathFinder):
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
            spec.loader = _Hiding(spec.loader)
        return spec


class _Hiding(Loader):
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
