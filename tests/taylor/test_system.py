"""Steps, their orders, and how a solution ends."""

import math
from typing import Any

import numpy
import pytest

from tests.taylor.problems import EPS, FN, FULL, pieces, system
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
def test_steps_with_zeros_of_outputs_are_suspect(
    name: str, output: int, zeros: list[Any], limbs: int
) -> None:
    column, left = len(system(name, limbs).graph.components) + output, list(zeros)
    aside = 2**8 * EPS[limbs]
    for piece in pieces(name, limbs):
        ends = piece.begins[:, 0] + piece.lengths * piece.units
        suspects = [(piece.begins[k, 0], ends[k]) for k in piece.suspect]
        for zero in [t for t in left if t <= ends[-1]]:
            left.remove(zero)
            assert any(low <= zero <= high for low, high in suspects)
            sides = piece.at(moments([zero * (1 - aside), zero * (1 + aside)]))
            before, after = (numbers_of(row, FN)[column] for row in sides)
            assert before * after < 0  # the zero is where its closed form is
    assert not left


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
