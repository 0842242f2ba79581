"""The package is imported by the scenes that ask for it, and by no others."""

import pytest

from tt_precise.integration import registry
from tt_precise.runtime.cache import SOURCES
from tt_precise.scene.scene import load_scene, shipped


@pytest.mark.parametrize("name", shipped())
def test_scenes_ask_by_what_they_can_do(name: str) -> None:
    modules = [module.__name__ for module in registry.asked_by(load_scene(name))]
    assert modules == ["tt_precise.nonsmooth.backend"] * load_scene(name).in_pieces


def test_cached_results_rest_on_registered_packages_too() -> None:
    """No import leads there, so the list of sources must have them by name."""
    assert {name.split(".")[1] for name in registry._MODULES.values()} <= {*SOURCES}
