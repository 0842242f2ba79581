"""Scenes with one place of their file changed, and the end of their motion."""

from collections.abc import Iterable
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


def orders(limit: Scene, others: Iterable[Scene], names: str, ratio: float) -> Any:
    """The orders in which the ends of motions, each ``ratio`` nearer, tend to that of a limit."""
    states = [tt.integrate(one, events=()).state for one in (limit, *others)]
    ends = numpy.array([[float(getattr(s, name)) for name in names.split()] for s in states])
    errors = abs(ends[1:] - ends[0]).max(axis=1)
    return numpy.log(errors[:-1] / errors[1:]) / numpy.log(ratio)
