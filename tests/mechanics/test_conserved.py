"""What each scene conserves, and how drift is measured."""

import dataclasses
from typing import Any

import pytest

from tt_precise.mechanics.conserved import INTEGRALS, conserved, drift
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.scene import load_scene


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", ""),
        ("rolling", "energy routh modified_energy"),
        ("frictionless", "energy spin vertical_angular_momentum momentum_x momentum_y"),
    ],
)
def test_conserved_by_the_scene(scene: str, names: str) -> None:
    loaded = load_scene(scene)
    found = {integral.name for integral in conserved(loaded.model, loaded.body)}
    assert found == {"jellett", "axis_norm", *names.split()}


def test_drift_is_relative_to_the_start(numbers: Parameters, mp: Any) -> None:
    first = NewtonState(*map(mp.mpf, (0, 0, 1, 0, 0, 2, 0, 0)))
    later = first._replace(Lz=mp.mpf("2.5"))
    motions = [Motion(numbers, state, mp) for state in (first, later, first)]
    still, changed, back = drift(INTEGRALS["jellett"], motions)
    assert still == back == 0
    assert abs(changed - mp.mpf("0.25")) < 4 * mp.eps


@pytest.mark.parametrize("axis", "xy")
def test_an_integral_that_is_zero_has_a_scale(axis: str, numbers: Parameters, mp: Any) -> None:
    numbers = dataclasses.replace(numbers, mu=mp.mpf(0))
    first = NewtonState(*map(mp.mpf, (0, 0, 1, 0, 0, 2, 0, 0)))
    moved = first._replace(**{f"v{axis}": mp.mpf("1e-10")})
    motions = [Motion(numbers, one, mp) for one in (first, moved)]
    found = drift(INTEGRALS[f"momentum_{axis}"], motions)
    scale = numbers.m * numbers.R * 2 / numbers.I3
    assert abs(found[1] - numbers.m * mp.mpf("1e-10") / scale) < 10 * mp.eps
    assert found[0] == 0
    other = INTEGRALS[f"momentum_{'y' if axis == 'x' else 'x'}"]
    assert drift(other, motions)[1] == 0
