"""The reference scene in every precision."""

from __future__ import annotations

import pytest

from tt_precise.integration import integrate
from tt_precise.report.precision import SCENE, precision_runs, state_distance


@pytest.mark.slow
def test_the_finest_run_is_what_200_bits_give() -> None:
    *others, finest = precision_runs()
    assert finest.trajectory.precision.name == "triple-double"
    wide = integrate(SCENE, "mp")
    assert state_distance(finest.trajectory, wide) < 1e-40
    for one in others:
        apart = state_distance(one.trajectory, wide)
        assert apart == pytest.approx(one.state_error, rel=1e-6)
        assert apart > 1e-34  # what the first bound would not let pass
