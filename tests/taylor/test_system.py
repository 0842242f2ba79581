"""Steps, their orders, and how a solution ends."""

import math

import numpy
import pytest

from tests.taylor.problems import EPS, FN, FULL, blocks, system
from tt_precise.taylor.machine import MOST_ORDER
from tt_precise.taylor.system import System, moments, numbers_of, order_of, orders_of


@pytest.mark.parametrize("limbs", [2, 3])
@pytest.mark.parametrize(
    ("name", "output", "zeros"),
    [
        ("product and quotient", 0, [FN.sqrt(2 * FN.log(2))]),  # x - 2 in x = exp(t^2/2)
        ("Kepler's circle, twelve times", 1, [k * FN.pi for k in range(1, int(75 / FN.pi) + 1)]),
    ],
)
def test_every_step_with_a_zero_of_an_output_is_suspect(
    name: str, output: int, zeros: list[FN.mpf], limbs: int
) -> None:
    column, aside = len(system(name, limbs).graph.components) + output, 2**8 * EPS[limbs]
    steps = [(block, k) for block in blocks(name, limbs) for k in block.suspect]
    for zero in zeros:
        signs = set()
        for block, k in steps:
            begin = block.begins[k, 0]
            if begin <= zero <= begin + block.lengths[k] * block.units[k]:
                sides = moments([zero * (1 - aside), zero * (1 + aside)])
                rows = block.rows(numpy.array([k, k]), sides)
                signs |= {numbers_of(row, FN)[column] > 0 for row in rows}
        assert signs == {True, False}  # the zero is where its closed form is


def test_a_solution_that_ends_gives_no_more_than_numbers() -> None:
    """x' = x^2 blows up at t = 1."""
    square = System(2, 1, 0, lambda y, p, fn: ([y[0] * y[0]], []))
    times = []
    for block in square.pieces(square.initial_data((FN.mpf(1),), (), FN), 2.0, FULL[2]):
        times += block.begins[: block.good, 0].tolist()
        if len(times) > 25_000:
            break
    assert 1 - 1e-12 < max(times) <= 1
    assert len(times) > 100


def test_orders_fall_with_the_limbs_and_rise_with_accuracy() -> None:
    for tolerance in (1e-16, 1e-20, 1e-32, FULL[3]):
        three, two, one = orders_of(tolerance, 3)
        assert 1 <= three <= two <= one == order_of(tolerance) + 1
    assert orders_of(FULL[2], 2)[0] == 0
    assert orders_of(1e-40, 3) > orders_of(1e-20, 3)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-20, math.nan, 1e-104])
def test_a_tolerance_beyond_the_highest_order_is_refused(tolerance: float) -> None:
    """Beyond the table of reciprocals a step would be made of whatever memory holds there."""
    with pytest.raises(ValueError, match="expected one below 1 that an order of 99 reaches"):
        order_of(tolerance)
    assert order_of(1e-103) == MOST_ORDER
