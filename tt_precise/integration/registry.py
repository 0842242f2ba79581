"""Further backends, each imported when a scene first asks for it.

A package that integrates motions which this folder does not know registers a module. The module has
the functions of a ``run.Backend``.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # ``import tt_precise`` runs this file
    from tt_precise.scene.scene import Scene

_MODULES: dict[str, str] = {}


def register(capability: str, module: str) -> None:
    """Name the module for scenes whose property ``capability`` is true."""
    _MODULES[capability] = module


def asked_by(scene: Scene) -> list[ModuleType]:
    """Return the modules for a scene, usually none."""
    return [import_module(name) for asked, name in _MODULES.items() if getattr(scene, asked)]
