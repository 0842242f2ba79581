"""Scenes with one place of their file changed, and the end of their motion."""

from typing import Any

import numpy

import tt_precise as tt
from tt_precise.scene.scene import Scene, load_scene, parse_scene

FLIES = ("[start]", '[contact]\nlost = "fly"\n[start]')  # a place of a file, and its replacement


def edited(name: str, *places: str) -> Scene:
    """A shipped scene with places of its file, each followed by its replacement, changed."""
    text = load_scene(name).text
    for before, after in zip(places[::2], places[1::2], strict=True):
        assert before in text
        text = text.replace(before, after, 1)
    return parse_scene(text, name, f"{name}.toml")


def final(scene: Scene, *names: str) -> Any:
    state = tt.integrate(scene, events=()).state
    return numpy.array([float(getattr(state, name)) for name in names])
