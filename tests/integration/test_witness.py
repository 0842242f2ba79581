"""Random scenes over the whole space of parameters, against an integrator of other make."""

import pytest

from benchmarks.witness import UNTIL_S, compared, drawn
from tt_precise.scene.scene import load_scene

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("first", "elastic", "least"),
    [
        *((first, False, 2) for first in range(0, 300, 10)),
        *((first, True, 5) for first in range(0, 30, 10)),
    ],
)
def test_events_are_those_of_the_witness(first: int, elastic: bool, least: int) -> None:
    said = [compared(drawn(seed, elastic)) for seed in range(first, first + 10)]
    assert sum("events" in one for one in said) >= least, said


def test_the_witness_finds_the_turning_points_of_the_reference_scene() -> None:
    """A top with another friction has them at other times."""
    scene = load_scene("reference").varied(until=UNTIL_S)
    assert "events" in compared(scene)
    with pytest.raises(AssertionError, match="followed to"):
        compared(scene, scene.varied(mu="0.31"))
