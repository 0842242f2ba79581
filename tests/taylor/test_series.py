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


def lines(fn: Any) -> tuple[Any, ...]:
    """2 + t and 3 - t/4."""
    return series.solution(lambda e: [1, -(fn.mpf(1) / 4)], [fn.mpf(2), fn.mpf(3)])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_coefficients_are_derivatives(name: str) -> None:
    with mpmath.workdps(40):
        function = FUNCTIONS[name]
        x, y = lines(mpmath.mp)
        found = function(x, y, series.SeriesFunctions(mpmath.mp))
        true = mpmath.taylor(
            lambda t: function(2 + t, 3 - t / 4, mpmath.mp), 0, ORDER, method="step"
        )
        for k in range(ORDER + 1):
            assert abs(found[k] - true[k]) < 1e-16, k
        moved = function(x + 0, y + mpmath.mpf(10) ** -30, series.SeriesFunctions(mpmath.mp))
        assert name in ("power", "sums") or any(moved[k] != found[k] for k in range(3))


def test_a_length_has_no_squares_that_vanish() -> None:
    x, y = series.solution(lambda e: [1e-200, -2e-200], [3e-200, 4e-200])
    length = series.SeriesFunctions(numpy).hypot(x, y)
    assert length[0] == pytest.approx(5e-200)
    assert length[1] == pytest.approx(-1e-200)


def test_a_solution_grows_with_its_rates() -> None:
    """x' = x y, y' = 1 from (1, 0): x = exp(t^2/2); over two rows at once."""
    x, y = series.solution(lambda e: [e[0] * e[1], 1], [numpy.ones(2), numpy.zeros(2)])
    for k in range(9):
        true = 0 if k % 2 else 0.5 ** (k // 2) / math.factorial(k // 2)
        assert x[k] == pytest.approx([true] * 2, rel=1e-15)
    assert series.rate(x)[3] == pytest.approx([0.5] * 2)
    assert (y[1] == 1).all()
    assert series.constant(5)[1] == 0


def test_sizes_are_those_of_the_summands() -> None:
    one, tiny = series.Sized(1.0, 1.0), series.Sized(1e-20, 1e-20)
    gone = (one + tiny) - one
    assert (gone.value, gone.size) == (0.0, 2.0 + 1e-20)
    assert (gone * 3).size == 6.0 + 3e-20
    assert (1 / series.Sized(4.0, 4.0)).size == 0.5
    fn = series.SizedFunctions()
    assert fn.sqrt(series.Sized(4.0, 8.0)).size == 2.0
    assert fn.atan2(series.Sized(1.0, 1.0), 1.0).size == 0.5
    assert fn.sqrt(9.0) == 3.0
    array, six = numpy.array([2.0, -3.0]), series.Sized(6.0, 7.0)
    assert (array * six).size.tolist() == [2 * (6 + 7), 3 * (6 + 7)]
    assert (array - six).size.tolist() == [2 + 7, 3 + 7]
    with pytest.raises(TypeError, match=r"numpy\.hypot of several numbers"):
        numpy.hypot(six, six)  # type: ignore[call-overload]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_size_bounds_what_errors_of_the_summands_make(name: str) -> None:
    """The bound is of first order; the arguments are moved by as much as their sizes say."""
    function, eps = FUNCTIONS[name], 1e-7
    plain = function(2.0, 3.0, series.SizedFunctions())
    x, y = series.Sized(2.0, 2.0), series.Sized(3.0, 3.0)
    size = function(
        series.constant(x), series.constant(y), series.SeriesFunctions(series.SizedFunctions())
    )[0].size
    for a in (-1, 1):
        for b in (-1, 1):
            moved = function(2.0 * (1 + a * eps), 3.0 * (1 + b * eps), series.SizedFunctions())
            assert abs(moved - plain) <= 1.001 * eps * size


def test_series_take_arrays_on_either_side() -> None:
    array = numpy.array([2.0, 3.0])
    for h in (
        series.Truncated(numpy.ones((2, 2))),
        series.TaylorSeries(lambda c, k: 1.0 + 0 * array),
    ):
        for found in (array * h, h * array):
            assert isinstance(found, series.TaylorSeries)
            assert [found[k].tolist() for k in (0, 1)] == [[2, 3], [2, 3]]
        assert [(array + h)[k].tolist() for k in (0, 1)] == [[3, 4], [1, 1]]
        assert [(array - h)[k].tolist() for k in (0, 1)] == [[1, 2], [-1, -1]]
        assert [(h / array)[k].tolist() for k in (0, 1)] == [[1 / 2, 1 / 3], [1 / 2, 1 / 3]]


def test_a_truncated_series_is_the_series() -> None:
    """1/(1 - h) = 1 + h + h^2 + ..., its square has the coefficients 1, 2, 3, ..."""
    h = series.Truncated(numpy.array([[0.0], [1.0], [0.0], [0.0], [0.0]]))
    geometric = series.Truncated(numpy.array((1 / (1 - h)).upto(4)))
    square = geometric * geometric
    assert isinstance(square, series.Truncated)
    assert square.c[:, 0].tolist() == [1, 2, 3, 4, 5]
    assert square.rate[:, 0].tolist() == [2, 6, 12, 20]
    assert [(square / geometric)[k][0] for k in range(5)] == [1] * 5
    assert [(square + 1 / (1 - h))[k][0] for k in range(5)] == [2, 3, 4, 5, 6]
    random = numpy.random.default_rng(1).uniform(0.1, 1, (8, 6, 4))
    fn = series.SeriesFunctions(numpy)
    for function in (
        lambda x, y: (1 + x) * (y - 3) * (3 - x) - 2 * x / 3 + -y,
        lambda x, y: fn.sqrt(1 + x * x) * y / (1 + x),
    ):
        whole = function(*map(series.Truncated, random[:2])).upto(5)
        lazy = function(*(series.TaylorSeries(lambda c, k: 0.0, c) for c in random[:2])).upto(5)
        assert numpy.array(whole) == pytest.approx(numpy.array(lazy), rel=1e-12)


def test_the_coefficients_of_an_oscillator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tt_precise.taylor.series.ROWS", 3)
    t = numpy.linspace(0, 3, 7)
    x, v = series.coefficients(lambda s: (s[1], -s[0]), [numpy.sin(t), numpy.cos(t)], 12)
    derivatives = (numpy.sin(t), numpy.cos(t), -numpy.sin(t), -numpy.cos(t))
    eps = numpy.finfo(float).eps
    for k in range(13):
        bound = 4 * eps / math.factorial(k)
        assert x[k] == pytest.approx(derivatives[k % 4] / math.factorial(k), rel=0, abs=bound)
    assert (v[0] == numpy.cos(t)).all()


def test_a_convolution_is_the_product_of_two_series() -> None:
    a, b = [1, 2, 3, 4], [5, -6, 7, 8]
    assert series.convolution(a, b) == [5, 4, 10, 24]


def test_running_errors_bound_the_roundings_of_an_evaluation() -> None:
    def value(a: Any, b: Any, c: Any, d: Any) -> Any:
        return ((a * b + c * d) * a - b / c) * (a - d) / (c + b)

    drawn, shares = random.Random(1), []
    for _ in range(200):
        numbers = [drawn.uniform(-1, 1) for _ in range(4)]
        found = value(*(series.Rounded(x, 0.0) for x in numbers))
        wrong = abs(Fraction(found.value) - value(*map(Fraction, numbers)))
        shares.append(float(wrong) / (2.0**-53 * found.size))
        assert value(*(series.Sized(x, 0.0) for x in numbers)).size == 0
    assert 0.1 < max(shares) <= 1
