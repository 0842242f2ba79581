"""Zeros in brackets: simple ones by secants, multiple ones and jumps by halving."""

import numpy
import pytest

from tt_precise.integration.roots import Bracket, refine, secants, vertex
from tt_precise.runtime.values import Array

ZERO = 0.3


@pytest.mark.parametrize("power", [1, 3])
def test_a_zero_is_found_to_what_its_order_allows(power: int) -> None:
    def function(place: Array, rows: Array | slice = slice(None)) -> Array:
        return (place - ZERO) ** power

    one = numpy.ones(1)
    bracket = Bracket(0.31 * one, 0.0 * one, one.copy(), power * 0.01 ** (power - 1) * one, one)
    place, value = refine(function, bracket, 53)
    # halving ends where neighbouring numbers have both signs
    assert place[0] == pytest.approx(ZERO, abs=4e-16)
    assert abs(value[0]) < 1e-15


def test_a_jump_is_bracketed_and_keeps_its_value() -> None:
    def function(place: Array, rows: Array | slice = slice(None)) -> Array:
        return numpy.where(place < ZERO, -1.0, 2.0)

    one = numpy.ones(1)
    bracket = Bracket(0.5 * one, 0.0 * one, one.copy(), 3.0 * one, one)
    with numpy.errstate(all="ignore"):
        place, value = refine(function, bracket, 53)
    assert place[0] == pytest.approx(ZERO, abs=1e-15)
    assert abs(value[0]) >= 1


def test_secants_suffice_from_a_thousandth_of_the_bracket() -> None:
    """In any arithmetic: each has 1.6 times the right bits of the one before."""
    assert [secants(bits) for bits in (53, 104, 113, 200)] == [6, 7, 8, 9]
    for bits in (53, 200, 1000):
        right = [10.0, 10.0]
        for _ in range(secants(bits)):
            right.append(right[-1] + right[-2])
        assert right[-1] >= bits


def test_a_vertex_stays_between_its_bounds() -> None:
    one = numpy.ones(2)
    place, value = vertex(
        lambda x: (x - ZERO) ** 2 * (2 + x) - 1, 0.3001 * one, 0.1 * one, 0 * one,
        numpy.array([1.0, 0.305]), 53,
    )  # fmt: skip
    assert place == pytest.approx([ZERO, ZERO], abs=1e-7)
    assert value == pytest.approx([-1, -1], abs=1e-11)
    place, value = vertex(
        lambda x: (x - ZERO) ** 2 - 1, 0.29 * one, 0.1 * one, 0 * one, 0.295 * one, 53
    )
    assert place == pytest.approx([0.295, 0.295])
    assert value == pytest.approx([0.005**2 - 1] * 2, rel=1e-8)


def test_a_vertex_of_noise_is_no_larger_than_the_noise() -> None:
    """The vertex of a parabola through three values of noise is up to hundreds of times larger."""
    one = numpy.linspace(0.2, 0.8, 200)
    _, value = vertex(
        lambda x: numpy.sin(1e17 * x), one, 0.1 + 0 * one, 0 * one, 1 + 0 * one, 53
    )  # fmt: skip
    assert abs(value).max() <= 1
