"""The table behind ``digits=``: right digits are those of golden data."""

from dataclasses import replace
from fractions import Fraction

from benchmarks import settings_table
from tt_precise.integration import integrate
from tt_precise.scene.scene import load_scene


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
