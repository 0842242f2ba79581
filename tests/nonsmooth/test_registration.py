"""The package is imported by the scenes that ask for it, and by no others."""

import subprocess
import sys

import pytest

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
