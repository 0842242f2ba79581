"""Single numbers that explain every residual: of the body, of the clock, of further torques."""

import pytest

from tests.check.conftest import Engine
from tests.check.test_explain import causes

NUMBERS = {
    "no gyroscopic term": "no gyroscopic term",
    "I1 a hundredth more": "I1 is 1.0100 times the scene's",
    "I3 a hundredth more": "I3 is 1.010 times the scene's",
    "centre of mass at the centre": "the centre of mass is at the centre of the sphere",
    "gravity is 9": "g is 0.916 times the scene's",
    "alpha a hundredth more": "alpha is 1.010 times the scene's",
    "mass a tenth more": "m is 1.100 times the scene's",
    "mu a tenth more": "mu is 1.100 times the scene's",
    "torsional friction": "about the vertical, as torsional friction is",
}
WIDE = {"I1 a hundredth more": 100, "mu a tenth more": 33}  # Hz


@pytest.mark.parametrize("fault", NUMBERS)
def test_the_number_is_named(engine: Engine, fault: str) -> None:
    for hertz in {500, WIDE.get(fault, 500)}:
        assert NUMBERS[fault] in causes(engine(hertz, 0.5, fault=fault))


def test_a_clock_is_named(engine: Engine) -> None:
    frame = engine(60)
    for factor in (1.05, 1.01):
        found = causes(frame.assign(t=factor * frame.t), friction="other")
        assert found == f"clock: t runs {factor:.3f} times as fast as the motion"
