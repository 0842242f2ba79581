"""A small scene with golden data of its own, built once."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tt_precise.golden import building, store
from tt_precise.golden.building import Built
from tt_precise.golden.runs import LADDER, Run, perform, tasks
from tt_precise.golden.workers import RunCache
from tt_precise.scene.scene import Scene, load_scene, parse_scene


class Shelf(RunCache):
    """Runs that are never forgotten, so that the tests compute each of them once."""

    def forget(self) -> None:
        pass


@dataclass
class Small:
    """The first 0.06 s of the reference scene, its runs, and where its data were built."""

    scene: Scene
    runs: list[Run]
    shelf: Shelf
    folder: Path
    built: Built


def shortened(name: str, until: str) -> Scene:
    """A shipped scene of 8 s with another horizon, in s."""
    text = load_scene(name).text.replace('until = "8"', f'until = "{until}"')
    return parse_scene(text, name, f"{name}.toml")


@pytest.fixture(scope="session")
def shorten() -> Callable[[str, str], Scene]:
    """The function that gives a shipped scene another horizon."""
    return shortened


@pytest.fixture(scope="session")
def small_built(tmp_path_factory: pytest.TempPathFactory) -> Small:
    place = tmp_path_factory.mktemp("golden")
    scene = shortened("reference", "0.06")
    shelf = Shelf(place / "shelf")
    plan = tasks(scene, LADDER[0])
    runs = [perform(task) for task in plan]
    for task, run in zip(plan, runs, strict=True):
        shelf.keep(task, run)
    built = building.build([scene], folder=place / "data", workers=1, cache=shelf)
    return Small(scene, runs, shelf, place / "data", built[0])


@pytest.fixture
def small(small_built: Small, tmp_path: Path) -> Small:
    """The small scene with a copy of its data that a test may spoil."""
    folder = shutil.copytree(small_built.folder, tmp_path / "data")
    return Small(small_built.scene, small_built.runs, small_built.shelf, folder, small_built.built)


@pytest.fixture(scope="session")
def committed() -> list[str]:
    """Names of the scenes with committed data."""
    names = store.scenes()
    assert names, "no golden data in this checkout"
    return names
