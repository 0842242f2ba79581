"""The emitted arithmetic of several doubles against mpmath."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import pytest

from tests.taylor.problems import FN, FULL
from tt_precise.taylor.emit import LN_2, nearest
from tt_precise.taylor.system import System

BOUND = {2: FN.mpf(2) ** -102, 3: FN.mpf(2) ** -154}
A, B = FN.mpf(22) / 7, -(FN.mpf(10) ** 40 + 1) / (3 * FN.mpf(10) ** 39)
OPERATIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "sum": lambda a, b, fn: a + b,
    "product": lambda a, b, fn: a * b,
    "quotient": lambda a, b, fn: a / b,
    "root": lambda a, b, fn: fn.sqrt(a),
    "exponential": lambda a, b, fn: fn.exp(b),
    "small exponential": lambda a, b, fn: fn.exp(8 * b),
}


@cache
def results(limbs: int) -> dict[str, tuple[list[float], Any]]:
    """Limbs of each operation on A and B, and its value on A and B as they are in so many limbs."""

    def define(y: Any, p: Any, fn: Any) -> Any:
        return [0, 0], [operation(y[0], y[1], fn) for operation in OPERATIONS.values()]

    system = System(limbs, 2, 0, define)
    (block,) = system.pieces(system.initial_data((A, B), (), FN), 1.0, FULL[limbs])
    columns = block.data[:, 0, 0].T.tolist()
    a, b = (sum(map(FN.mpf, column)) for column in columns[:2])
    exact = [operation(a, b, FN) for operation in OPERATIONS.values()]
    return dict(zip(OPERATIONS, zip(columns[2:], exact, strict=False), strict=True))


@pytest.mark.parametrize("limbs", [2, 3])
@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_loses_a_few_units_of_the_last_limb(name: str, limbs: int) -> None:
    """Without the last limb the bound is exceeded: the control."""
    value, exact = results(limbs)[name]
    assert abs(sum(map(FN.mpf, value)) / exact - 1) < BOUND[limbs]
    assert abs(sum(map(FN.mpf, value[:-1])) / exact - 1) > BOUND[limbs]


def test_limbs_are_nearest_to_the_remainders() -> None:
    limbs = list(map(FN.mpf, nearest(LN_2, 3)))
    for count in (1, 2, 3):
        assert abs(FN.ln2 - sum(limbs[:count])) < abs(limbs[count - 1]) * FN.mpf(2) ** -53
    assert nearest(Fraction(1, 4), 2) == [0.25, 0.0]
