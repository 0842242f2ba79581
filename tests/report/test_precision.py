"""The reference scene in every precision."""

from __future__ import annotations

import pytest

from tt_precise.integration import integrate
from tt_precise.report.precision import SCENE, precision_runs, state_distance
from tt_precise.scene.scene import load_scene


@pytest.mark.slow
def test_the_finest_run_is_what_200_bits_give() -> None:
    *others, finest = precision_runs()
    assert finest.trajectory.precision.name == "triple-double"
    wide = integrate(SCENE, "mp")
    assert state_distance(finest.trajectory, wide) < 1e-40
    for run in others:
        apart = state_distance(run.trajectory, wide)
        assert apart == pytest.approx(run.state_error, rel=1e-6)
        assert apart > 1e-34  # what the first bound would not let pass


def test_the_distance_is_that_of_the_worst_component() -> None:
    scene = load_scene(SCENE).varied(until="1e-3")
    own, other = integrate(scene), integrate(scene.varied(omega_3="156"))
    # L.z is I3 cos(theta) omega_3, of which 1 rad/s is sqrt(R/g) units
    apart = 0.4 * 0.995 * (0.02 / 9.82) ** 0.5
    assert state_distance(own, other) == pytest.approx(apart, rel=0.01)
