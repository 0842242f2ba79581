"""Scenes with one place of their file changed, and the end of their motion."""

from typing import Any

import numpy

import tt_precise as tt
from tt_precise.scene.scene import Scene, load_scene, parse_scene


def edited(name: str, before: str, after: str) -> Scene:
    """A shipped scene with one place of its file changed."""
    text = load_scene(name).text
    assert before in text
    return parse_scene(text.replace(before, after, 1), name, f"{name}.toml")


def final(scene: Scene, *names: str) -> Any:
    state = tt.integrate(scene, events=()).state
    return numpy.array([float(getattr(state, name)) for name in names])
