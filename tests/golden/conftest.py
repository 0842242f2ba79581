"""A small scene with golden data of its own, built once."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from tt_precise.golden import building, store
from tt_precise.golden.building import Built, derive
from tt_precise.golden.runs import BITS, GoldenRun
from tt_precise.golden.store import MANIFEST
from tt_precise.golden.table import Table
from tt_precise.scene.scene import Scene, load_scene, parse_scene


@dataclass
class Small:
    """The first 0.06 s of the reference scene, its runs, and where its data were built."""

    scene: Scene
    runs: Sequence[GoldenRun]
    folder: Path
    built: Built

    @property
    def path(self) -> Path:
        return self.folder / self.scene.name


def shortened(name: str, until: str) -> Scene:
    """A shipped scene of 8 s with another horizon, in s."""
    text = load_scene(name).text.replace('until = "8"', f'until = "{until}"')
    return parse_scene(text, name, f"{name}.toml")


def with_table(run: GoldenRun, file: str, table: Table) -> GoldenRun:
    """A run with another table."""
    return replace(run, tables={**run.tables, file: table})


def rehash(path: Path) -> None:
    """Write the manifest anew, as somebody would who has edited golden data."""
    stored = store.read_files(path.name, path.parent)
    derived = derive(stored.scene, stored.scene_text, stored.tables)
    old = stored.manifest
    for file, entry in derived["files"].items():
        for name, column in entry.get("columns", {}).items():
            column |= {
                k: v for k, v in old["files"][file]["columns"][name].items() if k == "agreement"
            }
    merged = {key: {**old[key], **derived[key]} for key in ("files", "evidence")}
    (path / MANIFEST).write_text(store.json_text({**old, **derived, **merged}))


@pytest.fixture(scope="session")
def small_built(tmp_path_factory: pytest.TempPathFactory) -> Small:
    place = tmp_path_factory.mktemp("golden")
    scene = shortened("reference", "0.06")
    runs = building.witnesses(scene, BITS[0])
    with pytest.MonkeyPatch.context() as patch:  # each run once, and no process of its own
        patch.setattr(building, "witnesses", lambda *_: runs)
        built = building.build_scene(scene.name, scene.text, place / "data", False)
    return Small(scene, runs, place / "data", built)


@pytest.fixture
def small(small_built: Small, tmp_path: Path) -> Small:
    """The small scene with a copy of its data that a test may spoil."""
    folder = shutil.copytree(small_built.folder, tmp_path / "data")
    return Small(small_built.scene, small_built.runs, folder, small_built.built)
