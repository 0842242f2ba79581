"""The table behind ``digits=``: right digits are those of golden data."""

from dataclasses import replace
from fractions import Fraction

import pytest

from tt_precise.bench import settings_table
from tt_precise.golden import scenes
from tt_precise.integrate import integrate
from tt_precise.scene import load_scene


def test_ways_are_distinguished() -> None:
    every = list(settings_table.settings())
    assert len(every) == len(set(every))
    assert {setting.precision for setting in every if setting.formulation == "euler"} == set(
        settings_table.EULER
    )


def test_right_digits_are_those_of_golden_data() -> None:
    trajectory = integrate("upright", events=(), record=())
    assert 15 < settings_table.right_digits(trajectory) < 16.1
    moving = integrate("stays-upright", tolerance=1e-6, events=(), record=())
    assert 0 < settings_table.right_digits(moving) < 9


def test_another_ending_has_no_right_digits() -> None:
    scene = load_scene("contact-lost")
    short = replace(scene, until=Fraction(1, 100))
    assert settings_table.right_digits(integrate(short)) == 0


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [3, 6, 9, 12, 15])
@pytest.mark.parametrize("name", scenes())
def test_digits_are_delivered_on_every_golden_scene(name: str, wanted: int) -> None:
    trajectory = integrate(name, digits=wanted, events=(), record=())
    assert settings_table.right_digits(trajectory) >= wanted
    assert trajectory.digits_throughout - settings_table.right_digits(trajectory) < 1
