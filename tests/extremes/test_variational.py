"""Variational equations: shapes and products."""

import numpy
import pytest

from tt_precise.extremes.variational import Sensitivity, sensitivity

TIMES = ("0", "0.01", "0.03", "0.05")
EPS = 2.0**-52


@pytest.fixture(scope="module")
def kicked() -> Sensitivity:
    return sensitivity("kicked", TIMES)


def test_shapes_and_the_start(kicked: Sensitivity) -> None:
    assert kicked.columns == ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
    assert kicked.parameters == ("alpha", "I1", "I3", "mu")
    assert kicked.transitions.shape == (3, 8, 8)
    assert kicked.pushes.shape == (3, 8, 4)
    assert (kicked.by_start[0] == numpy.eye(8)).all()
    assert (kicked.by_parameters[0] == 0).all()
    # at the start errors of the start count once, those of the parameters not yet
    assert kicked.condition[0] == kicked.rounding[0] == 1


def test_pieces_make_the_whole(kicked: Sensitivity) -> None:
    whole = sensitivity("kicked", (TIMES[0], TIMES[-1]))
    for name in ("by_start", "by_parameters"):
        one, other = (getattr(run, name)[-1] for run in (whole, kicked))
        # some steps of a few eps, times the size
        assert numpy.abs(one - other).max() < 1000 * EPS * numpy.abs(one).max()
    assert numpy.abs(whole.by_start[-1] - kicked.by_start[-2]).max() > 0.01


def test_one_time_alone() -> None:
    found = sensitivity("rolling", ("0",))
    assert found.by_start.shape == (1, 6, 6)
    assert found.condition.tolist() == [1.0]
