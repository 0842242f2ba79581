"""The compiled recurrences against closed forms, in both number types."""

import pytest

from tests.taylor.problems import EPS, FN, FULL, PROBLEMS, at, error, pieces, run, system
from tt_precise.taylor.system import System, numbers_of


@pytest.mark.parametrize("limbs", [2, 3])
@pytest.mark.parametrize("name", PROBLEMS)
def test_closed_forms_at_the_end_and_between(name: str, limbs: int) -> None:
    until = PROBLEMS[name].until
    first, *_, last = 2 * pieces(name, limbs)
    growth = FN.mpf(2) ** 6 if "Kepler" in name else 1  # errors in phase grow with t^2
    assert error(name, at(last, until), until) < EPS[limbs] * growth
    middle = FN.mpf(first.begins[len(first.lengths) // 2, 0]) + FN.mpf(1) / 97
    assert error(name, at(first, middle), middle) < EPS[limbs] * growth


@pytest.mark.parametrize("tolerance", [1e-16, 1e-20, 1e-26])
def test_a_tolerance_is_what_is_lost(tolerance: float) -> None:
    """Mixed arithmetic does not cost more digits than the tolerance does; and does cost them."""
    name = "sine and cosine"
    lost = error(name, at(pieces(name, 2, tolerance)[-1], 3), 3)
    assert tolerance / 1e4 < lost < tolerance * 100


def test_the_last_part_of_a_start_counts() -> None:
    name = "product and quotient"
    one = PROBLEMS[name]
    for limbs in (2, 3):
        moved = one.start[0] * (1 + 4 * EPS[limbs]), one.start[1]
        last = run(system(name, limbs), one._replace(start=moved), FULL[limbs])[-1]
        assert error(name, at(last, 3), 3) > 3 * EPS[limbs]


@pytest.mark.parametrize("limbs", [2, 3])
def test_a_decay_of_1e14_per_unit_of_time_is_integrated(limbs: int) -> None:
    """x = exp(-1e14 t): in the first unit of time its terms have no doubles."""
    fast = FN.mpf(10) ** 14
    made = System(limbs, 1, 1, lambda y, p, fn: ([-p[0] * y[0]], []))
    initial = made.initial_data((FN.mpf(1),), (fast,), FN)
    (block,) = made.pieces(initial, 1e-13, FULL[limbs])
    assert block.good == len(block.lengths)
    end = sum(map(FN.mpf, block.end_time))
    (found,) = numbers_of(block.end_row, FN)
    assert end >= 1e-13
    assert abs(found - FN.exp(-end * fast)) < EPS[limbs]
