"""Events in the first Taylor step are not hidden by a root at the start itself."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from tt_precise.integration import integrate
from tt_precise.scene.scene import Scene, load_scene


@pytest.fixture(scope="module")
def slow_start() -> Scene:
    # so close to the pole that the first step, without events, reaches to 0.03 s
    return replace(load_scene("beside-the-pole"), until=Fraction("0.05"))


@pytest.mark.parametrize("formulation", ["newton", "euler"])
@pytest.mark.parametrize("precision", ["double", "quad"])
def test_events_of_the_first_step_are_found(
    slow_start: Scene, formulation: str, precision: str
) -> None:
    events = integrate(
        slow_start,
        precision,
        formulation=formulation,
        events=("theta_min", "theta_max"),  # compiles faster
    ).events
    assert list(events["name"]) == ["theta_min", "theta_max"]
    # by the Euler form, whose first steps are short
    assert float(events["t"].iloc[0]) == pytest.approx(0.018061239564, abs=1e-11)


def test_a_frame_reads_each_time_from_its_own_piece() -> None:
    times = [Fraction(i, 100) for i in range(101)]
    scene = replace(load_scene("reference"), until=Fraction(1))
    whole = integrate(scene).frame(times=times)
    pieces = integrate(scene, events=("theta_min",)).frame(times=times)
    # 1e5 eps: the two take other steps, and the scene is ill conditioned
    scale = whole.abs().max().to_numpy()
    assert (abs(pieces.to_numpy() - whole.to_numpy()) <= 1e5 * 2**-52 * scale).all()
