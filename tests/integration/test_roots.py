"""Zeros in brackets: simple ones by secants, multiple ones and jumps by halving."""

import numpy
import pytest

from tt_precise.integration.roots import Bracket, refined
from tt_precise.runtime.values import Array

ZERO = 0.3


@pytest.mark.parametrize("power", [1, 3])
def test_a_zero_is_found_to_what_its_order_allows(power: int) -> None:
    def function(place: Array, rows: Array | slice = slice(None)) -> Array:
        return (place - ZERO) ** power

    one = numpy.ones(1)
    bracket = Bracket(0.31 * one, 0.0 * one, one.copy(), power * 0.01 ** (power - 1) * one, one)
    place, value = refined(function, bracket, 20, 2.0**-50)
    # halving ends where neighbouring numbers have both signs
    assert place[0] == pytest.approx(ZERO, abs=4e-16)
    assert abs(value[0]) < 1e-15


def test_a_jump_is_bracketed_and_keeps_its_value() -> None:
    def function(place: Array, rows: Array | slice = slice(None)) -> Array:
        return numpy.where(place < ZERO, -1.0, 2.0)

    one = numpy.ones(1)
    bracket = Bracket(0.5 * one, 0.0 * one, one.copy(), 3.0 * one, one)
    with numpy.errstate(all="ignore"):
        place, value = refined(function, bracket, 20, 2.0**-50)
    assert place[0] == pytest.approx(ZERO, abs=1e-15)
    assert abs(value[0]) >= 1
