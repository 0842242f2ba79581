"""Phases: the steps of slow gliding."""

from dataclasses import replace

import pytest

from tt_precise.integration.equations import RIGID_CONTACT, longest_step
from tt_precise.integration.precision import precision_named
from tt_precise.nonsmooth.phases import SLOW_GLIDING, SLOW_SPEED
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import load_scene


def test_in_a_time_of_its_own_a_step_is_as_many_times_longer_as_rates_are_smaller() -> None:
    """Without friction: a rate is v times as large, and v is twice the slow speed at most."""
    double = precision_named("double")
    one = InitialState.of(load_scene("reference").varied(theta="1e-9"), double.arithmetic)
    body = replace(one.body, mu=0 * one.body.mu)
    plain, own = (
        longest_step(body, one.vectors, 20, double, phase)
        for phase in (RIGID_CONTACT, SLOW_GLIDING)
    )
    assert plain is not None
    assert own / plain == pytest.approx(1 / (2 * SLOW_SPEED), rel=1e-12)
