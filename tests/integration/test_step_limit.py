"""The longest step beside a pole, which keeps a tilt of 1e-20 rad."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tt_precise.integration.precision import precision_named
from tt_precise.integration.step_limit import LARGE_TILT, longest_step
from tt_precise.integration.system import SLOW_SPEED
from tt_precise.mechanics.formulations import SLOW
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.scene.scene import Inclination, load_scene

DOUBLE = precision_named("double")
ORDER = 20


def start(theta: str) -> InitialState:
    scene = load_scene("reference")
    leaning = replace(scene.start, theta=Inclination.parse(theta), omega_3=scene.start.omega_3)
    return InitialState.of(replace(scene, start=leaning), DOUBLE.arithmetic)


@pytest.mark.parametrize(("tilt", "limited"), [("1e-20", True), ("0.007", True), ("0.1", False)])
def test_only_a_small_tilt_needs_a_limit(tilt: str, limited: bool) -> None:
    assert (float(tilt) < LARGE_TILT) == limited
    one = start(tilt)
    assert (longest_step(one.body, one.vectors, ORDER, DOUBLE) is not None) == limited


def test_on_the_axis_there_is_no_tilt_to_keep() -> None:
    one = start("0")
    assert longest_step(one.body, one.vectors, ORDER, DOUBLE) is None


def test_in_a_time_of_its_own_a_step_is_as_many_times_longer_as_rates_are_smaller() -> None:
    """Without friction: a rate is v times as large, and v is twice the slow speed at most."""
    one = start("1e-9")
    body = replace(one.body, mu=0 * one.body.mu)
    plain, own = (
        longest_step(body, one.vectors, ORDER, DOUBLE, form) for form in (None, SLOW["newton"])
    )
    assert plain is not None
    assert own / plain == pytest.approx(1 / (2 * SLOW_SPEED), rel=1e-12)
