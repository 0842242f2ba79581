"""The package is imported by the scenes that ask for it, and by no others."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tt_precise import integration
from tt_precise.integration import registry
from tt_precise.runtime.cache import SOURCES
from tt_precise.scene.scene import load_scene, shipped

IMPORTED = """
import sys, tt_precise
tt_precise.integrate({scene!r}, until="0.01", events="all", digits=6).frame()
print(*(name for name in sys.modules if name.startswith("tt_precise.nonsmooth")))
"""


def imported(scene: str) -> list[str]:
    """Modules of the package after an integration in a fresh process."""
    code = IMPORTED.format(scene=scene)
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def test_a_viscous_top_on_a_rigid_table_imports_none_of_it() -> None:
    assert imported("reference") == []


# negative control of the test above
@pytest.mark.evidence
def test_coulomb_friction_imports_it() -> None:
    assert {"tt_precise.nonsmooth", "tt_precise.nonsmooth.backend"} <= {
        *imported("coulomb-stick-slip")
    }


@pytest.mark.parametrize("name", shipped())
def test_scenes_ask_by_what_they_can_do(name: str) -> None:
    modules = [module.__name__ for module in registry.asked_by(load_scene(name))]
    assert modules == ["tt_precise.nonsmooth.backend"] * load_scene(name).in_pieces


def test_cached_results_rest_on_registered_packages_too() -> None:
    """No import leads there, so the list of sources must have them by name."""
    assert {name.split(".")[1] for name in registry._MODULES.values()} <= {*SOURCES}


WORDS = ("spring", "flight", "flies", "land", "stick", "slip", "lift", "height")


def named(source: str) -> Iterator[str]:
    """Names in a program that stand for a motion whose equations change."""
    for node in ast.walk(ast.parse(source)):
        for field in ("id", "attr", "arg", "name"):
            name = getattr(node, field, None)
            if isinstance(name, str) and any(word in name.lower() for word in WORDS):
                yield name


def test_the_core_names_none_of_its_motions() -> None:
    """It asks the scene, the formulation and the segment; only texts for users name them."""
    files = [*Path(integration.__file__).parent.glob("*.py")]
    assert len(files) > 10
    found = {path.name: {*named(path.read_text())} for path in files}
    starts = {"LiftedStart"}  # the start that the package computes itself needs no contact
    assert {name: names - starts for name, names in found.items() if names - starts} == {}


# negative control of the test above
def test_a_name_is_found() -> None:
    assert [*named("if body.spring:\n    stick = 'flight'")] == ["spring", "stick"]
