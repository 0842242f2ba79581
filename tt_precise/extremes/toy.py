"""The paper's top and its start with other entries: what most cases drive to an edge."""

from __future__ import annotations

from typing import Any

from tt_precise.scene.scene import Scene, load_scene


def varied(**changes: Any) -> Scene:
    """The reference scene with ``changes``, as of ``Scene.varied``."""
    return load_scene("reference").varied(**changes)
