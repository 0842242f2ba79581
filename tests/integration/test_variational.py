"""Derivatives of solutions: difference quotients, and what holds without any."""

from dataclasses import replace
from fractions import Fraction

import numpy
import pytest

from tt_precise.integration import integrate
from tt_precise.integration.variational import Sensitivity, sensitivity
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import load_scene

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
    for one, other in (
        (whole.by_start[-1], kicked.by_start[-1]),
        (whole.by_parameters[-1], kicked.by_parameters[-1]),
    ):
        # some steps of a few eps, times the size
        assert numpy.abs(one - other).max() < 1000 * EPS * numpy.abs(one).max()
    assert numpy.abs(whole.by_start[-1] - kicked.by_start[-2]).max() > 0.01


def test_the_derivative_by_mu_is_a_difference_quotient(kicked: Sensitivity) -> None:
    scene, size = replace(load_scene("kicked"), until=Fraction(TIMES[-1])), Fraction(1, 10**9)
    ends = []
    for sign in (1, -1):
        mu = scene.body.mu * (1 + sign * size)
        run = integrate(replace(scene, body=replace(scene.body, mu=mu)), "quad")
        ends.append([run.state.vx, run.state.vy, run.start.units])
    unit = ends[0][2].length / ends[0][2].time
    quotient = [float((a - b) / unit / (2e-9)) for a, b in zip(ends[0], ends[1][:2], strict=False)]
    where = kicked.parameters.index("mu")
    found = kicked.by_parameters[-1][6:, where] * kicked.values[where]
    # the quotient's own error is the square of 1e-9; the rest are some steps in double
    assert numpy.abs(found - quotient).max() < 1000 * EPS * numpy.abs(quotient).max()
    assert numpy.abs(found).max() > 0.1


def test_where_the_model_ends_the_times_end() -> None:
    end = float(integrate("contact-lost").t_end)
    found = sensitivity("contact-lost")
    assert found.times[-1] <= end < found.times[-1] + 0.01
    assert numpy.isfinite(found.transitions).all()
    assert numpy.isfinite(found.rounding).all()


def test_one_time_alone() -> None:
    found = sensitivity("rolling", ("0",))
    assert found.by_start.shape == (1, 6, 6)
    assert found.condition.tolist() == [1.0]


@pytest.mark.parametrize("times", [("1", "2"), ("0", "0.02", "0.01"), ("-1", "0"), ()])
def test_times_that_do_not_rise_from_0_are_refused(times: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="expected times in s that rise from 0"):
        sensitivity("kicked", times)
