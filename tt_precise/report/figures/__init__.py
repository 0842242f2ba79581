"""The figures of the report: each a function without arguments that returns a ``Figure``.

A new figure is one new function with ``@registered(section)`` in a module of this folder.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable

from tt_precise.report.document import Figure
from tt_precise.runtime.registry import Registry

Draw = Callable[[], Figure | None]

_registered: Registry[tuple[str, Draw]] = Registry("figure")


def registered(section: str) -> Callable[[Draw], Draw]:
    """Make a function a figure of that section; it returns None if its data is missing."""

    def register(function: Draw) -> Draw:
        _registered.enter(function.__qualname__, (section, function), function.__module__)
        return function

    return register


def figures_of(section: str) -> list[Figure]:
    """The figures of a section: those of the paper redrawn first, then the others."""
    drawn = [draw() for home, draw in _all() if home == section]
    found = [figure for figure in drawn if figure is not None]
    return sorted(found, key=lambda figure: not figure.name.startswith("figure-"))


def all_figures() -> list[Figure]:
    """The figures of all sections."""
    sections = dict.fromkeys(home for home, _ in _all())
    return [figure for section in sections for figure in figures_of(section)]


def _all() -> list[tuple[str, Draw]]:
    for module in sorted(m.name for m in pkgutil.iter_modules(__path__, f"{__name__}.")):
        importlib.import_module(module)
    return list(_registered)
