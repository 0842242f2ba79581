"""All sweeps of this folder have few lanes."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def _few_lanes(few_lanes: None) -> None:
    """Before what a module computes once."""
