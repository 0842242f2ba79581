"""The problem of a scene: its start, and the components that stay zero."""

from typing import Any

import flint
import pytest
from flint import arb

import tt_precise as tt
from tt_precise.certify import problem_of
from tt_precise.certify.kernel import StateSet
from tt_precise.certify.models import Rates
from tt_precise.certify.problem import BALLS
from tt_precise.scene.initial_state import InitialState

BITS = 120


@pytest.fixture(autouse=True)
def precision() -> Any:
    with flint.ctx.workprec(2 * BITS):
        yield


def names(scene: tt.Scene) -> set[str]:
    """Return the names of the components that stay zero."""
    found = problem_of(scene)
    rates = Rates(found.phases[0].rates, len(found.start))
    free = StateSet.of(rates, arb(0), found.start).free
    columns = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "s_dot_x", "s_dot_y")
    return {name for i, name in enumerate(columns) if i not in free}


def test_what_stays_zero_in_the_scenes() -> None:
    assert names(tt.load_scene("upright")) == {"kx", "ky", "Lx", "Ly", "s_dot_x", "s_dot_y"}
    assert names(tt.load_scene("reference")) == set()
    rocking = tt.load_scene("rocking")
    assert names(rocking) == {"ky", "Lx", "Lz", "s_dot_y"}
    # a spin however small leaves the plane; zero at the start is not enough
    assert names(rocking.varied(omega_3="1e-60")) == set()
    rates = Rates(lambda y: [1 + 0 * y[0], y[0] - 1 + y[1]], 2)
    assert StateSet.of(rates, arb(0), [arb(1), arb(0)]).free == [0, 1]


def test_the_start_of_a_problem_is_that_of_its_scene() -> None:
    found, scene = problem_of(tt.load_scene("track")), tt.load_scene("track")
    first = InitialState.of(scene, BALLS)
    assert len(found.start) == 8 + len(scene.record)
    assert all(a.overlaps(arb(b)) for a, b in zip(found.start[:3], first.vectors, strict=False))
