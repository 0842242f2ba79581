"""The compiled recurrences against closed forms, in both number types."""

from typing import Any

import numpy
import pytest

from tests.taylor.problems import EPS, FN, FULL, PROBLEMS, blocks, error
from tt_precise.taylor.system import System, numbers_of

BOTH = pytest.mark.parametrize("limbs", [2, 3])


@BOTH
@pytest.mark.parametrize("name", PROBLEMS)
def test_closed_forms_at_the_end_and_between(name: str, limbs: int) -> None:
    until = PROBLEMS[name].until
    first, *_, last = 2 * blocks(name, limbs)
    growth = FN.mpf(2) ** 6 if "Kepler" in name else 1  # errors in phase grow with t^2
    assert error(name, last, until) < EPS[limbs] * growth
    middle = FN.mpf(first.begins[len(first.lengths) // 2, 0]) + FN.mpf(1) / 97
    assert error(name, first, middle) < EPS[limbs] * growth


@pytest.mark.parametrize("tolerance", [1e-16, 1e-20, 1e-26])
def test_mixed_arithmetic_loses_what_the_tolerance_does(tolerance: float) -> None:
    loss = error("sine and cosine", blocks("sine and cosine", 2, tolerance)[-1], 3)
    assert tolerance / 1e4 < loss < tolerance * 100


@BOTH
def test_a_decay_of_1e14_per_unit_of_time(limbs: int) -> None:
    """x = exp(-1e14 t): in the first unit of time its terms have no doubles."""
    fast = FN.mpf(10) ** 14
    decay = System(limbs, 1, 1, lambda y, p, fn: ([-p[0] * y[0]], []))
    (block,) = decay.pieces(decay.initial_data((FN.mpf(1),), (fast,), FN), 1e-13, FULL[limbs])
    assert block.good == len(block.lengths)
    end = sum(map(FN.mpf, block.end_time))
    (value,) = numbers_of(block.end_row, FN)
    assert end >= 1e-13
    assert abs(value - FN.exp(-end * fast)) < EPS[limbs]


def coming_to_rest(y: Any, p: Any, fn: Any) -> Any:
    """Return v' = -1 and x' = v (1/v), a product that grows without bound."""
    return [-1 + 0 * y[0], y[0] * (1 / y[0])], []


@pytest.mark.parametrize("limbs", [2, 3])
@pytest.mark.parametrize("tolerance", [1e-18, 1e-23, 1e-28])
def test_steps_are_a_constant_part_of_the_time_to_rest(tolerance: float, limbs: int) -> None:
    """Measured against the largest component, 1/v = 1e28 shortened the steps hundredfold."""
    rest = System(limbs, 2, 0, coming_to_rest)
    speed = FN.mpf(2) ** -40
    initial = rest.initial_data((speed, FN.mpf(1)), (), FN)
    parts = [
        (block := each).lengths * each.units / each.coefficients[:, 0, 0]
        for each in rest.pieces(initial, float(speed), tolerance)
    ]
    assert len(parts) == (1 if tolerance > 1e-20 else 2)
    part = numpy.concatenate(parts)
    # the last steps are bounded by the time that is left in doubles
    assert part[2:-3] == pytest.approx(numpy.full(len(part) - 5, part[2]), rel=0.1)
    assert part[2] > 0.2
    distance = numbers_of(block.end_row, FN)[1] - 1 - sum(map(FN.mpf, block.end_time))
    assert abs(distance) < 1e3 * speed * tolerance + EPS[limbs]
