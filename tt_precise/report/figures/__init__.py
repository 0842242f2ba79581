"""The figures of the report: each a function without arguments that returns a ``Figure``.

A new figure is one new function with ``@registered`` in a module of this folder.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable

from tt_precise.registry import Registry
from tt_precise.report.document import Figure

_registered: Registry[Callable[[], Figure | None]] = Registry("figure")


def registered(function: Callable[[], Figure | None]) -> Callable[[], Figure | None]:
    """Make ``function`` one of the report's figures; it returns None if its data is missing."""
    _registered.enter(function.__qualname__, function, function.__module__)
    return function


def all_figures() -> list[Figure]:
    """All figures, module by module, those left out whose data is missing."""
    for module in sorted(m.name for m in pkgutil.iter_modules(__path__, f"{__name__}.")):
        importlib.import_module(module)
    made = (function() for function in _registered)
    return [figure for figure in made if figure is not None]
