"""Power series against mpmath's derivatives, in several arithmetics, and sizes of summands."""

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.taylor.series import (
    Series,
    SeriesFunctions,
    Sized,
    SizedFunctions,
    constant,
    rate,
    solution,
)

FUNCTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "sums": lambda x, y, fn: 3 - x + (y - 2) - (1 + x) + (x - y),
    "product": lambda x, y, fn: x * y * x,
    "power": lambda x, y, fn: x**3,
    "quotient": lambda x, y, fn: x / y + 1 / x + y / 7,
    "root": lambda x, y, fn: fn.sqrt(x * x + y * y) + fn.sqrt(4),
    "exponential": lambda x, y, fn: fn.exp(x * y),
    "sine and cosine": lambda x, y, fn: fn.sin(x * y) - 2 * fn.cos(y),
    "angle": lambda x, y, fn: fn.atan2(x, y) + fn.atan2(x, 2) + fn.atan2(3, y),
}
ORDER = 7


def lines(fn: Any) -> tuple[Any, ...]:
    """2 + t and 3 - t/4."""
    return solution(lambda e: [1, -(fn.mpf(1) / 4)], [fn.mpf(2), fn.mpf(3)])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_coefficients_are_derivatives(name: str) -> None:
    with mpmath.workdps(40):
        function = FUNCTIONS[name]
        x, y = lines(mpmath.mp)
        found = function(x, y, SeriesFunctions(mpmath.mp))
        true = mpmath.taylor(
            lambda t: function(2 + t, 3 - t / 4, mpmath.mp), 0, ORDER, method="step"
        )
        for k in range(ORDER + 1):
            assert abs(found[k] - true[k]) < 1e-16, k
        moved = function(x + 0, y + mpmath.mpf(10) ** -30, SeriesFunctions(mpmath.mp))
        assert name in ("power", "sums") or any(moved[k] != found[k] for k in range(3))


def test_a_solution_grows_with_its_rates() -> None:
    """x' = x y, y' = 1 from (1, 0): x = exp(t^2/2); over two rows at once."""
    x, y = solution(lambda e: [e[0] * e[1], 1], [numpy.ones(2), numpy.zeros(2)])
    for k in range(9):
        true = 0 if k % 2 else 0.5 ** (k // 2) / math.factorial(k // 2)
        assert x[k] == pytest.approx([true] * 2, rel=1e-15)
    assert rate(x)[3] == pytest.approx([0.5] * 2)
    assert (y[1] == 1).all()
    assert constant(5)[1] == 0


def test_sizes_are_those_of_the_summands() -> None:
    one, tiny = Sized(1.0, 1.0), Sized(1e-20, 1e-20)
    gone = (one + tiny) - one
    assert (gone.value, gone.size) == (0.0, 2.0 + 1e-20)
    assert (gone * 3).size == 6.0 + 3e-20
    assert (1 / Sized(4.0, 4.0)).size == 0.5
    fn = SizedFunctions()
    assert fn.sqrt(Sized(4.0, 8.0)).size == 2.0
    assert fn.atan2(Sized(1.0, 1.0), 1.0).size == 0.5
    assert fn.sqrt(9.0) == 3.0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_size_bounds_what_errors_of_the_summands_make(name: str) -> None:
    """Of first order, with the arguments moved by as much as their sizes say."""
    function, eps = FUNCTIONS[name], 1e-7
    plain = function(2.0, 3.0, SizedFunctions())
    x, y = Sized(2.0, 2.0), Sized(3.0, 3.0)
    size = function(constant(x), constant(y), SeriesFunctions(SizedFunctions()))[0].size
    for a in (-1, 1):
        for b in (-1, 1):
            moved = function(2.0 * (1 + a * eps), 3.0 * (1 + b * eps), SizedFunctions())
            assert abs(moved - plain) <= 1.001 * eps * size


def test_series_take_arrays_on_either_side() -> None:
    found = numpy.array([1.0, 2.0]) * constant(numpy.array([3.0, 4.0]))
    assert isinstance(found, Series)
    assert found[0].tolist() == [3.0, 8.0]
