"""What a package offers: names that are imported when they are first used.

heyoka, pandas, SymPy and matplotlib take a second to import, so ``import tt_precise`` and what only
reads files do without them.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def lazy_names(
    package: str, homes: Mapping[str, Sequence[str]], modules: Sequence[str] = ()
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package.

    ``homes`` gives the names that each of its modules has; ``modules`` are used as such. For type
    checkers the package imports the same under ``TYPE_CHECKING``, and lists it in ``__all__``.
    """
    home_of = {name: module for module, names in homes.items() for name in names}

    def find(name: str) -> Any:
        if name in home_of:
            found = getattr(importlib.import_module(f"{package}.{home_of[name]}"), name)
            return vars(sys.modules[package]).setdefault(name, found)  # this is asked once
        if name in modules:
            return importlib.import_module(f"{package}.{name}")
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    def names() -> list[str]:
        return sorted(importlib.import_module(package).__all__)

    return find, names
