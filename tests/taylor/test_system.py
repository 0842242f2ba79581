"""Steps, their orders, and how a solution ends."""

import math

import numpy
import pytest

from tests.taylor.problems import FN, FULL
from tt_precise.taylor.machine import MOST_ORDER
from tt_precise.taylor.system import System, order_of, orders_of


def test_a_solution_that_ends_gives_no_more_than_numbers() -> None:
    """x' = x^2 blows up at t = 1."""
    made = System(2, 1, 0, lambda y, p, fn: ([y[0] * y[0]], []))
    good = []
    for piece in made.pieces(made.initial_data((FN.mpf(1),), (), FN), 2.0, FULL[2]):
        good.append(piece.begins[: piece.good, 0])
        if len(good) > 50:
            break
    times = numpy.concatenate(good)
    assert 1 - 1e-12 < times.max() <= 1
    assert len(times) > 100


def test_orders_fall_with_the_parts_and_rise_with_accuracy() -> None:
    for tolerance in (1e-16, 1e-20, 1e-32, FULL[3]):
        three, two, one = orders_of(tolerance, 3)
        assert 1 <= three <= two <= one == order_of(tolerance) + 1
    assert orders_of(FULL[2], 2)[0] == 0
    assert orders_of(1e-40, 3) > orders_of(1e-20, 3)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-20, math.nan, 1e-104])
def test_a_tolerance_that_no_order_of_a_kernel_reaches_is_refused(tolerance: float) -> None:
    # beyond the table of reciprocals a step would be made of whatever memory holds there
    with pytest.raises(ValueError, match="expected one below 1 that an order of 99 reaches"):
        order_of(tolerance)
    assert order_of(1e-103) == MOST_ORDER
