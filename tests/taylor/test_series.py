"""Power series against mpmath's derivatives, in several arithmetics, and sizes of summands."""

import math
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.taylor import series

FUNCTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "sums": lambda x, y, fn: 3 - x + (y - 2) - (1 + x) + (x - y),
    "product": lambda x, y, fn: x * y * x,
    "power": lambda x, y, fn: x**3,
    "quotient": lambda x, y, fn: x / y + 1 / x + y / 7,
    "root": lambda x, y, fn: fn.sqrt(x * x + y * y) + fn.sqrt(4),
    "exponential": lambda x, y, fn: fn.exp(x * y),
    "sine and cosine": lambda x, y, fn: fn.sin(x * y) - 2 * fn.cos(y),
    "length": lambda x, y, fn: fn.hypot(x, y) + fn.hypot(x, 2) + fn.hypot(3, 4),
    "arcs": lambda x, y, fn: fn.asin(x / (3 * y)) + fn.acos(x / (3 * y)) * y + fn.tan(x / y),
    "broken power": lambda x, y, fn: x**-1.5 + (x * y) ** 0.5,
    "logarithm": lambda x, y, fn: fn.log(x * y) + fn.log(4) * fn.exp(1),
    "distance": lambda x, y, fn: abs(x - y) * y,
    "arc": lambda x, y, fn: fn.atan(x / y),
    "angle": lambda x, y, fn: fn.atan2(3, 4) + fn.atan2(x, y) + fn.atan2(x, 2) + fn.atan2(3, y),
}
ORDER = 7


@pytest.mark.parametrize("name", FUNCTIONS)
def test_coefficients_are_derivatives(name: str) -> None:
    """Along the lines 2 + t and 3 - t/4; a line moved by 1e-30 has others."""
    with mpmath.workdps(40):
        function, fn = FUNCTIONS[name], series.SeriesFunctions(mpmath.mp)
        lines = [mpmath.mpf(2), mpmath.mpf(3)]
        x, y = series.solution(lambda e: [1, -mpmath.mpf(1) / 4], lines)
        coefficients = function(x, y, fn)
        exact = mpmath.taylor(
            lambda t: function(2 + t, 3 - t / 4, mpmath.mp), 0, ORDER, method="step"
        )
        for k in range(ORDER + 1):
            assert abs(coefficients[k] - exact[k]) < 1e-16, k
        other = function(x + 0, y + mpmath.mpf(10) ** -30, fn)
        assert name in ("power", "sums") or any(other[k] != coefficients[k] for k in range(3))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_size_bounds_the_effect_of_errors_of_the_summands(name: str) -> None:
    """The bound is of first order; each argument is moved by a part ``eps`` of its size."""
    function, eps, fn = FUNCTIONS[name], 1e-7, series.SizedFunctions()
    plain = function(2.0, 3.0, fn)
    x, y = (series.constant(series.Sized(value, value)) for value in (2.0, 3.0))
    size = function(x, y, series.SeriesFunctions(fn))[0].size
    for a in (-1, 1):
        for b in (-1, 1):
            other = function(2.0 * (1 + a * eps), 3.0 * (1 + b * eps), fn)
            assert abs(other - plain) <= 1.001 * eps * size


def test_a_length_is_not_lost_in_squares() -> None:
    x, y = series.solution(lambda e: [1e-200, -2e-200], [3e-200, 4e-200])
    length = series.SeriesFunctions(numpy).hypot(x, y)
    assert length[0] == pytest.approx(5e-200)
    assert length[1] == pytest.approx(-1e-200)


def test_a_solution_grows_with_its_rates() -> None:
    """x' = x y, y' = 1 from (1, 0): x = exp(t^2/2); over two rows at once."""
    x, y = series.solution(lambda e: [e[0] * e[1], 1], [numpy.ones(2), numpy.zeros(2)])
    for k in range(9):
        exact = 0 if k % 2 else 0.5 ** (k // 2) / math.factorial(k // 2)
        assert x[k] == pytest.approx([exact] * 2, rel=1e-15)
    assert series.rate(x)[3] == pytest.approx([0.5] * 2)
    assert (y[1] == 1).all()


def test_sizes_of_sums_quotients_and_arrays() -> None:
    one, tiny, six = series.Sized(1.0, 1.0), series.Sized(1e-20, 1e-20), series.Sized(6.0, 7.0)
    difference, array = (one + tiny) - one, numpy.array([2.0, -3.0])
    assert (difference.value, difference.size) == (0.0, 2.0 + 1e-20)
    assert (difference * 3).size == 6.0 + 3e-20
    assert (1 / series.Sized(4.0, 4.0)).size == 0.5
    assert (array * six).size.tolist() == [2 * (6 + 7), 3 * (6 + 7)]
    assert (array - six).size.tolist() == [2 + 7, 3 + 7]
    with pytest.raises(TypeError, match=r"numpy\.hypot of several numbers"):
        numpy.hypot(six, six)  # type: ignore[call-overload]


def test_running_errors_bound_the_roundings_of_an_evaluation() -> None:
    def value(a: Any, b: Any, c: Any, d: Any) -> Any:
        return ((a * b + c * d) * a - b / c) * (a - d) / (c + b)

    generator, shares = random.Random(1), []
    for _ in range(200):
        numbers = [generator.uniform(-1, 1) for _ in range(4)]
        result = value(*(series.Rounded(x, 0.0) for x in numbers))
        error = abs(Fraction(result.value) - value(*map(Fraction, numbers)))
        shares.append(float(error) / (2.0**-53 * result.size))
    assert 0.1 < max(shares) <= 1
